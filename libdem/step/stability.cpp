#include "libdem/step/stability.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/friction.hpp"
#include "libdem/particles/particles.hpp"
#include "libdem/step/stiffness_bound.hpp"

namespace subsoil::dem {

double stable_step_of_mode(double a, double b) {
  if (a <= 0) return 2 / b;
  return (std::sqrt(b * b + 4 * a) - b) / a;
}

int most_neighbours(std::size_t spheres) {
  return static_cast<int>(std::min<std::size_t>(12, spheres > 0 ? spheres - 1 : 0));
}

namespace {

struct Mode {
  double a, b;
  const char* name;
};

/// Neighbours that a sphere is bonded to in a fibre.
constexpr int kAlongFibre = 2;

/// What a bond adds between spheres. Throws std::invalid_argument when its gap would bond spheres with others behind
/// their neighbours, which the count of neighbours does not cover.
void add_bond(const Bond& bond, const WorstContact& worst, double i_roll, bool between_spheres, StiffnessBound& bound,
              double& arm) {
  if (!between_spheres) return;
  if (bond.gap > 0.5 * worst.r_min)
    throw std::invalid_argument("`bond gap` = " + std::to_string(1e3 * bond.gap) +
                                " mm: at most half the smallest radius, " + std::to_string(1e3 * worst.r_min) +
                                " mm: a bond spans a gap, not a neighbour");
  const StiffnessBound b = bond.bound(worst, 2.0 / 7.0 * i_roll);
  bound.k_n += b.k_n, bound.k_t += b.k_t, bound.k_r += b.k_r;
  bound.c_n += b.c_n, bound.c_t += b.c_t, bound.c_r += b.c_r;
  arm = std::max(arm, worst.r_min + 0.5 * bond.gap);
}

}  // namespace

StiffnessBound stiffness_bound(const Law& law, const WorstContact& worst, double i_roll, bool between_spheres,
                               double& arm) {
  StiffnessBound bound = law->bound(worst);
  const Friction& friction = law->friction();
  friction.bound(bound, worst.m_eff, worst.r_eff, i_roll);
  // Rolling and sliding without friction have no spring to be unstable.
  if (!(friction.mu > 0)) bound.k_t = bound.c_t = 0;
  if (!friction.resists_rolling()) bound.k_r = bound.c_r = 0;
  arm = worst.r_min - std::min(0.5, friction.shares(between_spheres).force) * law->rest_overlap();
  if (friction.slip_moment_arm == SlipMomentArm::radius) arm = worst.r_min;
  // Bonds of a fibre join two neighbours of the many: stable_step adds them.
  if (law->bond() != nullptr && !law->bond()->replaces_contact())
    add_bond(*law->bond(), worst, i_roll, between_spheres, bound, arm);
  return bound;
}

namespace {

/// Laws that attract say whether their contact can hold that off; the worst may be the smallest or the largest spheres.
void refuse_collapse(const Law& law, std::initializer_list<double> r_eff) {
  for (const double r : r_eff) law->refuse_collapse(r);
}

StableStep smallest(std::initializer_list<Mode> modes, const char* where) {
  StableStep out{.step = std::numeric_limits<double>::infinity(), .cause = {}};
  for (const Mode& m : modes) {
    if (m.a <= 0 && m.b <= 0) continue;
    const double step = stable_step_of_mode(m.a, m.b);
    if (step >= out.step) continue;
    // Which of the two sets the limit: 2/b against 2/sqrt(a).
    const bool damped = m.b * m.b > m.a;
    out = {.step = step, .cause = std::string(damped ? "damping" : "stiffness") + " of " + m.name + " " + where};
  }
  return out;
}

}  // namespace

namespace {

/// Modes of a sphere of mass m among z equal neighbours.
std::array<Mode, 3> modes_among(const StiffnessBound& k, double z, double m, double inertia, double arm) {
  // Along one contact the whole normal stiffness acts; among many a third of each.
  const auto along = [&](double n, double t) {
    return std::max(std::min(z, 2.0) * n, z * (n / 3 + 2 * t / 3)) * 2 / m;
  };
  // A lone contact turns a sphere about two axes with its full arm.
  const auto about = [&](double t, double roll) {
    return std::max(1.0, z * 2 / 3) * 2 * (t * arm * arm + roll) / inertia;
  };
  // A lone contact slides by translation and rotation of both spheres at once: their mobilities add. Among many
  // contacts the fastest translation and the fastest rotation are different modes.
  const auto slide = [&](double t) { return 2 * t / m + 2 * t * arm * arm / inertia; };
  return {{{along(k.k_n, k.k_t), along(k.c_n, k.c_t), "translation"},
           {about(k.k_t, k.k_r), about(k.c_t, k.c_r), "rotation"},
           {slide(k.k_t), slide(k.c_t), "sliding of a pair"}}};
}

/// Of a sphere in a fibre: bonds along the row. A wave of number q along it has 4 k_n/m sin^2(q/2) along, and across
///     4 ((k_t/m + k_r/I) sin^2(q/2) + (k_t l^2/I) cos^2(q/2))
/// at most: shear is of rank one, u sin(q/2) against l theta cos(q/2), and bending adds to it.
std::array<Mode, 3> modes_along_fibre(const StiffnessBound& k, double m, double inertia, double arm) {
  const double twice = 2 * kAlongFibre;
  const auto across = [&](double t, double roll) {
    return twice * std::max(t / m + roll / inertia, t * arm * arm / inertia);
  };
  const Mode sway{across(k.k_t, k.k_r), across(k.c_t, k.c_r), ""};
  return {{{twice * k.k_n / m, twice * k.c_n / m, ""}, sway, sway}};
}

}  // namespace

StableStep stable_step(const Law& law, const StepQuestion& q) {
  const double r = q.smallest_radius, m = q.density * sphere_volume(r);
  const double inertia = 0.4 * m * r * r;
  const WorstContact worst{.m_eff = m / 2, .r_eff = r / 2, .r_min = r, .speed = q.speed, .overlap = q.overlap};
  const double i_roll = 0.7 * m * r * r;
  double arm = r;
  const bool in_fibres = law->bond() != nullptr && law->bond()->replaces_contact();
  const StiffnessBound k = stiffness_bound(law, worst, i_roll, true, arm);
  refuse_collapse(law, {r / 2, q.largest_radius / 2});
  if (q.neighbours <= 0) return {.step = std::numeric_limits<double>::infinity(), .cause = "nothing to touch"};
  std::array<Mode, 3> modes = modes_among(k, q.neighbours, m, inertia, arm);
  std::string where =
      "with " + std::to_string(q.neighbours) + " contacts on a sphere of radius " + std::to_string(r * 1e3) + " mm";
  if (in_fibres) {
    const std::array<Mode, 3> bonded = modes_along_fibre(law->bond()->bound(worst, 2.0 / 7.0 * i_roll), m, inertia, r);
    for (std::size_t n = 0; n < modes.size(); ++n) modes[n].a += bonded[n].a, modes[n].b += bonded[n].b;
    where += " in a fibre";
  }
  return smallest({modes[0], modes[1], modes[2]}, where.c_str());
}

StableStep stable_step_at_surface(const Law& law, const StepQuestion& q) {
  const double r = q.smallest_radius, m = q.density * sphere_volume(r);
  const double inertia = 0.4 * m * r * r;
  refuse_collapse(law, {r, q.largest_radius});
  double arm = r;
  const StiffnessBound k = stiffness_bound(
      law, {.m_eff = m, .r_eff = r, .r_min = r, .speed = q.speed, .overlap = q.overlap}, 1.4 * m * r * r, false, arm);
  // Two masses on one spring move with their reduced mass against each other.
  const double reduced = m / (1 + m / q.body_mass);
  // Three surfaces at right angles: along each normal one contact pushes and two drag.
  const auto along = [&](double n, double t) { return (n + 2 * t) / reduced; };
  const auto about = [&](double t, double roll) { return 2 * (t * arm * arm + roll) / inertia; };
  // Sliding at all three couples both: slip is v + l w x n, so the block between them is k_t l |n1 + n2 + n3|.
  const auto coupled = [&](double n, double t, double roll) {
    const double a = along(n, t), b = about(t, roll), c = std::sqrt(3.0) * t * arm / std::sqrt(reduced * inertia);
    return 0.5 * (a + b) + std::sqrt(0.25 * (a - b) * (a - b) + c * c);
  };
  return smallest({{coupled(k.k_n, k.k_t, k.k_r), coupled(k.c_n, k.c_t, k.c_r), "translation and rotation"}},
                  "in a corner of surfaces");
}

}  // namespace subsoil::dem
