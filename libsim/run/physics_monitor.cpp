#include "libsim/run/physics_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/run/machine_fault.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/run/run_summary.hpp"

namespace subsoil::sim {

PhysicsMonitor::PhysicsMonitor(RunOutput& output) : o_(output), physics_(o_.s, o_.world), bodies_(o_.s, o_.world) {
  start_.gravity = o_.s.gravity;
  if (o_.world.machine) start_.machine_potential = o_.world.machine->energy().potential;
}

namespace {

/// What the potential of the soil is more under another gravity, J.
double soil_rises_by(const World& world, const Vec3& gravity) {
  double sum = 0;
  for (const dem::Sphere& s : world.bed->spheres())
    if (s.kind == dem::SphereKind::free) sum -= s.m * dem::dot(gravity, s.x);
  for (const dem::Clump& c : world.bed->clumps())
    sum -= world.bed->clump_shapes()[c.shape].mass * dem::dot(gravity, c.position);
  return sum;
}

double machine_rises_by(const mbd::Machine& machine, const Vec3& gravity) {
  double sum = 0;
  const auto& bodies = machine.system().model().bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const mbd::Vec2 at = machine.body(static_cast<int>(i) + 1).r;
    sum -= bodies[i].mass * (gravity.x * at.x + gravity.y * at.y);
  }
  return sum;
}

}  // namespace

void PhysicsMonitor::take_up(const SavedRun& saved, bool changed) {
  if (!saved.progress || !saved.progress->energy_start) return;
  start_ = *saved.progress->energy_start;
  begun_ = !changed, changed_ = changed;
  if (!changed) return;
  const Vec3 more = o_.s.gravity - start_.gravity.value_or(o_.s.gravity);
  start_.gravity = o_.s.gravity;
  if (o_.world.bed) start_.bed_gravity += soil_rises_by(o_.world, more);
  if (o_.world.machine) start_.machine_potential += machine_rises_by(*o_.world.machine, more);
}

void PhysicsMonitor::before_step(bool, StepRequest& request) {
  o_.now.first = o_.steps == 0 && !begun_;
  request.energies |= o_.now.first;
  o_.now.energies = request.energies;
}

bool PhysicsMonitor::after_step() {
  if (o_.now.first) begin();
  if (o_.world.bed && o_.now.energies) {
    balance_ = energy_balance(start_, o_.world, o_.simulation,
                              o_.world.machine ? o_.world.machine->energy() : mbd::MachineEnergy{});
    balance_["time [s]"] = o_.now.t;
  }
  return !o_.now.row || !(o_.fails(machine_fault(o_.s, o_.world)) || physics_fails());
}

void PhysicsMonitor::begin() {
  begun_ = true;
  if (!o_.world.bed) return;
  const dem::BedEnergy& bed = o_.world.bed->energy();
  start_.bed = bed.total() - bed.work();
  if (!changed_) {
    start_.bed_gravity = bed.gravity;
    start_.there = std::max(bed.kinetic, 0.0) + std::max(bed.rotational, 0.0) + std::abs(bed.stored);
    if (o_.world.machine) {
      const mbd::MachineEnergy machine = o_.world.machine->energy();
      start_.there += machine.kinetic + std::abs(machine.stored);
    }
  }
  if (const auto found = physics_.start(o_.world)) o_.warn(found->text);
}

bool PhysicsMonitor::physics_fails() {
  if (!o_.world.bed || !begun_) return false;
  for (const PhysicsWatch::Finding& finding : physics_.look(o_.world, start_, fastest_, deepest_)) {
    const std::string text = fmt::format("t = {:.9g} s: {}", o_.reached, finding.text);
    if (finding.stops) return o_.failure = text, true;
    o_.warn(text);
  }
  for (const std::string& text : bodies_.look(o_.simulation))
    o_.warn(fmt::format("t = {:.9g} s: {}", o_.reached, text));
  return false;
}

void PhysicsMonitor::count_step() {
  if (!o_.world.bed) return;
  deepest_ = std::max(deepest_, o_.world.bed->max_overlap());
  fastest_ = std::max(fastest_, o_.world.bed->max_speed());
}

}  // namespace subsoil::sim
