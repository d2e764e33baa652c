#pragma once
#include <map>

#include "tests/tools/dem_beds.hpp"

/// A second engine, as plain as can be: every pair of spheres every step, Vec3 and double, histories in a map by id.
/// It takes only the normal laws from the product (they have their own tests); geometry, friction, rolling, moment
/// arms, time stepping are written here anew from the theory. Planes only.
namespace subsoil::dem::test {

struct History {
  Vec3 xi, rho;
  double twist = 0;  ///< angle of the twisting spring
  bool slipping = false;
  double own[kOwnMemory] = {};  ///< of the law
};

struct ContactResult {
  Vec3 force;  ///< on i
  Vec3 torque_i, torque_j;
};

/// One side of a contact.
struct Side {
  Vec3 v, w;
  double r, m;
};

/// A spring x and a dashpot with a limit.
struct Element {
  double k, c;
  double hold, slide;     ///< limit until it slips, and while it does
  bool together;          ///< the limit caps spring and dashpot, else the spring alone
  double kept;            ///< share of the dashpot beside a spring at its limit
  bool set_back = false;  ///< the spring goes back to the limit less the dashpot's part, wherever that is
};

/// Force against v after a step; `x` is what the spring was when the step began and becomes what it is now.
inline Vec3 limited(const Element& of, Vec3& x, const Vec3& v, double dt, bool& slips) {
  const Vec3 before = x;
  x += dt * v;
  const Vec3 all = of.together ? of.k * x + of.c * v : of.k * x;
  const double size = norm(all), limit = slips ? of.slide : of.hold;
  slips = size > limit;
  if (!slips) return of.together ? all : all + of.c * v;
  const Vec3 along = (1 / size) * all;
  if (of.k > 0 && of.set_back) {
    x = (1 / of.k) * (of.slide * along - of.c * v);
    return of.slide * along;
  }
  // Back by what exceeds the limit, until it is free along the force; where it stood against the force before, no
  // further than to the same stretch along it.
  const double stretch = dot(x, along), most = std::min(stretch, stretch + dot(before, along));
  if (of.k > 0) x -= std::max(0.0, std::min((size - of.slide) / of.k, most)) * along;
  return of.together ? of.slide * along : of.slide * along + (of.kept * of.c) * v;
}

inline bool together(FrictionRule rule) {
  return rule == FrictionRule::spring_and_dashpot || rule == FrictionRule::spring_set_back;
}

/// Arm about the centre of a sphere of radius r.
inline double arm_of(const Friction& friction, bool wall, double r, double overlap) {
  const bool own = wall && friction.surface_moment_arm != SurfaceMomentArm::by_moment_arm;
  if (own ? friction.surface_moment_arm == SurfaceMomentArm::radius : friction.moment_arm == MomentArm::radius)
    return r;
  if (own ? friction.surface_moment_arm == SurfaceMomentArm::mid_overlap
          : friction.moment_arm == MomentArm::mid_overlap && !wall)
    return r - overlap / 2;
  return r - overlap;
}

/// Normal force that friction is limited by.
inline double limiting_of(LimitingForce rule, const NormalForce<double>& n) {
  switch (rule) {
    case LimitingForce::absolute:
      return std::abs(n.force);
    case LimitingForce::positive:
      return std::max(0.0, n.force);
    case LimitingForce::elastic:
      return std::max(0.0, n.force - n.damping);
    case LimitingForce::plus_attraction:
      return std::max(0.0, n.force + n.attraction);
    case LimitingForce::absolute_plus_attraction:
      return std::abs(n.force + n.attraction);
    default:
      return n.limiting_force;
  }
}

inline double tangential_damping_of(const Friction& friction, const NormalForce<double>& n, double m_eff) {
  if (!std::isnan(friction.c_t)) return friction.c_t;
  if (!std::isnan(friction.e_t)) {
    const double log_e = std::log(friction.e_t);  // of the oscillator (2/7) m x'' + c x' + k x = 0
    return -2 * log_e / std::hypot(pi, log_e) * std::sqrt(2.0 / 7.0 * m_eff * n.k_t);
  }
  return friction.damping == TangentialDamping::none
             ? 0
             : friction.damping_factor * (friction.damping == TangentialDamping::of_law ? n.c_t : n.c_n);
}

/// Slip of a pair or a sphere at a surface in the middle of the step, turned with the normal to its end. @param arms
/// of i and j there
inline Vec3 middle_slip(const Vec3& n, const Vec3& turn, const Vec3& v, const Vec3& arms) {
  return v - dot(v, n) * (n - turn) - cross(arms + dot(arms, n) * turn, n);
}

/// n less the normal of the middle of the step, of a pair.
inline Vec3 turn_of_pair(const Vec3& n, double distance, const Side& i, const Side& j, double dt) {
  const Vec3 v = i.v - j.v;
  return (0.5 * dt / distance) * (v - dot(v, n) * n);
}

/// n from j to i, unit. j.r = 0: a surface whose point moves at j.v (already with its spin) and turns at j.w.
/// Velocities are of the middle of the step, where the normal was n - turn.
inline ContactResult reference_contact(const Law& law, const Vec3& n, double distance, const Vec3& turn, const Side& i,
                                       const Side& j, double dt, History& h) {
  const bool wall = j.r == 0;
  const double overlap = i.r + j.r - distance;
  const Friction& friction = law->friction();
  const bool at_radius = friction.slip_moment_arm == SlipMomentArm::radius;
  const double l_i = arm_of(friction, wall, i.r, overlap), l_j = wall ? 0 : arm_of(friction, wall, j.r, overlap);
  const Vec3 apart = i.v - j.v, mid = n - turn;
  const double then = overlap + 0.5 * dt * dot(apart, n), v_n = dot(apart, mid);
  const auto arm = [&](const Side& of) { return at_radius ? of.r : arm_of(friction, wall, of.r, then); };
  const Vec3 v_t = middle_slip(n, turn, apart, arm(i) * i.w + (wall ? 0 : arm(j)) * j.w);
  const double m_eff = wall ? i.m : i.m * j.m / (i.m + j.m), r_eff = wall ? i.r : i.r * j.r / (i.r + j.r);
  const double per_sum = wall ? 0 : 1 / (i.r + j.r);
  auto normal = law->normal({overlap, -v_n, std::sqrt(m_eff), r_eff, dt, per_sum}, h.own);
  normal.limiting_force = limiting_of(friction.limiting, normal);
  normal.c_t = tangential_damping_of(friction, normal, m_eff);
  ContactResult out;
  out.force = normal.force * n;
  if (!normal.in_contact) {
    h.xi = h.rho = {};
    h.twist = 0;
    h.slipping = false;
    return out;
  }
  const double ratio = normal.stiffness_ratio, keep = std::min(1.0, ratio);
  const double kept = friction.changing == Changing::keep_spring  ? 1
                      : friction.changing == Changing::keep_force ? ratio
                      : friction.changing == Changing::rescale    ? std::min(1.0, 1 / ratio)
                                                                  : keep;
  const double mu = law->friction().mu, mu_d = std::isnan(law->friction().mu_d) ? mu : law->friction().mu_d;
  const bool springs = law->friction().tangential == Tangential::spring;
  const FrictionRule rule = law->friction().rule;
  Vec3 xi = kept * (h.xi - dot(h.xi, n) * mid), pull;
  if (law->friction().tangential == Tangential::constant_direction)
    pull = (mu_d * normal.limiting_force / norm(v_t)) * v_t;
  else
    pull = limited({.k = springs ? normal.k_t : 0,
                    .c = normal.c_t,
                    .hold = mu * normal.limiting_force,
                    .slide = mu_d * normal.limiting_force,
                    .together = !springs || together(rule),
                    .kept = rule == FrictionRule::spring_only ? 1.0 : 0.0,
                    .set_back = rule == FrictionRule::spring_set_back},
                   xi, v_t, dt, h.slipping);
  h.xi = springs ? xi : Vec3{};
  out.force -= pull;
  // Rolling and twist: Ai's type C.
  const auto turning = [&](double k, double c, double cap) {
    return Element{
        .k = k, .c = c, .hold = cap, .slide = cap, .together = false, .kept = law->friction().rolling_damping_at_limit};
  };
  const Vec3 w_all = i.w - j.w, w = w_all - dot(w_all, n) * mid;
  const double cap = law->friction().mu_r * r_eff * normal.limiting_force;
  Vec3 moment;
  if (law->friction().rolling == Rolling::constant_torque) {
    if (norm(w) > 1e-12) moment = (cap / norm(w)) * w;
  } else if (law->friction().rolling == Rolling::elastic_plastic && law->friction().mu_r > 0) {
    const bool own_stiffness = !std::isnan(friction.k_r);
    const double k_r = own_stiffness ? friction.k_r : 2.25 * normal.k_n * std::pow(friction.mu_r * r_eff, 2);
    const double own = 1.4 * i.m * i.r * i.r, other = 1.4 * j.m * j.r * j.r;
    const double i_r = wall ? own : own * other / (own + other);
    h.rho = (own_stiffness ? 1 : keep) * (h.rho - dot(h.rho, n) * mid);
    bool slips = false;
    Element spring = turning(
        k_r, std::isnan(friction.c_r) ? 2 * friction.rolling_damping * std::sqrt(i_r * k_r) : friction.c_r, cap);
    spring.together = together(friction.rolling_rule);
    spring.set_back = friction.rolling_rule == FrictionRule::spring_set_back;
    moment = limited(spring, h.rho, w, dt, slips);
  }
  if (law->friction().mu_t > 0) {
    const double k = normal.k_n * std::pow(1.5 * law->friction().mu_t * r_eff, 2),
                 most = law->friction().mu_t * r_eff * normal.limiting_force;
    const double own = 0.4 * i.m * i.r * i.r, other = 0.4 * j.m * j.r * j.r;
    const double inertia = wall ? own : own * other / (own + other), spin = dot(w_all, mid);
    Vec3 angle = keep * h.twist * n;
    bool slips = false;
    moment += limited(turning(k, 2 * law->friction().rolling_damping * std::sqrt(inertia * k), most), angle, spin * n,
                      dt, slips);
    h.twist = dot(angle, n);
  }
  out.torque_i = cross(-l_i * n, -pull) - moment;
  out.torque_j = cross(l_j * n, pull) + moment;
  return out;
}

/// Parallel bond, from the equations of Potyondy & Cundall 2004: sums of forces and moments, which turn with the pair.
struct ReferenceBond {
  bool intact = false;
  double reference = 0, twisting = 0;  ///< m, N m
  Vec3 shear, bending;                 ///< N, N m, on i with the sign turned
};

/// Adds what the bond gives.
inline void reference_bond(const Bond& law, const Vec3& n, double distance, const Side& i, const Side& j, double dt,
                           ReferenceBond& b, ContactResult& out) {
  if (!b.intact) return;
  const double R = law.radius * std::min(i.r, j.r), A = pi * R * R, I = pi * std::pow(R, 4) / 4, J = 2 * I;
  const double k_n = law.modulus / (i.r + j.r), k_s = k_n / law.ratio, overlap = i.r + j.r - distance;
  const Vec3 to_i = -(i.r - overlap / 2) * n, to_j = (j.r - overlap / 2) * n;
  const Vec3 w = i.w - j.w, apart = i.v - j.v;
  const Vec3 turn = turn_of_pair(n, distance, i, j, dt), mid = n - turn;
  const double v_n = dot(apart, mid), w_n = dot(w, mid), about_n = 0.5 * dot(i.w + j.w, mid) * dt;
  const Vec3 roll = w - dot(w, n) * mid;
  const double sink = 0.5 * (overlap + 0.5 * dt * dot(apart, n));
  const Vec3 v_t = middle_slip(n, turn, apart, (i.r - sink) * i.w + (j.r - sink) * j.w);
  const auto carried = [&](const Vec3& force, const Vec3& more) {
    const Vec3 flat = force - dot(force, n) * mid, turned = flat + about_n * cross(n, flat);
    return (norm(turned) > 0 ? norm(force) / norm(turned) : 1) * turned + more;
  };
  b.shear = carried(b.shear, (k_s * A * dt) * v_t);
  b.bending = carried(b.bending, (k_n * I * dt) * roll);
  b.twisting += k_s * J * dt * w_n;
  const double normal = k_n * A * (overlap - b.reference);
  const double sigma = -normal / A + law.moment_share * norm(b.bending) * R / I;
  const double tau = norm(b.shear) / A + law.moment_share * std::abs(b.twisting) * R / J;
  if (sigma >= law.tensile || tau >= law.shear + normal / A * std::tan(law.friction_angle)) {
    b = {};
    return;
  }
  const double m = i.m * j.m / (i.m + j.m), own = 0.4 * i.m * i.r * i.r, other = 0.4 * j.m * j.r * j.r;
  const double inertia = own * other / (own + other), twice = 2 * law.damping;
  const Vec3 shear = b.shear + (twice * std::sqrt(m * k_s * A)) * v_t;
  const Vec3 moment = b.bending + (twice * std::sqrt(inertia * k_n * I)) * roll +
                      (b.twisting + twice * std::sqrt(inertia * k_s * J) * w_n) * n;
  const Vec3 force = (normal - twice * std::sqrt(m * k_n * A) * v_n) * n - shear;
  out.force += force;
  out.torque_i += cross(to_i, force) - moment;
  out.torque_j += cross(to_j, -force) + moment;
}

/// All pairs, every step.
class ReferenceBed {
 public:
  ReferenceBed(LawTable laws, const Vec3& gravity) : laws_(std::move(laws)), gravity_(gravity) {}

