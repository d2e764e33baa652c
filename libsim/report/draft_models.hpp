#pragma once
#include <string>

/// What the field's closed formulas give for a narrow tool, to set beside a simulated draft.
namespace subsoil::sim {

struct Band {
  double low = 0, high = 0;  ///< N
};

/// ASABE D497: draft of one subsoiler (narrow point) at a speed S and depth T:
///
///     D = F_i (A + B S + C S^2) W T,   A = 226, B = 0, C = 1.8 for W in tools, T in cm, S in km/h, D in N
///
/// F_1 = 1 fine, F_2 = 0.70 medium, F_3 = 0.45 coarse soil; the standard gives +- 50 % about each. `depth` in m,
/// `speed` in m/s. The band spans coarse - 50 % to fine + 50 %. Source: ASABE D497, Agricultural machinery management
/// data, table of draft parameters, "subsoiler/manure injector, narrow point".
Band asabe_subsoiler(double depth, double speed);

/// Soil of the wedge models; SI.
struct WedgeSoil {
  double density = 0;        ///< bulk, kg/m^3
  double cohesion = 0;       ///< c, Pa
  double friction = 0;       ///< phi, rad
  double wall_friction = 0;  ///< delta between soil and tool, rad
  double adhesion = 0;       ///< c_a between soil and tool, Pa
  double surcharge = 0;      ///< q, Pa
  double gravity = 9.81;     ///< m/s^2
};

/// McKyes and Ali: passive failure of a wedge ahead of a narrow tool of width w, depth d and rake angle alpha, with two
/// circular crescents beside it. With k = cot alpha + cot beta, r = d k, s = d sqrt(cot^2 beta + 2 cot alpha cot beta),
/// m = cos(alpha + delta) + sin(alpha + delta) cot(beta + phi), as forces on the wedge balance:
///
///     N_g = k/2 (1 + 2 s / (3 w)) / m,    N_q = k (1 + s / w) / m,
///     N_c = (1 + cot beta cot(beta + phi)) (1 + s / w) / m,   N_a = (1 - cot alpha cot(beta + phi)) / m
///     P = w (rho g d^2 N_g + c d N_c + q d N_q + c_a d N_a),  H = P sin(alpha + delta) + c_a d w cot alpha
///
/// P acts at delta to the tool's normal. Of a wide tool in soil without cohesion it is Coulomb's passive force. beta
/// minimises N_g. For a narrow tool at a low rake N_g falls up to beta = 90 deg: no wedge forms ahead, the model
/// lifts what lies on the tool alone, and its draft is a lower bound. Horizontal force H in N; NaN where alpha + delta
/// reaches 180 deg or beta has no room. Source: McKyes, Ali, Journal of Terramechanics 14 (1977) 43-51.
double mckyes_ali(const WedgeSoil& soil, double width, double depth, double rake);

/// The rupture angle beta (rad) that mckyes_ali takes.
double mckyes_ali_rupture(const WedgeSoil& soil, double width, double depth, double rake);

}  // namespace subsoil::sim
