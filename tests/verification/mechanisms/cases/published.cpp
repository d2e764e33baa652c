// Mechanisms with published solutions: Andrews' squeezing mechanism and the car axis of the IVP test set, slider-crank
// and pendulum of SUNDIALS. Those that move by themselves also against minimal coordinates, which tell more columns.

#include <cmath>

#include "tests/verification/mechanisms/cases/case.hpp"

namespace subsoil::cases {
namespace {

constexpr double beta_0 = -0.0617138900142764496358948458001;

/// Andrews' squeezing mechanism: seven bodies, one freedom (beta, the angle of the crank OF); names and numbers of
/// Hairer & Wanner, Solving Ordinary Differential Equations II, VII.7.
Reference squeezer() {
  Mechanism m;
  m.gravity = 0;
  m.names = {"OF", "FE", "BDE", "EG", "AG", "HE", "AH"};
  m.mass = {{0.04325, 0.04325, 2.194e-6}, {0.00365, 0.00365, 4.410e-7}, {0.02373, 0.02373, 5.255e-6},
            {0.00706, 0.00706, 5.667e-7}, {0.07050, 0.07050, 1.169e-5}, {0.00706, 0.00706, 5.667e-7},
            {0.05498, 0.05498, 1.912e-5}};
  m.start = {beta_0, 0};
  m.poses = [](const Coordinates& q, Jet) {
    const Point origin, a{-0.06934, -0.00227}, b{-0.03635, 0.03273}, f = polar(0.007, q[0]);
    const Point e = meet(f, 0.028, b, 0.035, 1), g = meet(e, 0.02, a, 0.04, -1), h = meet(e, 0.02, a, 0.04, 1);
    return Poses{body_at(origin, q[0], 0.00092),
                 body_at(f, direction(e, f), -0.0115),
                 body_at(b, direction(b, e), 0.01874, 0.01043),
                 body_at(g, direction(g, e), 0.02 - 0.01421),
                 body_at(a, direction(a, g), 0.02308, 0.00916),
                 body_at(h, direction(h, e), 0.02 - 0.01421),
                 body_at(a, direction(a, h), 0.01228, -0.00449)};
  };
  const Place e{-0.020960022346354337, 0.0012951691937066864}, f{0.0069866741154514457, -0.00043172306456889546},
      g{-0.033997203885839981, 0.016461971674997683}, h{-0.031633134507408900, -0.015618868668304537},
      a{-0.06934, -0.00227}, b{-0.03635, 0.03273};
  const auto pin = [&](const char* name, int one, int two, Place at) {
    m.joints.push_back({.kind = Joint::pin, .name = name, .a = one, .b = two, .at = at});
  };
  pin("O", world, 0, {}), pin("F", 0, 1, f), pin("B", world, 2, b), pin("E of BDE", 1, 2, e), pin("E of EG", 1, 3, e);
  pin("E of HE", 1, 5, e), pin("G", 3, 4, g), pin("H", 5, 6, h), pin("A of AG", world, 4, a),
      pin("A of AH", world, 6, a);
  m.springs = {{.name = "spring",
                .a = 2,
                .on_a = {-0.010472393888814623, 0.025357788530275246},
                .on_b = {0.014, 0.072},
                .stiffness = 4530,
                .free_length = 0.07785}};
  m.loads = [](double, const Motion&, Triples& w) { w[0][2] += 0.033; };
  return minimal(m);
}

/// IVP test set, solution at t = 0.03 s (PSIDE, tolerance 1e-14): beta, Theta, gamma, Phi, delta, Omega, epsilon with
/// first and second derivatives and multipliers. Multipliers are the forces at E on BDE, EG and HE.
Expected squeezer_published(double t) {
  if (std::abs(t - 0.03) > 1e-12) return {};
  const double q[3][7] = {{0.1581077119629904e2, -0.1575637105984298e2, 0.4082224013073101e-1, -0.5347301163226948,
                           0.5244099658805304, 0.5347301163226948, 0.1048080741042263e1},
                          {0.1139920302151208e4, -0.1424379294994111e4, 0.1103291221937134e2, 0.1929337464421385e2,
                           0.5735699284790808, -0.1929337464421385e2, 0.3231791658026955},
                          {-0.2463176316945196e5, 0.5185037701610329e5, 0.3241025686413781e6, 0.5667493645176213e6,
                           0.1674362929479361e5, -0.5667493645176222e6, 0.9826520791458422e4}};
  const double start[7] = {beta_0,
                           0,
                           0.455279819163070380255912382449,
                           0.222668390165885884674473185609,
                           0.487364979543842550225598953530,
                           -0.222668390165885884674473185609,
                           1.23054744454982119249735015568};
  const double lambda[6] = {0.1991753333731910e3, -0.2975531228015052e2, 0.2306654119098399e2,
                            0.3145271365475927e2, 0.2264249232082739e2,  0.1161740700019673e2};
  Expected out;
  const char* const words[3] = {".angle", ".spin", ".alpha"};
  for (std::size_t n = 0; n < 3; ++n) {
    double v[7];
    for (std::size_t i = 0; i < 7; ++i) v[i] = q[n][i] - (n == 0 ? start[i] : 0);
    const std::pair<const char*, double> bodies[] = {{"OF", v[0]},        {"FE", v[0] + v[1]}, {"BDE", v[2]},
                                                     {"EG", v[3] + v[4]}, {"AG", v[4]},        {"HE", v[5] + v[6]},
                                                     {"AH", v[6]}};
    for (const auto& [name, value] : bodies) out.push_back({std::string(name) + words[n], value});
  }
  const char* const joints[3] = {"E of BDE", "E of EG", "E of HE"};
  for (std::size_t k = 0; k < 3; ++k) {
    out.push_back({std::string(joints[k]) + ".fx", -lambda[2 * k]});
    out.push_back({std::string(joints[k]) + ".fy", -lambda[2 * k + 1]});
  }
  return out;
}

/// Crank 0.5 m, rod 1 m, spring-damper between their middles, 1 N on a point of the rod beyond the slider.
Reference sundials() {
  Mechanism m;
  m.gravity = 0;
  m.names = {"crank", "rod", "slider"};
  m.mass = {{1, 1, 1}, {0.5, 0.5, 2}, {0.5, 0.5, 1}};
  m.start = {pi / 2, 0};
  m.poses = [](const Coordinates& q, Jet) {
    const Point pin = polar(0.5, q[0]), slider{pin.x + sqrt(1 - pin.y * pin.y), 0};
    return Poses{{0, 0, q[0]}, {slider.x, 0, direction(pin, slider)}, {slider.x, 0, 0}};
  };
  const double root = std::sqrt(0.75);
  m.joints = {{.kind = Joint::pin, .name = "main pin", .b = 0},
              {.kind = Joint::pin, .name = "crank pin", .a = 0, .b = 1, .at = {0, 0.5}},
              {.kind = Joint::pin, .name = "slider pin", .a = 1, .b = 2, .at = {root, 0}},
              {.kind = Joint::slide, .name = "slide", .b = 2, .at = {root, 0}}};
  m.springs = {{.name = "spring",
                .a = 0,
                .b = 1,
                .on_a = {0, 0.25},
                .on_b = {root / 2, 0.25},
                .stiffness = 1,
                .free_length = 1,
                .damping = 1}};
  m.loads = [](double, const Motion& now, Triples& f) {
    f[1][0] += 1;
    f[1][2] += -std::sin(now.pose[1][2]);  // 1 N along x at 1 m along the rod
  };
  return minimal(m);
}

/// Printed by the example idaSlCrank_dns at rtol = atol = 1e-6: crank angle, slider, rod angle.
Expected sundials_published(double t) {
  struct Line {
    double t, q, x, p;
  };
  static constexpr Line lines[] = {{2, 5.7904e-01, 1.3803e+00, -2.7715e-01},
                                   {4, -1.2064e+00, 1.0623e+00, 4.8609e-01},
                                   {6, -1.1080e+00, 1.1176e+00, 4.6386e-01},
                                   {8, 6.4422e-01, 1.3536e+00, -3.0500e-01},
                                   {10, 1.2757e+00, 1.0236e+00, -4.9881e-01}};
  for (const Line& l : lines)
    if (std::abs(t - l.t) < 1e-9)
      return {{"crank.angle", l.q - pi / 2}, {"slider.x", l.x}, {"rod.angle", l.p + pi / 6}};
  return {};
}

/// Car axis: the axis turns about the origin so that its wheel end follows a bumpy road; one mass slides on its normal
/// through the origin, the other hangs on it by a massless bar of 1 m; springs carry both. Mass eps^2 M/2 = 5e-4.
Reference car_axis() {
  Mechanism m;
  m.gravity = 1;
  m.names = {"axis", "left", "right"};
  m.mass = {{1, 1, 0.1}, {5e-4, 5e-4, 1e-6}, {5e-4, 5e-4, 1e-14}};
  m.start = {0.5, 0, 0, 0};
  m.poses = [](const Coordinates& q, Jet t) {
    const Jet rise = 0.1 * sin(10 * t), run = sqrt(1 - rise * rise), turn = atan2(rise, run);
    const Point left{-q[0] * rise, q[0] * run}, right = left + polar(1, q[1]);
    return Poses{{run, rise, turn}, {left.x, left.y, turn}, {right.x, right.y, q[1]}};
  };
  m.joints = {{.kind = Joint::pin, .name = "hub", .b = 0},
              {.kind = Joint::ram, .name = "road", .b = 0, .at = {1, 0}, .angle = pi / 2},
              {.kind = Joint::slide, .name = "track", .a = 0, .b = 1, .at = {0, 0.5}, .angle = pi / 2},
              {.kind = Joint::pin, .name = "link", .a = 1, .b = 2, .at = {0, 0.5}}};
  m.springs = {
      {.name = "left spring", .b = 1, .on_b = {0, 0.5}, .stiffness = 1, .free_length = 0.5},
      {.name = "right spring", .a = 0, .b = 2, .on_a = {1, 0}, .on_b = {1, 0.5}, .stiffness = 1, .free_length = 0.5}};
  return minimal(m);
}

/// IVP test set, solution at t = 3 s (GAMD in quadruple precision); multipliers as the forces that they stand for.
Expected car_axis_published(double t) {
  if (std::abs(t - 3) > 1e-9) return {};
  const double x_l = 0.493455784275402809122e-1, y_l = 0.496989460230171153861, x_r = 0.104174252488542151681e1,
               y_r = 0.373911027265361256927, lambda_1 = -0.473688659084893324729e-2,
               lambda_2 = -0.110468033125734368808e-2, y_b = 0.1 * std::sin(30.0), x_b = std::sqrt(1 - y_b * y_b);
  return {{"left.x", x_l},
          {"left.y", y_l},
          {"right.x", x_r},
          {"right.y", y_r},
          {"left.vx", -0.770583684040972357970e-1},
          {"left.vy", 0.744686658723778553466e-2},
          {"right.vx", 0.175568157537232222276e-1},
          {"right.vy", 0.770341043779251976443},
          {"track.fx", -lambda_1 * x_b},
          {"track.fy", -lambda_1 * y_b},
          {"link.fx", 2 * lambda_2 * (x_l - x_r)},
          {"link.fy", 2 * lambda_2 * (y_l - y_r)}};
}

/// The example's gravity makes the period of a swing from the horizontal 2 s: every 2 s it is back at rest at (1, 0).
Expected sundials_pendulum_published(double t) {
  if (std::abs(std::remainder(t, 2.0)) > 1e-9) return {};
  return {{"mass.x", 1}, {"mass.y", 0}, {"mass.vx", 0}, {"mass.vy", 0}, {"mass.ay", -13.750371636040745}};
}

}  // namespace

std::vector<Case> published() {
  // The published squeezer itself is good to nine digits at 0.03 s, where its bodies accelerate by 1e6 rad/s^2.
  const Bounds squeezing{1e-10, 1e-7, 1e-4, 1e-7, 1e-10}, printed{1e-8, 1e-5, 1e-1, 1e-4, 1e-9},
      axis{1e-10, 1e-9, 1e-7, 1e-10, 1e-11};
  // The published bar has no inertia; ours has 2e-11 of the mass' own about its end, which speeds of 1 m/s show as
  // 1e-9.
  const Bounds massless{1e-10, 1e-8, 1e-7, 1e-10, 1e-11};
  return {
      {"andrews", "Hairer & Wanner VII.7, IFToMM benchmark A03; one minimal coordinate", squeezing, squeezer},
      {"andrews", "IVP test set, solution at 0.03 s (16 digits)", printed,
       [] { return Reference(squeezer_published); }},
      {"car-axis", "IVP test set; minimal coordinates", axis, car_axis},
      {"car-axis", "IVP test set, solution at 3 s (21 digits)", massless, [] { return Reference(car_axis_published); }},
      {"sundials-pendulum",
       "SUNDIALS cvPendulum_dns: at rest again every 2 s",
       {1e-9, 1e-9, 1e-8, 1e-8, 1e-9},
       [] { return Reference(sundials_pendulum_published); }},
      {"sundials-slider-crank",
       "SUNDIALS idaSlCrank_dns; one minimal coordinate",
       {1e-9, 1e-9, 1e-8, 1e-8, 1e-9},
       sundials},
      // The example's own error at its tolerance of 1e-6 is a few 1e-5.
      {"sundials-slider-crank",
       "SUNDIALS idaSlCrank_dns, printed output (5 digits)",
       {1e-4, 1e-4, 1e-4, 1e-4, 1e-4},
       [] { return Reference(sundials_published); }},
  };
}

}  // namespace subsoil::cases
