#include "tests/verification/mechanisms/cases/minimal_coordinates.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>

#include "tests/tools/reference_ode.hpp"

namespace subsoil::test {

namespace {
std::size_t at(int body) { return static_cast<std::size_t>(body); }
/// Row r of all bodies' coordinates one after the other.
double& row(Triples& of, Eigen::Index r) {
  return of[static_cast<std::size_t>(r / 3)][static_cast<std::size_t>(r % 3)];
}
double row(const Triples& of, Eigen::Index r) {
  return of[static_cast<std::size_t>(r / 3)][static_cast<std::size_t>(r % 3)];
}
}  // namespace

MinimalCoordinates::MinimalCoordinates(Mechanism mechanism)
    : m_(std::move(mechanism)), y_(m_.start), n_(m_.start.size() / 2) {
  const std::vector<Jet> q(y_.begin(), y_.begin() + static_cast<std::ptrdiff_t>(n_));
  for (const Pose& p : m_.poses(q, Jet(0))) start_.push_back({p[0].v, p[1].v, p[2].v});
  if (start_.size() != m_.mass.size() || start_.size() != m_.names.size())
    throw std::logic_error("a name, a mass and a pose for every body");
}

Expected MinimalCoordinates::at(double t) {
  if (n_ > 0 && t > t_)
    y_ = solve_ode([this](const OdeState& y, OdeState& d, double s) { accelerate(y, d, s); }, y_, t_, t);
  t_ = t;
  OdeState rates(2 * n_);
  const Motion now = accelerate(y_, rates, t);
  Expected out;
  report_bodies(now, out);
  report_joints(t, now, out);
  for (const Spring& s : m_.springs) {
    const Line l = line(s, now);
    out.push_back({s.name + ".force", s.stiffness * (s.free_length - l.length) - s.damping * l.rate});
    out.push_back({s.name + ".length", l.length});
  }
  report_energies(now, out);
  return out;
}

MinimalCoordinates::Carried MinimalCoordinates::carried(int body, Place p, const Motion& now) const {
  if (body == world) return {p.x, p.y, 0, 0, {}};
  const Triple &from = start_[test::at(body)], &to = now.pose[test::at(body)], &v = now.velocity[test::at(body)];
  const double turn = to[2] - from[2], c = std::cos(turn), s = std::sin(turn), dx = p.x - from[0], dy = p.y - from[1];
  const Place lever{c * dx - s * dy, s * dx + c * dy};
  return {to[0] + lever.x, to[1] + lever.y, v[0] - v[2] * lever.y, v[1] + v[2] * lever.x, lever};
}

MinimalCoordinates::Line MinimalCoordinates::line(const Spring& s, const Motion& now) const {
  const Carried a = carried(s.a, s.on_a, now), b = carried(s.b, s.on_b, now);
  const double x = b.x - a.x, y = b.y - a.y, length = std::hypot(x, y);
  return {x / length, y / length, length, (x * (b.vx - a.vx) + y * (b.vy - a.vy)) / length, a.lever, b.lever};
}

/// Given forces on all bodies: weight, springs, loads.
Triples MinimalCoordinates::given(double t, const Motion& now) const {
  Triples f(m_.mass.size());
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = {0, -m_.mass[i][0] * m_.gravity, 0};
  const auto add = [&](int body, Place lever, double fx, double fy) {
    if (body == world) return;
    Triple& w = f[test::at(body)];
    w[0] += fx, w[1] += fy, w[2] += lever.x * fy - lever.y * fx;
  };
  for (const Spring& s : m_.springs) {
    const Line l = line(s, now);
    const double push = s.stiffness * (s.free_length - l.length) - s.damping * l.rate;
    add(s.b, l.on_b, push * l.x, push * l.y);
    add(s.a, l.on_a, -push * l.x, -push * l.y);
  }
  if (m_.loads) m_.loads(t, now, f);
  return f;
}

/// rates = (q', q''): J^T M J q'' = J^T (F - M J' q'), J = dx/dq. The way along (q', 1) in (q, t) gives x' and J' q';
/// steps along each coordinate give the columns of J.
Motion MinimalCoordinates::accelerate(const OdeState& y, OdeState& rates, double t) const {
  std::vector<Jet> q(n_);
  for (std::size_t k = 0; k < n_; ++k) q[k] = {y[k], y[n_ + k], 0};
  Motion now;
  for (const Pose& p : m_.poses(q, Jet(t, 1, 0))) {
    now.pose.push_back({p[0].v, p[1].v, p[2].v});
    now.velocity.push_back({p[0].d, p[1].d, p[2].d});
    now.acceleration.push_back({p[0].dd, p[1].dd, p[2].dd});
  }
  if (n_ == 0) return now;
  const auto rows = static_cast<Eigen::Index>(3 * now.pose.size()), columns = static_cast<Eigen::Index>(n_);
  Eigen::MatrixXd j(rows, columns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    for (std::size_t i = 0; i < n_; ++i) q[i] = {y[i], static_cast<Eigen::Index>(i) == k ? 1.0 : 0.0, 0};
    const std::vector<Pose> step = m_.poses(q, Jet(t));
    for (Eigen::Index r = 0; r < rows; ++r)
      j(r, k) = step[static_cast<std::size_t>(r / 3)][static_cast<std::size_t>(r % 3)].d;
  }
  const Triples f = given(t, now);
  Eigen::VectorXd rest(rows);
  Eigen::MatrixXd mass_j = j;
  for (Eigen::Index r = 0; r < rows; ++r) {
    rest[r] = row(f, r) - row(m_.mass, r) * row(now.acceleration, r);
    mass_j.row(r) *= row(m_.mass, r);
  }
  const Eigen::MatrixXd m = j.transpose() * mass_j;
  const Eigen::VectorXd load = j.transpose() * rest, curve = m.ldlt().solve(load), more = j * curve;
  for (std::size_t k = 0; k < n_; ++k) rates[k] = y[n_ + k], rates[n_ + k] = curve[static_cast<Eigen::Index>(k)];
  for (Eigen::Index r = 0; r < rows; ++r) row(now.acceleration, r) += more[r];
  return now;
}

void MinimalCoordinates::report_bodies(const Motion& now, Expected& out) const {
  static constexpr const char* words[3][3] = {
      {".x", ".y", ".angle"}, {".vx", ".vy", ".spin"}, {".ax", ".ay", ".alpha"}};
  const Triples* const values[3] = {&now.pose, &now.velocity, &now.acceleration};
  for (std::size_t i = 0; i < m_.names.size(); ++i)
    for (std::size_t order = 0; order < 3; ++order)
      for (std::size_t c = 0; c < 3; ++c) {
        const double zero = order == 0 && c == 2 ? start_[i][2] : 0.0;
        out.push_back({m_.names[i] + words[order][c], (*values[order])[i][c] - zero});
      }
}

void MinimalCoordinates::report_energies(const Motion& now, Expected& out) const {
  double kinetic = 0, potential = 0;
  for (std::size_t i = 0; i < m_.mass.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) kinetic += 0.5 * m_.mass[i][c] * now.velocity[i][c] * now.velocity[i][c];
    potential += m_.mass[i][0] * m_.gravity * now.pose[i][1];
  }
  out.insert(out.end(), {{"energy.kinetic", kinetic}, {"energy.potential", potential}, {"energy.balance", 0.0}});
}

