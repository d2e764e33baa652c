#include "libsim/run/stepper.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libsim/run/restart.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {

int use_threads(const Loaded& loaded, int asked) {
  int threads = asked > 0 ? asked : static_cast<int>(loaded.scenario.time.threads);
  if (!loaded.scenario.has_bed() && threads == 0) threads = 1;  // a machine alone has no work for more
  if (threads > 0) omp_set_num_threads(threads);                // of output too
  return threads;
}

coupling::SimulationOptions Stepper::options_of(const Loaded& loaded, const World& world) {
  const bool iterated = loaded.scenario.time.coupling == CouplingWord::iterated;
  return {.soil_step = world.step.soil_step,
          .soil_steps = static_cast<int>(loaded.scenario.time.machine.soil_steps),
          .machine_step = world.step.machine_step,
          .tolerance = iterated ? loaded.scenario.time.coupling_tolerance : 0,
          .most_iterations = static_cast<int>(loaded.scenario.time.coupling_iterations)};
}

Stepper::Stepper(const Loaded& loaded, World world, const SavedRun* saved)
    : loaded_(loaded),
      world_(std::move(world)),
      simulation_(world_.bed.get(), world_.machine.get(), world_.body_surfaces, world_.motions,
                  options_of(loaded, world_)) {
  if (saved != nullptr) sim::restore(*saved, world_, simulation_);
  columns_ = std::make_unique<Columns>(loaded_, world_, simulation_);
  values_.assign(columns_->list().size(), 0.0);
  if (!world_.bed && columns_->has_means()) world_.machine->keep_dense_output();  // means are those of the middle
}

bool Stepper::advance(std::span<StepObserver* const> observers) {
  refresh_machine();
  for (StepObserver* o : observers) o->at_instant();
  const bool spheres_changed = !is_at_end() && bring_soil();
  StepRequest request;
  for (StepObserver* o : observers) o->before_step(spheres_changed, request);
  if (request.stop) return false;
  const bool follows = !is_exact() && columns_->has_history();
  if (!is_exact() && (request.instant || follows)) columns_->take_instant(values_);
  const double t = simulation_.time();
  // Each observer's take() wraps that of the ones behind it.
  const std::function<bool(std::size_t)> take = [&](std::size_t i) {
    if (i == observers.size()) return take_step(request), true;
    bool taken = false;
    return observers[i]->take([&] { taken = take(i + 1); }) && taken;
  };
  if (!take(0)) return false;
  if (!is_exact()) columns_->take_step(values_, request.energies);
  if (follows) columns_->follow(t, values_);
  for (StepObserver* o : observers)
    if (!o->after_step()) return false;
  ++steps_;
  return true;
}

/// No step follows that instant. Soil that came then would be in the summary and in no row.
bool Stepper::is_at_end() const {
  const double past = simulation_.time() - loaded_.scenario.time.end;
  return past >= -close() && past < simulation_.window_length() - close();
}

bool Stepper::bring_soil() {
  const bool advanced = world_.moving && world_.moving->follow(*world_.bed, simulation_);
  const double last_step = has_stepped() ? simulation_.step_length() : 0;
  std::size_t poured = 0;
  for (PouredSoil& one : world_.inlets) poured += one.inlet.pour(*world_.bed, last_step);
  return advanced || poured > 0;
}

double Stepper::close() const {
  constexpr double of_step = 1e-6, of_exact_step = 1e-9;
  return (is_exact() ? of_exact_step : of_step) * simulation_.step_length();
}

void Stepper::take_step(const StepRequest& request) {
  const bool ends_there = !world_.bed && std::isfinite(request.until) && world_.machine->integrator().ends_anywhere();
  if (ends_there) return simulation_.step_to(request.until);
  simulation_.step({.energy = request.energies, .snapshot = request.snapshot, .contacts = request.contacts});
}

void Stepper::refresh_machine() {
  machine_is_fresh_ = world_.machine == nullptr;
  if (world_.bed && steps_ % steps_between_states == 0) refresh_now();
}

