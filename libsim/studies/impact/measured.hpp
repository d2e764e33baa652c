#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace subsoil::sim {

/// A column that a file of measurements may have: name and dimension.
struct MeasuredColumn {
  std::string name, unit;
};

struct MeasuredTable {
  std::vector<std::vector<double>> values;  ///< by row, in the order of the columns asked for; NaN: not measured
  std::vector<int> lines;                   ///< of each row in the file
};

/// Reads a CSV file whose header names columns of `known` with their units, in any order: `speed [m/s], force [kN]`.
/// Values are above 0; an empty field is not measured; `#` begins a comment. Throws ScenarioError with file:line, the
/// rule and the cure.
MeasuredTable read_measured_table(const std::filesystem::path& file, const std::vector<MeasuredColumn>& known);

}  // namespace subsoil::sim
