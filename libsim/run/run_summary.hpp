#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "libsim/io/summary.hpp"
#include "libsim/run/energy_start.hpp"
#include "libsim/run/fibre_drag.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/run/tool.hpp"
#include "libsim/setup/world.hpp"

/// What summary.json states of a run beside its columns, and the means as they are printed at its end.
namespace subsoil::sim {

/// How a run went.
struct RunFacts {
  int code = exit_ok;
  std::string failure;  ///< of a failed one
  double reached = 0;   ///< s, simulated
  double wall_time = 0;
  long steps = 0, frames = 0;
  double deepest = 0;  ///< overlap, share of a radius
};

void write_run_section(Summary& summary, const RunFacts& facts, const Scenario& scenario, const RunRequest& request,
                       const World& world);
/// The energy balance of an instant at which the bed's energies are taken.
Json energy_balance(const EnergyStart& start, const World& world, const coupling::Simulation& simulation,
                    const mbd::MachineEnergy& of_machine);
/// Where fibres lay at the start and lie now, and what they did to surfaces in the window.
void write_fibres(Summary& summary, const World& world, const FibreDrag& drag);
/// What inlets have poured.
void write_inlets(Summary& summary, const World& world);
/// What came into a moving bed and what was left.
void write_window(Summary& summary, const World& world);
/// Maximum error of restitution at the speeds met or expected.
void write_restitution_error(Summary& summary, double error);
/// What fixed machine steps are estimated to err by.
void write_step_error(Summary& summary, const mbd::StepError& error);
/// Of each servo: load, what resists it, travel, work.
void write_servos(Summary& summary, const World& world, const coupling::Simulation& simulation);
/// Of the iterated exchange.
void write_exchange(Summary& summary, const coupling::ExchangeCount& count);
void write_events(Summary& summary, const mbd::Machine& machine);
/// Means of each tool: force on it forward, upward and sideways, with their intervals.
void write_tools(Summary& summary, const ToolProgress& progress);
/// What the pass has done to the soil, from the frames that lie in the folder; nothing where no tool passes through
/// soil, and the reason where frames do not tell. @param reaches_wall as the run has looked and warned; else unknown
void write_disturbance(Summary& summary, const ToolProgress& progress, const std::filesystem::path& folder,
                       const Scenario& scenario, std::optional<bool> reaches_wall);

/// The means of tools and monitors, a line each: "draft 61.2 N +- 4.1 N".
std::string means_text(const Summary& summary, const ToolProgress& progress, const Scenario& scenario);

}  // namespace subsoil::sim
