#include "libsim/studies/laboratory/sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libdem/packing/settle.hpp"
#include "libdem/step/stability.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/soil.hpp"
#include "libsim/studies/laboratory/tests.hpp"

namespace subsoil::sim {
namespace {

/// The table with one more material, a wall that pushes as `wall` does, without friction and attraction.
dem::LawTable with_smooth_wall(const dem::LawTable& table, int grain, int wall) {
  dem::LawTable out;
  out.materials = table.materials + 1;
  out.laws = table.laws;
  out.index.assign(static_cast<std::size_t>(out.materials * out.materials), -1);
  const auto at = [&](int a, int b) -> int& { return out.index[static_cast<std::size_t>(a * out.materials + b)]; };
  for (int a = 0; a < table.materials; ++a)
    for (int b = 0; b < table.materials; ++b) at(a, b) = table.of(a, b);
  const dem::Law& rough = table.laws[static_cast<std::size_t>(table.of(grain, wall))];
  at(grain, table.materials) = at(table.materials, grain) = static_cast<int>(out.laws.size());
  out.laws.push_back(dem::softened(rough, 0, 0));
  return out;
}

/// A law whose attraction wins over its repulsion is refused where it stands.
void refuse_collapse(const Loaded& loaded, const Sample& sample, int other) {
  const int index = sample.laws.of(sample.grain, other);
  const double radius = dem::least_radius(sample.sizes);
  try {
    const dem::StepQuestion question{.smallest_radius = radius,
                                     .largest_radius = dem::largest_radius(sample.sizes),
                                     .density = sample.density,
                                     .speed = 1,
                                     .neighbours = 12};
    const dem::Law& law = sample.laws.laws[static_cast<std::size_t>(index)];
    other == sample.grain ? dem::stable_step(law, question) : dem::stable_step_at_surface(law, question);
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(loaded.where(fmt::format("contacts[{}].law", index)) + ": " + error.what());
  }
}

/// By drawing: right for every distribution, and the same everywhere.
double mean_diameter(const dem::RadiusDistribution& sizes, dem::ShareOf shares) {
  if (const auto* equal = std::get_if<dem::EqualRadius>(&sizes)) return 2 * equal->radius;
  const dem::RadiusSampler sampler(sizes, shares);
  dem::RandomNumbers random(1);
  constexpr int draws = 20000;
  double sum = 0;
  for (int i = 0; i < draws; ++i) sum += sampler.draw(random);
  return 2 * sum / draws;
}

/// Clumps of the bed, as parts of the grains.
void add_clumps(Sample& sample, const Loaded& loaded, const SampleWords& words) {
  for (const ClumpSection& c : words.shapes) {
    try {
      sample.shapes.push_back(clump_shape_of(c, c.density.value_or(sample.density)));
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded.where("soil.clumps." + c.name) + ": " + error.what());
    }
  }
  double spheres = 1, diameter = 0;
  for (const ClumpShare& c : words.clumps) {
    const auto shape = std::find_if(sample.shapes.begin(), sample.shapes.end(),
                                    [&](const dem::ClumpShape& s) { return s.name == c.shape; });
    sample.clumps.push_back({static_cast<int>(shape - sample.shapes.begin()), c.share, shape->reach, shape->volume});
    spheres -= c.share, diameter += c.share * 2 * std::cbrt(shape->volume / dem::sphere_volume(1));
  }
  if (only_clumps(words.clumps))
    sample.sizes = dem::EqualRadius{sample.shapes.front().members.front().radius}, spheres = 0;
  sample.diameter = spheres * mean_diameter(sample.sizes, sample.shares) + diameter;
}

}  // namespace

double Sample::fall_time() const { return std::sqrt(2 * diameter / gravity); }
double Sample::fall_speed() const { return std::sqrt(gravity * diameter); }

Sample make_sample(const Loaded& loaded, const SampleWords& words) {
  const Scenario& s = loaded.scenario;
  Sample sample;
  sample.grain = material_index(s, words.material), sample.wall = material_index(s, words.walls);
  sample.laws = with_smooth_wall(build_laws(loaded), sample.grain, sample.wall);
  sample.smooth = sample.laws.materials - 1;
  sample.density = s.materials[static_cast<std::size_t>(sample.grain)].density;
  sample.sizes = sizes_of(words.radius);
  sample.shares = words.shares == ShareOf::mass ? dem::ShareOf::mass : dem::ShareOf::number;
  add_clumps(sample, loaded, words);
  sample.gravity = -s.gravity.y;
  sample.safety = s.time.safety;
  sample.step = s.time.soil_step;
  sample.simd = s.simd;
  sample.speed_limit = s.limits.speed, sample.overlap_limit = s.limits.overlap;
  sample.lowered = words.lowered, sample.at_most = words.at_most;
  sample.seed = static_cast<std::uint64_t>(words.seed);
  for (const int other : {sample.grain, sample.wall}) refuse_collapse(loaded, sample, other);
  return sample;
}

}  // namespace subsoil::sim
