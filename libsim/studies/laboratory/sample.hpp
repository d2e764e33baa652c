#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "libdem/laws/law_table.hpp"
#include "libdem/packing/placement.hpp"
#include "libdem/packing/sizes.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

struct SampleWords;

/// The material under test, as all specimens of it share it: laws, sizes, and how a packing is made. Read only.
struct Sample {
  dem::LawTable laws;                   ///< the scenario's, and a wall without friction and attraction beside them
  int grain = 0, wall = 0, smooth = 0;  ///< materials of `laws`
  double density = 0;                   ///< of a grain, kg/m3
  dem::RadiusDistribution sizes;
  dem::ShareOf shares = dem::ShareOf::number;
  std::vector<dem::ClumpShape> shapes;  ///< of clumps among the grains
  std::vector<dem::ClumpPart> clumps;   ///< by index in `shapes`
  double diameter =
      0;  ///< mean by number, of clumps that of their volume, m; lengths that a test leaves out are multiples of it
  double gravity = 0;  ///< m/s2, along -y
  double safety = 0.8;
  std::optional<double> step;  ///< s, given by the scenario
  std::string simd;
  double speed_limit = 0, overlap_limit = 0;
  double lowered = 0.1, ramp = 0.1, at_most = 10;  ///< SettlePlan's
  std::uint64_t seed = 1;                          ///< of the first packing

  /// Time in which a grain falls by its diameter, sqrt(2 d/g), s, and the speed that goes with it, sqrt(g d), m/s.
  double fall_time() const;
  double fall_speed() const;
};

/// Throws ScenarioError with the place of a contact that cannot be resolved.
Sample make_sample(const Loaded& loaded, const SampleWords& words);

}  // namespace subsoil::sim
