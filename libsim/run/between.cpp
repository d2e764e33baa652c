#include "libsim/run/between.hpp"

#include <cstddef>
#include <utility>
#include <vector>

#include "libdem/base/small_rotation.hpp"

namespace subsoil::sim {
namespace {

using dem::Vec3;

Vec3 mean(const Vec3& before, const Vec3& now, double share) { return share * before + (1 - share) * now; }

/// Hermite's cubic at s = 1 - share of the step.
Vec3 on_cubic(const Vec3& x0, const Vec3& v0, const Vec3& x1, const Vec3& v1, double step, double share) {
  const double s = 1 - share;
  return x0 + (s * s * (3 - 2 * s)) * (x1 - x0) + (step * s * share) * (share * v0 - s * v1);
}

/// Sphere `a` of `before`, which is `b` in `now`, to its place in `out`.
void put(dem::Snapshot& out, const dem::Snapshot& before, std::size_t a, const dem::Snapshot& now, std::size_t b,
         double step, double share, const dem::PeriodicCell& cell) {
  Vec3 was = before.position[a];
  if (cell.any()) was = now.position[b] + cell.shortest(was - now.position[b]);  // it may have come in anew
  out.id[a] = now.id[b], out.radius[a] = now.radius[b], out.material[a] = now.material[b];
  out.position[a] = cell.wrapped(on_cubic(was, before.velocity[a], now.position[b], now.velocity[b], step, share));
  out.velocity[a] = mean(before.velocity[a], now.velocity[b], share);
  out.angular_velocity[a] = mean(before.angular_velocity[a], now.angular_velocity[b], share);
  out.force[a] = mean(before.force[a], now.force[b], share);
  out.torque[a] = mean(before.torque[a], now.torque[b], share);
  out.contacts[a] = share > 0.5 ? before.contacts[a] : now.contacts[b];
  if (!out.bonds.empty()) out.bonds[a] = share > 0.5 ? before.bonds[a] : now.bonds[b];
}

/// One that leaves at the end of the step, `elapsed` after its beginning.
void put_leaving(dem::Snapshot& out, const dem::Snapshot& before, std::size_t a, double elapsed,
                 const dem::PeriodicCell& cell) {
  out.id[a] = before.id[a], out.radius[a] = before.radius[a], out.material[a] = before.material[a];
  out.position[a] = cell.wrapped(before.position[a] + elapsed * before.velocity[a]);
  out.velocity[a] = before.velocity[a], out.angular_velocity[a] = before.angular_velocity[a];
  out.force[a] = before.force[a], out.torque[a] = before.torque[a];
  out.contacts[a] = before.contacts[a];
  if (!out.bonds.empty()) out.bonds[a] = before.bonds[a];
}

constexpr std::size_t kLeaves = ~std::size_t{0};

/// Of each sphere of `before` its place in `now`; both in rising id.
std::vector<std::size_t> places_in_now(const dem::Snapshot& before, const dem::Snapshot& now) {
  std::vector<std::size_t> out(before.id.size(), kLeaves);
  for (std::size_t a = 0, b = 0; a < before.id.size(); ++a) {
    while (b < now.id.size() && now.id[b] < before.id[a]) ++b;
    if (b < now.id.size() && now.id[b] == before.id[a]) out[a] = b;
  }
  return out;
}

}  // namespace

dem::Snapshot interpolate(const dem::Snapshot& before, const dem::Snapshot& now, double step, double share,
                          const dem::PeriodicCell& cell, dem::Snapshot memory) {
  dem::Snapshot out = std::move(memory);
  const std::size_t count = before.id.size();
  const bool bonds = !before.bonds.empty() && (!now.bonds.empty() || now.id.empty());
  out.id.resize(count), out.radius.resize(count), out.material.resize(count), out.contacts.resize(count);
  for (auto* column : {&out.position, &out.velocity, &out.angular_velocity, &out.force, &out.torque})
    column->resize(count);
  out.bonds.resize(bonds ? count : 0);
  const std::vector<std::size_t> place = places_in_now(before, now);
  constexpr std::size_t many = 10000;  // below, other threads are not worth waking
#pragma omp parallel for schedule(static) if (count > many)
  for (std::size_t a = 0; a < count; ++a)
    if (place[a] != kLeaves)
      put(out, before, a, now, place[a], step, share, cell);
    else
      put_leaving(out, before, a, (1 - share) * step, cell);
  return out;
}

dem::Pose interpolate(const dem::Pose& before, const dem::Pose& now, double share) {
  const Vec3 turn = dem::small_rotation(before.attitude, now.attitude);
  return {mean(before.position, now.position, share),
          (dem::Quaternion::from_rotation_vector((1 - share) * turn) * before.attitude).normalized()};
}

mbd::BodyState interpolate(const mbd::BodyState& before, const mbd::BodyState& now, double share) {
  const auto on_line = [&](double a, double b) { return share * a + (1 - share) * b; };
  return {{on_line(before.r.x, now.r.x), on_line(before.r.y, now.r.y)},
          on_line(before.angle, now.angle),
          {on_line(before.v.x, now.v.x), on_line(before.v.y, now.v.y)},
          on_line(before.omega, now.omega)};
}

}  // namespace subsoil::sim
