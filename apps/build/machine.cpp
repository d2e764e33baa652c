#include "apps/build/machine.hpp"

#include "apps/scenario/load.hpp"

namespace subsoil::app {

std::unique_ptr<mbd::Machine> build_machine(const Loaded& loaded) {
  const Scenario& s = loaded.scenario;
  if (!s.machine) return nullptr;
  mbd::Model model;
  model.gravity = {s.gravity.x, s.gravity.y};
  for (const Body& b : s.machine->bodies)
    model.add({.name = b.name,
               .mass = b.mass,
               .inertia = b.inertia,
               .pose = {b.at[0], b.at[1], b.angle},
               .velocity = {b.velocity[0], b.velocity[1], b.spin}});
  model.redundancy = s.machine->redundant;
  for (const NamedJoint& j : s.machine->joints) model.add(j.name, j.element);
  for (const NamedDriver& d : s.machine->drivers) model.add(d.name, d.element);
  for (const NamedForce& f : s.machine->forces) model.add(f.name, f.element);
  const MachineTime& time = s.time.machine;
  mbd::MachineOptions options;
  options.integrator =
      time.integrator == IntegratorWord::ida ? mbd::IntegratorKind::ida : mbd::IntegratorKind::adams_moulton;
  options.adams_moulton.order = static_cast<int>(time.order);
  options.ida = {.rtol = time.rtol, .atol = time.atol};
  try {
    auto machine = std::make_unique<mbd::Machine>(std::move(model), options);
    if (s.machine->start.kind == StartKind::towing_equilibrium)
      machine->start_from_towing_equilibrium(s.machine->start.speed);
    else
      machine->start_from_pose();
    return machine;
  } catch (const std::exception& error) {
    throw ScenarioError(loaded.where("machine") + ": " + error.what());
  }
}

}  // namespace subsoil::app
