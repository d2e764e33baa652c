#include "libdem/packing/settle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
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
constexpr long kLookSteps = 10;     ///< between looks whether the bed is still
constexpr long kDensitySteps = 20;  ///< between looks at the density

// Compaction.
constexpr double kFrictionStep = 0.7;    ///< of the friction of one cycle to the next
constexpr double kLeastFriction = 0.05;  ///< below it the next cycle has none
constexpr double kShaking = 0.5;         ///< amplitude, of gravity
constexpr double kShakingPeriod = 4;     ///< in times of a fall by one radius
constexpr double kShakingPeriods = 10;   ///< of one shaking
constexpr double kFirstAim = 0.97;       ///< of the density: levelling off changes it by some percent
constexpr double kAimGain = 0.8;         ///< of what is missing
constexpr int kRefills = 8;              ///< of a bed that has sunk below its depth
constexpr double kRoom = 1.1;            ///< from the loosest packing to the densest, 0.58 to 0.64

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

/// Decisions of a settling in their order: those of a state to go on from first, then its own.
class Decisions {
 public:
  explicit Decisions(const SettleState* from) {
    if (from != nullptr) made_ = from->decisions;
  }
  bool replaying() const { return next_ < made_.size(); }
  /// What was decided here; else what `decide` says now.
  template <class Decide>
  double operator()(const Decide& decide) {
    if (!replaying()) made_.push_back(decide());
    return made_[next_++];
  }
  const std::vector<double>& made() const { return made_; }

 private:
  std::vector<double> made_;
  std::size_t next_ = 0;
};

/// Not under a constant torque against rolling: the step reverses it about zero.
bool rotation_comes_to_rest(const LawTable& laws) {
  return std::none_of(laws.laws.begin(), laws.laws.end(), [](const Law& law) {
    const Friction& f = law->friction();
    return f.rolling == Rolling::constant_torque && f.mu_r > 0;
  });
}

/// One settling from its start to its report.
class Settler {
 public:
  Settler(Bed& bed, const LawTable& laws, const SettlePlan& plan, const Bounds& region)
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

  void soften() { bed_.set_laws(softened(laws_, 0, plan_.lowered)); }
  void harden() { bed_.set_laws(laws_); }

  void rain() { run_until(std::nullopt, "raining"); }

  void raise() {
    for (int k = 1; k < kRampSteps && !stopped_; ++k) {
      const double up = static_cast<double>(k) / kRampSteps;
      bed_.set_laws(softened(laws_, up, plan_.lowered + (1 - plan_.lowered) * up));
      run_for(plan_.ramp / kRampSteps, "raising attraction and friction");
    }
    harden();
  }

  void finish() {
    if (plan_.duration)
      run_for(*plan_.duration, "settling");
    else
      run_until(plan_.until_speed, "settling");
  }

  /// Under the load until the bed is still; then without it.
  void press() {
    BedLoad& load = *plan_.compaction.load;
    load.begin(bed_);
    load_ = &load;
    run_until(std::nullopt, "pressing");
    load_ = nullptr;
    load.end(bed_);
    run_until(std::nullopt, "resting after the load");
  }

  bool is_dense() { return density() >= (1 - Compaction::kTolerance) * *plan_.compaction.density; }
  void require_density() {
    if (!plan_.compaction.density || stopped_) return;
    const double now = density(), target = *plan_.compaction.density;
    if (now < (1 - Compaction::kTolerance) * target) refuse_density(now);
    if (now > (1 + Compaction::kTolerance) * target) refuse_passed(now);
  }
  /// A density is measured away from floor, surface and walls. @param depth of the bed at its end, m; or as it lies
  void require_room(std::optional<double> depth) const {
    if (!plan_.compaction.density) return;
    const Bounds& region = plan_.compaction.region;
    const Vec3& period = bed_.options().periodic.length;
    const double diameter = 2 * mean_radius(bed_.spheres());
    refuse_small(depth ? *depth : surface_height(bed_.spheres(), region).mean - region.low.y, diameter, "deep");
    if (!(period.x > 0)) refuse_small(region.high.x - region.low.x, diameter, "long");
    if (!(period.z > 0)) refuse_small(region.high.z - region.low.z, diameter, "wide");
  }

  void aim_at_once() { aim_ = 1; }  ///< nothing is levelled off
  /// Level off and a bed has another density, rougher at its surface: aim so that it is the right one then.
  /// From below, since no bed is made looser.
  void aim_by_what_is_left() { aim_ *= 1 + kAimGain * (*plan_.compaction.density / density() - 1); }

