#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/element/force.hpp"

namespace subsoil::mbd {

/// Rigid wheel on plastic soil (Bekker), one planar body = one wheel, with a rut memory along x.
///   z   = R - (y_axle - y_soil)                                     sinkage; nothing for z <= 0      (m)
///   N   = b k sqrt(2 R) ((3 - n)/3) z^(n + 1/2)                     upward at the axle               (N)
///   R_c = b k (z^(n+1) - z_p^(n+1))/(n + 1)                         against the axle's velocity      (N)
///   k   = k_c/b + k_phi
/// z_p: rut left by an earlier pass under the front of the patch, x_axle + sqrt(2 R z) in the direction of travel.
/// On unrutted ground (z_p = 0) N and R_c follow the virgin curve of z in both directions; in a rut N = 0 for z <= z_p.
/// R_c is scaled by |v|/(1 mm/s) below 1 mm/s and makes no moment on the wheel; the direction of travel turns round
/// when the axle runs back faster than that, so that a wheel at rest does not see its own rut flicker.
///
/// With Heave::plastic the soil gives nothing back: of the arc, at x ahead of the axle, only what is being pressed
/// deeper bears, dz/dt + x |v|/R > 0, and in a rut only what is deeper than z_p. In parts of the arc's length,
/// u = -(R dz/dt)/(|v| sqrt(2 R z)) is where the first begins and e = sqrt(1 - z_p/z) where the second ends:
///   N   = N above, times I(e^2) - sgn(u) I(min(u^2, e^2)),  I(s) = I(s; 1/2, n + 1);   none for u >= e or z <= z_p
///   R_c = b k ((z (1 - min(u^2, e^2)))^(n+1) - z_p^(n+1))/(n + 1)
/// (I: regularised incomplete beta function). N begins from 0 at the rut's depth, so that a wheel rides in the rut of
/// another. Steadily towed on unrutted ground, dz/dt = 0, it is the law above; small heave is damped there by
/// dN/dv_y = -N R/(|v| sqrt(2 R z) B), B = integral of (1 - s^2)^n from 0 to 1. |v| is sqrt(v^2 + (1 mm/s)^2).
///
/// With a shear displacement K the rim also takes traction H along x (N), which acts at the wheel's lowest point:
///   H = -sgn(s) (b l c + N tan phi) (1 - (K/j) (1 - exp(-j/K))),  j = l |s|/|R omega|,  l = sqrt(2 R z)
/// s = v_x + R omega: velocity of the rim on the soil (m/s), < 0 where the wheel drives along +x; j: shear displacement
/// at the end of the patch. With the slip i = 1 - v/(R |omega|) of a driven wheel j = i l. |omega| is regularised:
/// below R |omega| = 10 mm/s the wheel creeps. c cohesion [Pa], phi internal friction [rad], K [m] > 0.
///
/// R radius, b width, y_soil surface [m]; k_c [N/m^(n+1)], k_phi [N/m^(n+2)], n [1] in (0, 3).
///
/// Energy, reversible: stored = U(z) - U(z_p) for z > z_p, U = N z/(n + 3/2): what N gives back on the way up; lost
/// rate = R_c |v| + N(z_p) dz_p/dt: what running over a rut's edge swallows (negative where it is left again: the law
/// then gives the wheel energy that nobody put in, and the balance reports it instead of hiding it). Plastic: nothing
/// is stored; lost rate = N dz/dt + R_c |v|, which for n < 1 can fall below zero as the wheel leaves the soil, by what
/// Bekker's (3 - n)/3 exceeds B (6 % of N |dz/dt| at n = 0.5). Traction: lost rate = -H s >= 0.
///
/// Source: Bekker 1969, Introduction to Terrain-Vehicle Systems; rut rule of the rig 1S-300; plastic heave: Bekker's
/// pressure on the part of the arc that presses (docs/theory 12); traction: Janosi & Hanamoto 1961, for a patch under
/// uniform pressure as in Wong, Theory of Ground Vehicles, 2.
struct WheelOnSoil {
  enum class Heave { reversible, plastic };
  static constexpr ForceMembers has{.check = true, .trace = true, .rut = true, .towing_spin = true};
  static constexpr std::array<ForceColumn, 6> columns{
      {{"N", "N"}, {"R_c", "N"}, {"sinkage", "m"}, {"rut", "m"}, {"traction", "N"}, {"slip", "1"}}};
  static constexpr double creep = 1e-3;  ///< speed below which R_c fades (m/s)
  static constexpr double slow = 1e-2;   ///< speed of the rim below which traction fades (m/s)
  int body = -1;
  double radius = std::numeric_limits<double>::quiet_NaN();
  double width = std::numeric_limits<double>::quiet_NaN();
  double n = std::numeric_limits<double>::quiet_NaN();
  double k_c = std::numeric_limits<double>::quiet_NaN();
  double k_phi = std::numeric_limits<double>::quiet_NaN();
  double surface = 0;
  Heave heave = Heave::reversible;
  std::string track{};  ///< wheels of the same track share a rut; empty: its own
  double shear_displacement = std::numeric_limits<double>::quiet_NaN();  ///< K; NaN: no traction
  double cohesion = 0, internal_friction = 0;
  // Set and kept by the system:
  std::size_t rut = 0;   ///< index of its rut
  double direction = 1;  ///< of travel, +1 or -1
  Vec2 last{0, -1};      ///< axle x and sinkage at the last accepted step

