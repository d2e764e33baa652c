#pragma once
#include <string>

/// What a mesh file is, before a reader is asked, and its text as the reader wants it.
namespace subsoil::sim {

/// A format that is not read, with its cure: "is a STEP file, which holds curved faces; export ..."; empty where the
/// content shows none.
std::string other_format(const std::string& content);

/// The first line whose coordinates have decimal commas, with its number: "line 7, `v 1,5 0 0`, ..."; empty where none
/// has. @param word that begins a line of coordinates; empty: every line of numbers
std::string decimal_commas(const std::string& text, const std::string& word);

/// OBJ as CGAL reads it: lines joined that end with a backslash, `fo`, the older word for a face, as `f`, lines (`l`)
/// left out, which bound no solid. Throws std::runtime_error for surfaces that are not polygons.
std::string plain_obj(const std::string& file, const std::string& text);

/// Text of an STL file as CGAL reads it: words in lower case, blanks in place of tabs, solids without their names,
/// which may be words of the format. Empty: no text of STL.
std::string plain_stl(const std::string& content);

/// Bytes of a binary STL file by the number of triangles in its header.
std::size_t bytes_of_binary(const std::string& content);

/// Throws std::runtime_error for a triangle of a binary STL file with a coordinate that is no number.
void refuse_no_numbers(const std::string& file, const std::string& content);

}  // namespace subsoil::sim
