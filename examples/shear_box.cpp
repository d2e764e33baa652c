// A direct shear box: grains under a lid of constant load, the upper half of the box drawn over the lower one. The
// friction angle of four packings under each of two loads, with its interval of 95 %.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/laws/linear.hpp"

using namespace subsoil::dem;

constexpr double kLength = 0.12, kWidth = 0.06, kDepth = 0.03, kRadius = 5e-3, kFriction = 0.5;  // m; depth of a half

/// Ratio of shear to normal force, mean over the second half of the path. @param pressure of the lid, Pa
double shear(double pressure, unsigned seed) {
  Linear law;
  law.k_n = 1e4, law.restitution = 0.3, law.friction.mu = kFriction;
  BedOptions options{.threads = 1};
  options.periodic = {.low = {}, .length = {0, 0, kWidth}};  // no side walls, whose friction would be counted
  Bed bed({.materials = 1, .index = {0}, .laws = {law}}, options);
  std::mt19937 dice(seed);
  const auto some = [&](double size) { return size * (static_cast<double>(dice()) / 4294967296.0 - 0.5); };
  std::vector<SphereSpec> grains(330);
  for (std::size_t n = 0; n < grains.size(); ++n) {
    const auto i = static_cast<double>(n % 11), j = static_cast<double>(n / 11 % 6), k = static_cast<double>(n / 66);
    grains[n].position = {0.0105 + 0.0099 * i + some(6e-4), 0.006 + 0.0115 * j, 0.006 + 0.012 * k + some(1e-3)};
    grains[n].velocity = {some(0.4), 0, some(0.4)};
    grains[n].radius = kRadius * (0.93 + some(0.14)), grains[n].density = 2650;
  }
  bed.add(grains);
  const auto add = [&](Shape shape, Vec3 at) {
    Boundary b;
    b.shape = std::move(shape), b.pose.position = at;
    return bed.add(std::move(b));
  };
  // Walls so thick that what slides past the other half's rim stays covered; across the period they have no end.
  const MeshSurface lower(box_mesh({0.05, kDepth, 2 * kWidth})), upper(box_mesh({0.05, 3 * kDepth, 2 * kWidth}));
  add(Plane({}, {0, 1, 0}), {});
  add(lower, {-0.025, 0.5 * kDepth, 0.5 * kWidth}), add(lower, {kLength + 0.025, 0.5 * kDepth, 0.5 * kWidth});
  const int moving[] = {add(upper, {-0.025, 2.5 * kDepth, 0.5 * kWidth}),
                        add(upper, {kLength + 0.025, 2.5 * kDepth, 0.5 * kWidth}),
                        add(Plane({}, {0, -1, 0}), {0, 0.075, 0})};
  const double dt = 6e-5, load = pressure * kLength * kWidth, settling = 0.25, speed = 0.05, path = 0.016;
  Vec3 on_upper;  // N, mean force of the grains on walls and lid; walls hang in the friction of the grains
  while (bed.time() < settling + path / speed) {
    const double along = bed.time() < settling ? 0 : speed;
    for (const int m : moving) bed.boundary(m).velocity.x = along, bed.boundary(m).pose.position.x += along * dt;
    Boundary& lid = bed.boundary(moving[2]);
    lid.velocity.y = std::clamp((lid.wrench.force.y - load) / 100, -0.3, 0.3);  // N over N s/m: a dashpot
    lid.pose.position.y += lid.velocity.y * dt;
    bed.step(dt);
    if (bed.time() > settling + 0.5 * path / speed)
      for (const int m : moving) on_upper += bed.boundary(m).wrench.force * (dt / (0.5 * path / speed));
  }
  for (const Sphere& s : bed.spheres()) on_upper.y += s.x.y > kDepth ? 9.81 * s.m : 0;  // above the plane of shear
  return -on_upper.x / on_upper.y;  // upper half and lid in equilibrium: what passes through the plane
}

int main() {
  double angle[2], interval[2], pressure[2] = {4e3, 8e3};
  for (int l = 0; l < 2; ++l) {
    double sum = 0, squares = 0;
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const double phi = std::atan(shear(pressure[l], seed)) * 180 / M_PI;
      sum += phi, squares += phi * phi;
    }
    angle[l] = sum / 4,
    interval[l] = 3.182 * std::sqrt((squares / 4 - angle[l] * angle[l]) / 3);  // Student, 3 freedoms
    std::printf("%.0f kPa: friction angle %.1f +- %.1f deg\n", pressure[l] / 1e3, angle[l], interval[l]);
  }
  // Hard grains without cohesion have no scale of stress, so the angle is that of any load (Coulomb). Friction adds to
  // the 5.8 deg of frictionless beads (Peyneau and Roux 2008). A layer that climbs the grooves of a close-packed one,
  // 19.5 deg, against the friction of its contacts has no more than 19.5 deg + atan(mu).
  const double most = 19.5 + std::atan(kFriction) * 180 / M_PI;
  const bool coulomb = std::abs(angle[1] - angle[0]) < std::hypot(interval[0], interval[1]);
  return coulomb && angle[0] > 5.8 && angle[1] > 5.8 && std::max(angle[0], angle[1]) < most ? 0 : 1;
}
