#include "tests/verification/mechanisms/cases/replay.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "libsim/scenario/load.hpp"
#include "tests/tools/paths.hpp"

namespace subsoil::cases {

std::string file_of(const Case& c) {
  return subsoil::test::source_dir() + "/tests/verification/mechanisms/cases/" + c.name + ".yaml";
}

Replay::Replay(const Case& of, const std::vector<std::string>& sets)
    : loaded_(sim::load_scenario(file_of(of), sets)), machine_(sim::build_machine(loaded_)) {
  const sim::Scenario& s = loaded_.scenario;
  const double every = s.output.row_interval();
  step_ = std::min(every, s.time.machine.step.value_or(every));
  steps_per_row_ = std::max(1L, std::lround(every / step_));
  rows_ = std::lround(s.time.end / every);
  const auto& names = machine_->column_names();
  row_values_.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) units_[names[i]] = machine_->column_units()[i];
  for (const auto& b : s.machine->bodies) {
    units_[b.name + ".ax"] = units_[b.name + ".ay"] = "m/s^2";
    units_[b.name + ".alpha"] = "rad/s^2";
  }
  look();
}

bool Replay::next() {
  if (row_ == rows_) return false;
  for (long i = 0; i < steps_per_row_; ++i) machine_->advance(step_);
  ++row_;
  look();
  return true;
}

void Replay::look() {
  machine_->columns(row_values_);
  const auto& names = machine_->column_names();
  for (std::size_t i = 0; i < names.size(); ++i) values_[names[i]] = row_values_[i];
  const Eigen::VectorXd& a = machine_->integrator().state().acceleration;
  Eigen::Index i = 0;
  for (const auto& b : loaded_.scenario.machine->bodies)
    for (const char* axis : {".ax", ".ay", ".alpha"}) values_[b.name + axis] = a[i++];
}

double Replay::value(const std::string& column) const {
  const auto found = values_.find(column);
  if (found == values_.end()) throw std::invalid_argument("the reference names a column that is not there: " + column);
  return found->second;
}

namespace {

struct Kind {
  const char* name;
  double Bounds::*bound;
};

Kind kind_of(const std::string& unit) {
  if (unit == "m" || unit == "rad") return {"position", &Bounds::position};
  if (unit == "m/s" || unit == "rad/s") return {"velocity", &Bounds::velocity};
  if (unit == "m/s^2" || unit == "rad/s^2") return {"acceleration", &Bounds::acceleration};
  if (unit == "N" || unit == "N m") return {"force", &Bounds::force};
  if (unit == "J") return {"energy", &Bounds::energy};
  throw std::invalid_argument("no bound for the unit " + unit);
}

}  // namespace

std::vector<Finding> compare(const Case& c, const std::vector<std::string>& sets) {
  Replay replay(c, sets);
  const Reference reference = c.reference();
  std::vector<Finding> findings;
  do {
    for (const auto& [column, value] : reference(replay.time())) {
      const std::string& unit = replay.unit(column);
      const Kind kind = kind_of(unit);
      auto at = std::find_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.kind == kind.name; });
      if (at == findings.end()) {
        findings.push_back({.kind = kind.name, .difference = -1, .bound = c.bounds.*kind.bound});
        at = std::prev(findings.end());
      }
      ++at->compared;
      const double ours = replay.value(column), full_turn = 2 * std::numbers::pi;
      const double off = unit == "rad" ? std::remainder(ours - value, full_turn) : ours - value;
      const double difference = std::abs(off);
      if (difference <= at->difference) continue;  // a NaN is taken: it is worse than anything
      at->column = column, at->unit = unit, at->t = replay.time();
      at->ours = ours, at->reference = unit == "rad" ? ours - off : value, at->difference = difference;
      if (std::isnan(difference)) return findings;
    }
  } while (replay.next());
  return findings;
}

}  // namespace subsoil::cases
