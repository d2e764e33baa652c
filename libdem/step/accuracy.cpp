#include "libdem/step/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "libdem/laws/contact.hpp"
#include "libdem/particles/particles.hpp"

namespace subsoil::dem {
namespace {

constexpr int kPhases = 8;
constexpr int kEnds = 4;        ///< phases of a step in which a contact ends, where it lets go at once
constexpr double kFiner = 600;  ///< steps of the reference in a stable step
constexpr double kFinest = 60;  ///< accurate steps in a stable one at most: what jumps converges slowly
constexpr double kFinestOnBody = 300;
constexpr double kLongest = 400;  ///< stable steps after which a contact counts as one that stays

struct Bodies {
  double m_eff, r_eff, per_sum;
  double body = std::numeric_limits<double>::infinity();  ///< mass of the body that is struck
  int body_steps = 1;
  bool yields() const { return std::isfinite(body); }
};
Bodies bodies_of(const StepQuestion& q, bool at_surface) {
  const double r = q.smallest_radius, m = q.density * sphere_volume(r);
  if (at_surface) return {m, r, 0, q.body_mass, q.body_steps};
  return {m / 2, r / 2, 0.5 / r};
}

/// One mass on the law, which may be told of another mass.
Impact one_mass(const Law& law, double m_of_law, double m, double r_eff, double per_sum, double speed, double dt,
                double phase, double longest) {
  const double cutoff = law->cutoff(r_eff), root_m = std::sqrt(m_of_law);
  double own[kOwnMemory] = {}, overlap = -cutoff - phase * speed * dt, rate = speed;
  long steps = 0, touching = 0;
  while (static_cast<double>(steps) * dt < longest) {
    const NormalForce<double> n = law->normal({overlap, rate, root_m, r_eff, dt, per_sum}, own);
    rate -= n.force / m * dt;
    overlap += rate * dt;
    ++steps, touching += overlap > 0;
    if (overlap <= -cutoff && rate < 0)
      return {-rate / speed, static_cast<double>(steps) * dt, static_cast<double>(touching) * dt};
  }
  return {};
}

/// Of two bodies their reduced mass alone: without the error of their exchange.
Impact reference(const Law& law, const Bodies& b, double speed, double stable) {
  return one_mass(law, b.m_eff, b.m_eff / (1 + b.m_eff / b.body), b.r_eff, b.per_sum, speed, stable / kFiner, 0.5,
                  kLongest * stable);
}

Impact in_steps(const Law& law, const Bodies& b, double speed, double dt, double phase, double longest) {
  if (b.yields())
    return impact_on_body_in_steps(law, b.m_eff, b.r_eff, b.body, b.body_steps, speed, dt, phase, longest);
  return impact_in_steps(law, b.m_eff, b.r_eff, b.per_sum, speed, dt, phase, longest);
}

/// Whether a pull is there at once when bodies touch, or when they come near.
bool pulls_at_touch(const Law& law, const Bodies& b) {
  const auto pull = [&](double share) {
    double own[kOwnMemory] = {};
    return law->normal({share * b.r_eff, 0, std::sqrt(b.m_eff), b.r_eff, 0, b.per_sum}, own).attraction;
  };
  return pull(1e-9) > 1e-3 * pull(1e-2);
}

double error_of(const Law& law, const Bodies& b, double speed, double step, const Impact& exact, double stable) {
  // A pull that begins and ends between steps errs twice, and a touch of just so many steps lets both cancel.
  const int ends = exact.touching > step && pulls_at_touch(law, b) ? kEnds : 1;
  double worst = 0;
  for (int end = 0; end < ends; ++end) {
    const double dt = ends > 1 ? step * (1 - step / exact.touching * end / ends) : step;
    for (int k = 0; k < kPhases; ++k) {
      const Impact i = in_steps(law, b, speed, dt, (k + 0.5) / kPhases, kLongest * stable);
      worst = std::max(worst, std::abs(i.restitution - exact.restitution));
    }
  }
  return worst;
}

}  // namespace

Impact impact_in_steps(const Law& law, double m_eff, double r_eff, double per_sum, double speed, double dt,
                       double phase, double longest) {
  return one_mass(law, m_eff, m_eff, r_eff, per_sum, speed, dt, phase, longest);
}

Impact impact_on_body_in_steps(const Law& law, double m, double r, double body_mass, int body_steps, double speed,
                               double dt, double phase, double longest) {
  const double cutoff = law->cutoff(r), root_m = std::sqrt(m), window = body_steps * dt;
  double own[kOwnMemory] = {};
  double sphere = -cutoff - phase * speed * dt, v = speed;  // position of its foremost point
  double body = 0, body_v = 0, body_a = 0, mean = 0;        // at the start of the body's step, and the mean force in it
  double surface = 0, surface_v = 0;                        // as the spheres see it
  int in_window = 0;
  for (long steps = 1; static_cast<double>(steps) * dt < longest; ++steps) {
    const double rate = v - surface_v;
    const NormalForce<double> n = law->normal({sphere - surface, rate, root_m, r, dt, 0}, own);
    v -= n.force / m * dt;
    sphere += v * dt;
    mean += n.force / body_steps;
    double moved_to;
    if (++in_window == body_steps) {
      body_a = mean / body_mass;
      body += body_v * window + 0.5 * body_a * window * window;
      body_v += body_a * window;
      mean = 0, in_window = 0;
      moved_to = body;
    } else {
      const double t = in_window * dt;
      moved_to = body + body_v * t + 0.5 * body_a * t * t;
    }
    surface_v = (moved_to - surface) / dt;
    surface = moved_to;
    const double apart = v - (body_v + mean * window / body_mass);  // when the impulse is handed over
    if (sphere - surface <= -cutoff && apart < 0) return {-apart / speed, static_cast<double>(steps) * dt};
  }
  return {};
}

double restitution_at_surface(const Law& law, const StepQuestion& question, double stable) {
  return reference(law, bodies_of(question, true), question.speed, stable).restitution;
}

double speed_before_pull(const Law& law, const StepQuestion& question, bool at_surface, double met, double stable) {
  const Bodies b = bodies_of(question, at_surface);
  const double dt = stable / kFiner, m = b.m_eff / (1 + b.m_eff / b.body), root_m = std::sqrt(b.m_eff);
  double own[kOwnMemory] = {}, overlap = -law->cutoff(b.r_eff), rate = met;
  for (long steps = 0; static_cast<double>(steps) < kLongest * kFiner; ++steps) {
    const NormalForce<double> n = law->normal({overlap, rate, root_m, b.r_eff, dt, b.per_sum}, own);
    if (n.force > 0) break;
    rate -= n.force / m * dt;
    overlap += rate * dt;
  }
  return rate > met ? std::sqrt(std::max(0.0, 2 * met * met - rate * rate)) : met;
}

double restitution_error(const Law& law, const StepQuestion& question, bool at_surface, double step, double stable) {
  const Bodies b = bodies_of(question, at_surface);
  return error_of(law, b, question.speed, step, reference(law, b, question.speed, stable), stable);
}

AccurateStep accurate_step(const Law& law, const StepQuestion& question, bool at_surface, double tolerance,
                           double stable) {
  const Bodies b = bodies_of(question, at_surface);
  const Impact exact = reference(law, b, question.speed, stable);
  const auto error = [&](double step) { return error_of(law, b, question.speed, step, exact, stable); };
  // Damped contacts of n steps are off by 0.3/n to 0.6/n; what few steps hit by chance is not taken for accuracy.
  const double finest = stable / (b.yields() ? kFinestOnBody : kFinest);
  const double most = exact.duration > 0 ? std::min(stable, tolerance / 0.4 * exact.duration) : stable;
  AccurateStep out{.step = most, .error = error(most), .contact = exact.duration};
  if (out.error > tolerance && most > finest) {
    // Bisection in the logarithm: the error falls with the step but for the scatter of eight phases.
    double low = finest, high = most;
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
