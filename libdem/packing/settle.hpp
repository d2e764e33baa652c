#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/bed.hpp"
#include "libdem/packing/layers.hpp"
#include "libdem/packing/measure.hpp"
#include "libdem/packing/placement.hpp"

/// Bringing a bed to rest.
///
/// Cohesive spheres rained down stick where they touch first and make fluff; attraction switched on at zero overlap
/// pulls the bed together by a tenth. Hence in stages: first without attraction and with little friction and rolling
/// resistance, so that the spheres slide into a dense packing at the distance at which their law lets them rest; then
/// all of it comes back in small steps; then the bed settles once more under the law of the run.
namespace subsoil::dem {

/// The law with its attraction, and its friction and rolling resistance, multiplied by a factor each. The rest distance
/// stays: a wet sphere without attraction repels from overlap dc + D on, as with it.
Law softened(const Law& law, double attraction, double friction);
LawTable softened(LawTable laws, double attraction, double friction);

struct SettleProgress {
  const char* stage;  ///< "raining", "raising attraction and friction", "settling"
  double elapsed;     ///< s since settling began
  double at_most;     ///< s
  double rms_speed;   ///< m/s
  std::size_t spheres;
};

/// Unfinished settling, to restart from. What it has decided so far (numbers of steps, of spheres that rained or were
/// levelled off, measured fractions) leads the same calls to the same place again without stepping; there the bed is
/// put in.
struct SettleState {
  std::vector<double> decisions;
  long steps = 0;          ///< of all stages
  long steps_of_run = 0;   ///< of the stage under way
  double still_since = 0;  ///< s at which the bed was last not still
  /// Along gravity at the last look (kg m/s), and when that was (s); NaN before the first.
  double momentum = 0, momentum_time = 0;
  Archive::Columns load;  ///< BedLoad::save, of one that acts
  Bed::State bed;
  /// All but the bed.
  void archive(Archive& a) {
    a("decisions", decisions)("steps", steps)("steps of run", steps_of_run)("still since", still_since);
    a("momentum", momentum)("momentum time", momentum_time);
    std::vector<std::string> names;
    for (const auto& [name, column] : load) names.push_back(name);
    a("of load", names);
    for (const std::string& name : names) a("load", load[name]);
  }
};

/// What presses on a bed from above while it is compacted.
class BedLoad {
 public:
  virtual ~BedLoad() = default;
  virtual void begin(Bed& bed) = 0;               ///< stands above the spheres
  virtual void advance(Bed& bed, double dt) = 0;  ///< to where it acts in the next step
  virtual bool holds() const = 0;                 ///< the spheres bear it
  virtual std::string state() const = 0;          ///< what they bear now, for a refusal
  virtual void end(Bed& bed) = 0;                 ///< acts on nothing
  virtual Archive::Columns save() const = 0;
  virtual void restore(const Archive::Columns& saved) = 0;
};

/// What a bed is compacted to once it lies: a density or a load.
///
/// To a density a bed is poured as loose as it gets, with all its friction. Friction is then lowered step by step: the
/// spheres slide closer until the density is reached or they rest, and all friction comes back. Where no friction is
/// left, horizontal shaking follows. Either way the whole depth is compacted alike; a plate packs the surface most.
/// A load is applied under the final laws, held until the bed is still, and taken off; layer by layer where the bed has
/// layers.
struct Compaction {
  std::optional<double> density;  ///< kg/m3, bulk_density() over `region`
  Bounds region{};
  BedLoad* load = nullptr;
  static constexpr double kTolerance = 0.005;  ///< of the density: half of what one more seed changes
  /// Of depth, and of width between walls, to measure a density: a window of five, and one more of the levelled
  /// surface.
  static constexpr double kLeastDiameters = 7;
  bool any() const { return density || load != nullptr; }
};

/// What is laid on a bed once it lies. The bed then comes to rest again, under the final laws.
class BedCover {
 public:
  struct Laid {
    std::uint32_t first = 0;   ///< number of its first sphere
    double height = 0;         ///< m, world y, to which it reaches
    std::size_t left_out = 0;  ///< spheres of the bed that were in its place
  };
  virtual ~BedCover() = default;
  /// Adds spheres with numbers from `first` on.
  virtual Laid lay(Bed& bed, std::uint32_t first) = 0;
  /// Before the bed comes to rest under it; of a settling that is continued, without `lay`.
  virtual void laid(const Laid& what) = 0;
};

struct SettlePlan {
  double step = 0;                    ///< s; stable for the final laws
  std::optional<double> duration;     ///< s of settling under the final laws; or
  std::optional<double> until_speed;  ///< m/s, rms, under the final laws; neither: until at rest (below)
  double at_most = 5;                 ///< s until at rest, from the start over all stages; longer is an error
  bool staged = false;
  double lowered = 0.1;     ///< factor on friction and rolling resistance before they are raised
  double ramp = 0.1;        ///< s over which attraction, friction and rolling resistance come back
  Compaction compaction{};  ///< `at_most` then holds for each of its stages by itself
  BedCover* cover = nullptr;
  /// Whether angular velocity counts in "at rest". A sphere that turns about the normal of its only contact is braked
  /// by nothing but torsion, which few laws have; one such sphere in a small bed keeps it from rest. It never counts
  /// where a law's rolling resistance is a constant torque: that reverses in every step about zero and ends no
  /// rotation.
  bool spins = true;
  /// Called every hundred steps; false ends the settling early (SettleReport::stopped).
  std::function<bool(const SettleProgress&)> progress;
  /// Asked between steps; true hands the state to `keep`, and so does an end by `progress`. Both or neither.
  std::function<bool()> keep_due;
  std::function<void(const SettleState&)> keep;
  /// Continues from here, with the same bed, laws and plan, and ends with the same bits; null: from the start.
  const SettleState* from = nullptr;
};

struct SettleReport : BedReport {
  double settled_time = 0;                ///< s that settling took
  double rms_speed = 0;                   ///< m/s at its end
  std::size_t levelled = 0;               ///< spheres taken off to level the surface and the interfaces of layers
  std::vector<std::uint32_t> layer_ends;  ///< of a layered fill: first id above those of each layer
  bool stopped = false;                   ///< by the progress callback
};

/// Speed below which a bed counts as at rest, m/s: the mean kinetic energy of a sphere, with rotation, could lift it by
/// no more than a ten-thousandth of its radius, v^2/2 = g r/10^4 (4.4 mm/s at 10 mm). Zero without gravity.
double rest_speed(double mean_radius, double gravity);

/// Runs the bed until it is still; boundaries stand. A speed must hold for sqrt(2 r/g), the time of a fall by one
/// radius, in which no sphere may become faster than that fall makes it: otherwise a bed would be "at rest" when it is
/// released, or while one sphere falls. Without a speed given, the bed's momentum along gravity must change by no more
/// than 1 % of its weight meanwhile. Leaves the final laws in the bed, its velocities as they are, and restarts its
/// energy balance, since exchanging laws is no work of anything. Throws std::invalid_argument for a plan without sense
/// and std::runtime_error when the bed is not still in time.
SettleReport settle(Bed& bed, const LawTable& laws, const SettlePlan& plan, const Bounds& region);

/// A random bed: this many spheres, or as many as fill the region's floor up to `depth`.
struct RandomFill {
  Bounds region;
  RadiusDistribution radius = EqualRadius{};
  ShareOf shares = ShareOf::number;
  BedMaterial of;
  std::uint64_t seed = 1;
  std::vector<ClumpPart> clumps{};  ///< among the grains; those of layers stand there
  std::optional<std::size_t> count;
  std::optional<double> depth;  ///< m, of the mean surface over the region's floor after settling
  /// From below, in place of radius, shares, of, count and depth; the highest ends at the depth.
  std::vector<BedLayer> layers;
};

/// Rains the spheres into the bed's boundaries and settles them. For a depth: as many spheres as a loose random packing
/// needs, more according to the solid fraction measured once they lie, then what stands above is levelled off, so that
/// the mean surface is at the depth, and the bed settles once more. A bed that is compacted is rained a tenth higher,
/// and again where that was not enough. Layers rain one after the other, each onto the one below when that has come to
/// rest and is levelled: raining all at once would give interfaces as steep as the heap.
SettleReport fill_at_random(Bed& bed, const LawTable& laws, const RandomFill& fill, const SettlePlan& plan);

}  // namespace subsoil::dem
