#include "libsim/scenario/shapes/mesh_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "libsim/document/characters.hpp"

namespace subsoil::sim {
namespace {

std::string in_lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

struct Format {
  std::string_view magic, what, cure;
};
constexpr std::string_view as_mesh = "export the surface as STL, OBJ or PLY";
constexpr std::array<Format, 17> formats{{
    {"\x1f\x8b", "compressed by gzip", "unpack it first"},
    {"BZh", "compressed by bzip2", "unpack it first"},
    {"\xfd"
     "7zXZ",
     "compressed by xz", "unpack it first"},
    {"7z\xbc\xaf", "an archive of 7-Zip", "unpack it first"},
    {"PK\x03\x04", "a ZIP archive, as 3MF files are", "unpack it, or export the surface as STL, OBJ or PLY"},
    {"ISO-10303-21", "a STEP file, which holds curved faces", as_mesh},
    {"glTF", "a binary glTF file", as_mesh},
    {"\x89HDF", "an HDF5 file", "name the mesh file"},
    {"<", "an HTML or XML file, as AMF, COLLADA and X3D are", as_mesh},
    {"#VRML", "a VRML file", as_mesh},
    {"# vtk", "a VTK file", as_mesh},
    {"OFF", "an OFF file", as_mesh},
    {"**ABCDEF", "a Parasolid file", as_mesh},
    {"%PDF", "a PDF file", as_mesh},
    {"Kaydara", "an FBX file", as_mesh},
    {"\xff\xfe", "text in UTF-16", "save it as UTF-8"},
    {"\xfe\xff", "text in UTF-16", "save it as UTF-8"},
}};

/// Lines of IGES have 80 columns; the first of them is of the section S, numbered 1.
bool is_iges(const std::string& content) {
  return content.size() > 80 && content[72] == 'S' && content.find_first_of("\r\n") == 80 && content[79] == '1';
}

bool has_decimal_comma(std::string_view line) {
  for (std::size_t at = line.find(','); at != std::string_view::npos; at = line.find(',', at + 1))
    if (at > 0 && at + 1 < line.size() && is_digit(line[at - 1]) && is_digit(line[at + 1])) return true;
  return false;
}

/// The first word of a line.
std::string word_of(const std::string& line) {
  std::string word;
  std::istringstream(line) >> word;
  return word;
}

}  // namespace

std::string other_format(const std::string& content) {
  for (const Format& f : formats)
    if (std::string_view(content).starts_with(f.magic)) return fmt::format("is {}; {}", f.what, f.cure);
  if (is_iges(content)) return fmt::format("is an IGES file, which holds curved faces; {}", as_mesh);
  return {};
}

std::string decimal_commas(const std::string& text, const std::string& word) {
  std::istringstream lines(text);
  std::string line;
  for (long number = 1; std::getline(lines, line); ++number) {
    const std::string first = word_of(line);
    const bool numbers = word.empty() ? !first.empty() && first.find_first_not_of("0123456789.,+-eE") == first.npos
                                      : in_lower_case(first) == word;
    if (!numbers || !has_decimal_comma(line)) continue;
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) line.pop_back();
    return fmt::format("line {}, `{}`, has decimal commas; export it with decimal points", number,
                       line.substr(std::min(line.size(), line.find_first_not_of(" \t")), 60));
  }
  return {};
}

std::string plain_obj(const std::string& file, const std::string& text) {
  std::string out;
  std::istringstream lines(text);
  long number = 0;
  bool continued = false, left_out = false;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.ends_with('\r')) line.pop_back();
    const bool goes_on = line.ends_with('\\') && !line.starts_with('#');
    if (goes_on) line.pop_back();
    if (!continued) {
      const std::string word = word_of(line);
      if (word == "curv" || word == "curv2" || word == "surf" || word == "bzp" || word == "bsp" || word == "cdp")
        throw std::runtime_error(fmt::format(
            "{}:{}: `{}` is of a curved surface, of which no triangle is made; export the surface as triangles", file,
            number, word));
      left_out = word == "l" || word == "call" || word == "csh";
      if (word == "fo") line.replace(line.find("fo"), 2, "f");
    }
    if (!left_out) out += line + (goes_on ? ' ' : '\n');
    continued = goes_on;
  }
  return out;
}

std::size_t bytes_of_binary(const std::string& content) {
  std::uint32_t count = 0;
  if (content.size() >= 84) std::memcpy(&count, content.data() + 80, 4);
  return 84 + 50 * static_cast<std::size_t>(count);
}

std::string plain_stl(const std::string& content) {
  const std::size_t begin = content.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || bytes_of_binary(content) == content.size()) return {};
  if (in_lower_case(content.substr(begin, 5)) != "solid") return {};
  std::string text = in_lower_case(content);
  if (text.find("facet") == std::string::npos) return {};
  std::replace(text.begin(), text.end(), '\t', ' ');
  std::replace(text.begin(), text.end(), '\r', '\n');
  std::string out;
  std::istringstream lines(text.substr(begin));
  for (std::string line; std::getline(lines, line);) {
    const std::string word = word_of(line);
    const bool named = (word == "solid" || word == "endsolid") && line.find(" normal") == std::string::npos;
    out += (named ? word : line) + '\n';
  }
  return out;
}

void refuse_no_numbers(const std::string& file, const std::string& content) {
  const std::size_t triangles = (std::min(bytes_of_binary(content), content.size()) - 84) / 50;
  for (std::size_t t = 0; t < triangles; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      float p[3];
      std::memcpy(p, content.data() + 84 + 50 * t + 12 + 12 * k, sizeof p);
      if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) continue;
      throw std::runtime_error(
          fmt::format("{}: triangle {} has its corner {} at ({:g}, {:g}, {:g}): must be finite numbers; export the "
                      "mesh again",
                      file, t + 1, k + 1, p[0], p[1], p[2]));
    }
}

}  // namespace subsoil::sim
