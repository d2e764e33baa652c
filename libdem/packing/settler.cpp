#include "libdem/packing/settler.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "libdem/laws/friction.hpp"
#include "libdem/particles/rigid_rotation.hpp"

namespace subsoil::dem {
namespace {

constexpr double kRestHeight = 1e-4;  ///< share of the radius that kinetic energy at rest could lift a sphere by
constexpr int kRampSteps = 20;        ///< a twentieth of the attraction at a time moves a sphere by less than its rest
constexpr long kProgressSteps = 100;
/// Share of the weight of the bed that may be unbalanced at rest, while a sphere falls by its radius: stresses by depth
/// are within it.
constexpr double kUnbalanced = 0.01;
constexpr long kLookSteps = 10;     ///< between looks whether the bed is still
constexpr long kDensitySteps = 20;  ///< between looks at the density

// Compaction.
constexpr double kFrictionStep = 0.7;    ///< of the friction of one cycle to the next
constexpr double kLeastFriction = 0.05;  ///< below it the next cycle has none
constexpr double kShaking = 0.5;         ///< amplitude, of gravity
constexpr double kShakingPeriod = 4;     ///< in times of a fall by one radius
constexpr double kShakingPeriods = 10;   ///< of one shaking
constexpr double kAimGain = 0.8;         ///< of what is missing

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

/// Not under a constant torque against rolling: the step reverses it about zero.
bool rotation_comes_to_rest(const LawTable& laws) {
  return std::none_of(laws.laws.begin(), laws.laws.end(), [](const Law& law) {
    const Friction& f = law->friction();
    return f.rolling == Rolling::constant_torque && f.mu_r > 0;
  });
}

}  // namespace

double rest_speed(double mean_radius, double gravity) { return std::sqrt(2 * kRestHeight * gravity * mean_radius); }

Settler::Settler(Bed& bed, const LawTable& laws, const SettlePlan& plan, const Bounds& region)
    : bed_(bed),
      laws_(laws),
      plan_(plan),
      region_(region),
      start_(bed.time()),
      gravity_(norm(bed.options().gravity)),
      rotation_counts_(plan.spins && rotation_comes_to_rest(laws)),
      decide_(plan.from),
      waits_(plan.from != nullptr) {
  plain_gravity_ = bed.options().gravity;
  if (!(plan.step > 0)) throw std::invalid_argument("settling: the step must be positive");
  if (plan.duration && plan.until_speed)
    throw std::invalid_argument("settling: give either a duration or a speed to fall below, not both");
  if (gravity_ == 0 && !plan.duration && !plan.until_speed)
    throw std::invalid_argument(
        "settling: without gravity nothing comes to rest by itself; give a duration or a speed");
  if (plan.staged && gravity_ == 0)
    throw std::invalid_argument("settling in stages needs gravity; without it settle in one stage");
}

void Settler::raise() {
  for (int k = 1; k < kRampSteps && !stopped_; ++k) {
    const double up = static_cast<double>(k) / kRampSteps;
    bed_.set_laws(softened(laws_, up, plan_.lowered + (1 - plan_.lowered) * up));
    run_for(plan_.ramp / kRampSteps, "raising attraction and friction");
  }
  harden();
}

void Settler::finish() {
  if (plan_.duration)
    run_for(*plan_.duration, "settling");
  else
    run_until(plan_.until_speed, "settling", !plan_.until_speed && gravity_ > 0);
}

void Settler::compact(std::optional<double> depth) {
  if (stopped_) return;
  require_room(depth);
  if (plan_.compaction.load != nullptr) press();
  if (plan_.compaction.density) densify();
}

void Settler::cover() {
  if (plan_.cover == nullptr || stopped_) return;
  BedCover::Laid laid;
  laid.first = next_id();
  laid.height = measured([&] { return (laid = plan_.cover->lay(bed_, laid.first)).height; });
  laid.left_out = static_cast<std::size_t>(measured([&] { return static_cast<double>(laid.left_out); }));
  plan_.cover->laid(laid);
  finish();
}

std::uint32_t Settler::next_id() {
  return static_cast<std::uint32_t>(measured([&] {
    std::uint32_t next = 0;
    for (const Sphere& s : bed_.spheres()) next = std::max(next, s.id + 1);
    return static_cast<double>(next);
  }));
}

void Settler::aim_by_what_is_left() { aim_ *= 1 + kAimGain * (*plan_.compaction.density / density() - 1); }

void Settler::press() {
  BedLoad& load = *plan_.compaction.load;
  load.begin(bed_);
  load_ = &load;
  run_until(std::nullopt, "pressing");
  load_ = nullptr;
  load.end(bed_);
  run_until(std::nullopt, "resting after the load");
}

void Settler::require_density() {
  if (!plan_.compaction.density || stopped_) return;
  const double now = density(), target = *plan_.compaction.density;
  if (now < (1 - Compaction::kTolerance) * target) refuse_density(now);
  if (now > (1 + Compaction::kTolerance) * target) refuse_passed(now);
}

void Settler::require_room(std::optional<double> depth) const {
  if (!plan_.compaction.density) return;
  const Bounds& region = plan_.compaction.region;
  const Vec3& period = bed_.options().periodic.length;
  const double diameter = 2 * mean_radius(bed_.spheres());
  refuse_small(depth ? *depth : surface_height(bed_.spheres(), region).mean - region.low.y, diameter, "deep");
  if (!(period.x > 0)) refuse_small(region.high.x - region.low.x, diameter, "long");
  if (!(period.z > 0)) refuse_small(region.high.z - region.low.z, diameter, "wide");
}

void Settler::densify() {
  friction_ = 1;
  const double target = aim_ * *plan_.compaction.density, low = target * (1 - Compaction::kTolerance);
  double now = density();
  const bool first = !loosest_;
  if (first) loosest_ = now;
  if (first && now > *plan_.compaction.density * (1 + Compaction::kTolerance) && !stopped_)
    refuse_density(compacted(now, std::numeric_limits<double>::infinity()));
  now = compacted(now, low);
  if (now < low && !stopped_) refuse_density(now);
}

SettleReport Settler::done() {
  bed_.reset_energy_balance();
  SettleReport out;
  static_cast<BedReport&>(out) = report(bed_, region_);
  out.settled_time = elapsed();
  out.rms_speed = rms_speed(false);
  out.stopped = stopped_;
  return out;
}

double Settler::rms_speed(bool with_spin) const {
  double energy = 0;
  for (const Sphere& s : bed_.spheres()) {
    if (s.kind != SphereKind::free) continue;
    energy += s.m * dot(s.v, s.v);
    if (with_spin) energy += inertia(s) * dot(s.w, s.w);
  }
  for (const Clump& c : bed_.clumps()) {
    const ClumpShape& shape = bed_.clump_shapes()[c.shape];
    energy += shape.mass * dot(c.velocity, c.velocity);
    if (with_spin)
      energy += dot(c.angular_momentum, angular_velocity_of(c.attitude, shape.inertia, c.angular_momentum));
  }
  return mass_ > 0 ? std::sqrt(energy / mass_) : 0;
}

Vec3 Settler::momentum_of_all() const {
  Vec3 momentum;
  for (const Sphere& s : bed_.spheres())
    if (!is_fixed(s)) momentum += s.m * s.v;
  return momentum;
}

void Settler::weigh() {
  mass_ = decide_([&] {
    double mass = 0;
    for (const Sphere& s : bed_.spheres())
      if (!is_fixed(s)) mass += s.m;
    return mass;
  });
  radius_ = decide_([&] { return mean_radius(bed_.spheres()); });
}

bool Settler::is_enough() const { return enough_ && steps_of_run_ % kDensitySteps == 0 && enough_(); }

double Settler::shaking_period() const { return kShakingPeriod * std::sqrt(2 * radius_ / gravity_); }

bool Settler::passed() {
  if (!waits_) return false;
  if (decide_.replaying()) {
    decide_([] { return 0.0; });  // the mark of its end
    return true;
  }
  bed_.restore(plan_.from->bed);
  waits_ = false;
  steps_ = plan_.from->steps, steps_of_run_ = plan_.from->steps_of_run, still_since_ = plan_.from->still_since;
  momentum_before_ = plan_.from->momentum, momentum_time_ = plan_.from->momentum_time;
  if (load_ != nullptr) load_->restore(plan_.from->load);
  return false;
}

double Settler::compacted(double now, double target) {
  while (now < target && friction_ > 0 && !stopped_) {
    friction_ = friction_ * kFrictionStep < kLeastFriction ? 0 : friction_ * kFrictionStep;
    now = cycle(target, false);
  }
  for (double before = 0; now < target && now > before * (1 + 0.2 * Compaction::kTolerance) && !stopped_;)
    before = std::exchange(now, cycle(target, true));
  return now;
}

double Settler::cycle(double target, bool shakes) {
  bed_.set_laws(softened(laws_, 1, friction_));
  if (target < std::numeric_limits<double>::infinity())
    enough_ = [this, target] { return bulk_density(bed_, plan_.compaction.region) >= target; };
  if (shakes) {
    shaking_ = kShaking * gravity_;
    run_for(kShakingPeriods * shaking_period(), "shaking");
    shaking_ = 0;
    bed_.set_gravity(plain_gravity_);
  } else {
    run_until(std::nullopt, "compacting with less friction");
  }
  enough_ = nullptr;
  bed_.freeze();  // else the flow passes the density
  harden();
  run_until(std::nullopt, "resting after compaction");
  return density();
}

void Settler::refuse_density(double densest) const {
  const auto whole = [](double x) { return std::to_string(std::lround(x)); };
  throw std::invalid_argument("the density of " + whole(*plan_.compaction.density) +
                              " kg/m3 is not reached: this bed goes from " + whole(*loosest_) +
                              " kg/m3, poured with all its friction, to " + whole(densest) +
                              " kg/m3, compacted; choose a density between, or change the friction or the sizes of "
                              "the spheres");
}

void Settler::refuse_passed(double now) const {
  const auto whole = [](double x) { return std::to_string(std::lround(x)); };
  throw std::invalid_argument("the density of " + whole(*plan_.compaction.density) +
                              " kg/m3 is passed: level, this bed has " + whole(now) +
                              " kg/m3, and it cannot be made looser; take another seed, or a larger bed, whose "
                              "density one sphere changes less");
}

void Settler::refuse_small(double length, double diameter, const char* direction) {
  const double least = Compaction::kLeastDiameters * diameter;
  if (length >= least) return;
  throw std::invalid_argument(std::string("a density is measured away from floor, surface and walls, in a bed of ") +
                              number(Compaction::kLeastDiameters) + " mean diameters at least, " + number(least) +
                              " m; this bed is " + number(length) + " m " + direction +
                              "; make it larger, its spheres smaller, or its sides periodic");
}

void Settler::keep_if_due() {
  if (!plan_.keep_due || !(stopped_ || plan_.keep_due())) return;
  plan_.keep({decide_.made(), steps_, steps_of_run_, still_since_, momentum_before_, momentum_time_,
              load_ != nullptr ? load_->save() : Archive::Columns{}, bed_.save()});
}

void Settler::step(const char* stage) {
  if (load_ != nullptr) load_->advance(bed_, plan_.step);
  if (shaking_ > 0) {
    const double turned = 2 * M_PI * static_cast<double>(steps_of_run_) * plan_.step / shaking_period();
    bed_.set_gravity(plain_gravity_ + Vec3{shaking_ * std::sin(turned), 0, shaking_ * std::cos(turned)});
  }
  bed_.step(plan_.step);
  ++steps_of_run_;
  if (++steps_ % kProgressSteps == 0 && plan_.progress)
    stopped_ = !plan_.progress({stage, elapsed(), plan_.at_most, rms_speed(false), bed_.spheres().size()});
}

void Settler::run_for(double duration, const char* stage) {
  weigh();
  begin_run();
  if (passed()) return;
  const long steps = std::lround(duration / plan_.step);
  while (steps_of_run_ < steps && !stopped_ && !is_enough()) {
    step(stage);
    keep_if_due();
  }
  if (!stopped_) end_run();
}

// A bed that swings up and down as a whole moves by less than its rest and presses its floor by percents more, and
// less, than it weighs.
bool Settler::carries_weight() {
  const double momentum = dot(momentum_of_all(), bed_.options().gravity) / gravity_, time = bed_.time();
  const double force = (momentum - momentum_before_) / (time - momentum_time_);  // NaN at first
  momentum_before_ = momentum, momentum_time_ = time;
  return std::abs(force) <= kUnbalanced * mass_ * gravity_;
}

void Settler::run_until(std::optional<double> speed, const char* stage, bool balanced) {
  weigh();
  if (radius_ == 0) return;  // there is no sphere
  begin_run();
  if (passed()) return;
  const double limit = speed.value_or(rest_speed(radius_, gravity_));
  // Without gravity nothing falls: then the speed alone decides.
  const double hold = gravity_ > 0 ? std::sqrt(2 * radius_ / gravity_) : 0;
  const double falling = gravity_ > 0 ? std::sqrt(2 * radius_ * gravity_) : std::numeric_limits<double>::infinity();
  while (!stopped_) {
    do step(stage);
    while (!stopped_ && steps_of_run_ % kLookSteps != 0);
    if (stopped_) return keep_if_due();
    const bool with_rotation = !speed && rotation_counts_;
    const double now = rms_speed(with_rotation);
    if (is_enough()) break;
    const bool borne = (load_ == nullptr || load_->holds()) && (!balanced || carries_weight());
    if (!(now < limit && bed_.max_speed() < std::max(falling, limit) && borne))
      still_since_ = bed_.time();
    else if (bed_.time() - still_since_ >= hold)
      break;
    const double used = plan_.compaction.any() ? static_cast<double>(steps_of_run_) * plan_.step : elapsed();
    if (used > plan_.at_most) refuse_motion(stage, now, limit, with_rotation);
    keep_if_due();
  }
  end_run();
}

void Settler::refuse_motion(const char* stage, double now, double limit, bool with_rotation) const {
  const Vec3& g = bed_.options().gravity;
  Vec3 lowest;  // corner of the region
  for (int d = 0; d < 3; ++d) lowest[d] = g[d] > 0 ? region_.high[d] : region_.low[d];
  double turning = 0;
  std::size_t fallen = 0;  // below it by more than a diameter
  for (const Sphere& s : bed_.spheres()) {
    if (is_fixed(s)) continue;
    turning = std::max(turning, s.r * norm(s.w));
    if (gravity_ > 0 && dot(s.x - lowest, g) > 2 * s.r * gravity_) ++fallen;
  }
  if (fallen > 0)
    throw std::runtime_error("settling: after " + number(elapsed()) + " s " + std::to_string(fallen) + " of " +
                             std::to_string(bed_.spheres().size()) +
                             " spheres have fallen below the region to be filled (" + stage +
                             "): a side of it is open. Hold them there until they rest, by a wall that is "
                             "taken away then (`open after settling` of a container) or a surface that closes the gap");
  refuse_sliding(stage, now);
  std::string text =
      "settling: after " + number(elapsed()) + " s the spheres still move at " + number(now) + " m/s rms";
  if (with_rotation) text += " with their rotation, at " + number(rms_speed(false)) + " m/s without";
  text += "; the fastest centre has " + number(bed_.max_speed()) + " m/s";
  if (with_rotation) text += ", the fastest surface turns at " + number(turning) + " m/s";
  if (load_ != nullptr) text += "; " + load_->state();
  throw std::runtime_error(text + " (" + stage + "; at rest means " + number(limit) +
                           " m/s rms); allow more time, raise the speed, or settle for a given duration");
}

void Settler::refuse_sliding(const char* stage, double now) const {
  const Vec3& period = bed_.options().periodic.length;
  const Vec3 momentum = momentum_of_all();
  Vec3 along, down = bed_.options().gravity;
  for (int d = 0; d < 3; ++d)
    if (period[d] > 0) along[d] = momentum[d] / mass_, down[d] = 0;
  const double slope = norm(bed_.options().gravity - down);
  if (!(slope > 0) || norm(along) < 0.7 * now) return;  // half of the kinetic energy
  std::string text = "settling: after " + number(elapsed()) + " s the bed slides as one at " + number(norm(along)) +
                     " m/s along its periodic sides (" + stage + "): gravity pulls with " + number(slope) +
                     " m/s^2 along them";
  if (plan_.staged && plan_.lowered < 1)
    text += ", and friction is lowered to " + number(plan_.lowered) +
            " of its value while the bed settles; give `settle` `lowered: 1`, which keeps all of it";
  else
    text += ", more than friction holds; give more friction or less slope";
  throw std::runtime_error(text);
}

}  // namespace subsoil::dem
