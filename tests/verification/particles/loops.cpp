#include <gtest/gtest.h>

#include "tests/tools/laws.hpp"
#include "tests/tools/verified.hpp"

/// Loading and unloading of the plastic laws through the engine: a plane presses a sphere that is too heavy to follow
/// to an overlap of 1 mm, and leaves it. Corners of the loop and its area by hand.
namespace subsoil::dem::test::loops {
namespace {

using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;
using subsoil::test::VerifiedCurve;

const std::string kField = "Plastic laws";
constexpr double kR = 5e-3, kDeepest = 1e-3;
constexpr int kSteps = 20000;  ///< each way

struct Reading {
  double overlap, force;
};
struct Loop {
  std::vector<Reading> in, out;
  double work;

  double at(const std::vector<Reading>& leg, double overlap) const {
    for (std::size_t k = 1; k < leg.size(); ++k)
      if ((leg[k - 1].overlap - overlap) * (leg[k].overlap - overlap) <= 0) {
        const double part = (overlap - leg[k - 1].overlap) / (leg[k].overlap - leg[k - 1].overlap);
        return leg[k - 1].force + part * (leg[k].force - leg[k - 1].force);
      }
    return NAN;
  }
  /// Overlap at which the force first vanishes on the way out.
  double residual() const {
    for (std::size_t k = 1; k < out.size(); ++k)
      if (out[k - 1].force > 0 && out[k].force <= 0)
        return out[k].overlap +
               (out[k - 1].overlap - out[k].overlap) * out[k].force / (out[k].force - out[k - 1].force);
    return NAN;
  }
  Reading strongest_pull() const {
    return *std::min_element(out.begin(), out.end(),
                             [](const Reading& a, const Reading& b) { return a.force < b.force; });
  }
};

Loop press(const std::string& name, const Law& law) {
  BedOptions options = quiet();
  options.overlap_limit = options.speed_limit = 1e9;
  Bed bed(table(law), options);
  const SphereSpec s{{0, kR, 0}, {}, {}, kR, 1e18, 0};
  bed.add(std::span(&s, 1));
  const int plane = add_plane(bed, {}, {0, 1, 0});
  VerifiedCurve curve("loop-" + name);
  Loop loop;
  const double dt = 1e-6, step = kDeepest / kSteps;
  for (int n = 0; n <= 2 * kSteps; ++n) {
    const bool inward = n < kSteps;
    const double overlap = inward ? n * step : (2 * kSteps - n) * step;
    bed.boundary(plane).pose.position = {0, overlap, 0};
    bed.boundary(plane).velocity = {0, n <= kSteps ? step / dt : -step / dt, 0};
    bed.step(dt);
    const double force = -bed.boundary(plane).wrench.force.y;
    (n <= kSteps ? loop.in : loop.out).push_back({overlap, force});
    if (n == kSteps) loop.out.push_back({overlap, force});
    if (n % 200 == 0) curve.point(overlap, force);
  }
  loop.work = bed.boundary(plane).work;
  return loop;
}

const char* const kExact = "overlap is a difference of lengths of 5 mm: 1e-15 of 5 mm of 1 mm";
const char* const kBetween = "interpolated between 20,000 readings";
const char* const kArea = "trapezoids of 20,000 steps each way, kinks within a step";

TEST(PlasticLoops, HystereticSpring) {
  const double yield = 4e5, e = 0.5, k1 = 5 * kR * yield;
  const Loop loop = press("hysteretic", compactable(yield, e));
  const Verified row(kField, "Hysteretic spring (Walton & Braun, Ucgul), S_y 0.4 MPa, e 0.5",
                     "K1 = 5 R S_y, K2 = K1/e^2, by hand");
  row.near("force at 1 mm", "N", loop.in.back().force, k1 * kDeepest, share(1e-9), kExact);
  row.near("force at 0.9 mm on the way out", "N", loop.at(loop.out, 0.9e-3), k1 / (e * e) * (0.9e-3 - 0.75e-3),
           share(1e-6), kBetween);
  row.near("residual overlap", "m", loop.residual(), (1 - e * e) * kDeepest, share(1e-6), kBetween);
  row.near("area of the loop", "J", loop.work, 0.5 * k1 * kDeepest * kDeepest * (1 - e * e), share(1e-4), kArea);
}

TEST(PlasticLoops, Luding) {
  const double k1 = 1e4, k2 = 5e4, k_c = 1e4, limit = k2 / (k2 - k1) * 0.2 * 2 * kR;
  Luding law = sticky(k1, k2, k_c, 0.2);
  law.damping = 0;
  const Loop loop = press("luding", law);
  const double p = k1 + (k2 - k1) * kDeepest / limit, tear = (p - k1) * kDeepest / (p + k_c);
  const Verified row(kField, "Luding 2008: k1 10, k2 50, k_c 10 kN/m, phi_f 0.2", "Luding 2008, by hand");
  row.near("force at 1 mm", "N", loop.in.back().force, k1 * kDeepest, share(1e-9), kExact);
  row.near("overlap without force", "m", loop.residual(), (1 - k1 / p) * kDeepest, share(1e-6), kBetween);
  row.near("maximum pull", "N", -loop.strongest_pull().force, k_c * tear, share(1e-4), kBetween);
  row.near("pull at half that overlap", "N", -loop.at(loop.out, 0.5 * tear), 0.5 * k_c * tear, share(1e-4), kBetween);
  row.near("area of the loop", "J", loop.work,
           0.5 * k1 * kDeepest * kDeepest - (std::pow(k1 * kDeepest, 2) - std::pow(k_c * tear, 2)) / (2 * p) +
               0.5 * k_c * tear * tear,
           share(1e-4), kArea);
}

void edinburgh(const Verified& row, double n, double chi, double k1) {
  const double lambda = 0.6, k2 = k1 / (1 - lambda), w = 20;
  Eepa law = powder(n, k1, lambda, w, 1);
  law.chi = chi;
  const Loop loop = press(n == 1 ? "eepa-1" : "eepa-1.5", law);
  const double top = lambda * std::pow(kDeepest, n), residual = std::pow(top, 1 / n);
  const double pull = std::fmin(1.5 * pi * w * std::sqrt(2 * kR * residual), 0.5 * k2 * top);
  const double corner = std::pow(top - pull / k2, 1 / n), m = n + 1;
  row.near("force at 1 mm", "N", loop.in.back().force, k1 * std::pow(kDeepest, n), share(1e-9), kExact);
  row.near("overlap without force", "m", loop.residual(), residual, share(1e-6), kBetween);
  row.near("maximum pull", "N", -loop.strongest_pull().force, pull, share(1e-3), "sampled 20,000 times, a kink");
  row.near("pull at half that overlap", "N", -loop.at(loop.out, 0.5 * corner), pull * std::pow(0.5, chi), share(1e-6),
           kBetween);
  const double back = k2 * ((std::pow(kDeepest, m) - std::pow(corner, m)) / m - top * (kDeepest - corner));
  row.near("area of the loop", "J", loop.work, k1 * std::pow(kDeepest, m) / m - back + pull * corner / (chi + 1),
           share(1e-4), kArea);
}

TEST(PlasticLoops, Edinburgh) {
  const std::string source = "Morrissey 2013, Thakur et al. 2014, by hand";
  edinburgh(Verified(kField, "EEPA, n 1, chi 1, lambda_p 0.6, 20 J/m^2", source), 1, 1, 1e4);
  edinburgh(Verified(kField, "EEPA, n 1.5, chi 1.5, lambda_p 0.6, 20 J/m^2", source), 1.5, 1.5, 3e5);
}

}  // namespace
}  // namespace subsoil::dem::test::loops