  template <class V>
  void describe(V& v) {
    v.card("wheel on soil", "sinkage and rolling resistance of a rigid wheel, with the rut that it leaves");
    v.body("wheel on soil", body, "the wheel; its centre of gravity is its axle");
    v.quantity("radius", radius, "m", "(0, inf)", "radius of the wheel");
    v.quantity("width", width, "m", "(0, inf)", "width of its tyre");
    v.exponent("n", n, "(0, 3)", "exponent of sinkage");
    v.quantity("k_c", k_c, "N/m^(n+1)", "[0, inf)", "cohesive modulus of the soil");
    v.quantity("k_phi", k_phi, "N/m^(n+2)", "[0, inf)", "frictional modulus of the soil");
    v.quantity("surface", surface, "m", "(-inf, inf)", "height y of the soil's surface");
    v.choice("heave", heave, {{"reversible", Heave::reversible}, {"plastic", Heave::plastic}},
             "plastic: soil gives nothing back when the wheel rises, and what rolls is damped by it; reversible: load "
             "follows the sinkage both ways, as in linear studies");
    v.text("track", track, "wheels of the same track share their rut; left out: the wheel's own");
    v.optional_quantity(
        "shear displacement", shear_displacement, "m", "(0, inf)",
        "K of Janosi and Hanamoto: the wheel drives and brakes by shearing the soil; left out: no traction");
    v.quantity("cohesion", cohesion, "Pa", "[0, inf)", "of the soil, for traction");
    v.quantity("internal friction", internal_friction, "rad", "[0, 1.5]",
               "angle of the soil's shear strength, for traction");
  }

  void check() const {
    if (!(radius > 0 && width > 0 && n > 0 && n < 3 && k_c >= 0 && k_phi >= 0))
      throw std::invalid_argument(
          "radius and width must be above 0, n in (0, 3), k_c and k_phi not negative; all five must be given");
    if (shear_displacement <= 0 || cohesion < 0 || !(internal_friction >= 0 && internal_friction <= 1.5))
      throw std::invalid_argument(
          "shear displacement must be above 0, cohesion not negative, internal friction in [0, 1.5] rad");
  }
  /// Angular velocity at which it rolls along without slip: how a towed wheel starts.
  double towing_spin(double speed) const { return -speed / radius; }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const BodyState& b = axle(scene);
    const double z = sinkage(b);
    values = {0, 0, std::max(z, 0.0), 0};
    if (!(z > 0)) return {};
    ForcePower power = sink(scene, b, z, loads, values);
    if (shears()) power.lost += shear(b, z, loads, values);
    return power;
  }

  /// Whether the wheel takes traction.
  bool shears() const { return !std::isnan(shear_displacement); }

