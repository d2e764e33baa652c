#include "libsim/run/physics_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libdem/particles/fixed.hpp"
#include "libdem/step/stability.hpp"
#include "libsim/run/deepest_contact.hpp"
#include "libsim/setup/container.hpp"

namespace subsoil::sim {
namespace {

/// Energy of spheres that all move by a few roundings of their coordinates within a step, J. Springs of contacts that
/// touch by rounding hold less: a stable step has k dt^2 < m.
double energy_of_rounding(const World& world, double mass) {
  constexpr double few = 16;
  double farthest = 0;
  for (const dem::Sphere& s : world.bed->spheres())
    for (int d = 0; d < 3; ++d) farthest = std::max(farthest, std::abs(s.x[d]) + s.r);
  const double speed = few * std::numeric_limits<double>::epsilon() * farthest / world.step.soil_step;
  return 0.5 * mass * speed * speed;
}

}  // namespace

PhysicsWatch::PhysicsWatch(const Scenario& scenario, const World& world) : s_(scenario) {
  if (!world.bed) return;
  double radius = 0;
  smallest_ = std::numeric_limits<double>::infinity();
  for (const dem::Sphere& s : world.bed->spheres()) {
    (dem::is_fixed(s) ? fixed_mass_ : mass_) += s.m, radius = std::max(radius, s.r);
    smallest_ = std::min(smallest_, s.r);
  }
  for (const PouredSoil& poured : world.inlets) smallest_ = std::min(smallest_, poured.inlet.smallest_radius());
  weight_times_radius_ = mass_ * dem::norm(scenario.gravity) * radius;
  rounding_ = energy_of_rounding(world, mass_);
  for (int b = 0; b < world.bed->boundary_count(); ++b) {
    const double far = dem::bounds(world.bed->boundary(b).shape).farthest(Vec3{});
    farthest_.push_back(std::isfinite(far) ? far : 0);
  }
}

std::pair<const dem::Boundary*, double> PhysicsWatch::fastest_surface(const World& world) const {
  std::pair<const dem::Boundary*, double> fastest{nullptr, 0};
  for (int b = 0; b < world.bed->boundary_count(); ++b) {
    const dem::Boundary& boundary = world.bed->boundary(b);
    if (!boundary.active) continue;
    const double speed =
        dem::norm(boundary.velocity) + dem::norm(boundary.angular_velocity) * farthest_[static_cast<std::size_t>(b)];
    if (speed > fastest.second) fastest = {&boundary, speed};
  }
  return fastest;
}

std::optional<PhysicsWatch::Finding> PhysicsWatch::start(const World& world) const {
  const double stored = world.bed->energy().stored;
  if (!(weight_times_radius_ > 0) || !(stored > begins_pressed * weight_times_radius_)) return std::nullopt;
  const auto& bed = *s_.soil->bed;
  const bool lattice = bed.fill == Fill::lattice;
  return Finding{fmt::format(
      "the bed begins with {:.3g} J in its contacts, {:.2g} times what lifts all spheres by a radius: they overlap and "
      "will fly apart; {}",
      stored, stored / weight_times_radius_,
      lattice && bed.jitter > 0
          ? fmt::format("give a `soil.bed.pitch` of {:.2g} radii or more, or less jitter", 2 + 2 * bed.jitter)
      : lattice ? "give a larger `soil.bed.pitch`, or keep surfaces away from it"
                : "place spheres and surfaces farther apart, or let the bed settle")};
}

std::optional<PhysicsWatch::Finding> PhysicsWatch::energy(const World& world, const EnergyStart& start) {
  const dem::BedEnergy& e = world.bed->energy();
  const double off = e.total() - e.work() - start.bed;
  // What leapfrog calls kinetic falls below zero where a contact turns round, and what an attraction stores is
  // negative.
  const double moving = std::max(e.kinetic, 0.0) + std::max(e.rotational, 0.0);
  most_present_ = std::max(most_present_, moving + std::abs(e.stored) - std::abs(off));  // not what came from nothing
  const double moved = std::abs(e.boundary_work) + std::abs(e.force_work) + std::abs(start.bed_gravity - e.gravity) +
                       moving + std::abs(e.lost.total()) + std::abs(e.removed) + e.frozen;
  // What meets spheres at rest with speed v is off by k (v dt)^2/2 in a contact's first step, when there is no more
  // energy than that; with dt = share 2 (m/k)^(1/2) that is 2 m (share v)^2, and not said.
  const double share = world.step.soil_step / world.step.limit.step, speed = share * fastest_surface(world).second;
  const double begins = 2 * (mass_ + fixed_mass_) * speed * speed / closure_said;
  const double scale = std::max(moved, most_present_) + weight_times_radius_ + rounding_ + begins;
  if (!(std::abs(off) > closure_said * scale)) return std::nullopt;
  const bool stops = std::abs(off) > s_.limits.soil_energy * scale;
  if (said_closure_ && !stops) return std::nullopt;
  said_closure_ = true;
  return Finding{
      fmt::format("the energy balance of the soil is off by {:.3g} J, {:.2g} of the {:.3g} J there or moved{}; "
                  "contacts are not resolved{}",
                  off, std::abs(off) / scale, scale,
                  stops ? fmt::format(", above limits.soil energy = {:g}", s_.limits.soil_energy) : "",
                  s_.output.sample_losses_every > 1
                      ? ", or samples of the losses miss too much: leave out `output.sample losses every`"
                  : s_.time.soil_step ? ": leave out `time.soil step`, or shorten it"
                                      : ": give a smaller `time.accuracy`"),
      stops};
}

std::optional<PhysicsWatch::Finding> PhysicsWatch::travel(const World& world) {
  const auto [worst, speed] = fastest_surface(world);
  const double most = speed * world.step.soil_step;
  if (worst == nullptr || !(most > travel_said * smallest_)) return std::nullopt;
  const bool stops = most > travel_stops * smallest_;
  if (said_travel_ && !stops) return std::nullopt;
  said_travel_ = true;
  return Finding{fmt::format("`{}` moves by {:.3g} mm in a step, {:.2g} of the smallest radius{}; give a smaller "
                             "`time.soil step`: {:.2g} s keeps it below a tenth",
                             worst->name, most * 1e3, most / smallest_, stops ? ": it steps over spheres" : "",
                             travel_said * smallest_ / most * world.step.soil_step),
                 stops};
}

namespace {

double stable_step(const PossibleImpact& impact, const dem::StepQuestion& question) {
  return (impact.at_surface ? dem::stable_step_at_surface(impact.law, question)
                            : dem::stable_step(impact.law, question))
      .step;
}

}  // namespace

/// Laws whose stiffness rises with the overlap are stable with shorter steps where bodies meet faster.
std::optional<PhysicsWatch::Finding> PhysicsWatch::step(const World& world, double fastest) {
  if (said_step_ || !(fastest > world.step.expected_speed)) return std::nullopt;
  for (const PossibleImpact& impact : world.step.impacts) {
    dem::StepQuestion question = impact.question;
    question.speed = fastest;
    const double limit = stable_step(impact, question);
    if (world.step.soil_step < limit) continue;
    said_step_ = true;
    return Finding{
        fmt::format("a sphere has {:.3g} m/s, more than the {:.3g} m/s expected: at that speed the step of "
                    "{:.3g} s is no longer stable between {} (limit {:.3g} s); give a smaller `time.soil step`",
                    fastest, world.step.expected_speed, world.step.soil_step, impact.between, limit)};
  }
  return std::nullopt;
}

/// And where a load presses them deeper than an impact does. Which contact it is, is looked for only where one of the
/// smallest spheres could be it.
std::optional<PhysicsWatch::Finding> PhysicsWatch::pressed(const World& world, double deepest) {
  if (said_pressed_ || world.bed->engine_name() != nullptr) return std::nullopt;
  const auto limit_at = [](const PossibleImpact& impact, double radius, double share) {
    dem::StepQuestion question = impact.question;
    question.smallest_radius = radius, question.overlap = share * radius;
    return stable_step(impact, question);
  };
  const auto possible = [&](const PossibleImpact& impact) {
    return world.step.soil_step >= limit_at(impact, impact.question.smallest_radius, deepest);
  };
  if (std::none_of(world.step.impacts.begin(), world.step.impacts.end(), possible)) return std::nullopt;
  const auto spheres = world.bed->spheres();
  const std::uint32_t id = world.bed->deepest_sphere();
  const auto sphere = std::find_if(spheres.begin(), spheres.end(), [&](const dem::Sphere& s) { return s.id == id; });
  const DeepestContact contact = deepest_contact(*sphere, world);
  for (PossibleImpact impact : world.step.impacts) {
    const auto joins = [&](int a, int b) { return sphere->material == a && contact.material == b; };
    if (impact.at_surface != contact.at_surface ||
        !(joins(impact.material, impact.other) || (!contact.at_surface && joins(impact.other, impact.material))))
      continue;
    impact.question.neighbours = contact.contacts;
    const double share = contact.overlap / contact.smaller_radius;
    const double limit = limit_at(impact, contact.smaller_radius, share);
    if (world.step.soil_step < limit) continue;
    said_pressed_ = true;
    return Finding{
        fmt::format("sphere {} is pressed {:.2g} of a radius into {}, deeper than by an impact at the {:.3g} "
                    "m/s expected: the stable step there, {:.3g} s, is below the step of {:.3g} s, and forces "
                    "may be wrong; give a smaller `time.soil step`, or a stiffer law between {}",
                    id, share, contact.other, world.step.expected_speed, limit, world.step.soil_step, impact.between)};
  }
  return std::nullopt;
}

std::optional<PhysicsWatch::Finding> PhysicsWatch::walls(const World& world) {
  if (said_outside_) return std::nullopt;
  if (!s_.soil || !s_.soil->container) return std::nullopt;
  Faces closed, open{};  // what left through an open side may fall below the floor
  for (std::size_t f = 0; f < closed.size(); ++f)
    closed[f] = !s_.soil->container->open[f] && !s_.soil->container->open_after_settling[f];
  for (const std::size_t f : {0u, 1u, 4u, 5u}) open[f] = !closed[f];
  const std::size_t count = spheres_beyond(closed, s_, world, open);
  if (count == 0) return std::nullopt;
  said_outside_ = true;
  return Finding{fmt::format(
      "{} sphere{} beyond a wall of the container: pressed through it, fallen over its rim or placed there; make the "
      "container higher or its contacts stiffer",
      count, count == 1 ? " is" : "s are")};
}

std::vector<PhysicsWatch::Finding> PhysicsWatch::look(const World& world, const EnergyStart& start, double fastest,
                                                      double deepest) {
  std::vector<Finding> found;
  if (world.bed->spheres().empty()) return found;
  const auto take = [&](std::optional<Finding> one) {
    if (one) found.push_back(std::move(*one));
  };
  take(energy(world, start));
  take(travel(world));
  take(step(world, fastest));
  take(pressed(world, deepest));
  constexpr long every = 20;  // a look at the walls goes through all spheres
  if (looks_++ % every == 0) take(walls(world));
  return found;
}

}  // namespace subsoil::sim
