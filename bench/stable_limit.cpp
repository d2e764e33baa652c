/// How far the advised step is from the step at which a bed really becomes unstable, law by law.
///
/// The bed of bed_step, 13,000 settled spheres, lies at rest or is ploughed at 0.5 m/s; the same run is made with
/// longer and longer steps. Unstable: a sphere faster than the bed can make it (0.1 m/s at rest, ten times the tool's
/// speed when ploughed) or a contact deeper than half a radius, within 600 steps; a mode two per cent above its limit
/// grows by four per cent a step at least (tests/verification/particles/stable_step.cpp). The limit is found by
/// bisection to two per cent. Prints a table in Markdown.
///
///     stable_limit [folder of the settled blocks]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "bench/bed_case.hpp"
#include "libdem/stability.hpp"

namespace {

using namespace subsoil;

constexpr double kSafety = 0.8;  // of `time.safety` in scenarios

dem::StableStep advised(const bench::Case& c, double speed) {
  const dem::StepQuestion question{.smallest_radius = bench::kRadius,
                                   .largest_radius = bench::kRadius,
                                   .density = bench::kDensity,
                                   .speed = speed,
                                   .neighbours = 12};
  const dem::StableStep pair = dem::stable_step(c.laws.laws[0], question),
                        wall = dem::stable_step_at_surface(c.laws.laws[1], question);
  return pair.step < wall.step ? pair : wall;
}

bool stays_calm(const bench::Case& c, double step, double speed_limit) {
  dem::BedOptions options;
  options.speed_limit = 1e3;
  dem::Bed bed(c.laws, options);
  const int tool = bench::fill(bed, c);
  try {
    for (int i = 0; i < 600; ++i) {
      bed.step(step);
      if (tool >= 0) bed.boundary(tool).pose.position += c.tool.velocity * step;
      if (bed.max_speed() > speed_limit) return false;
    }
  } catch (const dem::BedFault&) {
    return false;
  }
  return true;
}

/// The longest calm step, s.
double measured(const bench::Case& c, double guess, double speed_limit) {
  double calm = 0.5 * guess, wild = 8 * guess;
  if (!stays_calm(c, calm, speed_limit)) return 0;
  while (wild > 1.02 * calm) {
    const double middle = std::sqrt(calm * wild);
    (stays_calm(c, middle, speed_limit) ? calm : wild) = middle;
  }
  return calm;
}

void row(const std::string& tiles, bench::LawName law, const char* name, bench::Kind kind) {
  bench::CaseRequest request{.kind = kind, .law = law, .spheres = 13e3, .tiles = tiles};
  const bench::Case c = bench::make_case(request);
  const double speed = c.has_tool ? dem::norm(c.tool.velocity) : 0.1;
  const dem::StableStep limit = advised(c, speed);
  const double found = measured(c, limit.step, c.has_tool ? 10 * speed : speed);
  std::printf("| %s | %s | %.1f us | %s | %.1f us | %.2f | %.2f |\n", name, c.has_tool ? "ploughed" : "at rest",
              1e6 * limit.step, limit.cause.substr(0, limit.cause.find(" with")).c_str(), 1e6 * found,
              found / limit.step, kSafety * limit.step / found);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string tiles = argc > 1 ? argv[1] : std::filesystem::path(argv[0]).parent_path().string();
    std::printf(
        "| law | bed | stable step | set by | measured limit | measured/stable | step at safety %.1f/measured |\n",
        kSafety);
    std::printf("|---|---|---|---|---|---|---|\n");
    for (const bench::Kind kind : {bench::Kind::rest, bench::Kind::plough}) {
      row(tiles, bench::LawName::linear, "linear", kind);
      row(tiles, bench::LawName::rolling, "linear, rolling", kind);
      row(tiles, bench::LawName::hertz, "hertz-mindlin", kind);
      row(tiles, bench::LawName::cohesive, "wet, film of 10 um", kind);
      row(tiles, bench::LawName::wet, "wet, of the source", kind);
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "stable_limit: %s\n", e.what());
    return 2;
  }
}
