#pragma once

/// Growth of a small oscillation by the exchange between a bed and a machine, per machine step.
///
/// A body of mass m on a spring K and a dashpot C of the soil, over a window H of n soil steps. With a = K H^2/m and
/// c = C H/m, x and u = v H at the window's start:
///   explicit   s_j = x + u j/n + (g/2)(j/n)^2 with the change g of u in the window before, p the place before s_0,
///              f = -a mean(s_0 ... s_{n-1}) - c (s_{n-1} - p)
///   iterated   s_j = x + (z - x) j/n, z the end; q the displacement of the window before,
///              f = -a (x + z)/2 - c ((z - x)(n - 1/2)/n + q/(2 n))
///   u' = u + f,   z = x + u + f/2 where the machine takes the jump of the wrench exactly (Method::exact);
///   z = x + (9 u' + 19 u - 5 u_1 + u_2)/24 by Adams-Moulton of order 4 on the velocities u_1, u_2 of the windows
///   before, which bend at the jumps (mbd::WrenchJump::shift)
/// Growth is the maximum absolute eigenvalue of one window. For n = 1 and `exact` the explicit exchange is stable
/// (Jury) for
///   c (1 - c/2) > (a/2)(1 + c/2),   for small c: H < 2 C/K and m > C H/2
/// The iterated one is stable for all a and c.
namespace subsoil::coupling {

struct ContactMode {
  double stiffness, damping;  ///< of all contacts together, N/m and N s/m
  double mass;                ///< of the body, kg
};

enum class Method { exact, adams_moulton_4 };

double explicit_growth(const ContactMode& mode, double soil_step, int soil_steps,
                       Method method = Method::adams_moulton_4);
/// With Method::exact, as the program takes it.
double iterated_growth(const ContactMode& mode, double soil_step, int soil_steps);

}  // namespace subsoil::coupling
