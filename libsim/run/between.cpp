#include "libsim/run/between.hpp"

#include <cstddef>

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

/// Of one sphere that is `a` in `before` and `b` in `now`.
void add(dem::Snapshot& out, const dem::Snapshot& before, std::size_t a, const dem::Snapshot& now, std::size_t b,
         double step, double share, const dem::PeriodicCell& cell) {
  Vec3 was = before.position[a];
  if (cell.any()) was = now.position[b] + cell.shortest(was - now.position[b]);  // it may have come in anew
  out.id.push_back(now.id[b]);
  out.radius.push_back(now.radius[b]);
  out.material.push_back(now.material[b]);
  out.position.push_back(
      cell.wrapped(on_cubic(was, before.velocity[a], now.position[b], now.velocity[b], step, share)));
  out.velocity.push_back(mean(before.velocity[a], now.velocity[b], share));
  out.angular_velocity.push_back(mean(before.angular_velocity[a], now.angular_velocity[b], share));
  out.force.push_back(mean(before.force[a], now.force[b], share));
  out.torque.push_back(mean(before.torque[a], now.torque[b], share));
  out.contacts.push_back(share > 0.5 ? before.contacts[a] : now.contacts[b]);
  if (!now.bonds.empty() && !before.bonds.empty()) out.bonds.push_back(share > 0.5 ? before.bonds[a] : now.bonds[b]);
}

/// Of one that leaves at the end of the step, `elapsed` after its beginning.
void add_leaving(dem::Snapshot& out, const dem::Snapshot& before, std::size_t a, double elapsed,
                 const dem::PeriodicCell& cell) {
  out.id.push_back(before.id[a]);
  out.radius.push_back(before.radius[a]);
  out.material.push_back(before.material[a]);
  out.position.push_back(cell.wrapped(before.position[a] + elapsed * before.velocity[a]));
  out.velocity.push_back(before.velocity[a]);
  out.angular_velocity.push_back(before.angular_velocity[a]);
  out.force.push_back(before.force[a]);
  out.torque.push_back(before.torque[a]);
  out.contacts.push_back(before.contacts[a]);
  if (!before.bonds.empty()) out.bonds.push_back(before.bonds[a]);
}

}  // namespace

dem::Snapshot interpolate(const dem::Snapshot& before, const dem::Snapshot& now, double step, double share,
                          const dem::PeriodicCell& cell) {
  dem::Snapshot out;
  for (std::size_t a = 0, b = 0; a < before.id.size(); ++a) {  // both in rising id
    while (b < now.id.size() && now.id[b] < before.id[a]) ++b;
    if (b < now.id.size() && now.id[b] == before.id[a])
      add(out, before, a, now, b, step, share, cell);
    else
      add_leaving(out, before, a, (1 - share) * step, cell);
  }
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
