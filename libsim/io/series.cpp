#include "libsim/io/series.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "libsim/io/csv.hpp"

namespace subsoil::sim {

int Series::find(std::string_view name) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const auto& c) { return c.name == name; });
  return found == columns.end() ? -1 : static_cast<int>(found - columns.begin());
}

const std::vector<double>& Series::at(std::string_view name) const {
  if (const int i = find(name); i >= 0) return values[static_cast<std::size_t>(i)];
  std::vector<std::string> names;
  for (const auto& column : columns) names.push_back(column.name);
  throw std::runtime_error(fmt::format("the series has no column '{}'; it has {}", name, fmt::join(names, ", ")));
}

Series read_series(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  Series series;
  std::string line;
  std::getline(file, line);
  for (const auto& label : csv::split(line)) {
    auto [name, unit] = csv::split_label(label);
    series.columns.push_back({std::move(name), std::move(unit)});
  }
  series.values.resize(series.columns.size());
  for (long number = 2; std::getline(file, line); ++number) {
    const bool cut_short = file.eof();  // no line end: the writer was killed in the middle of it
    if (cut_short || line.empty()) break;
    if (line.find('\0') != std::string::npos) break;  // a cut of the power lost what was written there
    const auto fields = csv::split(line);
    if (fields.size() != series.columns.size())
      throw std::runtime_error(fmt::format("{}:{}: {} fields under {} columns", path.string(), number, fields.size(),
                                           series.columns.size()));
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double value = 0;
      if (!csv::to_number(fields[i], value))
        throw std::runtime_error(
            fmt::format("{}:{}: {} = '{}' is no number", path.string(), number, series.columns[i].label(), fields[i]));
      series.values[i].push_back(value);
    }
  }
  return series;
}

}  // namespace subsoil::sim
