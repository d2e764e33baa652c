#include <gtest/gtest.h>

#include "libdem/impact/models.hpp"
#include "tests/tools/verified.hpp"

/// Models of one impact against printed values.
namespace subsoil::dem::impact::test::impact_published {
namespace {

using subsoil::test::absolute;
using subsoil::test::Verified;

const std::string kField = "Impact models";

/// To the printed digits: half a unit of the last, and a hundredth for what rounding leaves.
void to_digits(const Verified& row, const std::string& quantity, const std::string& unit, double got, double printed,
               int digits) {
  const double last = std::pow(10.0, std::floor(std::log10(std::abs(printed))) - (digits - 1));
  row.near(quantity, unit, got, printed, absolute(0.51 * last), std::to_string(digits) + " printed digits");
}

TEST(ImpactPublished, HuntCrossleyTableOfTheSteelBall) {
  struct {
    double v, x, f, t, k, lost;
  } const rows[] = {
      {0.5, 1.9893579643e-5, 1521.9160893, 1.1904584326e-4, 0.9677385785, 7.9352554529e-4},
      {2, 5.8156728356e-5, 7709.8673681, 9.1181013535e-5, 0.8821899862, 4.4348165633e-2},
      {5, 1.1372585556e-4, 22315.267381, 7.7655384043e-5, 0.7484349316, 0.54980644146},
  };
  HuntCrossleyModel law;
  law.c = 1.7135e10, law.b = 0.1;
  const Verified row(kField, "Hunt-Crossley: steel ball of 0.1 kg on a plate",
                     "first integrals of Borovin, Dyagel & Lapshin, KIAM preprint 53, 2008");
  for (const auto& r : rows) {
    const Event e = law.strike({.mass = 0.1}, r.v);
    char at[24];
    std::snprintf(at, sizeof at, " at %g m/s", r.v);
    to_digits(row, std::string("maximum indentation") + at, "m", e.largest, r.x, 11);
    to_digits(row, std::string("peak force") + at, "N", e.peak_force, r.f, 11);
    to_digits(row, std::string("duration") + at, "s", e.duration(), r.t, 11);
    to_digits(row, std::string("restitution") + at, "1", e.restitution, r.k, 10);
    to_digits(row, std::string("energy lost") + at, "J", e.lost, r.lost, 11);
  }
  to_digits(row, "restitution at b V = 0.1", "1", hunt_crossley_restitution(0.1), 0.9374755799, 10);
  to_digits(row, "restitution at b V = 0.9", "1", hunt_crossley_restitution(0.9), 0.6197364661, 10);
}

/// Millimetre sphere of a soft metal.
const Pair metal{.mass = 7800 * 4.0 / 3 * 3.14159265358979 * 1e-9, .radius = 1e-3, .E_eff = 1e11, .density = 7800};

TEST(ImpactPublished, Thornton) {
  const Thornton law{.p_y = 1e9};
  const double v_y = law.yield_speed(metal);
  const Verified row(kField, "Thornton 1997: elastic - perfectly plastic sphere", "its restitution evaluated by hand");
  to_digits(row, "restitution at 2 V_y", "1", law.restitution_at(metal, 2 * v_y), 0.93063, 5);
  to_digits(row, "restitution at 10 V_y", "1", law.restitution_at(metal, 10 * v_y), 0.65856, 5);
  to_digits(row, "restitution at 100 V_y", "1", law.restitution_at(metal, 100 * v_y), 0.37430, 5);
}

TEST(ImpactPublished, JacksonGreen) {
  const JacksonGreen law{.S_y = 1e8, .poisson = 0.3};  // eps_y = 0.001
  const double v_c = law.critical_speed(metal);
  const Verified row(kField, "Jackson, Green & Marghitu 2010: restitution, eps_y 0.001", "its fit evaluated by hand");
  to_digits(row, "restitution at 2 V_c", "1", law.restitution_at(metal, 2 * v_c), 0.9633, 4);
  to_digits(row, "restitution at 10 V_c", "1", law.restitution_at(metal, 10 * v_c), 0.8283, 4);
  to_digits(row, "restitution at 100 V_c", "1", law.restitution_at(metal, 100 * v_c), 0.5339, 4);
}

}  // namespace
}  // namespace subsoil::dem::impact::test::impact_published
