#include "libmbd/machine.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "libmbd/controllers.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/measures.hpp"
#include "libmbd/system/extent.hpp"
#include "libmbd/system/wrench.hpp"

namespace subsoil::mbd {

namespace {
Reaction reaction_of(const System& system, std::size_t joint, const Eigen::VectorXd& lambda) {
  const int first = visit([](const auto& j) { return j.body_a; }, system.model().joints[joint].element);
  const Wrench w = joint_wrench(system, joint, lambda, first);
  return {w.force.x, w.force.y, w.moment};
}
}  // namespace

Machine::Machine(Model model, MachineOptions options) : options_(options), system_(std::move(model)) {
  if (!options_.locate_events)
    for (const auto& force : system_.model().forces)
      if (needs_events(force.element))
        throw ModelFault({PartName::Kind::force, force.name},
                         "force '" + force.name +
                             "' sticks or has a restitution, which are events; locate these, or take them out of it");
  integrator_ = make_integrator(options_.integrator, system_, options_.adams_moulton, options_.ida, options_.cvode);
  integrator_->locate_events(options_.locate_events);
  name_columns();
}

void Machine::settle_pose(Eigen::VectorXd& q, Eigen::VectorXd& velocity) {
  q = system_.start_position(), velocity = system_.start_velocity();
  const double t = system_.model().start_time;
  if (!options_.assemble) refuse_open_joints(system_, t, q);
  report_ = assemble(system_, t, q, velocity);
  refuse_redundant();
  system_.settle_forces(t, q, velocity);
  equilibrium_.reset();
}

const AssemblyReport& Machine::start_from_pose() {
  Eigen::VectorXd q, velocity;
  settle_pose(q, velocity);
  if (options_.hold_start) refuse_changed_start(system_, q, velocity);
  begin(q, velocity);
  return report_;
}

const AssemblyReport& Machine::start_from_towing_equilibrium(double speed) {
  Eigen::VectorXd q, velocity;
  settle_pose(q, velocity);
  equilibrium_ = towing_equilibrium(system_, system_.model().start_time, q, speed);
  system_.set_start_states(equilibrium_->states);
  system_.set_start_grips(equilibrium_->grips);
  begin(equilibrium_->q, equilibrium_->velocity);
  return report_;
}

void Machine::refuse_redundant() const {
  if (system_.model().redundancy == Redundancy::minimum_norm || report_.redundant.empty()) return;
  std::string text = "the machine has redundant constraints: ";
  for (std::size_t i = 0; i < report_.redundant.size(); ++i) text += (i ? "; " : "") + report_.redundant[i];
  throw ModelFault(report_.redundant_parts.front().front(),
                   text + ". Free one of each group, or let redundant be minimum-norm");
}

void Machine::begin(const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  integrator_->start(system_.model().start_time, q, velocity);
  started_ = true;
  watch_energy(true);
  energy_at_start_ = 0;
  energy_at_start_ = energy().balance();  // with what the start itself has lost, as joints close or friction lets go
}

const BodyState& Machine::body(int index) const {
  const System& system = integrator_->system();
  if (index < 0 || index >= system.bodies())
    throw std::out_of_range("machine: body " + std::to_string(index) + ": there are " +
                            std::to_string(system.bodies()) + " with the ground, counted from 0");
  return system.body(index);
}

// A machine that was not started has neither reactions nor a method that knows its velocities.
void Machine::refuse_unstarted() const {
  if (!started_)
    throw std::logic_error("machine: advance() before start_from_pose(), start_from_towing_equilibrium() or restore()");
}

void Machine::advance(double h) {
  refuse_unstarted();
  integrator_->advance(h);
  watch_energy(false);
}

void Machine::advance_to(double time) {
  refuse_unstarted();
  integrator_->advance_to(time);
  watch_energy(false);
}

void Machine::watch_energy(bool first) {
  EnergyRange range = integrator_->take_energy_range();
  if (first) range = {}, most_energy_ = 0, lowest_potential_ = highest_potential_ = system().potential();
  range.see(system());
  most_energy_ = std::max(most_energy_, range.most);
  lowest_potential_ = std::min(lowest_potential_, range.lowest);
  highest_potential_ = std::max(highest_potential_, range.highest);
}

double MachineEnergy::closure() const {
  // Rounding of sums of this size is no energy of its own.
  const double rounding = 1e-9 * (std::abs(potential) + std::abs(at_start));
  const double size = moved + rounding;
  return size > 0 ? std::abs(balance()) / size : 0;
}

void Machine::measure(const std::string& name, AnyMeasure measure) {
  visit(
      [&]<class Measure>(Measure& m) {
        if constexpr (Measure::has.attach) m.attach(system_);
        const std::vector<MeasureColumn> columns = m.columns();
        for (const MeasureColumn& column : columns) {
          names_.push_back(column.suffix.empty() ? name : name + "." + column.suffix);
          units_.emplace_back(column.unit);
          whole_.push_back(false);
        }
        measures_.push_back({std::move(measure), columns.size()});
      },
      measure);
}

Reaction Machine::joint_reaction(const std::string& name, const Instant& at) const {
  return reaction_of(at.system, find_named(system_.model().joints, "joint", name), at.reactions());
}

double Machine::driver_force(const std::string& name, const Instant& at) const {
  return -at.reactions()[system_.row_of_driver(find_named(system_.model().drivers, "driver", name))];
}

double Machine::force_value(const std::string& name, const std::string& column, const Instant& at) const {
  const std::size_t i = find_named(system_.model().forces, "force", name);
  return visit(
      [&](const auto& force) {
        std::string known;
        for (std::size_t k = 0; k < force.columns.size(); ++k) {
          if (column == force.columns[k].name) return at.system.values()[i][k];
          known += (k ? ", " : "") + std::string(force.columns[k].name);
        }
        throw std::invalid_argument("force '" + name + "' reports no '" + column + "'; it reports " + known);
      },
      system_.model().forces[i].element);
}

MachineEnergy Machine::energy(const Instant& at) const {
  MachineEnergy energy;
  energy.kinetic = at.system.kinetic();
  energy.potential = at.system.potential();
  energy.stored = at.system.stored();
  const auto& flows = at.flows;
  const auto forces = static_cast<Eigen::Index>(system_.model().forces.size());
  energy.lost = flows.of_elements.head(forces).sum() + flows.latched;
  energy.force_work = flows.of_elements.segment(forces, forces).sum();
  energy.driver_work = flows.of_elements.segment(2 * forces, system_.flow_count() - 2 * forces).sum();
  energy.external_work = flows.external_work;
  energy.at_start = energy_at_start_;
  energy.moved = most_energy_ + (highest_potential_ - lowest_potential_) + std::abs(energy.lost) +
                 std::abs(energy.driver_work) + std::abs(energy.force_work) + std::abs(energy.external_work) +
                 energy_at_rest(system_);
  return energy;
}

void Machine::name_columns() {
  const auto add = [&](const std::string& name, const char* unit, bool whole = false) {
    names_.push_back(name), units_.emplace_back(unit), whole_.push_back(whole);
  };
  const Model& model = system_.model();
  for (const auto& b : model.bodies) {
    add(b.name + ".x", "m"), add(b.name + ".y", "m"), add(b.name + ".angle", "rad");
    add(b.name + ".vx", "m/s"), add(b.name + ".vy", "m/s"), add(b.name + ".spin", "rad/s");
    add(b.name + ".ax", "m/s^2"), add(b.name + ".ay", "m/s^2"), add(b.name + ".alpha", "rad/s^2");
  }
  for (const auto& j : model.joints) add(j.name + ".fx", "N"), add(j.name + ".fy", "N"), add(j.name + ".moment", "N m");
  for (std::size_t i = 0; i < model.joints.size(); ++i)
    if (system_.may_open(i)) add(model.joints[i].name + ".open", "1", true);
  for (const auto& d : model.drivers) {
    const bool turns = visit([](const auto& driver) { return driver.angular(); }, d.element);
    add(d.name + (turns ? ".torque" : ".force"), turns ? "N m" : "N");
  }
  for (const auto& f : model.forces)
    visit(
        [&](const auto& force) {
          for (const auto& column : force.columns) add(f.name + "." + column.name, column.unit, column.whole);
        },
        f.element);
  for (const auto& c : model.controllers)
    visit(
        [&]<class Controller>(const Controller& controller) {
          add(c.name + ".output", controller.output_unit.c_str());
          if constexpr (Controller::has.error) add(c.name + ".error", controller.measured_unit.c_str());
        },
        c.element);
  for (const char* term :
       {"kinetic", "potential", "stored", "lost", "driver work", "force work", "external work", "balance"})
    add(std::string("energy.") + term, "J");
}

void Machine::columns(const Instant& at, std::span<double> out) const {
  if (out.size() != names_.size())
    throw std::invalid_argument("machine columns: space for " + std::to_string(out.size()) + " values, there are " +
                                std::to_string(names_.size()));
  auto next = out.begin();
  const auto put = [&](auto... values) { ((*next++ = values), ...); };
  const System& system = at.system;
  const Model& model = system.model();
  for (int i = 1; i < system.bodies(); ++i) {
    const BodyState& b = at.body(i);
    put(b.r.x, b.r.y, b.angle, b.v.x, b.v.y, b.omega);
    const auto acceleration = at.state.acceleration.segment<3>(3 * (i - 1));
    put(acceleration[0], acceleration[1], acceleration[2]);
  }
  const Eigen::VectorXd lambda = at.reactions();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Reaction r = reaction_of(system, i, lambda);
    put(r.fx, r.fy, r.moment);
  }
  for (std::size_t i = 0; i < model.joints.size(); ++i)
    if (system.may_open(i)) put(static_cast<double>(system.open_joints()[i]));
  for (std::size_t i = 0; i < model.drivers.size(); ++i) put(-lambda[system.row_of_driver(i)]);
  for (std::size_t i = 0; i < model.forces.size(); ++i) {
    const std::size_t count = visit([](const auto& force) { return force.columns.size(); }, model.forces[i].element);
    for (std::size_t k = 0; k < count; ++k) put(system.values()[i][k]);
  }
  for (std::size_t i = 0; i < model.controllers.size(); ++i)
    visit(
        [&]<class Controller>(const Controller&) {
          put(system.signals()[i]);
          if constexpr (Controller::has.error) put(system.controller_error(i));
        },
        model.controllers[i].element);
  const MachineEnergy e = energy(at);
  put(e.kinetic, e.potential, e.stored, e.lost, e.driver_work, e.force_work, e.external_work, e.balance());
  const Observation seen{system, at.state.acceleration, lambda};
  for (const auto& [measure, count] : measures_) {
    visit([&](const auto& m) { m.evaluate(seen, {next, count}); }, measure);
    next += static_cast<std::ptrdiff_t>(count);
  }
}

Snapshot Machine::snapshot() const {
  Snapshot out = integrator_->save();
  out.energy_at_start = energy_at_start_, out.most_energy = most_energy_;
  out.lowest_potential = lowest_potential_, out.highest_potential = highest_potential_;
  return out;
}

void Machine::restore(const Snapshot& from) {
  if (report_.equations != system_.equations()) start_from_pose();  // fills what the start pose decides
  integrator_->restore(from);
  started_ = true;
  energy_at_start_ = from.energy_at_start, most_energy_ = from.most_energy;
  lowest_potential_ = from.lowest_potential, highest_potential_ = from.highest_potential;
}

}  // namespace subsoil::mbd