void Stepper::refresh_now() {
  machine_is_fresh_ = world_.machine == nullptr;
  if (world_.machine == nullptr) return;
  if (world_.machine->integrator().partition().near_singular()) return;
  // To a state that is its own restoration: joints are closed to rounding after one or two.
  constexpr int most = 4;
  mbd::Snapshot state = world_.machine->snapshot();
  for (int k = 0; k < most && !machine_is_fresh_; ++k) {
    world_.machine->restore(state);
    mbd::Snapshot again = world_.machine->snapshot();
    machine_is_fresh_ = again == state;
    state = std::move(again);
  }
}

void Stepper::note_jump() {
  // Integrators look for jumps where the external wrench has changed; that it is back at its value changes no bit.
  const int body = 1;
  const std::array<double, 3> w = world_.machine->external_wrench(body);
  world_.machine->set_external_wrench(body, w[0] + 1, w[1], w[2]);
  world_.machine->set_external_wrench(body, w[0], w[1], w[2]);
}

void Stepper::restore(const SavedRun& saved, const dem::Bed::Checkpoint* checkpoint) {
  if (world_.moving && saved.moving) world_.moving->window = *saved.moving;
  sim::restore(saved, world_, simulation_, checkpoint);
  // A restoration begins where the machine stands: the second one at the state itself, as in refresh_now().
  if (world_.machine) world_.machine->restore(saved.machine.value());
}

// Fixed spheres meet surfaces that move.
void Stepper::meet_fixed_spheres(int boundary, bool driven) {
  const auto of = [&](const SurfaceRecord& s) { return s.boundary == boundary; };
  const bool moves = std::find_if(world_.surfaces.begin(), world_.surfaces.end(), of)->moves;
  dem::Boundary& surface = world_.bed->boundary(boundary);
  if (surface.meets_fixed == (moves || driven)) return;
  surface.meets_fixed = moves || driven;
  world_.bed->surfaces_changed();
}

void Stepper::set_motion(int boundary, std::function<dem::Pose(double)> pose) {
  meet_fixed_spheres(boundary, pose != nullptr);
  if (const auto found = driven_.find(boundary); found != driven_.end()) {
    Driven& driven = *found->second;
    driven.pose = pose ? std::move(pose) : driven.given;
    if (!has_stepped()) simulation_.restore(simulation_.save());  // which places the surfaces again
    return;
  }
  if (!pose) return;
  const auto of = [&](const coupling::GivenMotion& m) { return m.boundary == boundary; };
  auto motion = std::find_if(world_.motions.begin(), world_.motions.end(), of);
  if (motion == world_.motions.end()) {
    const dem::Pose stands = world_.bed->boundary(boundary).pose;
    motion = world_.motions.insert(motion, {.boundary = boundary, .pose = [stands](double) { return stands; }});
  }
  const auto driven = std::make_shared<Driven>(Driven{std::move(pose), motion->pose});
  driven_[boundary] = driven;
  motion->pose = [driven](double t) { return driven->pose(t); };
  replace_simulation();
}

// The simulation keeps its motions for good; a new one takes over its state, in the same place for the columns.
void Stepper::replace_simulation() {
  const coupling::ExchangeState state = simulation_.save();
  struct Standing {
    dem::Pose pose, before;
    dem::Vec3 velocity, angular_velocity;
  };
  std::vector<Standing> standing;
  for (int b = 0; b < world_.bed->boundary_count(); ++b) {
    const dem::Boundary& is = world_.bed->boundary(b);
    standing.push_back({is.pose, is.pose_before, is.velocity, is.angular_velocity});
  }
  const bool stepped = has_stepped();
  simulation_ = coupling::Simulation(world_.bed.get(), world_.machine.get(), world_.body_surfaces, world_.motions,
                                     options_of(loaded_, world_));
  simulation_.restore(state);
  if (!stepped) return;  // the new motion says how its surface begins
  for (int b = 0; b < world_.bed->boundary_count(); ++b) {
    dem::Boundary& is = world_.bed->boundary(b);
    const Standing& was = standing[static_cast<std::size_t>(b)];
    is.pose = was.pose, is.pose_before = was.before;
    is.velocity = was.velocity, is.angular_velocity = was.angular_velocity;
  }
}

}  // namespace subsoil::sim
