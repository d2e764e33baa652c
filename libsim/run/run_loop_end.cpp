#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "libsim/post/disturbance.hpp"
#include "libsim/run/machine_fault.hpp"
#include "libsim/run/run_loop.hpp"
#include "libsim/run/wear.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {
namespace {

// Beyond these a run is no answer to trust: shares of the energy, of the machine's length and speed, and of the work
// between soil and machine.
constexpr double most_step_error = 1e-3, most_exchange_error = 1e-2;
constexpr double most_unseen = 0.1;  // of an input: smooth ones of six steps a period are below it
// Of the window of the means: less rest at its end is no reason to read them otherwise.
constexpr double most_standing = 0.1;

/// What the scenario gives of a machine alone that keeps its step from following its error.
std::string fixes_machine_step(const Scenario& s) {
  const MachineTime& time = s.time.machine;
  std::vector<std::string> given;
  if (time.integrator == IntegratorWord::adams_moulton) given.emplace_back("time.machine.integrator");
  if (time.step) given.emplace_back("time.machine.step");
  if (time.order) given.emplace_back("time.machine.order");
  return fmt::format("{}", fmt::join(given, " and "));
}

/// A key that promises speed and gave none.
bool stayed_awake(const Scenario& s, const dem::Bed& bed) {
  return s.soil && s.soil->active && bed.frozen_count() == 0 && bed.energy().frozen == 0;
}

}  // namespace

void RunLoop::warn_of_coarse_contacts() {
  double speed = world_.step.expected_speed, error = world_.step.error_at(speed);
  // Where all were slower than expected, attraction takes a larger share of them, and its errors too.
  if (physics_.fastest() > 0)
    if (const ImpactError met = world_.step.error_where_met(physics_.fastest());
        physics_.fastest() > speed || met.error > error)
      speed = met.speed, error = met.error;
  write_restitution_error(*summary_, error);
  if (error <= 1.2 * s_.time.accuracy + 1e-3) return;
  StepReport fine = world_.step;
  fine.soil_step = fine.at_speed(speed, s_.time.accuracy, s_.time.safety * fine.limit.step).step;
  summary_->warn(
      fmt::format("impacts at {:.3g} m/s, as met or expected, have a restitution wrong by up to {:.2g} "
                  "with the step of {:.3g} s; {:.3g} s would keep `time.accuracy: {:.3g}`",
                  speed, error, world_.step.soil_step, fine.soil_step, s_.time.accuracy));
}

void RunLoop::write_step_error() {
  const mbd::StepError& error = world_.machine->integrator().step_error();
  if (error.fastest == 0) return;
  sim::write_step_error(*summary_, error);
  warn_of_ground_contacts();
  if (error.unseen > most_unseen)
    summary_->warn(fmt::format(
        "machine steps of {:.3g} s miss or add {:.2g} of what an input does in the run: between their ends they "
        "see nothing, and it has pulses or swings of a step or two; {}",
        world_.step.machine_step, error.unseen,
        world_.bed ? finer_machine(s_, world_) : "shorten them, or leave out " + fixes_machine_step(s_)));
  // The waves of beams take most of the velocities' part, and nothing is seen of them: their energy is judged.
  const bool beams = s_.machine && !s_.machine->beams.empty();
  // Where drivers move all, the pose is theirs, and only works err, which the energy balance judges.
  const bool driven = world_.machine->integrator().partition().freedom() == 0;
  if (!driven && (beams ? error.positions : error.sum()) > most_step_error)
    summary_->warn(
        fmt::format("machine steps of {:.3g} s are estimated to err by {:.2g} of the machine's length and speed over "
                    "the run; {}",
                    world_.step.machine_step, error.sum(),
                    world_.bed ? finer_machine(s_, world_) : "shorten them, or leave out " + fixes_machine_step(s_)));
}

/// The error estimate of fixed steps sees no contact that begins and ends between two of them.
void RunLoop::warn_of_ground_contacts() {
  constexpr double least_steps = 200;  // a contact of 200 steps costs 2e-3 of the sinkage, one of 2 steps 6e-2
  for (const auto& force : world_.machine->system().model().forces) {
    const auto* ground = force.element.get_if<mbd::GroundElement>();
    if (ground == nullptr || ground->share <= 0 || ground->contact_time > 0.99 * least_steps * world_.step.machine_step)
      continue;
    summary_->warn(fmt::format(
        "{}: body and follower meet for {:.2g} s, {:.2g} machine steps of {:.2g} s, and no estimate sees the error of "
        "that; {}",
        force.name, ground->contact_time, ground->contact_time / world_.step.machine_step, world_.step.machine_step,
        world_.bed ? finer_machine(s_, world_)
                   : fmt::format("take `time.machine.step` of {:.2g} s at most, or leave out {}",
                                 ground->contact_time / least_steps, fixes_machine_step(s_))));
  }
}

