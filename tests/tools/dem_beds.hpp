#pragma once
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "libdem/bed.hpp"

/// What the tests of the bed share: laws with usual numbers, beds of one law, spheres by the user's number, hashes.
namespace subsoil::dem::test {

inline constexpr double pi = std::numbers::pi;

/// Table 3 between particles, read in N/m: the pair's values.
inline Wet soil() {
  Wet w;
  w.K_X = 10000, w.C_X = 20, w.K_Y = 8000, w.C_Y = 20, w.K_B = 7000, w.dc = w.dB = 2e-3, w.D = 0;
  w.friction.mu = 0.5, w.friction.mu_r = 0.3;
  return w;
}

inline Linear grains(double k_n = 1e5, double restitution = 0.6, double mu = 0.4, double mu_r = 0.05) {
  Linear l;
  l.k_n = k_n, l.restitution = restitution;
  l.friction.mu = mu, l.friction.mu_r = mu_r;
  return l;
}

inline HertzMindlin elastic(double young, double poisson, double restitution, double mu, double mu_r = 0) {
  HertzMindlin h;
  h.take_materials(young, poisson, young, poisson);
  h.restitution = restitution;
  h.friction.mu = mu, h.friction.mu_r = mu_r;
  return h;
}

/// The law between a deformable sphere and a rigid surface.
inline HertzMindlin against_rigid(double young, double poisson, double restitution, double mu) {
  HertzMindlin h;
  h.E_eff = young / (1 - poisson * poisson);
  h.G_eff = young / (2 * (1 + poisson) * (2 - poisson));
  h.restitution = restitution;
  h.friction.mu = mu;
  return h;
}

/// Hunt-Crossley with c of its own.
inline HuntCrossley viscoelastic(double n, double c, double b, double mu, double mu_r = 0) {
  HuntCrossley h;
  h.impact.n = n, h.impact.c = c, h.impact.b = b;
  h.friction.mu = mu, h.friction.mu_r = mu_r;
  return h;
}

/// Soil after Ucgul, Fielke & Saunders: loading stiffness from the yield strength.
inline Hysteretic compactable(double yield = 5.88e5, double restitution = 0.6, double mu = 0.4, double mu_r = 0.05) {
  Hysteretic h;
  h.yield = yield, h.restitution = restitution;
  h.friction.mu = mu, h.friction.mu_r = mu_r;
  return h;
}

inline Luding sticky(double k1 = 1e4, double k2 = 5e4, double k_c = 1e4, double phi_f = 0.1, double mu = 0.4) {
  Luding l;
  l.k1 = k1, l.k2 = k2, l.k_c = k_c, l.phi_f = phi_f, l.damping = 0.05;
  l.friction.mu = mu, l.friction.mu_r = 0.05;
  return l;
}

inline Eepa powder(double n, double k1, double plasticity, double surface_energy, double restitution = 0.7) {
  Eepa e;
  e.n = n, e.k1 = k1, e.plasticity = plasticity, e.w = surface_energy, e.restitution = restitution;
  e.friction.mu = 0.4, e.friction.mu_r = 0.05;
  return e;
}

/// Softer than the map's metals, so that it yields in a test's bed; what is placed in touch bounces less each time.
inline VariableRestitution yielding(VariableRestitution::Normal part) {
  VariableRestitution v;
  v.part = part, v.E_eff = 1e7, v.map.S_y = 2e5, v.map.density = 1800, v.largest = 0.95;
  if (part == VariableRestitution::Normal::linear) v.k_n = 1e5;
  v.friction.mu = 0.4, v.friction.mu_r = 0.05;
  return v;
}

/// Soft adhesive spheres, a contact radius of 0.3 mm without load.
inline Jkr tacky(double work = 1, double restitution = 0.7, double mu = 0.4, double mu_r = 0.05) {
  Jkr j;
  j.take_materials(1e7, 0.3, 1e7, 0.3);
  j.work = work, j.restitution = restitution;
  j.friction.mu = mu, j.friction.mu_r = mu_r;
  return j;
}

inline Cohesion cohesion_by_area(double density, Cohesion::Area area = Cohesion::Area::lens) {
  Cohesion c;
  c.kind = Cohesion::Kind::linear, c.density = density, c.area = area;
  return c;
}
inline Cohesion dmt(double work) {
  Cohesion c;
  c.kind = Cohesion::Kind::dmt, c.work = work;
  return c;
}
/// Water between spheres of some millimetres.
inline Cohesion water(double volume = 1e-9, double angle = 0.3) {
  Cohesion c;
  c.kind = Cohesion::Kind::liquid_bridge;
  c.tension = 0.072, c.angle = angle, c.volume = volume;
  return c;
}
/// Cement between spheres of some millimetres that grains thrown about in a test break in part.
inline Bond cement(double modulus = 1.5e7, double strength = 2e5) {
  Bond b;
  b.kind = Bond::Kind::parallel;
  b.modulus = modulus, b.tensile = strength, b.shear = strength, b.gap = 1e-3;
  return b;
}
template <class Normal>
Normal with(Normal law, const Bond& bond) {
  law.bond = bond;
  return law;
}
template <class Normal>
Normal with(Normal law, const Cohesion& cohesion) {
  law.cohesion = cohesion;
  return law;
}

/// One law for everything.
inline LawTable table(const Law& law) { return {.materials = 1, .index = {0}, .laws = {resolved(law)}}; }

/// Every law of the list with numbers that suit spheres of some millimetres: a property test runs over it.
inline std::vector<std::pair<std::string, Law>> every_law() {
  Wet all_bands = soil();
  all_bands.damping = Wet::Damping::all_bands;
  all_bands.limit = Wet::FrictionLimit::elastic_force;
  Wet gap = soil();  // largest attraction across a gap: friction acts through the film
  gap.D = -0.5e-3;
  HertzMindlin hertz = elastic(1e7, 0.3, 0.7, 0.4, 0.05);
  Linear constant = grains();
  constant.friction.rolling = Rolling::constant_torque;
  constant.friction.mu_d = 0.3;
  HuntCrossley spheres = viscoelastic(1.5, NAN, 0.3, 0.4, 0.05);
  spheres.E_eff = 5e6;
  Jkr at_pull_off = tacky(10);
  at_pull_off.separation = Jkr::Separation::pull_off;
  Cohesion by_area = cohesion_by_area(2e5, Cohesion::Area::sjkr2);
  by_area.limit = Cohesion::FrictionLimit::net_force;
  HertzMindlin twisting = hertz;
  twisting.friction.mu_t = 0.1, twisting.friction.mu_r = 0, twisting.friction.rolling_damping_at_limit = 0.5;
  Linear beside = with(grains(), by_area);
  beside.friction.rule = FrictionRule::spring_only, beside.friction.rolling_damping_at_limit = 1;
  Hysteretic undamped = with(compactable(), cohesion_by_area(1e5));
  undamped.friction.rule = FrictionRule::spring_only_undamped, undamped.damping_factor = 0.1;
  Cohesion from_afar = water(5e-9, 0.8);
  from_afar.forms = Cohesion::Forms::at_rupture_distance, from_afar.limit = Cohesion::FrictionLimit::thornton;
  Linear smooth = grains();
  smooth.friction.tangential = Tangential::dashpot, smooth.friction.mu_t = 0.02;
  Linear opposing = grains();
  opposing.friction.tangential = Tangential::constant_direction;
  Hysteretic kept = compactable();
  kept.yield = NAN, kept.K1 = 1e4, kept.residual = Hysteretic::Residual::kept, kept.damping_factor = 0.1;
  Luding steady = sticky();
  steady.unloading = Luding::Unloading::constant, steady.damping = NAN, steady.restitution = 0.8;
  Eepa hertzian = powder(1.5, 3e5, 0.6, 20);
  hertzian.f0 = 0.01, hertzian.chi = 3.5;
  Bond frictional = cement(1e7, 1.5e5);
  frictional.ratio = 2, frictional.radius = 0.8, frictional.friction_angle = 0.5, frictional.moment_share = 0.5;
  frictional.damping = 0.1;
  return {{"linear, bonded", with(grains(), cement())},
          {"hertz-mindlin, bonded, twist", with(twisting, frictional)},
          {"hysteretic", compactable()},
          {"hysteretic, kept", kept},
          {"luding", sticky()},
          {"luding, constant", steady},
          {"eepa, n = 1.5", hertzian},
          {"eepa, n = 1", powder(1, 1e4, 0.7, 50)},
          {"variable restitution", yielding(VariableRestitution::Normal::hertz)},
          {"variable restitution, linear", yielding(VariableRestitution::Normal::linear)},
          {"hysteretic, cohesion by area", undamped},
          {"hunt-crossley", spheres},
          {"hunt-crossley, n = 1", viscoelastic(1, 2e4, 0.5, 0.4, 0.05)},
          {"hunt-crossley, n = 1.7", viscoelastic(1.7, 2e6, 0.2, 0.4)},
          {"wet", soil()},
          {"wet, all bands", all_bands},
          {"wet, D < 0", gap},
          {"linear", grains()},
          {"linear, constant torque", constant},
          {"linear, constant direction", opposing},
          {"hertz-mindlin", hertz},
          {"jkr", tacky()},
          {"jkr, pull-off", at_pull_off},
          {"linear, cohesion by area", beside},
          {"hertz-mindlin, dmt, twist", with(twisting, dmt(5))},
          {"hunt-crossley, liquid bridge", with(spheres, water())},
          {"linear, liquid bridge from afar", with(smooth, from_afar)}};
}

inline BedOptions quiet(const Vec3& gravity = {}, int threads = 1) {
  BedOptions o;
  o.gravity = gravity;
  o.threads = threads;
  return o;
}

inline const Sphere& sphere(const Bed& bed, std::uint32_t id) {
  for (const Sphere& s : bed.spheres())
    if (s.id == id) return s;
  throw std::out_of_range("no such sphere");
}

/// State at t_n of all spheres in ascending id; advances by dt.
inline Snapshot observe(Bed& bed, double dt) {
  Snapshot s;
  bed.step(dt, {.energy = true, .snapshot = &s});
  return s;
}

/// FNV-1a over the bits of every sphere in ascending id.
inline std::uint64_t hash(const Bed& bed) {
  std::vector<const Sphere*> order;
  for (const Sphere& s : bed.spheres()) order.push_back(&s);
  std::sort(order.begin(), order.end(), [](const Sphere* a, const Sphere* b) { return a->id < b->id; });
  std::uint64_t h = 1469598103934665603ull;
  const auto take = [&](double x) {
    std::uint64_t bits;
    std::memcpy(&bits, &x, 8);
    h = (h ^ bits) * 1099511628211ull;
  };
  for (const Sphere* s : order)
    for (int d = 0; d < 3; ++d) take(s->x[d]), take(s->v[d]), take(s->w[d]);
  return h;
}

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0);
  }
  Vec3 in_box(const Vec3& a, const Vec3& b) {
    const double x = between(a.x, b.x), y = between(a.y, b.y), z = between(a.z, b.z);
    return {x, y, z};
  }
  Vec3 ball(double size) { return in_box({-size, -size, -size}, {size, size, size}); }

 private:
  std::mt19937 engine_;
};

