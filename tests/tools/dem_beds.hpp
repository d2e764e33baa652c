#pragma once
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/laws/hertz_mindlin.hpp"
#include "libdem/laws/linear.hpp"
#include "libdem/laws/wet.hpp"

/// What the tests of the bed share: the commonest laws with usual numbers (others: laws.hpp, all: every_law.hpp), beds
/// of one law, spheres by the user's number, hashes.
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

/// One law for everything.
inline LawTable table(const Law& law) { return {.materials = 1, .index = {0}, .laws = {law}}; }

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
        s.angular_velocity = dice.ball(speed / radius);
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
    b.angular_velocity = spin;
  }
};

}  // namespace subsoil::dem::test
