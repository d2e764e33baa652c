#include "libsim/studies/impact/measured.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "libsim/document/document.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/csv_separator.hpp"

namespace subsoil::sim {
namespace {

/// Which of the known columns a header's field means, and its unit.
struct HeaderField {
  std::size_t column;
  std::string unit;
};

class MeasuredReader {
 public:
  MeasuredReader(const std::filesystem::path& file, const std::vector<MeasuredColumn>& known)
      : file_(file), known_(known) {
    for (const MeasuredColumn& c : known) names_.push_back(c.name);
  }
  void line(const std::string& text, int number, MeasuredTable& out) {
    number_ = number;
    if (text.find_first_not_of(" \t\r") == std::string::npos || text[0] == '#') return;
    const std::vector<std::string> fields = csv::split(text);
    if (header_.empty()) {
      if (const std::string other = csv::other_separator(text); !other.empty()) refuse(other);
      for (const std::string& f : fields) header_.push_back(field_of(f));
      return;
    }
    if (fields.size() != header_.size())
      refuse(fmt::format("holds {} fields, the header {}", fields.size(), header_.size()));
    std::vector<double> row(known_.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t k = 0; k < fields.size(); ++k)
      if (!fields[k].empty()) row[header_[k].column] = value_of(fields[k], header_[k]);
    out.values.push_back(std::move(row));
    out.lines.push_back(number);
  }

 private:
  [[noreturn]] void refuse(const std::string& rule) const {
    throw ScenarioError(fmt::format("{}:{}: {}", file_.string(), number_, rule));
  }
  HeaderField field_of(const std::string& text) const {
    const csv::Label label = csv::split_label(text);
    const auto found = std::find(names_.begin(), names_.end(), label.name);
    if (found == names_.end())
      refuse(fmt::format("unknown column `{}`{}; a header names {} with units", label.name,
                         suggestion(label.name, names_), fmt::join(names_, ", ")));
    const HeaderField field{static_cast<std::size_t>(found - names_.begin()), label.unit == "1" ? "" : label.unit};
    value_of("1", field);  // refuses a unit of another dimension at the header
    return field;
  }
  double value_of(const std::string& text, const HeaderField& field) const {
    const MeasuredColumn& column = known_[field.column];
    double value = 0;
    try {
      value = parse_quantity(text + " " + field.unit, column.unit);
    } catch (const UnitError& error) {
      refuse(fmt::format("{} = {}: {}", column.name, text, error.what()));
    }
    if (!(value > 0)) refuse(fmt::format("{} = {}: must be above 0", column.name, text));
    return value;
  }

  const std::filesystem::path& file_;
  const std::vector<MeasuredColumn>& known_;
  std::vector<std::string> names_;
  std::vector<HeaderField> header_;
  int number_ = 0;
};

}  // namespace

MeasuredTable read_measured_table(const std::filesystem::path& file, const std::vector<MeasuredColumn>& known) {
  std::ifstream stream(file);
  if (!stream) throw ScenarioError(fmt::format("{}: there is no such file", file.string()));
  MeasuredReader reader(file, known);
  MeasuredTable table;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) reader.line(text, number, table);
  if (table.values.empty())
    throw ScenarioError(fmt::format("{}: holds no measurements below its header", file.string()));
  return table;
}

}  // namespace subsoil::sim