/// A box of spheres on a jittered lattice of `pitch`; corner at `low`. Velocities and spins random up to `speed`.
inline std::vector<SphereSpec> loose_lattice(const Vec3& low, int nx, int ny, int nz, double pitch, double radius,
                                             double radius_spread, double speed, Dice& dice) {
  std::vector<SphereSpec> out;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) {
        SphereSpec s;
        s.radius = radius * (1 - dice.between(0, radius_spread));
        s.position = low + Vec3{(i + 0.5) * pitch, (j + 0.5) * pitch, (k + 0.5) * pitch} + dice.ball(0.02 * pitch);
        s.velocity = dice.ball(speed);
        s.spin = dice.ball(speed / radius);
        s.density = 1800;
        out.push_back(s);
      }
  return out;
}

inline int add_plane(Bed& bed, const Vec3& point, const Vec3& normal, int material = 0) {
  Boundary b;
  b.shape = Plane(point, normal);
  b.material = material;
  return bed.add(std::move(b));
}

/// Five planes around x, z in [0, size] and above y = 0.
inline void add_bin(Bed& bed, double size_x, double size_z) {
  add_plane(bed, {0, 0, 0}, {0, 1, 0});
  add_plane(bed, {0, 0, 0}, {1, 0, 0});
  add_plane(bed, {size_x, 0, 0}, {-1, 0, 0});
  add_plane(bed, {0, 0, 0}, {0, 0, 1});
  add_plane(bed, {0, 0, size_z}, {0, 0, -1});
}

/// A boundary that moves at a constant velocity and spin about its origin: stands at t_n with the mid-step velocity.
struct Motion {
  int boundary;
  Pose start;
  Vec3 velocity, spin;

  void place(Bed& bed) const {
    Boundary& b = bed.boundary(boundary);
    const double t = bed.time();
    b.pose = {start.position + velocity * t, Quaternion::from_rotation_vector(spin * t) * start.attitude};
    b.velocity = velocity;
    b.spin = spin;
  }
};

}  // namespace subsoil::dem::test