  /// From all the friction down each time: what has been added is as loose as the bed was.
  void densify() {
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

  SettleReport done() {
    bed_.reset_energy_balance();
    SettleReport out;
    static_cast<BedReport&>(out) = report(bed_, region_);
    out.settled_time = elapsed();
    out.rms_speed = rms_speed(false);
    out.stopped = stopped_;
    return out;
  }

  bool stopped() const { return stopped_; }
  /// The bed is not that of the state yet: what is done to it has been done already.
  bool waits() const { return waits_; }

  /// A number that is measured of the bed.
  template <class Measure>
  double measured(const Measure& measure) {
    return decide_(measure);
  }

 private:
  double elapsed() const { return bed_.time() - start_; }
  /// Kinetic energy of the spheres as a speed, m/s; that of their spin included or not.
  double rms_speed(bool with_spin) const {
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

  /// Mass and size of what lies in the bed now; it changes only between runs.
  void weigh() {
    mass_ = decide_([&] {
      double mass = 0;
      for (const Sphere& s : bed_.spheres())
        if (!is_fixed(s)) mass += s.m;
      return mass;
    });
    radius_ = decide_([&] { return mean_radius(bed_.spheres()); });
  }

  /// Whether a run of steps lies behind the state. If it is the one that the state is of, the bed takes its place now.
  bool passed() {
    if (!waits_) return false;
    if (decide_.replaying()) {
      decide_([] { return 0.0; });  // the mark of its end
      return true;
    }
    bed_.restore(plan_.from->bed);
    waits_ = false;
    steps_ = plan_.from->steps, steps_of_run_ = plan_.from->steps_of_run, still_since_ = plan_.from->still_since;
    if (load_ != nullptr) load_->restore(plan_.from->load);
    return false;
  }
  double density() {
    return decide_([&] { return bulk_density(bed_, plan_.compaction.region); });
  }

  /// The density from cycles of ever less friction, then from shaking while that gains anything.
  double compacted(double now, double target) {
    while (now < target && friction_ > 0 && !stopped_) {
      friction_ = friction_ * kFrictionStep < kLeastFriction ? 0 : friction_ * kFrictionStep;
      now = cycle(target, false);
    }
    for (double before = 0; now < target && now > before * (1 + 0.2 * Compaction::kTolerance) && !stopped_;)
      before = std::exchange(now, cycle(target, true));
    return now;
  }

  /// With little friction until the density is reached or nothing moves any more; then at rest with all of it.
  double cycle(double target, bool shakes) {
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
  double shaking_period() const { return kShakingPeriod * std::sqrt(2 * radius_ / gravity_); }
  bool is_enough() const { return enough_ && steps_of_run_ % kDensitySteps == 0 && enough_(); }

  [[noreturn]] void refuse_density(double densest) const {
    const auto whole = [](double x) { return std::to_string(std::lround(x)); };
    throw std::invalid_argument("the density of " + whole(*plan_.compaction.density) +
                                " kg/m3 is not reached: this bed goes from " + whole(*loosest_) +
                                " kg/m3, poured with all its friction, to " + whole(densest) +
                                " kg/m3, compacted; choose a density between, or change the friction or the sizes of "
                                "the spheres");
  }

  [[noreturn]] void refuse_passed(double now) const {
    const auto whole = [](double x) { return std::to_string(std::lround(x)); };
    throw std::invalid_argument("the density of " + whole(*plan_.compaction.density) +
                                " kg/m3 is passed: level, this bed has " + whole(now) +
                                " kg/m3, and it cannot be made looser; take another seed, or a larger bed, whose "
                                "density one sphere changes less");
  }

  static void refuse_small(double length, double diameter, const char* direction) {
    const double least = Compaction::kLeastDiameters * diameter;
    if (length >= least) return;
    throw std::invalid_argument(std::string("a density is measured away from floor, surface and walls, in a bed of ") +
                                number(Compaction::kLeastDiameters) + " mean diameters at least, " + number(least) +
                                " m; this bed is " + number(length) + " m " + direction +
                                "; make it larger, its spheres smaller, or its sides periodic");
  }

  void begin_run() { steps_of_run_ = 0, still_since_ = bed_.time(); }
  void end_run() {
    decide_([] { return 0.0; });
  }
  void keep_if_due() {
    if (!plan_.keep_due || !(stopped_ || plan_.keep_due())) return;
    plan_.keep({decide_.made(), steps_, steps_of_run_, still_since_,
                load_ != nullptr ? load_->save() : std::vector<double>{}, bed_.save()});
  }

  void step(const char* stage) {
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

  void run_for(double duration, const char* stage) {
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

  void run_until(std::optional<double> speed, const char* stage) {
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
      const bool borne = load_ == nullptr || load_->holds();
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

  /// States speeds of centres and of surfaces that turn: either may keep the bed from rest.
  [[noreturn]] void refuse_motion(const char* stage, double now, double limit, bool with_rotation) const {
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
      throw std::runtime_error(
          "settling: after " + number(elapsed()) + " s " + std::to_string(fallen) + " of " +
          std::to_string(bed_.spheres().size()) + " spheres have fallen below the region to be filled (" + stage +
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

  /// Of a bed that slides as one along periodic sides, which no wall ends: most of its motion is that of its mass
  /// centre.
  void refuse_sliding(const char* stage, double now) const {
    const Vec3& period = bed_.options().periodic.length;
    Vec3 momentum;
    double mass = 0;
    for (const Sphere& s : bed_.spheres())
      if (!is_fixed(s)) momentum += s.m * s.v, mass += s.m;
    Vec3 along, down = bed_.options().gravity;
    for (int d = 0; d < 3; ++d)
      if (period[d] > 0) along[d] = momentum[d] / mass, down[d] = 0;
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

  Bed& bed_;
  const LawTable& laws_;
  const SettlePlan& plan_;
  Bounds region_;
  double start_, gravity_;
  bool rotation_counts_;
  double mass_ = 0, radius_ = 0;
  Decisions decide_;
  bool waits_ = false;
  long steps_ = 0, steps_of_run_ = 0;
  double still_since_ = 0;
  bool stopped_ = false;
  // Of compaction.
  BedLoad* load_ = nullptr;  ///< that acts now
  Vec3 plain_gravity_;
  double shaking_ = 0;      ///< m/s2
  double friction_ = 1;     ///< factor of the last cycle
  double aim_ = kFirstAim;  ///< of the density
  std::optional<double> loosest_;
  std::function<bool()> enough_;  ///< ends a run early
};

/// Of each clump, m.
std::vector<double> highest_centres(const Bed& bed) {
  std::vector<double> out(bed.clumps().size(), -std::numeric_limits<double>::infinity());
  if (out.empty()) return out;
  for (const Sphere& s : bed.spheres())
    if (const long clump = bed.clump_of(s); clump >= 0) {
      double& top = out[static_cast<std::size_t>(clump)];
      top = std::max(top, s.x.y);
    }
  return out;
}

/// Height of a cut that takes off all free spheres whose centres lie above it and leaves the mean surface at the
/// target. The surface falls with the cut, by steps as spheres go: bisection ends at the step nearest to the target.
double level_cut(const Bed& bed, const Bounds& region, double target) {
  const std::span<const Sphere> spheres = bed.spheres();
  double low = region.low.y, high = surface_height(spheres, region).highest;
  const std::vector<double> top_of_clump = highest_centres(bed);
  std::vector<Sphere> left;
  for (int k = 0; k < 40; ++k) {
    const double cut = 0.5 * (low + high);
    left.clear();
    for (const Sphere& s : spheres) {
      const long clump = bed.clump_of(s);
      if (is_fixed(s) || (clump < 0 ? s.x.y : top_of_clump[static_cast<std::size_t>(clump)]) <= cut) left.push_back(s);
    }
    (surface_height(left, region).mean > target ? high : low) = cut;
  }
  return low;
}

double highest_top(std::span<const Sphere> spheres, double otherwise) {
  double top = otherwise;
  for (const Sphere& s : spheres) top = std::max(top, s.x.y + s.r);
  return top;
}

/// Solid volume per volume of what was added on top of a surface: overlapping spheres count in full.
double solid_fraction(const Bed& bed, const Bounds& region, std::uint32_t first, double below, double area) {
  double volume = 0;
  for (const Sphere& s : bed.spheres())
    if (s.id >= first) volume += bed.volume_of(s);
  return volume / (area * (surface_height(bed.spheres(), region).mean - below));
}

std::uint32_t next_id(const Bed& bed) {
  std::uint32_t next = 0;
  for (const Sphere& s : bed.spheres()) next = std::max(next, s.id + 1);
  return next;
}

/// Rains spheres until they lie as high as the layer goes, and a diameter more for the shrinking under attraction and
/// the levelling.
void rain_layer(Bed& bed, const LawTable& laws, const Bounds& region, const BedLayer& layer, std::uint64_t seed,
                const std::vector<ClumpPart>& clumps, Settler& settler) {
  LoosePlacer placer(region, layer.radius, layer.shares, seed, layer.of, clumps);
  const Vec3 size = region.high - region.low;
  const double area = size.x * size.z, floor = region.low.y;
  double diameter = least_radius(layer.radius) + largest_radius(layer.radius);
  for (const ClumpPart& part : clumps) diameter = std::max(diameter, 2 * part.reach);
  const int law = laws.of(layer.of.material, layer.of.material);
  const double overlap = law < 0 ? 0 : laws.laws[static_cast<std::size_t>(law)]->rest_overlap();
  // Loose random packing, 0.60 of solid; spheres that rest with an overlap stand as close as smaller ones.
  const double closer = diameter / (diameter - std::clamp(overlap, 0.0, 0.5 * diameter));
  double fraction = 0.60 * closer * closer * closer;
  // Before the first grains only stones may be there, whose width is not that of the columns.
  const auto surface = [&] {
    const std::span<const Sphere> spheres = bed.spheres();
    return (std::all_of(spheres.begin(), spheres.end(), is_fixed) ? surface_height(spheres, region, 2 * diameter)
                                                                  : surface_height(spheres, region))
        .mean;
  };
  const auto first = static_cast<std::uint32_t>(settler.measured([&] { return next_id(bed); }));
  const double below = settler.measured(surface);
  constexpr int attempts = 5;
  for (int k = 0; k < attempts && !settler.stopped(); ++k) {
    const double missing = floor + layer.top + diameter - settler.measured(surface);
    if (missing <= 0.5 * diameter) return;
    const double top = settler.measured([&] { return highest_top(bed.spheres(), floor); });
    const Grains grains = placer.grains_of_volume(fraction * area * missing, top);
    if (!settler.waits()) add(bed, grains);
    settler.rain();
    fraction = settler.measured([&] { return solid_fraction(bed, region, first, below, area); });
  }
}

std::size_t level(Bed& bed, const Bounds& region, double top, Settler& settler) {
  return static_cast<std::size_t>(settler.measured([&] {
    const double cut = level_cut(bed, region, region.low.y + top);
    return static_cast<double>(bed.remove_if([&](const Sphere& s) { return !is_fixed(s) && s.x.y > cut; }));
  }));
}

/// @param depth of the bed at its end, m; left out: as it lies
void compact(Settler& settler, const Compaction& to, std::optional<double> depth = {}) {
  if (settler.stopped()) return;
  settler.require_room(depth);
  if (to.load != nullptr) settler.press();
  if (to.density) settler.densify();
}

/// One layer after the other, each compacted where a load is, onto what lies.
class LayeredRain {
 public:
  LayeredRain(Bed& bed, const LawTable& laws, const RandomFill& fill, const SettlePlan& plan, Settler& settler)
      : bed_(bed), laws_(laws), fill_(fill), plan_(plan), settler_(settler) {}

  /// @param again how often it has been rained and levelled before
  void rain(const std::vector<BedLayer>& layers, std::size_t k, int again = 0) {
    const double below = k == 0 ? 0 : layers[k - 1].top;
    BedLayer room = layers[k];
    if (plan_.compaction.any()) room.top = below + kRoom * (room.top - below);
    for (int n = 0; n < kRefills && !settler_.stopped(); ++n) {
      if (n + again > 0 && plan_.staged) settler_.soften();
      rain_layer(bed_, laws_, fill_.region, room,
                 fill_.seed + k + 1000 * static_cast<std::uint64_t>(n + kRefills * again), fill_.clumps, settler_);
      const bool last = k + 1 == layers.size();
      if (plan_.staged && (last || plan_.compaction.load != nullptr)) settler_.raise();
      if (last) settler_.finish();
      if (plan_.compaction.load != nullptr || last) compact(settler_, plan_.compaction, layers.back().top);
      if (!plan_.compaction.any() || reaches(layers[k].top)) break;
    }
    if (plan_.staged && plan_.compaction.load != nullptr && k + 1 < layers.size()) settler_.soften();
  }

 private:
  bool reaches(double top) {
    return settler_.measured([&] {
      return surface_height(bed_.spheres(), fill_.region).mean >= fill_.region.low.y + top ? 1.0 : 0.0;
    }) > 0;
  }
  Bed& bed_;
  const LawTable& laws_;
  const RandomFill& fill_;
  const SettlePlan& plan_;
  Settler& settler_;
};

void cover(Bed& bed, const SettlePlan& plan, Settler& settler) {
  if (plan.cover == nullptr || settler.stopped()) return;
  BedCover::Laid laid;
  laid.first = static_cast<std::uint32_t>(settler.measured([&] { return next_id(bed); }));
  laid.height = settler.measured([&] { return (laid = plan.cover->lay(bed, laid.first)).height; });
  laid.left_out = static_cast<std::size_t>(settler.measured([&] { return static_cast<double>(laid.left_out); }));
  plan.cover->laid(laid);
  settler.finish();
}

void check_layers(const std::vector<BedLayer>& layers) {
  double below = 0;
  for (const BedLayer& layer : layers) {
    if (!(layer.top - below >= 2 * largest_radius(layer.radius)))
      throw std::invalid_argument(layers.size() == 1
                                      ? "random bed: the depth must be at least a sphere's diameter"
                                      : "random bed: each layer must be at least a sphere's diameter thick");
    below = layer.top;
  }
}

}  // namespace

Law softened(const Law& law, double attraction, double friction) {
  Friction f = law->friction();
  f.mu *= friction;
  f.mu_d *= friction;  // NaN, left out, stays NaN
  f.mu_r *= friction;
  f.mu_t *= friction;
  return law->weakened(attraction)->with_friction(f);
}

LawTable softened(LawTable laws, double attraction, double friction) {
  for (Law& law : laws.laws) law = softened(law, attraction, friction);
  return laws;
}

double rest_speed(double mean_radius, double gravity) { return std::sqrt(2 * kRestHeight * gravity * mean_radius); }

SettleReport settle(Bed& bed, const LawTable& laws, const SettlePlan& plan, const Bounds& region) {
  Settler settler(bed, laws, plan, region);
  if (plan.staged) {
    settler.soften();
    settler.rain();
    settler.raise();
  }
  settler.harden();
  settler.finish();
  settler.aim_at_once();
  compact(settler, plan.compaction);
  settler.require_density();
  cover(bed, plan, settler);
  return settler.done();
}

SettleReport fill_at_random(Bed& bed, const LawTable& laws, const RandomFill& fill, const SettlePlan& plan) {
  if (fill.count.has_value() + fill.depth.has_value() + !fill.layers.empty() != 1)
    throw std::invalid_argument("random bed: give either the number of spheres, the depth to fill, or layers");
  std::vector<BedLayer> layers = fill.layers;
  if (fill.depth) layers = {{.top = *fill.depth, .radius = fill.radius, .shares = fill.shares, .of = fill.of}};
  check_layers(layers);
  Settler settler(bed, laws, plan, fill.region);
  plan.staged ? settler.soften() : settler.harden();
  std::size_t levelled = 0;
  std::vector<std::uint32_t> ends;
  if (fill.count) {
    LoosePlacer placer(fill.region, fill.radius, fill.shares, fill.seed, fill.of, fill.clumps);
    if (plan.from == nullptr) add(bed, placer.grains(*fill.count, highest_top(bed.spheres(), fill.region.low.y)));
    if (plan.staged) settler.rain();
  }
  for (std::size_t k = 0; k < layers.size() && !settler.stopped(); ++k) {
    if (k > 0) levelled += level(bed, fill.region, layers[k - 1].top, settler);
    LayeredRain(bed, laws, fill, plan, settler).rain(layers, k);
    ends.push_back(static_cast<std::uint32_t>(settler.measured([&] { return next_id(bed); })));
  }
  if (fill.count) {
    settler.aim_at_once();
    if (plan.staged) settler.raise();
    settler.finish();
    compact(settler, plan.compaction);
  }
  for (int n = 0; n < kRefills && !layers.empty() && !settler.stopped(); ++n) {
    levelled += level(bed, fill.region, layers.back().top, settler);
    settler.finish();
    if (!plan.compaction.density || settler.stopped() || settler.is_dense()) break;
    settler.aim_by_what_is_left();
    LayeredRain(bed, laws, fill, plan, settler).rain(layers, layers.size() - 1, n + 1);
  }
  settler.require_density();
  cover(bed, plan, settler);
  SettleReport out = settler.done();
  out.levelled = levelled;
  if (!fill.layers.empty()) out.layer_ends = ends;
  return out;
}

}  // namespace subsoil::dem
