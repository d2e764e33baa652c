#pragma once

#include <functional>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace subsoil::mbd {

/// Stiffness K'(z, v, m) of ground under an impact, N/m: force over depth z (m), spring and damping in one, for a body
/// of mass m (kg) that struck at speed v (m/s). F = K' z must grow with z. Source of the form: Ye, "Ground modeling in
/// machinery-ground interaction system"; its regression for clay is lost, so every number here is the user's.

/// K' = K0 (z/z0)^alpha (v/v0)^beta (m/m0)^gamma, beyond z1 (z1/z0)^alpha (z/z1)^alpha_1 in place of the first power.
struct PowerStiffness {
  double K0 = std::numeric_limits<double>::quiet_NaN();
  double z0 = 0.01, v0 = 1, m0 = 1;
  double alpha = 0, beta = 0, gamma = 0;
  double z1 = std::numeric_limits<double>::infinity();
  double alpha_1 = 0;

  template <class V>
  void describe(V& v) {
    v.card("power", "powers of depth, speed and mass, of the depth in two ranges");
    v.quantity("power", K0, "N/m", "(0, inf)", "K' at the depth, speed and mass below");
    v.quantity("depth", z0, "m", "(0, inf)", "depth at which this holds");
    v.quantity("speed", v0, "m/s", "(0, inf)", "speed at which this holds");
    v.quantity("mass", m0, "kg", "(0, inf)", "mass at which this holds");
    v.quantity("depth exponent", alpha, "1", "(-1, inf)", "power of the depth");
    v.quantity("speed exponent", beta, "1", "(-inf, inf)", "power of the speed of impact");
    v.quantity("mass exponent", gamma, "1", "(-inf, inf)", "power of the mass that strikes");
    v.quantity("deep from", z1, "m", "(0, inf]", "depth from which another power holds; left out: none");
    v.quantity("deep exponent", alpha_1, "1", "(-1, inf)", "power of the depth beyond it");
  }
  void check() const;
  double value(double z, double v, double m) const;
};

/// K' = A (k_c/b + k_phi) z^(n-1) (v/v0)^beta: Bekker's pressure under an area A, with the rate of tillage soils.
struct BekkerStiffness {
  double area = std::numeric_limits<double>::quiet_NaN();
  double width = std::numeric_limits<double>::quiet_NaN();
  double n = std::numeric_limits<double>::quiet_NaN();
  double k_c = std::numeric_limits<double>::quiet_NaN();
  double k_phi = std::numeric_limits<double>::quiet_NaN();
  double v0 = 0.01, beta = 0.06;

  template <class V>
  void describe(V& v) {
    v.card("bekker", "Bekker's pressure-sinkage curve under a stamp, growing with speed");
    v.quantity("bekker", area, "m^2", "(0, inf)", "area of the stamp");
    v.quantity("width", width, "m", "(0, inf)", "smaller side b of the stamp");
    v.exponent("n", n, "(0, 3)", "exponent of sinkage");
    v.quantity("k_c", k_c, "N/m^(n+1)", "[0, inf)", "cohesive modulus of the soil");
    v.quantity("k_phi", k_phi, "N/m^(n+2)", "[0, inf)", "frictional modulus of the soil");
    v.quantity("speed", v0, "m/s", "(0, inf)", "speed of the plate test that gave the moduli");
    v.quantity("speed exponent", beta, "1", "(-inf, inf)", "power of the speed of impact over it");
  }
  void check() const;
  double value(double z, double v, double m) const;
};

/// K' through given points (z, K'), straight between and constant outside, times (v/v0)^beta.
struct TableStiffness {
  std::vector<double> depths, values;
  double v0 = 1, beta = 0;

  template <class V>
  void describe(V& v) {
    v.card("table", "given points of K' over the depth, straight between, constant outside");
    v.table("table", depths, values, "m", "N/m", "depth and K', depths increasing");
    v.quantity("speed", v0, "m/s", "(0, inf)", "speed of impact at which it was measured");
    v.quantity("speed exponent", beta, "1", "(-inf, inf)", "power of the speed of impact over it");
  }
  void check() const;
  double value(double z, double v, double m) const;
};

/// A formula in z, v and m that whoever reads formulas has turned into a callable.
struct FormulaStiffness {
  std::string text;
  std::function<double(double, double, double)> call;

  template <class V>
  void describe(V& v) {
    v.card("formula", "a formula in z (m), v (m/s) and m (kg)");
    v.formula("formula", text, call, "K' in N/m, such as 1e5*(z/0.01)^0.3*v^0.06");
  }
  void check() const;
  double value(double z, double v, double m) const { return call(z, v, m); }
};

using PlasticStiffness = std::variant<PowerStiffness, BekkerStiffness, TableStiffness, FormulaStiffness>;

/// F = K' z, N; 0 for z <= 0.
double plastic_force(const PlasticStiffness& stiffness, double z, double v, double m);

}  // namespace subsoil::mbd
