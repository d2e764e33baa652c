#include "libsim/run/physics_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libsim/run/machine_fault.hpp"
#include "libsim/run/restart.hpp"

namespace subsoil::sim {

PhysicsMonitor::PhysicsMonitor(RunOutput& output) : o_(output), physics_(o_.s, o_.world), bodies_(o_.s, o_.world) {
  if (o_.world.machine) start_.machine_potential = o_.world.machine->energy().potential;
}

void PhysicsMonitor::take_up(const SavedRun& saved) {
  if (!saved.progress || !saved.progress->energy_start) return;
  start_ = *saved.progress->energy_start;
  begun_ = true;
}

void PhysicsMonitor::before_step(bool, StepRequest& request) {
  o_.now.first = o_.steps == 0 && !begun_;
  request.energies |= o_.now.first;
}

bool PhysicsMonitor::after_step() {
  if (o_.now.first) begin();
  return !o_.now.row || !(o_.fails(machine_fault(o_.s, o_.world)) || physics_fails());
}

void PhysicsMonitor::begin() {
  begun_ = true;
  if (!o_.world.bed) return;
  start_.bed = o_.world.bed->energy().total() - o_.world.bed->energy().work();
  start_.bed_gravity = o_.world.bed->energy().gravity;
  if (const auto found = physics_.start(o_.world)) o_.warn(found->text);
}

bool PhysicsMonitor::physics_fails() {
  if (!o_.world.bed || !begun_) return false;
  for (const PhysicsWatch::Finding& finding : physics_.look(o_.world, start_, fastest_)) {
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
