/// How far the advised step is from the step at which a bed really becomes unstable, law by law.
///
/// The bed of bed_step, 13,000 spheres brought to rest under the law, runs twice, once with every velocity and spin
/// disturbed by some 1e-7 m/s. While the step is stable the two runs stay together; two per cent beyond its limit the
/// fastest mode grows by four per cent a step at least (tests/verification/particles/stable_step.cpp), a hundred
/// thousandfold in 300 steps. A distance that grows three hundredfold is unstable: one mode is a hundredth of the first
/// distance, which is that of all spheres. Not the energy: a mode of rotation stops growing where friction slips, far
/// below what would be seen. The limit is found by bisection to two per cent. Prints a table in Markdown.
///
///     stable_limit [folder of the settled blocks]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "bench/bed_case.hpp"
#include "libdem/packing/sizes.hpp"
#include "libdem/step/stability.hpp"

namespace {

using namespace subsoil;

constexpr double kSafety = 0.8;  // of `time.safety` in scenarios

/// What a scenario is advised; it expects speeds up to that of a fall through its container, here the bed's 0.33 m.
dem::StableStep advised(const bench::Case& c) {
  const double speed = std::sqrt(2 * 9.81 * 0.33);
  const dem::StepQuestion question{.smallest_radius = bench::kRadius,
                                   .largest_radius = bench::kRadius,
                                   .density = bench::kDensity,
                                   .speed = speed,
                                   .neighbours = 12};
  const dem::StableStep pair = dem::stable_step(c.laws.laws[0], question),
                        wall = dem::stable_step_at_surface(c.laws.laws[1], question);
  return pair.step < wall.step ? pair : wall;
}

double distance(const dem::Bed& a, const dem::Bed& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.spheres().size(); ++i) {
    const dem::Vec3 v = a.spheres()[i].v - b.spheres()[i].v, w = a.spheres()[i].w - b.spheres()[i].w;
    sum += dem::dot(v, v) + 0.4 * bench::kRadius * bench::kRadius * dem::dot(w, w);
  }
  return std::sqrt(sum);
}

dem::Bed make_bed(const bench::Case& c) {
  dem::BedOptions options;
  options.skin = 5e-3;  // one search: both runs keep the same order
  dem::Bed bed(c.laws, options);
  bench::fill(bed, c);
  return bed;
}

/// The bed after it came to rest under its own law, friction included.
dem::Bed::State at_rest(bench::Case c, double step) {
  for (dem::SphereSpec& s : c.spheres) s.velocity = {};
  dem::Bed bed = make_bed(c);
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 150; ++i) bed.step(0.8 * step);
    bed.freeze();
  }
  return bed.save();
}

bool stays_together(const bench::Case& c, const dem::Bed::State& rest, double step) {
  dem::Bed still = make_bed(c), disturbed = make_bed(c);
  still.restore(rest);
  dem::Bed::State other = rest;
  dem::RandomNumbers random(51);
  for (dem::Sphere& s : other.spheres) s.v += 1e-7 * random.in_unit_ball(), s.w += 1e-5 * random.in_unit_ball();
  disturbed.restore(other);
  try {
    still.step(step), disturbed.step(step);
    const double start = distance(still, disturbed);
    for (int i = 0; i < 300; ++i) {
      still.step(step), disturbed.step(step);
      if (i % 20 == 19 && distance(still, disturbed) > 300 * start) return false;
    }
  } catch (const dem::BedFault&) {
    return false;
  }
  return true;
}

/// The longest stable step, s.
double measured(const bench::Case& c, double advised) {
  const dem::Bed::State rest = at_rest(c, advised);
  double stable = 0.5 * advised, unstable = 8 * advised;
  if (!stays_together(c, rest, stable)) throw std::runtime_error("unstable at half the advised step");
  while (unstable > 1.02 * stable) {
    const double middle = std::sqrt(stable * unstable);
    (stays_together(c, rest, middle) ? stable : unstable) = middle;
  }
  return stable;
}

void row(const std::string& tiles, bench::LawName law, const char* name) {
  const bench::Case c = bench::make_case({.law = law, .spheres = 13e3, .tiles = tiles});
  const dem::StableStep limit = advised(c);
  const double found = measured(c, limit.step);
  std::printf("| %s | %.1f us | %s | %.1f us | %.2f | %.2f |\n", name, 1e6 * limit.step,
              limit.cause.substr(0, limit.cause.find(" with")).c_str(), 1e6 * found, found / limit.step,
              kSafety * limit.step / found);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string tiles = argc > 1 ? argv[1] : std::filesystem::path(argv[0]).parent_path().string();
    std::printf("| law | stable step | set by | measured limit | measured/stable | step at safety %.1f/measured |\n",
                kSafety);
    std::printf("|---|---|---|---|---|---|\n");
    row(tiles, bench::LawName::linear, "linear");
    row(tiles, bench::LawName::rolling, "linear, rolling");
    row(tiles, bench::LawName::hertz, "hertz-mindlin");
    row(tiles, bench::LawName::cohesive, "wet, film of 10 um");
    row(tiles, bench::LawName::wet, "wet, of the source");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "stable_limit: %s\n", e.what());
    return 2;
  }
}