void RunLoop::warn_of_machine_energy() {
  if (!world_.machine) return;
  // Where a step has failed, the state is one of its trials, and the failure says what to do.
  if (!output_.failure.empty()) return;
  const double closure = world_.machine->energy().closure();
  if (closure > most_closure)
    summary_->warn(
        fmt::format("the machine's energy balance is off by {:.2g} of the energy there or moved: its motion is not "
                    "resolved; {}",
                    closure, finer_machine(s_, world_)));
}

void RunLoop::warn_of_exchange() {
  if (!world_.bed || !world_.machine || !physics_.has_begun()) return;
  const coupling::InterfaceWork work = simulation_.interface_work();
  const double moved = std::max(std::abs(work.on_soil), std::abs(work.on_machine)), error = std::abs(work.error());
  // A share of little changes no motion, and of what dampers take anyway less than a tenth is left to it.
  const dem::BedEnergy& soil = world_.bed->energy();
  const double there = world_.machine->energy().moved + soil.kinetic + soil.rotational + std::abs(soil.stored);
  if (error <= most_exchange_error * moved || error <= 0.1 * most_exchange_error * there) return;
  if (error <= 0.1 * soil.lost.total()) return;
  summary_->warn(fmt::format(
      "the exchange between soil and machine {} {:.3g} J, {:.2g} of the {:.3g} J that went between them: a body is "
      "light against what it touches; {}",
      work.error() > 0 ? "made" : "lost", error, error / moved, moved,
      shorter_step(s_, world_) +
          (s_.time.coupling == CouplingWord::once ? ", or take `time.coupling: iterated`" : "")));
}

void RunLoop::warn_of_open_exchange() {
  if (s_.time.coupling != CouplingWord::iterated) return;
  const coupling::ExchangeCount& count = simulation_.exchange();
  write_exchange(*summary_, count);
  if (count.open == 0) return;
  summary_->warn(
      fmt::format("soil and machine did not agree in {} of {} machine steps: surfaces ended up to {:.2g} m from where "
                  "the soil took them to end, above `coupling tolerance` = {:.2g} m; raise `time.coupling iterations`, "
                  "or {}",
                  count.open, count.windows, count.widest, s_.time.coupling_tolerance, shorter_step(s_, world_)));
}

void RunLoop::attempt(int& code, const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    if (code != exit_failed) output_.failure = fmt::format("t = {:.9g} s: {}", output_.reached, error.what());
    code = exit_failed;
    lock_.free_reserve();
  }
}

// A step that fails leaves the machine in a trial of it and the soil before it: the balance is that of the last instant
// at which all of it was taken.
void RunLoop::write_energy(int code) {
  if (code == exit_failed && world_.bed && !physics_.balance().is_null()) {
    summary_->section("energy") = physics_.balance();
    return;
  }
  // Of a machine alone the run's last instant, which a crossing may have set inside a step; of soil the end of its last
  // step, to which all terms belong.
  Json balance = energy_balance(physics_.energy_start(), world_, simulation_,
                                world_.machine ? world_.machine->energy(samples_->machine()) : mbd::MachineEnergy{});
  balance["time [s]"] = world_.bed ? simulation_.time() : output_.reached;
  summary_->section("energy") = std::move(balance);
}

void RunLoop::finish(int& code) {
  live_.close();
  if (code == exit_failed) lock_.free_reserve();
  attempt(code, [&] { output_.series->sync(); });
  attempt(code, [&] { output_.frames->finish(); });
  if (tools_.never_steady()) summary_->drop_window();
  last_warnings(code);
  write_run_section(*summary_,
                    {.code = code,
                     .failure = output_.failure,
                     .reached = code == exit_failed ? simulation_.time() : output_.reached,
                     .wall_time = live_.elapsed(),
                     .steps = steps_,
                     .frames = output_.frames->count(),
                     .deepest = physics_.deepest()},
                    s_, request_, world_);
  if (world_.machine) write_events(*summary_, *world_.machine);
  output_.crossings->write(*summary_);
  write_energy(code);
  if (!tools_.progress().tools().empty()) write_tools(*summary_, tools_.progress());
  if (code != exit_failed)
    write_disturbance(*summary_, tools_.progress(), request_.out, s_, tools_.walls().any_reached());
  write_window(*summary_, world_);
  write_inlets(*summary_, world_);
  write_fibres(*summary_, world_, output_.frames->fibre_drag());
  if (world_.bed) write_servos(*summary_, world_, simulation_);
  if (world_.bed) write_wear(*summary_, world_);
  attempt(code, [&] { summary_->write(request_.out / "summary.json"); });
  if (code == exit_ok) checkpoints_.remove();
  if (const std::string means = means_text(*summary_, tools_.progress(), s_); !means.empty() && world_.bed)
    spdlog::info("{}", means.substr(0, means.size() - 1));
  // Others were printed when they were found, perhaps hours ago.
  for (const std::string& text : summary_->warnings())
    if (!printed_.contains(text)) spdlog::warn("warning: {}", text);
  if (const std::size_t all = summary_->warnings().size(); all > 0)
    spdlog::warn("{} warning{} in all: see summary.json", all, all == 1 ? "" : "s");
  if (code == exit_failed) {
    spdlog::error("{}", output_.failure);
    spdlog::error("the run stops here; results up to then are in {}", request_.out.string());
  } else {
    if (!output_.crossings->stopped_by().empty())
      spdlog::info("stopped by `{}` at t = {:.9g} s", output_.crossings->stopped_by(), output_.crossings->stopped_at());
    spdlog::info("{} in {}; results in {}", code == exit_ok ? "done" : "interrupted", clock_text(live_.elapsed()),
                 request_.out.string());
  }
}

