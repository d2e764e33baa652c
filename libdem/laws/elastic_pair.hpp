#pragma once
#include <cmath>
#include <limits>

/// Effective elastic constants of two materials, for the laws that are computed from them.
///     E* = [(1 - nu1^2)/E1 + (1 - nu2^2)/E2]^-1,   G* = [(2 - nu1)/G1 + (2 - nu2)/G2]^-1,   G = E/(2 (1 + nu))
/// Symbols: E Young's modulus Pa, nu Poisson's ratio, G shear modulus Pa.
namespace subsoil::dem {

/// E*, Pa.
inline double effective_modulus(double young_1, double poisson_1, double young_2, double poisson_2) {
  return 1 / ((1 - poisson_1 * poisson_1) / young_1 + (1 - poisson_2 * poisson_2) / young_2);
}

struct ElasticPair {
  double E_eff = std::numeric_limits<double>::quiet_NaN();
  double G_eff = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe_elasticity(V& v) {
    v.derived("E_eff", E_eff, "Pa", "(0, inf)",
              "effective Young's modulus; left out: from both materials' young and poisson");
    v.derived("G_eff", G_eff, "Pa", "(0, inf)",
              "effective shear modulus; left out: from both materials' young and poisson");
  }

  bool needs_materials() const { return std::isnan(E_eff) || std::isnan(G_eff); }
  static constexpr const char* in_place_of_materials = "E_eff and G_eff";
  /// Fills E_eff and G_eff from the elastic constants of the two materials where they were left out.
  void take_materials(double young_1, double poisson_1, double young_2, double poisson_2) {
    const auto shear = [](double young, double poisson) { return young / (2 * (1 + poisson)); };
    if (std::isnan(E_eff)) E_eff = effective_modulus(young_1, poisson_1, young_2, poisson_2);
    if (std::isnan(G_eff))
      G_eff = 1 / ((2 - poisson_1) / shear(young_1, poisson_1) + (2 - poisson_2) / shear(young_2, poisson_2));
  }
};

}  // namespace subsoil::dem
