#include "libsim/keys/points_file.hpp"

#include <fmt/format.h>

#include <array>
#include <fstream>

#include "libsim/base/byte_order_mark.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/csv_separator.hpp"

namespace subsoil::sim {
namespace {

/// Reads one file of points, with its own places in every refusal.
class PointsFile {
 public:
  explicit PointsFile(const std::string& file) : file_(file) {}

  std::vector<Vec2> read() {
    std::ifstream stream(file_);
    if (!stream) throw Refusal(fmt::format("there is no file {}", file_));
    std::vector<Vec2> points;
    bool header = true;
    for (std::string line; std::getline(stream, line);) {
      ++line_;
      line = std::string(without_byte_order_mark(line));
      if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
      if (const std::string fault = csv::other_separator(line); header && !fault.empty()) refuse(fault);
      const std::vector<std::string> fields = csv::split(line);
      if (fields.size() != 2) refuse(fmt::format("holds {} columns; must be two, x and y", fields.size()));
      if (header)
        take_header(fields);
      else
        points.push_back({value(fields, 0), value(fields, 1)});
      header = false;
    }
    return points;
  }

 private:
  static constexpr std::array<char, 2> names_{'x', 'y'};

  [[noreturn]] void refuse(const std::string& rule) const {
    throw Refusal(fmt::format("{}:{}: {}", file_, line_, rule));
  }
  void take_header(const std::vector<std::string>& fields) {
    std::array<bool, 2> found{};
    for (std::size_t field = 0; field < 2; ++field) {
      const csv::Label label = csv::split_label(fields[field]);
      if (label.name != "x" && label.name != "y")
        refuse(fmt::format("column '{}' is unknown; must be a header such as x [mm], y [mm]", label.name));
      const std::size_t k = label.name == "x" ? 0 : 1;
      if (found[k]) refuse(fmt::format("column '{0}' stands twice; name one of them {1}", label.name, names_[1 - k]));
      if (label.unit.empty())
        refuse(fmt::format("column '{0}' has no unit; must be a header such as x [mm], y [mm]", label.name));
      found[k] = true;
      field_[k] = field;
      unit_[k] = label.unit;
      meters("1", k);  // refuses a unit of another dimension at the header
    }
  }
  double value(const std::vector<std::string>& fields, std::size_t k) const { return meters(fields[field_[k]], k); }
  double meters(const std::string& number, std::size_t k) const {
    try {
      return parse_quantity(number + " " + unit_[k], "m");
    } catch (const UnitError& error) {
      refuse(fmt::format("{} = {}: {}", names_[k], number, error.what()));
    }
  }

  const std::string& file_;
  int line_ = 0;
  std::array<std::size_t, 2> field_{};  ///< where x and y stand in a line
  std::array<std::string, 2> unit_;
};

}  // namespace

std::vector<Vec2> points_of_file(const std::string& file) { return PointsFile(file).read(); }

}  // namespace subsoil::sim
