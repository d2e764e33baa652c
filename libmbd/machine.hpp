#pragma once

// The face of libmbd for a coupling loop and an output writer.
//
//   mbd::Model model;                                   // plain structs, SI
//   int shovel = model.add({.name = "shovel", .mass = 35.2, .inertia = 2.662, .pose = {-1.224, 0.24, 0}});
//   model.add("H8", Revolute{.body_a = frame, .body_b = shovel, .p_a = ..., .p_b = ...});
//   mbd::Machine machine(model, {.integrator = IntegratorKind::adams_moulton});
//   machine.start_from_pose();                          // or start_from_towing_equilibrium(0.5)
//   loop: machine.set_external_wrench(shovel, fx, fy, mz);   // about the centre of gravity, world axes, constant over
//   h
//         machine.advance(h);
//         machine.body(shovel)                          // BodyState: r, angle, v, omega
//         machine.columns(values)                       // in the order of column_names()

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/equilibrium/equilibrium.hpp"
#include "libmbd/integrators/integrator.hpp"
#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

struct MachineOptions {
  IntegratorKind integrator = IntegratorKind::adams_moulton;
  AdamsMoultonOptions adams_moulton{};
  IdaOptions ida{};
  CvodeOptions cvode{};
  bool locate_events = true;  ///< zeros of switching functions are located, the integrator restarted there
  bool assemble = true;       ///< false: a start pose whose joints are open is refused, not closed
  bool hold_start = false;    ///< a start that assembly has to change is refused: see refuse_changed_start()
};

/// Energy balance of the machine since the start (J). balance() is 0 up to integration error: kinetic + potential +
/// stored + lost
/// - work minus its value at the start. No term is a remainder: kinetic, potential and stored are functions of the
/// state, lost and work are integrals of force times velocity.
struct MachineEnergy {
  double kinetic = 0, potential = 0, stored = 0;
  double lost = 0;           ///< dissipated by forces
  double driver_work = 0;    ///< done on the machine by drivers
  double force_work = 0;     ///< done by applied forces
  double external_work = 0;  ///< done by external wrenches (soil)
  double at_start = 0;
  /// Energy that was there or moved: the most of kinetic + stored, the range of potential, and what drivers, forces,
  /// soil and dissipation exchanged.
  double moved = 0;
  /// |balance()| as a share of it: how far the balance is from closing.
  double closure() const;
  double balance() const {
    return kinetic + potential + stored + lost - driver_work - force_work - external_work - at_start;
  }
};

/// Force and moment that a joint puts on its first body, at the joint's point, world axes; the second body gets the
/// opposite (with a carrier: the other two together). The point is that of the second body, or what the joint names as
/// its reaction_point: the contact of disks and cams, the pitch point of gears. Drivers: force or torque along the
/// driven coordinate on the driven (second) body, fx holding it.
struct Reaction {
  double fx = 0, fy = 0, moment = 0;
};

class Machine {
 public:
  explicit Machine(Model model, MachineOptions options = {});

  /// Assembles the model's pose and velocities; the report names redundant constraints.
  const AssemblyReport& start_from_pose();
  /// Assembles, then finds the steady state with every body at `speed` along x, external wrenches as set.
  const AssemblyReport& start_from_towing_equilibrium(double speed);
  /// The steady state that the last start found; empty after a start from the pose.
  const std::optional<Equilibrium>& equilibrium() const { return equilibrium_; }
  const AssemblyReport& assembly() const { return report_; }

  int body_index(const std::string& name) const { return system_.body_index(name); }
  void set_external_wrench(int body, double fx, double fy, double mz) { system_.set_external_wrench(body, fx, fy, mz); }
  const std::array<double, 3>& external_wrench(int body) const { return system_.external_wrench(body); }
  /// One machine step with constant wrenches.
  void advance(double h);
  /// The same to an instant: see Integrator::advance_to().
  void advance_to(double time);
  double time() const { return integrator_->state().t; }

  /// Keeps from now on what a step leaves between its ends.
  void keep_dense_output() { integrator_->keep_dense_output(); }
  /// Of the last step; empty where it was not kept.
  const DenseOutput& dense_output() const { return integrator_->dense_output(); }
  /// What evaluates states of this machine, without a trace in its motion.
  Evaluation evaluation() const { return Evaluation(system_); }

  /// The machine at the end of the last step.
  Instant now() const { return integrator_->now(); }
  const BodyState& body(int index) const;
  Reaction joint_reaction(const std::string& name) const { return joint_reaction(name, now()); }
  Reaction joint_reaction(const std::string& name, const Instant& at) const;
  /// Force (N) or torque (N m) of a driver along its coordinate: for the towed trolley the pull.
  double driver_force(const std::string& name) const { return driver_force(name, now()); }
  double driver_force(const std::string& name, const Instant& at) const;
  /// A reported value of a force, e.g. ("H9", "force"), ("left wheel", "sinkage").
  double force_value(const std::string& name, const std::string& column) const {
    return force_value(name, column, now());
  }
  double force_value(const std::string& name, const std::string& column, const Instant& at) const;
  MachineEnergy energy() const { return energy(now()); }
  MachineEnergy energy(const Instant& at) const;
  /// Adds the columns NAME or NAME.x ... of a measure at the end. Throws std::invalid_argument when it names a joint,
  /// force or body that is not there.
  void measure(const std::string& name, AnyMeasure measure);

  /// Everything that can be reported: per body pose, velocity and acceleration, per joint its reaction on the first
  /// body, drivers, forces, energies, measures. Units beside. Values in the same order.
  const std::vector<std::string>& column_names() const { return names_; }
  const std::vector<std::string>& column_units() const { return units_; }
  /// Whether a column holds whole numbers, which have no value between two instants.
  bool column_is_whole(std::size_t column) const { return whole_[column] != 0; }
  void columns(std::span<double> out) const { columns(now(), out); }
  void columns(const Instant& at, std::span<double> out) const;

  /// The machine at the end of the last step, as a value.
  Snapshot snapshot() const;
  /// Takes a snapshot of a machine built from the same model and options. Throws std::invalid_argument for another's.
  void restore(const Snapshot& from);

  /// At the end of the last step.
  const System& system() const { return std::as_const(*integrator_).system(); }
  System& system() { return integrator_->system(); }
  const Integrator& integrator() const { return *integrator_; }
  /// Contacts closed and opened, stops hit, since the start.
  const std::vector<Event>& events() const { return integrator_->events(); }
  /// Partition choices made so far.
  long partition_choices() const { return integrator_->partition().choices(); }

 private:
  void settle_pose(Eigen::VectorXd& q, Eigen::VectorXd& velocity);
  void refuse_redundant() const;
  void refuse_unstarted() const;
  void begin(const Eigen::VectorXd& q, const Eigen::VectorXd& velocity);
  void watch_energy(bool first);
  void name_columns();

  MachineOptions options_;
  System system_;
  std::unique_ptr<Integrator> integrator_;
  AssemblyReport report_;
  std::optional<Equilibrium> equilibrium_;
  bool started_ = false;
  double energy_at_start_ = 0;
  double most_energy_ = 0, lowest_potential_ = 0, highest_potential_ = 0;
  std::vector<std::string> names_, units_;
  std::vector<char> whole_;
  struct Placed {
    AnyMeasure measure;
    std::size_t columns;
  };
  std::vector<Placed> measures_;
};

}  // namespace subsoil::mbd
