#pragma once

#include <map>
#include <string>
#include <vector>

#include "libsim/setup/machine.hpp"
#include "tests/verification/mechanisms/cases/case.hpp"

namespace subsoil::cases {

/// A scenario's machine, moved by the scenario's step and looked at where a row of its series would be.
class Replay {
 public:
  /// `sets` as for `subsoil run --set`.
  explicit Replay(const Case& of, const std::vector<std::string>& sets = {});

  /// On to the next row of the series; false at the end.
  bool next();
  double time() const { return machine_->time(); }
  double end() const { return loaded_.scenario.time.end; }
  mbd::Machine& machine() { return *machine_; }

  /// A column of series.csv now, or an acceleration BODY.ax, .ay, .alpha.
  double value(const std::string& column) const;
  /// Its unit.
  const std::string& unit(const std::string& column) const { return units_.at(column); }

 private:
  void look();

  sim::Loaded loaded_;
  std::unique_ptr<mbd::Machine> machine_;
  long steps_per_row_ = 1, rows_ = 0, row_ = 0;
  double step_ = 0;
  std::vector<double> row_values_;
  std::map<std::string, double> values_;
  std::map<std::string, std::string> units_;
};

/// Path of a case's scenario.
std::string file_of(const Case& c);

/// What a comparison found: the worst of a kind of quantity over all rows.
struct Finding {
  std::string kind{}, column{}, unit{};
  double t = 0, ours = 0, reference = 0, difference = 0, bound = 0;
  long compared = 0;
};

/// Compares a run with its reference in every row; one finding for each kind of quantity that the reference knows.
/// Angles are compared modulo a full turn, since closed formulas of angles do not count turns.
std::vector<Finding> compare(const Case& c, const std::vector<std::string>& sets = {});

}  // namespace subsoil::cases
