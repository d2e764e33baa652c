#pragma once
#include <memory>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libmbd/base/function.hpp"

namespace subsoil::sim {

struct Loaded;

/// A function of time of the scenario whose values come from outside while the simulation runs.
///   f(t) = value + rate (t - t_0) from the last set() at t_0 on; before the first one the scenario's own function
/// Integrals run on over all that was set, so that a driver given by its velocity keeps its position.
class Input {
 public:
  Input(std::string name, std::string unit, mbd::Function given)
      : name_(std::move(name)), unit_(std::move(unit)), given_(std::move(given)) {}

  const std::string& name() const { return name_; }
  const std::string& unit() const { return unit_; }
  void set(double t, double value, double rate);
  void archive(Archive& a);

  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;

 private:
  std::string name_, unit_;
  mbd::Function given_;
  /// value + rate (t - from), with its integrals at `from`.
  struct Piece {
    double from = 0, value = 0, rate = 0, once = 0, twice = 0;
    void archive(Archive& a);
  };
  /// The piece in force at t; null: the given function. None before the last two is kept: values are asked for
  /// within the last step, or at the start of a driver, where the given function is in force.
  const Piece* piece_at(double t) const;

  bool set_ = false;
  double first_ = 0;  ///< time of the first set()
  Piece last_, before_;
};

/// The inputs of a simulation, put in place of functions of a scenario that is not built yet.
class Inputs {
 public:
  /// Names of all functions of time that may become inputs: `machine.drivers.feed.velocity`,
  /// `machine.controllers.depth.set point`, `boundaries.plate.servo.load` ...
  static std::vector<std::string> available(const Loaded& loaded);
  /// Makes an input of each name; throws ScenarioError with the nearest name for one that is not there.
  void replace(Loaded& loaded, const std::vector<std::string>& names);
  /// Adds a given force at a body's centre of mass, with the inputs `NAME.fx`, `NAME.fy`, `NAME.moment`. Its columns
  /// are those of a force `force on NAME`.
  void add_force_on(Loaded& loaded, const std::string& body);

  const std::vector<std::shared_ptr<Input>>& list() const { return inputs_; }
  /// Throws std::invalid_argument with the nearest name.
  Input& at(const std::string& name) const;

 private:
  mbd::Function make(const std::string& name, const std::string& unit, mbd::Function given);
  std::vector<std::shared_ptr<Input>> inputs_;
};

}  // namespace subsoil::sim
