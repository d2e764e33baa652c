#pragma once
#include <cmath>

#include "libdem/impact/impact.hpp"

namespace subsoil::dem::impact {

/// Restitution that falls with the speed, by equivalence of energies in an elastic - ideally plastic body.
///     Ce = (1 + 2 eps_p/eps_y)^(-1/2)
/// from Ce^2 = E_e/(E_e + E_p), both energies taken at the point of mean energy density in one volume. The mean plastic
/// strain follows from the dimensionless lambda = rho V^2/S_y by a map,
///     eps_p/eps_y = A ((lambda/lambda_c)^B - 1) for lambda > lambda_c, else 0;
///     lambda_c = (4/(5 pi)) (pi C/2)^5 eps_y^4,  eps_y = S_y/E*,  C = 1.295 exp(0.736 nu)
/// The source keeps its own map to itself: A = 0.0649 and B = 0.3256 are our own fit, to a numerical integration of the
/// Jackson-Green loading, unloaded as F ~ (x - x_res)^1.5 down to their residual x_res = 1.02 (1 - ((w
/// + 5.9)/6.9)^-0.54) x* (|dCe| < 0.009 for V/V_c from 1 to 1000 at eps_y = 0.002). Give your own A, B and lambda_c, or
/// let `--fit` find them. The motion is Hunt and Crossley's, its damping such that the rebound at this speed meets Ce.
/// rho density of the striking body, S_y yield strength, nu Poisson ratio of the softer body.
/// Source: energies after the patent of Changsha University of Science and Technology on a normal impact model with
/// variable restitution (2023); lambda's form and the map are ours.
struct EnergyEquivalent {
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  double S_y = left_out;
  double density = left_out;
  double poisson = 0.3;
  double A = 0.0649, B = 0.3256;
  double lambda_c = left_out;

  template <class V>
  void describe(V& v) {
    v.card("energy-equivalent", "restitution that falls with the speed, by energy equivalence");
    parameters(v);
  }
  /// The map alone: the contact law of variable restitution has it too.
  template <class V>
  void parameters(V& v) {
    v.derived("S_y", S_y, "Pa", "(0, inf)",
              "yield strength of the body that yields; left out: the smaller one of the two bodies or materials");
    v.derived("rho", density, "kg/m^3", "(0, inf)",
              "density in lambda = rho V^2/S_y; left out: that of the first body; of two materials that of the one "
              "with the lower yield strength");
    v.quantity("nu", poisson, "1", "[0, 0.5]", "Poisson ratio of the body that yields");
    v.quantity("A", A, "1", "(0, inf)", "factor of the map from lambda to plastic strain; the default is our own fit");
    v.quantity("B", B, "1", "(0, inf)", "exponent of the map; the default is our own fit");
    v.derived("lambda_c", lambda_c, "1", "(0, inf)",
              "lambda at which yield begins; left out: from S_y, the elasticity of the bodies and nu");
  }
  double strength(const Pair& pair) const;  ///< Pa
  double lambda(const Pair& pair, double speed) const;
  double critical_lambda(const Pair& pair) const;
  double restitution_at(const Pair& pair, double speed) const;
  Event strike(const Pair& pair, double speed, int samples = usual_samples) const;
};

}  // namespace subsoil::dem::impact