void RunLoop::warn_of_missing(const PouredSoil& one) {
  constexpr double shown = 0.01;  // of what was asked for; half a sphere and an interval are always open
  const dem::Inlet& inlet = one.inlet;
  const double asked = inlet.asked(world_.bed->time()), come = inlet.come();
  if (inlet.waited() == 0 || come >= (1 - shown) * asked) return;
  const char* const unit = inlet.plan().counts ? "spheres" : "kg";
  summary_->warn(
      fmt::format("soil.inlets.{}: {:.4g} of {:.4g} {} came: {} times a sphere that was due found no room; make the "
                  "region larger, the velocity higher, or the rate lower",
                  one.name, come, asked, unit, inlet.waited()));
}

void RunLoop::last_warnings(int code) {
  if (world_.bed) warn_of_coarse_contacts();
  if (world_.machine) write_step_error();
  warn_of_machine_energy();
  warn_of_exchange();
  warn_of_open_exchange();
  if (world_.soil.stopped)
    summary_->warn("the run was interrupted while the bed settled: time 0 shows it on its way to rest");
  if (world_.bed && !world_.soil.stopped && world_.bed->has_bonding_laws() && world_.bed->bonds().formed == 0)
    summary_->warn("a law has bonds but none formed: no spheres were within `bond gap` at `bond time`");
  if (world_.bed && code == exit_ok && stayed_awake(s_, *world_.bed))
    summary_->warn(
        "soil.active: no sphere fell asleep and no time was saved: soil is within `within` of a moving surface, or "
        "still "
        "moves; let the bed settle longer, lower `within`, or leave the section out");
  if (world_.moving && world_.moving->window.pushed_out() > 0)
    summary_->warn(
        fmt::format("{} spheres went over the end of the window ahead of the tool and were removed; make the container "
                    "longer there",
                    world_.moving->window.pushed_out()));
  for (const PouredSoil& one : world_.inlets) warn_of_missing(one);
  if (code != exit_ok) return;
  for (const Tool& tool : tools_.progress().tools())
    if (!tool.touched && !is_beam_node(s_.machine, tool.name))  // most of a tine is above the soil
      summary_->warn(
          fmt::format("{} touched no soil in the whole run: see where it starts and how it moves; `subsoil "
                      "check` prints how far it is from the soil",
                      tool.name));
  if (const auto [a, b] = tools_.progress().opposed(); a != nullptr)
    summary_->warn(
        fmt::format("{} and {} travel against each other: `soil.draft` is the sum of their forces along one direction, "
                    "and no specific draft is given; take the draft of each from `tools` in summary.json, or monitor "
                    "`soil force` of each",
                    a->name, b->name));
  for (const Tool& tool : tools_.progress().tools())
    if (tool.travels() && tool.share_out() > most_out_of_soil)
      summary_->warn(
          fmt::format("{} was out of the soil in {:.0f} % of the window of the means: they are of soil and air, and no "
                      "specific draft is given; set output.window to a time in which it works",
                      tool.name, 100 * tool.share_out()));
  for (const Tool& tool : tools_.progress().tools()) {
    if (!tool.travels() || tool.share_out() > most_out_of_soil) continue;
    if (tool.fell_back > 0.5 * tool.gained && tool.fell_back > tool.length() + tool.depth)
      summary_->warn(fmt::format(
          "{} comes back by {:.3g} m in the window of the means, of {:.3g} m that it gained: they add strokes "
          "in both directions; set output.window to one of them",
          tool.name, tool.fell_back, tool.gained));
    else if (tool.share_standing() > most_standing && tool.gained > 0)
      summary_->warn(
          fmt::format("{} has stood still for the last {:.0f} % of the window of the means: they are of work "
                      "and of rest; set output.window to the time in which it works",
                      tool.name, 100 * tool.share_standing()));
  }
  if (tools_.never_steady()) {
    summary_->warn(
        "no tool came to steady work (its length in soil plus its depth of travel): no means; let it travel "
        "farther, or set output.window");
  } else if (!std::isfinite(summary_->window_from()) || !(summary_->window_until() > summary_->window_from())) {
    summary_->warn(
        "the window of the means was never reached, or is shorter than a period of the given motion: means "
        "are null; let it run longer, or set output.window");
  }
}

}  // namespace subsoil::sim
