#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/packing/carried_soil.hpp"
#include "libdem/packing/placement.hpp"
#include "libdem/packing/sizes.hpp"

/// Spheres and clumps that are poured into a bed while it steps.
namespace subsoil::dem {

/// Flat and round; centres lie in its plane.
struct InletDisk {
  Vec3 centre;           ///< m
  Vec3 normal{0, 1, 0};  ///< of any length
  double radius = 0;     ///< m
};

struct InletPlan {
  std::variant<Bounds, InletDisk> region;  ///< that holds the grains when they come
  RadiusDistribution radius = EqualRadius{};
  ShareOf shares = ShareOf::number;
  BedMaterial of;
  std::uint64_t seed = 1;
  double rate = 0;                                         ///< kg/s, or grains per second
  bool counts = false;                                     ///< the rate is one of grains
  double from = 0;                                         ///< s, at which it opens
  double until = std::numeric_limits<double>::infinity();  ///< s, at which it closes
  Vec3 velocity;                                           ///< m/s, when they come
  double interval = 0;                                     ///< s, between times at which grains come
  std::uint32_t first_id = 0, id_step = 1;                 ///< grain k has the number first_id + k id_step
  std::vector<ClumpPart> clumps{};                         ///< among the grains, each in an attitude of its own
  std::vector<ClumpShape> shapes{};                        ///< of the bed, which they name
};

/// A sphere or a clump in the order of an inlet.
struct InletGrain {
  Sphere body;            ///< of a clump: number, mass and material, and as radius its reach
  int shape = -1;         ///< of a clump; -1: it is a sphere
  Quaternion attitude{};  ///< of a clump: principal axes to world axes
  /// It, or the spheres of the clump, where the body is. The first has its number, the others follow.
  std::vector<Sphere> spheres(const std::vector<ClumpShape>& shapes) const;
};

/// What a restart needs of an inlet beside its plan.
struct InletState {
  CarriedSoil poured;
  double interval = 0;     ///< of the plan, s: another run's may differ, and turns are counted in it
  std::int64_t turn = -1;  ///< last interval in which grains came or should have
  std::uint32_t first_id = 0;
  std::uint64_t waited = 0;  ///< intervals in which a grain that was due found no room
  void archive(Archive& a) {
    a("poured", poured)("interval", interval)("turn", turn)("first id", first_id)("waited", waited);
  }
};

/// Pours grains at a rate: grain k is due when half of it and all before it make the rate times the time since the
/// inlet opened. Those that are due come between two steps, at the end of an interval, anywhere in the region where
/// they touch nothing, with the velocity given. Where there is no room the grain waits, and those behind it.
///
/// Shapes, radii and attitudes are those of one stream of random numbers, in the order of the grains; places are those
/// of one stream an interval. So a grain that waits keeps its size and attitude, neither depends on what happens in the
/// bed, and a restart needs no state of a generator. An attitude drawn again for each place that is tried lost: in a
/// region that fills up, grains that stand upright find room more easily. Spheres of a reserve that lie parked until
/// they are due lost: every step and every file would carry them, and a bed grows between two steps as it does
/// (Bed::insert).
class Inlet {
 public:
  /// Throws std::invalid_argument for a plan without sense.
  explicit Inlet(InletPlan plan);

  /// Grains that are due at the bed's time come; how many. @param last_step that led there, s; 0: none did
  std::size_t pour(Bed& bed, double last_step);
  /// All grains that are due by a time, however many have come; without places.
  std::vector<InletGrain> due_by(double time) const;
  /// What the rate asks for by a time, kg or grains.
  double asked(double time) const;
  /// What of it has come.
  double come() const { return plan_.counts ? static_cast<double>(state_.poured.spheres) : state_.poured.mass; }

  const InletPlan& plan() const { return plan_; }
  double smallest_radius() const;  ///< of all spheres that it pours, those of clumps included, m
  const CarriedSoil& poured() const { return state_.poured; }
  std::uint64_t waited() const { return state_.waited; }
  const InletState& state() const { return state_; }
  /// Continues as the inlet that wrote the state, with its interval and numbers, so that the same grains come at the
  /// same times and places.
  void restore(const InletState& state);

 private:
  /// Grains in their order, without places.
  class Stream {
   public:
    explicit Stream(const InletPlan& plan);
    const InletGrain& next() const { return next_; }
    double before() const { return mass_; }  ///< mass of all that came before it, kg
    std::uint32_t number() const { return number_; }
    void pass();

   private:
    void draw();
    RadiusSampler sampler_;
    RandomNumbers random_;
    BedMaterial of_;
    std::vector<ClumpPart> clumps_;
    std::vector<double> masses_;  ///< of their shapes, kg
    std::uint32_t first_id_, id_step_, number_ = 0;
    double mass_ = 0;
    InletGrain next_{};
  };
  bool is_due(const Stream& stream, double asked) const;

  InletPlan plan_;
  InletState state_;
  std::optional<Stream> stream_;  ///< at the grain that comes next
};

}  // namespace subsoil::dem
