#include "libdem/particles/clump.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "libdem/geometry/sphere_union.hpp"
#include "libdem/particles/particles.hpp"

namespace subsoil::dem {
namespace {

/// Rotation matrix, its columns the axes, as a quaternion (Shepperd 1978).
Quaternion quaternion_of_axes(const SquareMatrix<3>& m) {
  const double trace = m[0][0] + m[1][1] + m[2][2];
  Quaternion q;
  if (trace > 0) {
    const double s = 2 * std::sqrt(1 + trace);
    q = {0.25 * s, (m[2][1] - m[1][2]) / s, (m[0][2] - m[2][0]) / s, (m[1][0] - m[0][1]) / s};
  } else if (m[0][0] >= m[1][1] && m[0][0] >= m[2][2]) {
    const double s = 2 * std::sqrt(1 + m[0][0] - m[1][1] - m[2][2]);
    q = {(m[2][1] - m[1][2]) / s, 0.25 * s, (m[0][1] + m[1][0]) / s, (m[0][2] + m[2][0]) / s};
  } else if (m[1][1] >= m[2][2]) {
    const double s = 2 * std::sqrt(1 + m[1][1] - m[0][0] - m[2][2]);
    q = {(m[0][2] - m[2][0]) / s, (m[0][1] + m[1][0]) / s, 0.25 * s, (m[1][2] + m[2][1]) / s};
  } else {
    const double s = 2 * std::sqrt(1 + m[2][2] - m[0][0] - m[1][1]);
    q = {(m[1][0] - m[0][1]) / s, (m[0][2] + m[2][0]) / s, (m[1][2] + m[2][1]) / s, 0.25 * s};
  }
  return q.normalized();
}

double determinant(const SquareMatrix<3>& m) {
  const auto row = [&](std::size_t k) { return Vec3{m[k][0], m[k][1], m[k][2]}; };
  return dot(row(0), cross(row(1), row(2)));
}

Vec3 column(const SquareMatrix<3>& m, std::size_t k) { return {m[0][k], m[1][k], m[2][k]}; }

/// Where two principal moments are equal rounding alone would choose the axes in their plane: one becomes the part
/// across the third axis of the coordinate axis that is farthest from it. What is a mirror image then has mirrored
/// axes.
void settle_equal_axes(SymmetricEigen<3>& principal) {
  constexpr double rounding = 1e-9;
  const auto& j = principal.values;
  const auto equal = [&](std::size_t a, std::size_t b) { return std::abs(j[a] - j[b]) <= rounding * (j[a] + j[b]); };
  auto& m = principal.vectors;
  if (equal(0, 1) && equal(1, 2)) {
    m = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    return;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
    if (!equal(a, b)) continue;
    const Vec3 third = column(m, k);
    int farthest = 0;
    for (int d = 1; d < 3; ++d)
      if (std::abs(third[d]) < std::abs(third[farthest]) - rounding) farthest = d;
    Vec3 along{};
    along[farthest] = 1;
    const Vec3 u = normalized(along - dot(along, third) * third), v = cross(third, u);
    for (int d = 0; d < 3; ++d) m[static_cast<std::size_t>(d)][a] = u[d], m[static_cast<std::size_t>(d)][b] = v[d];
    return;
  }
}

void require_body(const Vec3& j) {
  const double sum = j.x + j.y + j.z;
  for (int k = 0; k < 3; ++k)
    if (!(j[k] > 0) || !(2 * j[k] <= sum * (1 + 1e-9)))
      throw std::invalid_argument(
          "no body has this inertia: each principal moment must be positive and at most the sum of the other two");
}

}  // namespace

ClumpShape clump_shape(std::string name, const std::vector<ClumpMember>& members, double density,
                       const std::optional<GivenMass>& given) {
  std::vector<Ball> balls;
  for (const ClumpMember& m : members) {
    if (!std::isfinite(dot(m.at, m.at))) throw std::invalid_argument("centres of spheres must be finite");
    balls.push_back({m.at, m.radius});
  }
  const SolidMoments solid = moments_of_union(balls);
  ClumpShape out;
  out.name = std::move(name), out.volume = solid.volume, out.error = solid.error;
  out.mass = given ? given->mass : density * solid.volume;
  if (!(out.mass > 0) || !std::isfinite(out.mass)) throw std::invalid_argument("the mass must be positive");
  out.centre = given && given->centre ? *given->centre : solid.centre;
  SquareMatrix<3> inertia = solid.inertia;
  for (auto& row : inertia)
    for (double& x : row) x *= out.mass / solid.volume;
  if (given && given->inertia) inertia = *given->inertia;
  SymmetricEigen<3> principal = symmetric_eigen<3>(inertia);
  settle_equal_axes(principal);
  if (determinant(principal.vectors) < 0)
    for (auto& row : principal.vectors) row[2] = -row[2];
  out.inertia = {principal.values[0], principal.values[1], principal.values[2]};
  require_body(out.inertia);
  out.axes = quaternion_of_axes(principal.vectors);
  // One that stands twice would make contacts twice as stiff.
  for (std::size_t k = 0; k < members.size(); ++k) {
    const ClumpMember& m = members[k];
    const auto end = members.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::find_if(members.begin(), end,
                     [&](const ClumpMember& b) { return b.at == m.at && b.radius == m.radius; }) != end)
      continue;
    out.members.push_back({out.axes.conjugate().rotate(m.at - out.centre), m.radius});
    out.reach = std::max(out.reach, norm(m.at - out.centre) + m.radius);
  }
  return out;
}

void ClumpShape::archive(Archive& a) {
  a("spheres", members)("mass", mass)("inertia", inertia)("volume", volume)("error", error)("reach", reach)(
      "centre", centre)("axes", axes);
}

double widest_gap(const ClumpShape& shape) {
  double widest = 0;
  for (const ClumpMember& a : shape.members)
    for (const ClumpMember& b : shape.members) widest = std::max(widest, norm(a.at - b.at));
  return widest;
}

std::vector<double> shares_by_volume(const ClumpShape& shape) {
  std::vector<double> out;
  double sum = 0;
  for (const ClumpMember& m : shape.members) out.push_back(sphere_volume(m.radius)), sum += out.back();
  for (double& x : out) x /= sum;
  return out;
}

}  // namespace subsoil::dem
