#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "libdem/geometry/sphere_union.hpp"
#include "libdem/step/stability.hpp"
#include "libdem/step/stiffness_bound.hpp"

/// Stable step of clumps: modes of a rigid body among contacts.
namespace subsoil::dem {

namespace {

using Six = SquareMatrix<6>;

/// Use(s) for the eight products of reflections in the coordinate planes. Samples that are closed under them give a
/// clump and its mirror image the same bits.
template <class Use>
void each_reflection(const Use& use) {
  for (const double x : {1.0, -1.0})
    for (const double y : {1.0, -1.0})
      for (const double z : {1.0, -1.0}) use(Vec3{x, y, z});
}
Vec3 reflected(const Vec3& v, const Vec3& s) { return {s.x * v.x, s.y * v.y, s.z * v.z}; }

/// Directions spread evenly over an octant of the sphere (Fibonacci lattice).
std::vector<Vec3> even_directions(int count) {
  std::vector<Vec3> out;
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  for (int k = 0; k < count; ++k) {
    const double z = (k + 0.5) / count, r = std::sqrt(1 - z * z), turn = golden * (k + 0.5);
    const double angle = 0.5 * std::numbers::pi * (turn - std::floor(turn));
    out.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return out;
}

/// Stiffnesses or dampings of one contact: along the normal, across it, against rolling.
struct Triple {
  double n, t, roll;
};

/// Matrix of contacts in coordinates in which the mass matrix is 1.
class ContactMatrix {
 public:
  explicit ContactMatrix(const ClumpShape& shape)
      : translation_(1 / std::sqrt(shape.mass)),
        rotation_{1 / std::sqrt(shape.inertia.x), 1 / std::sqrt(shape.inertia.y), 1 / std::sqrt(shape.inertia.z)} {}

  /// A contact at `point` with its normal; tangential forces act at `arm_point`.
  void add(const Vec3& point, const Vec3& arm_point, const Vec3& normal, const Triple& k, double weight) {
    add_direction(point, normal, weight * k.n);
    const Vec3 u = dem::normalized(cross(normal, std::abs(normal.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    const Vec3 v = cross(normal, u);
    add_direction(arm_point, u, weight * k.t), add_direction(arm_point, v, weight * k.t);
    for (const Vec3& across : {u, v}) add_turn(across, weight * k.roll);
  }
  double largest() const {
    const auto values = symmetric_eigen<6>(sum_).values;
    return *std::max_element(values.begin(), values.end());
  }

 private:
  void add_direction(const Vec3& point, const Vec3& d, double k) {
    const Vec3 turn = cross(point, d);
    add_outer({d.x * translation_, d.y * translation_, d.z * translation_, turn.x * rotation_[0], turn.y * rotation_[1],
               turn.z * rotation_[2]},
              k);
  }
  void add_turn(const Vec3& d, double k) {
    add_outer({0, 0, 0, d.x * rotation_[0], d.y * rotation_[1], d.z * rotation_[2]}, k);
  }
  void add_outer(const std::array<double, 6>& b, double k) {
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) sum_[i][j] += k * b[i] * b[j];
  }

  double translation_;
  std::array<double, 3> rotation_;
  Six sum_{};
};

struct SurfacePoint {
  Vec3 at, normal;
  double radius, weight;  ///< of its member; share of the member's whole surface
};

/// What of the members lies in no other.
std::vector<SurfacePoint> surface_points(const ClumpShape& shape) {
  constexpr int per_octant = 25;
  std::vector<Vec3> directions;
  for (const Vec3& n : even_directions(per_octant))
    each_reflection([&](const Vec3& s) { directions.push_back(reflected(n, s)); });
  std::vector<Ball> balls;
  for (const ClumpMember& m : shape.members) balls.push_back({m.at, m.radius});
  std::vector<SurfacePoint> out;
  for (std::size_t k = 0; k < balls.size(); ++k)
    for (const Vec3& n : directions)
      if (const Vec3 at = balls[k].centre + balls[k].radius * n; is_exposed(balls, at, k))
        out.push_back({at, n, balls[k].radius, 1.0 / static_cast<double>(directions.size())});
  return out;
}

double largest_member(const ClumpShape& shape) {
  double r = 0;
  for (const ClumpMember& m : shape.members) r = std::max(r, m.radius);
  return r;
}

StableStep of_mode(double a, double b, const std::string& what) {
  if (a <= 0 && b <= 0) return {.step = std::numeric_limits<double>::infinity(), .cause = "nothing acts"};
  return {.step = stable_step_of_mode(a, b), .cause = (b * b > a ? "damping of " : "stiffness of ") + what};
}

}  // namespace

/// At a point of the member at c with the normal n the mobility is 1/m + (c x n).J^-1 (c x n), the largest where n is
/// an eigenvector; where that point lies in another member the sampled points stand for it.
double least_effective_mass(const ClumpShape& shape) {
  double most = 1 / shape.mass;
  const auto take = [&](const Vec3& at, const Vec3& n) {
    const Vec3 turn = cross(at, n);
    most = std::max(most, 1 / shape.mass + turn.x * turn.x / shape.inertia.x + turn.y * turn.y / shape.inertia.y +
                              turn.z * turn.z / shape.inertia.z);
  };
  for (const SurfacePoint& p : surface_points(shape)) take(p.at, p.normal);
  std::vector<Ball> balls;
  for (const ClumpMember& m : shape.members) balls.push_back({m.at, m.radius});
  for (std::size_t k = 0; k < balls.size(); ++k) {
    const Vec3& c = balls[k].centre;
    const std::array<Vec3, 3> rows{Vec3{0, -c.z, c.y}, Vec3{c.z, 0, -c.x}, Vec3{-c.y, c.x, 0}};  // of n -> c x n
    SquareMatrix<3> square{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int d = 0; d < 3; ++d)
          square[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] +=
              rows[static_cast<std::size_t>(d)][i] * rows[static_cast<std::size_t>(d)][j] / shape.inertia[d];
    const SymmetricEigen<3> modes = symmetric_eigen<3>(square);
    for (std::size_t e = 0; e < 3; ++e)
      for (const double sign : {1.0, -1.0}) {
        const Vec3 n = sign * Vec3{modes.vectors[0][e], modes.vectors[1][e], modes.vectors[2][e]};
        if (is_exposed(balls, c + balls[k].radius * n, k)) take(c, n);
      }
  }
  return 1 / most;
}

StableStep stable_step(const Law& law, const ClumpShape& shape, const StepQuestion& q) {
  if (q.neighbours <= 0) return {.step = std::numeric_limits<double>::infinity(), .cause = "nothing to touch"};
  const double r = largest_member(shape), m = shape.mass;
  double arm = r;
  const StiffnessBound k =
      stiffness_bound(law, {.m_eff = m / 2, .r_eff = r / 2, .r_min = r, .speed = q.speed, .overlap = q.overlap},
                      0.7 * m * r * r, true, arm);
  const std::vector<SurfacePoint> points = surface_points(shape);
  double alone[2] = {0, 0};
  ContactMatrix stiff(shape), damped(shape);
  double contacts = 0;
  for (const SurfacePoint& p : points) {
    const double around = 0.5 * (p.radius + q.smallest_radius) / q.smallest_radius;
    const double weight = q.neighbours * around * around * p.weight;
    const Vec3 at_arm = p.at + (p.radius * (arm / r - 1)) * p.normal;
    const Triple stiffness{k.k_n, k.k_t, k.k_r}, damping{k.c_n, k.c_t, k.c_r};
    contacts += weight;
    stiff.add(p.at, at_arm, p.normal, stiffness, 2 * weight);
    damped.add(p.at, at_arm, p.normal, damping, 2 * weight);
    ContactMatrix one(shape), other(shape);
    one.add(p.at, at_arm, p.normal, stiffness, 2), other.add(p.at, at_arm, p.normal, damping, 2);
    alone[0] = std::max(alone[0], one.largest()), alone[1] = std::max(alone[1], other.largest());
  }
  return of_mode(std::max(stiff.largest(), alone[0]), std::max(damped.largest(), alone[1]),
                 "a clump `" + shape.name + "` with " + std::to_string(std::lround(contacts)) + " contacts");
}

StableStep stable_step_at_surface(const Law& law, const ClumpShape& shape, const StepQuestion& q) {
  const double r = largest_member(shape), m = shape.mass;
  double arm = r;
  const StiffnessBound k = stiffness_bound(
      law, {.m_eff = m, .r_eff = r, .r_min = r, .speed = q.speed, .overlap = q.overlap}, 1.4 * m * r * r, false, arm);
  constexpr int attitudes = 13;  // and their reflections
  double a = 0, b = 0;
  int turn = 0;
  for (const Vec3& axis : even_directions(attitudes)) {
    const Quaternion attitude = Quaternion::from_rotation_vector((2.4 * turn++) * axis);
    each_reflection([&](const Vec3& s) {
      ContactMatrix stiff(shape), damped(shape);
      for (const ClumpMember& member : shape.members)
        for (int d = 0; d < 3; ++d) {
          Vec3 normal{};
          normal[d] = 1;
          normal = reflected(attitude.rotate(normal), s);
          const Vec3 at = member.at + member.radius * normal, at_arm = member.at + (member.radius * arm / r) * normal;
          stiff.add(at, at_arm, normal, {k.k_n, k.k_t, k.k_r}, 1);
          damped.add(at, at_arm, normal, {k.c_n, k.c_t, k.c_r}, 1);
        }
      a = std::max(a, stiff.largest()), b = std::max(b, damped.largest());
    });
  }
  return of_mode(a, b, "a clump `" + shape.name + "` of which every sphere touches three surfaces");
}

}  // namespace subsoil::dem
