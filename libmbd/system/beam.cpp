#include "libmbd/system/beam.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "libmbd/base/spline.hpp"
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

namespace {

// Radius of the largest half disk in the left half plane on which the PECE method of order 1 ... 6 is stable.
constexpr std::array<double, 6> stable_radius{1.0, 1.28, 1.14, 0.9, 0.68, 0.52};
constexpr double safety = 0.8;

std::vector<double> gregory_weights(std::size_t elements) {
  if (elements == 1) return {0.5, 0.5};
  constexpr std::array<double, 3> ends{3. / 8 - 1, 7. / 6 - 1, 23. / 24 - 1};
  std::vector<double> w(elements + 1, 1.0);
  for (std::size_t i = 0; i < std::min<std::size_t>(3, w.size()); ++i) w[i] += ends[i], w[elements - i] += ends[i];
  return w;
}

/// The axis as two splines over the length of the chords, walked by its arc.
class Axis {
 public:
  explicit Axis(const std::vector<std::array<double, 2>>& points) {
    std::vector<double> u{0}, x{points[0][0]}, y{points[0][1]};
    for (std::size_t i = 1; i < points.size(); ++i) {
      u.push_back(u.back() + std::hypot(points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]));
      x.push_back(points[i][0]), y.push_back(points[i][1]);
    }
    x_ = PiecewiseCubic(u, x, PiecewiseCubic::Ends::natural), y_ = PiecewiseCubic(u, y, PiecewiseCubic::Ends::natural);
    knots_ = u, arcs_ = {0};
    for (std::size_t i = 1; i < u.size(); ++i) arcs_.push_back(arcs_.back() + arc(u[i - 1], u[i]));
  }
  double length() const { return arcs_.back(); }
  /// Parameter at an arc length, by Newton's method from the chord.
  double at_arc(double s) const {
    std::size_t i = 1;
    while (i + 1 < arcs_.size() && arcs_[i] < s) ++i;
    double u = knots_[i - 1] + (knots_[i] - knots_[i - 1]) * (s - arcs_[i - 1]) / (arcs_[i] - arcs_[i - 1]);
    for (int k = 0; k < 20; ++k) u -= (arcs_[i - 1] + arc(knots_[i - 1], u) - s) / speed(u);
    return u;
  }
  Vec2 point(double u) const { return {x_.at(u).value, y_.at(u).value}; }
  Vec2 tangent(double u) const { return {x_.at(u).first, y_.at(u).first}; }

 private:
  double speed(double u) const { return mbd::length(tangent(u)); }
  /// Gauss' five points on each of eight parts.
  double arc(double from, double to) const {
    constexpr std::array<double, 5> at{-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                                       0.9061798459386640};
    constexpr std::array<double, 5> weight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                           0.4786286704993665, 0.2369268850561891};
    constexpr int parts = 8;
    const double half = (to - from) / (2 * parts);
    double sum = 0;
    for (int part = 0; part < parts; ++part)
      for (std::size_t k = 0; k < at.size(); ++k) sum += weight[k] * speed(from + half * (2 * part + 1 + at[k]));
    return half * sum;
  }

  PiecewiseCubic x_, y_;
  std::vector<double> knots_, arcs_;
};

Body node_of(const Beam& beam, long i, Vec2 r, Vec2 r_first, double angle, double mass, double inertia) {
  const Vec2 v = Vec2{beam.velocity[0], beam.velocity[1]} + beam.spin * turned(r - r_first);
  return {.name = beam.node_name(i),
          .mass = mass,
          .inertia = inertia,
          .pose = {r.x, r.y, angle},
          .velocity = {v.x, v.y, beam.spin}};
}

/// Larger eigenvalue of [[a, c], [c, b]].
double larger_eigenvalue(double a, double b, double c) { return (a + b) / 2 + std::hypot((a - b) / 2, c); }

/// Bound of w^2 of an element whose nodes have these masses and inertias, at p_a, p_b from the centres of gravity.
double fastest_square(const BeamElement& e, std::array<double, 2> mass, std::array<double, 2> inertia) {
  const double arm[2] = {std::hypot(e.p_a[0], e.p_a[1]), std::hypot(e.p_b[0], e.p_b[1])}, l = e.length;
  double along = 0, across = 0, turning = 0, mixed = 0;  // c_j^T M^-1 c_k of the three strains
  for (std::size_t i = 0; i < 2; ++i) {
    along += 1 / mass[i] + arm[i] * arm[i] / inertia[i];
    const double lever = l / 2 + arm[i];
    across += 1 / mass[i] + lever * lever / inertia[i];
    turning += 1 / inertia[i];
    mixed += (i == 0 ? 1 : -1) * lever / inertia[i];
  }
  const double k = e.shear_spring(), bending = e.bending_stiffness / l;
  return std::max(e.axial_stiffness / l * along,
                  larger_eigenvalue(k * across, bending * turning, std::sqrt(k * bending) * mixed));
}

}  // namespace

SectionValues values_of(const SectionForm& section, double poisson) {
  return std::visit([poisson](const auto& s) { return s.values(poisson); }, section);
}

std::string Beam::node_name(long node) const {
  if (node == 0) return name + " start";
  return node == elements ? name + " end" : name + " " + std::to_string(node);
}