  double rut_size() const { return radius; }  ///< length by which the grid of its rut is chosen (m)

  /// An accepted step: the ground remembers, and the direction of travel is kept. Where the wheel turns round, its own
  /// rut is the ground ahead, and what the new ground under it had stored is lost.
  double commit(const Scene& scene, std::vector<Rut>& ruts) {
    const BodyState& b = axle(scene);
    const Vec2 now{b.r.x, sinkage(b)};
    const double turned = b.v.x > creep ? 1 : b.v.x < -creep ? -1 : direction;
    const double before = turned != direction ? stored(now, ruts[rut]) : 0;
    if (last.y > 0 || now.y > 0) ruts[rut].press(last.x, std::max(last.y, 0.0), now.x, std::max(now.y, 0.0));
    last = now;
    if (turned == direction) return 0;
    direction = turned;
    return before - stored(now, ruts[rut]);
  }
  /// Forgets the way to here: the next commit starts a new trace.
  void begin_trace(const Scene& scene) {
    const BodyState& b = axle(scene);
    last = {b.r.x, sinkage(b)};
    if (std::abs(b.v.x) > creep) direction = b.v.x > 0 ? 1 : -1;
  }
  std::array<double, 3> memory() const { return {direction, last.x, last.y}; }
  void set_memory(const std::array<double, 3>& m) { direction = m[0], last = {m[1], m[2]}; }

  double sinkage(const BodyState& b) const { return radius - (b.r.y - surface); }
  /// N on virgin ground.
  double load(double z) const { return width * modulus() * std::sqrt(2 * radius) * (3 - n) / 3 * std::pow(z, n + 0.5); }

 private:
  /// Bekker's load and resistance.
  ForcePower sink(const Scene& scene, const BodyState& b, double z, Loads& loads, ForceValues& values) const {
    const double reach = std::sqrt(2 * radius * z);
    const Rut::Depth rutted = scene.ruts[rut].at(b.r.x + direction * reach);
    if (heave == Heave::plastic) return press(b, z, rutted.z, loads, values);
    // z^(n+1) from the z^(n+1/2) in N: a power costs as much as the rest of the law.
    const double z_p = rutted.z, full = load(z), bearing = z > z_p ? full : 0.0;
    const double virgin = full * std::sqrt(z) * 3 / ((3 - n) * std::sqrt(2 * radius)), k_b = width * modulus();
    const double before = z_p > 0 ? k_b * std::pow(z_p, n + 1) : 0.0;
    const double resistance = z > z_p ? (virgin - before) / (n + 1) : 0.0;
    const double share = fading(b);
    loads.add_wrench(body, -resistance * share, bearing, 0);
    values = {bearing, resistance, z, z_p};
    if (!(z > z_p)) return {};
    const double front_speed = b.v.x - direction * radius / reach * b.v.y;
    const double edge = z_p > 0 ? load(z_p) * rutted.slope * front_speed : 0.0;
    return {full * z / (n + 1.5) - energy(z_p), resistance * share * b.v.x + edge, 0};
  }
  double shear(const BodyState& b, double z, Loads& loads, ForceValues& values) const;
  ForcePower press(const BodyState& b, double z, double z_p, Loads& loads, ForceValues& values) const;
  /// Of R_c, with the sign of the axle's velocity.
  static double fading(const BodyState& b) { return std::min(1.0, std::max(-1.0, b.v.x / creep)); }
  /// With the axle at x and the sinkage z.
  double stored(const Vec2& at, const Rut& ground) const {
    if (heave == Heave::plastic || !(at.y > 0)) return 0;
    const double z_p = ground.at(at.x + direction * std::sqrt(2 * radius * at.y)).z;
    return at.y > z_p ? energy(at.y) - energy(z_p) : 0;
  }
  double modulus() const { return k_c / width + k_phi; }
  double energy(double z) const { return z > 0 ? load(z) * z / (n + 1.5) : 0.0; }
  const BodyState& axle(const Scene& scene) const { return scene.bodies[static_cast<std::size_t>(body)]; }
};

}  // namespace subsoil::mbd
