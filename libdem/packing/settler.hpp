#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "libdem/packing/settle.hpp"

/// The stages of a settling: to rain, raise the laws, come to rest, press, compact. `settle` and `fill_at_random` are
/// made of them; nothing else includes this header.
namespace subsoil::dem {

/// Decisions of a settling in their order: those of a state to continue from first, then its own.
class Decisions {
 public:
  explicit Decisions(const SettleState* from) {
    if (from != nullptr) made_ = from->decisions;
  }
  bool replaying() const { return next_ < made_.size(); }
  /// What was decided here; else what `decide` returns now.
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

/// One settling from its start to its report.
class Settler {
 public:
  Settler(Bed& bed, const LawTable& laws, const SettlePlan& plan, const Bounds& region);

  void soften() { bed_.set_laws(softened(laws_, 0, plan_.lowered)); }
  void harden() { bed_.set_laws(laws_); }

  void rain() { run_until(std::nullopt, "raining"); }
  void raise();
  void finish();
  /// To the load and the density of the plan. @param depth of the bed at its end, m; left out: as it lies
  void compact(std::optional<double> depth = {});
  /// Lays what the plan lays on the bed, which comes to rest again.
  void cover();

  bool is_dense() { return density() >= (1 - Compaction::kTolerance) * *plan_.compaction.density; }
  void require_density();
  void aim_at_once() { aim_ = 1; }  ///< nothing is levelled off
  /// Level off and a bed has another density, rougher at its surface: aim so that it is the right one then.
  /// From below, since no bed is made looser.
  void aim_by_what_is_left();

  SettleReport done();

  bool stopped() const { return stopped_; }
  /// The bed is not that of the state yet: what is done to it has been done already.
  bool waits() const { return waits_; }

  /// A number that is measured of the bed.
  template <class Measure>
  double measured(const Measure& measure) {
    return decide_(measure);
  }
  /// Number that the next sphere takes.
  std::uint32_t next_id();

 private:
  double elapsed() const { return bed_.time() - start_; }
  /// Kinetic energy of the spheres as a speed, m/s; that of their rotation included or not.
  double rms_speed(bool with_spin) const;

  /// Mass and size of what lies in the bed now; it changes only between runs.
  void weigh();

  /// Whether a run of steps lies behind the state. If it is the one that the state is of, the bed takes its place now.
  bool passed();
  double density() {
    return decide_([&] { return bulk_density(bed_, plan_.compaction.region); });
  }

  /// The density from cycles of ever less friction, then from shaking while that gains anything.
  double compacted(double now, double target);

  /// With little friction until the density is reached or nothing moves any more; then at rest with all of it.
  double cycle(double target, bool shakes);
  double shaking_period() const;
  bool is_enough() const;
  /// Under the load until the bed is still; then without it.
  void press();
  /// From all the friction down each time: what has been added is as loose as the bed was.
  void densify();
  /// A density is measured away from floor, surface and walls. @param depth of the bed at its end, m; or as it lies
  void require_room(std::optional<double> depth) const;

  [[noreturn]] void refuse_density(double densest) const;
  [[noreturn]] void refuse_passed(double now) const;
  static void refuse_small(double length, double diameter, const char* direction);

  void begin_run() {
    steps_of_run_ = 0, still_since_ = bed_.time();
    momentum_time_ = std::numeric_limits<double>::quiet_NaN();
  }
  void end_run() {
    decide_([] { return 0.0; });
  }
  void keep_if_due();
  void step(const char* stage);
  void run_for(double duration, const char* stage);
  /// @param balanced the bed is at rest only where it presses the floor by its weight
  void run_until(std::optional<double> speed, const char* stage, bool balanced = false);
  Vec3 momentum_of_all() const;
  /// Whether the bed has been borne by its weight since the last look.
  bool carries_weight();

  /// States speeds of centres and of surfaces that turn: either may keep the bed from rest.
  [[noreturn]] void refuse_motion(const char* stage, double now, double limit, bool with_rotation) const;

  /// Of a bed that slides as one along periodic sides, which no wall ends: most of its motion is that of its mass
  /// centre.
  void refuse_sliding(const char* stage, double now) const;

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
  double momentum_before_ = 0, momentum_time_ = 0;  ///< along gravity, at the last look
  bool stopped_ = false;
  // Of compaction.
  BedLoad* load_ = nullptr;  ///< that acts now
  Vec3 plain_gravity_;
  double shaking_ = 0;   ///< m/s2
  double friction_ = 1;  ///< factor of the last cycle
  double aim_ = 0.97;    ///< of the density: levelling off changes it by some percent
  std::optional<double> loosest_;
  std::function<bool()> enough_;  ///< ends a run early
};

}  // namespace subsoil::dem
