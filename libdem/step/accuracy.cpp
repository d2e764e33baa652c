#include "libdem/step/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "libdem/laws/contact.hpp"
#include "libdem/particles/particles.hpp"

namespace subsoil::dem {
namespace {

constexpr int kPhases = 8;
constexpr double kFiner = 600;    ///< steps of the reference in a stable step
constexpr double kFinest = 60;    ///< accurate steps in a stable one at most: what jumps converges slowly
constexpr double kLongest = 400;  ///< stable steps after which a contact counts as one that stays

struct Bodies {
  double m_eff, r_eff, per_sum;
};
Bodies bodies_of(const StepQuestion& q, bool at_surface) {
  const double r = q.smallest_radius, m = q.density * sphere_volume(r);
  if (at_surface) return {m, r, 0};
  return {m / 2, r / 2, 0.5 / r};
}

Impact reference(const Law& law, const Bodies& b, double speed, double stable) {
  return impact_in_steps(law, b.m_eff, b.r_eff, b.per_sum, speed, stable / kFiner, 0.5, kLongest * stable);
}

double error_of(const Law& law, const Bodies& b, double speed, double step, double exact, double stable) {
  double worst = 0;
  for (int k = 0; k < kPhases; ++k) {
    const Impact i =
        impact_in_steps(law, b.m_eff, b.r_eff, b.per_sum, speed, step, (k + 0.5) / kPhases, kLongest * stable);
    worst = std::max(worst, std::abs(i.restitution - exact));
  }
  return worst;
}

}  // namespace

Impact impact_in_steps(const Law& law, double m_eff, double r_eff, double per_sum, double speed, double dt,
                       double phase, double longest) {
  const double cutoff = law->cutoff(r_eff), root_m = std::sqrt(m_eff);
  double own[kOwnMemory] = {}, overlap = -cutoff - phase * speed * dt, rate = speed;
  bool met = false;
  long steps = 0;
  while (static_cast<double>(steps) * dt < longest) {
    const NormalForce<double> n = law->normal(Approach<double>{overlap, rate, root_m, r_eff, dt, per_sum}, own);
    rate -= n.force / m_eff * dt;
    overlap += rate * dt;
    steps += met ? 1 : 0;
    if (overlap > -cutoff) {
      met = true;
    } else if (met) {
      return {std::max(0.0, -rate / speed), static_cast<double>(steps) * dt};
    }
    if (!met) longest -= dt;
  }
  return {};
}

double restitution_error(const Law& law, const StepQuestion& question, bool at_surface, double step, double stable) {
  const Bodies b = bodies_of(question, at_surface);
  return error_of(law, b, question.speed, step, reference(law, b, question.speed, stable).restitution, stable);
}

AccurateStep accurate_step(const Law& law, const StepQuestion& question, bool at_surface, double tolerance,
                           double stable) {
  const Bodies b = bodies_of(question, at_surface);
  const Impact exact = reference(law, b, question.speed, stable);
  const auto error = [&](double step) { return error_of(law, b, question.speed, step, exact.restitution, stable); };
  // Damped contacts of n steps are off by 0.3/n to 0.6/n; what few steps hit by chance is not taken for accuracy.
  const double most = exact.duration > 0 ? std::min(stable, tolerance / 0.4 * exact.duration) : stable;
  AccurateStep out{.step = most, .error = error(most), .contact = exact.duration};
  if (out.error > tolerance && most > stable / kFinest) {
    // Bisection in the logarithm: the error falls with the step but for the scatter of eight phases.
    double low = stable / kFinest, high = most;
    for (int k = 0; k < 12; ++k) {
      const double middle = std::sqrt(low * high);
      (error(middle) <= tolerance ? low : high) = middle;
    }
    out.step = low, out.error = error(low);
  }
  char text[120];
  std::snprintf(text, sizeof text, "an impact at %.3g m/s", question.speed);
  out.cause = text;
  if (exact.duration > 0) {
    std::snprintf(text, sizeof text, " that lasts %.0f steps", exact.duration / out.step);
    out.cause += text;
  }
  return out;
}

}  // namespace subsoil::dem
