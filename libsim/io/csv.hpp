#pragma once
#include <string>
#include <string_view>
#include <vector>

/// Comma separated lines as every spreadsheet writes them (RFC 4180), one record per line.
namespace subsoil::sim::csv {

/// Fields of a line without surrounding blanks; a quoted field may hold commas and doubled quotes. A byte order mark
/// is left out.
std::vector<std::string> split(std::string_view line);
/// The field with quotes around it when it needs them.
std::string quoted(std::string_view field);
/// Cuts "speed [m/s]" into name and unit; the unit is empty when there is none.
struct Label {
  std::string name, unit;
};
Label split_label(std::string_view label);
/// True when the whole text is one number (inf and nan included).
bool to_number(std::string_view text, double& value);
/// %.9g: all digits of a float32 and then some, short for round numbers. `exact_digits`: the shortest text that reads
/// back as the same double, 17 digits at most.
inline constexpr int exact_digits = 0;
void append_number(std::string& row, double value, int digits = 9);

}  // namespace subsoil::sim::csv