  std::vector<Sphere> spheres;
  std::vector<Plane> planes;
  std::vector<Vec3> force, torque;  ///< of the last step
  std::size_t pairs = 0;            ///< in reach at the last step
  std::size_t bonds = 0;            ///< intact at the last step

  void add(std::span<const SphereSpec> specs) {
    for (const SphereSpec& s : specs)
      spheres.push_back({s.position, s.radius, s.velocity, s.density * 4 / 3 * pi * std::pow(s.radius, 3),
                         s.angular_velocity, static_cast<std::uint32_t>(spheres.size()),
                         static_cast<std::uint16_t>(s.material), SphereKind::free, 0});
  }

  void step(double dt) {
    force.assign(spheres.size(), {});
    torque.assign(spheres.size(), {});
    pairs = bonds = 0;
    largest_ = 0;
    for (const Sphere& s : spheres) largest_ = std::max(largest_, s.r);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      for (std::size_t j = i + 1; j < spheres.size(); ++j) touch(i, j);
      for (std::size_t p = 0; p < planes.size(); ++p) touch_plane(i, p);
    }
    const double kick = 0.5 * (dt + dt_before_);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      Sphere& s = spheres[i];
      force[i] += s.m * gravity_;
      s.v += (kick / s.m) * force[i];
      s.w += (kick / (0.4 * s.m * s.r * s.r)) * torque[i];
      s.x += dt * s.v;
    }
    dt_before_ = dt;
    first_ = false;
  }

 private:
  const Law& law_of(int law) const { return laws_.laws[static_cast<std::size_t>(law)]; }

  ContactResult contact(int law, const Vec3& n, double distance, const Side& a, const Side& b, History& h) const {
    const Vec3 turn = b.r > 0 ? turn_of_pair(n, distance, a, b, dt_before_) : Vec3{};
    return reference_contact(law_of(law), n, distance, turn, a, b, dt_before_, h);
  }

  void touch(std::size_t i, std::size_t j) {
    const Sphere &a = spheres[i], &b = spheres[j];
    const double distance = norm(a.x - b.x);
    const int law = laws_.of(a.material, b.material);
    if (distance >= a.r + b.r + law_of(law)->pair_cutoff(largest_)) {
      history_.erase({i, j});
      return;
    }
    ++pairs;
    const Vec3 n = (1 / distance) * (a.x - b.x);
    const Side here{a.v, a.w, a.r, a.m}, there{b.v, b.w, b.r, b.m};
    auto c = contact(law, n, distance, here, there, history_[{i, j}]);
    if (const Bond* bond = law_of(law)->bond()) {
      ReferenceBond& state = bonds_[{i, j}];
      const double overlap = a.r + b.r - distance;
      if (first_ && overlap >= -bond->gap) state.intact = true, state.reference = overlap;
      reference_bond(*bond, n, distance, here, there, dt_before_, state, c);
      bonds += state.intact ? 1 : 0;
    }
    force[i] += c.force, force[j] -= c.force;
    torque[i] += c.torque_i, torque[j] += c.torque_j;
  }

  void touch_plane(std::size_t i, std::size_t p) {
    const Sphere& a = spheres[i];
    const double distance = dot(a.x - planes[p].point(), planes[p].normal());
    const int law = laws_.of(a.material, 0);
    if (distance > a.r + law_of(law)->cutoff(largest_)) {
      wall_history_.erase({i, p});
      return;
    }
    const auto c =
        contact(law, planes[p].normal(), distance, {a.v, a.w, a.r, a.m}, {{}, {}, 0, 0}, wall_history_[{i, p}]);
    force[i] += c.force;
    torque[i] += c.torque_i;
  }

  LawTable laws_;
  Vec3 gravity_;
  double dt_before_ = 0, largest_ = 0;
  bool first_ = true;
  std::map<std::pair<std::size_t, std::size_t>, History> history_, wall_history_;
  std::map<std::pair<std::size_t, std::size_t>, ReferenceBond> bonds_;
};

}  // namespace subsoil::dem::test