/// Unit forces and moments on a, at the joint, of which its reaction is made.
Triples MinimalCoordinates::units_of(const Joint& j, const Motion& now) const {
  const double turn = j.a == world ? 0 : now.pose[test::at(j.a)][2] - start_[test::at(j.a)][2];
  const double c = std::cos(j.angle + turn), s = std::sin(j.angle + turn);
  switch (j.kind) {
    case Joint::pin:
      return {{1, 0, 0}, {0, 1, 0}};
    case Joint::slide:
      return {{-s, c, 0}, {0, 0, 1}};
    case Joint::weld:
      return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case Joint::motor:
      return {{0, 0, -1}};
    case Joint::ram:
      return {{-c, -s, 0}};
  }
  return {};
}

/// Force and moment of every joint from M a = F + reactions, body by body; more equations than unknowns, which must
/// agree: what is left over would be a fault of this reference.
void MinimalCoordinates::report_joints(double t, const Motion& now, Expected& out) const {
  if (m_.joints.empty()) return;
  const auto rows = static_cast<Eigen::Index>(3 * m_.mass.size());
  const Triples f = given(t, now);
  Eigen::VectorXd need(rows);
  for (Eigen::Index r = 0; r < rows; ++r) need[r] = row(m_.mass, r) * row(now.acceleration, r) - row(f, r);
  std::vector<Triples> units;
  Eigen::MatrixXd effect(rows, 0);
  for (const Joint& j : m_.joints) {
    units.push_back(units_of(j, now));
    const Carried place = carried(j.b == world ? j.a : j.b, j.at, now);
    for (const Triple& u : units.back()) {
      effect.conservativeResize(rows, effect.cols() + 1);
      effect.rightCols(1).setZero();
      for (const auto& [body, sign] : {std::pair{j.a, 1.0}, std::pair{j.b, -1.0}}) {
        if (body == world) continue;
        const Triple& centre = now.pose[test::at(body)];
        const double moment = u[2] + (place.x - centre[0]) * u[1] - (place.y - centre[1]) * u[0];
        effect.rightCols(1).middleRows(3 * body, 3) = sign * Eigen::Vector3d(u[0], u[1], moment);
      }
    }
  }
  const Eigen::VectorXd found = effect.colPivHouseholderQr().solve(need);
  if ((effect * found - need).norm() > 1e-9 * (1 + need.norm()))
    throw std::logic_error("the reference's free-body diagrams contradict each other at t = " + std::to_string(t));
  Eigen::Index next = 0;
  for (std::size_t k = 0; k < m_.joints.size(); ++k) {
    const Joint& j = m_.joints[k];
    if (j.kind == Joint::motor || j.kind == Joint::ram) {
      out.push_back({j.name + (j.kind == Joint::motor ? ".torque" : ".force"), found[next++]});
      continue;
    }
    Triple sum{};
    for (const Triple& u : units[k]) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += found[next] * u[c];
      ++next;
    }
    out.insert(out.end(), {{j.name + ".fx", sum[0]}, {j.name + ".fy", sum[1]}, {j.name + ".moment", sum[2]}});
  }
}

}  // namespace subsoil::test
