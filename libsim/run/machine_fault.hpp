#pragma once
#include <exception>
#include <string>

#include "libsim/scenario/scenario.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// How to give the machine shorter steps, by the keys that act in this run.
std::string shorter_step(const Scenario& scenario, const World& world);
/// The same, or steps of the machine's own beside the soil's.
std::string finer_machine(const Scenario& scenario, const World& world);

/// Of the energy there or moved: an energy balance that is off by more is warned of.
inline constexpr double most_closure = 1e-3;

/// Why the machine's motion is not resolved, by its energy balance, and which force is maximum then; empty where the
/// balance is within `limits.energy`.
std::string machine_fault(const Scenario& scenario, const World& world);
/// The same at an instant of the machine.
std::string machine_fault(const Scenario& scenario, const World& world, const mbd::Instant& at);

/// What is reported of a step from the time t that failed: that fault with its cure, or that of a machine that is not
/// resolved, of which the soil's is a consequence.
std::string step_failure(const std::exception& error, double t, const Scenario& scenario, const World& world);

}  // namespace subsoil::sim