void Beam::check() const {
  if (points.size() < 2) throw std::invalid_argument("points: a beam needs at least two");
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i] == points[i - 1])
      throw std::invalid_argument("points: point " + std::to_string(i + 1) + " is the one before it; leave one out");
  const auto positive = [](const auto& sizes) {
    return std::all_of(sizes.begin(), sizes.end(), [](double size) { return size > 0; });
  };
  std::visit(
      [&]<class Section>(const Section& form) {
        if constexpr (requires { form.size; })
          if (!positive(form.size)) throw std::invalid_argument("section: its sizes must be above 0");
      },
      section);
  if (const auto* box = std::get_if<HollowRectangleSection>(&section))
    if (!(2 * box->size[2] <= std::min(box->size[0], box->size[1])))
      throw std::invalid_argument("section: the walls of the hollow rectangle are thicker than half of it");
  if (const auto* tube = std::get_if<TubeSection>(&section))
    if (!(2 * tube->size[1] <= tube->size[0]))
      throw std::invalid_argument("section: the wall of the tube is thicker than its radius");
  if (!std::isnan(damping_ratio) && damping_time > 0)
    throw std::invalid_argument("damping time: stands beside `damping ratio`, which says the same; keep one");
}

double first_frequency(double young, double density, const SectionValues& section, double length) {
  constexpr double first_root = 1.8751040687119611;  // of 1 + cos cosh = 0
  const double k = first_root / length;
  return k * k * std::sqrt(young * section.second_moment / (density * section.area));
}

DividedBeam divide(const Beam& beam) {
  DividedBeam out;
  const Axis axis(beam.points);
  const auto n = static_cast<std::size_t>(beam.elements);
  out.length = axis.length();
  const SectionValues s = out.section = values_of(beam.section, beam.poisson);
  const double l = out.length / static_cast<double>(n), shear_modulus = beam.young / (2 * (1 + beam.poisson));
  out.damping_time = std::isnan(beam.damping_ratio)
                         ? beam.damping_time
                         : 2 * beam.damping_ratio / first_frequency(beam.young, beam.density, s, out.length);
  const std::vector<double> weights = gregory_weights(n);
  double angle = 0;
  const Vec2 first = axis.point(0);
  for (std::size_t i = 0; i <= n; ++i) {
    out.places.push_back(l * static_cast<double>(i));
    const double u = axis.at_arc(out.places.back());
    const Vec2 r = axis.point(u), t = axis.tangent(u);
    const double next = std::atan2(t.y, t.x);
    angle = i == 0 ? next : angle + std::remainder(next - angle, 2 * std::numbers::pi);
    out.nodes.push_back(node_of(beam, static_cast<long>(i), r, first, angle, weights[i] * beam.density * s.area * l,
                                weights[i] * beam.density * s.second_moment * l));
  }
  for (std::size_t i = 1; i <= n; ++i) {
    BeamElement e{.body_a = static_cast<int>(i) - 1, .body_b = static_cast<int>(i)};
    e.axial_stiffness = beam.young * s.area, e.bending_stiffness = beam.young * s.second_moment;
    if (s.shear_share > 0) e.shear_stiffness = shear_modulus * s.shear_share * s.area;
    e.damping_time = out.damping_time, e.area = s.area, e.section_modulus = s.second_moment / s.edge;
    e.length = l, e.placed = true;
    const auto state = [&](std::size_t node) {
      const auto& pose = out.nodes[node].pose;
      return BodyState({pose[0], pose[1]}, pose[2], {}, 0);
    };
    const auto start = [&] { return e.strain(state(i - 1), state(i)).value; };
    e.rest_turn = start()[2], e.rest[1] = start()[1];
    e.rest[0] = start()[0];  // depends on the one across
    out.elements.push_back(e);
  }
  return out;
}

double longest_beam_step(const Model& model, int order) {
  std::vector<double> shares(model.bodies.size() + 1, 0.0);  // elements at each body
  for (const auto& f : model.forces)
    if (const auto* e = f.element.get_if<BeamElement>())
      for (const int body : {e->body_a, e->body_b}) shares[static_cast<std::size_t>(body)] += 1;
  double longest = std::numeric_limits<double>::infinity();
  for (const auto& f : model.forces) {
    const auto* e = f.element.get_if<BeamElement>();
    if (e == nullptr || std::isnan(e->length)) continue;
    std::array<double, 2> mass{}, inertia{};
    for (std::size_t i = 0; i < 2; ++i) {
      const int body = i == 0 ? e->body_a : e->body_b;
      const auto k = static_cast<std::size_t>(body);
      const double none = std::numeric_limits<double>::infinity();  // the ground does not move
      mass[i] = body == ground ? none : model.bodies[k - 1].mass / shares[k];
      inertia[i] = body == ground ? none : model.bodies[k - 1].inertia / shares[k];
    }
    const double square = fastest_square(*e, mass, inertia),
                 rate = std::max(std::sqrt(square), e->damping_time * square);
    longest = std::min(longest, safety * stable_radius[static_cast<std::size_t>(order - 1)] / rate);
  }
  return longest;
}

}  // namespace subsoil::mbd
