#include "libsim/setup/yielding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libmbd/base/dense.hpp"

namespace subsoil::sim {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr int most_coordinates = 600;  ///< of a machine whose joints are looked at: that costs their cube

/// Mobility of one body's coordinates in a machine held by its joints and drivers: of
///     M q'' + Phi_q^T lambda = F,  Phi_q q'' = 0
/// the block of q'' by F. With S = M^-1/2 Phi_q^T it is M^-1/2 (1 - S S^+) M^-1/2, the part that no constraint takes.
Eigen::Matrix3d mobility(const mbd::System& system, int body) {
  mbd::Constraints constraints;
  system.constraints(constraints);
  const Eigen::VectorXd root = system.mass().cwiseSqrt().cwiseInverse();
  const Eigen::Index at = 3 * (body - 1), n = root.size();
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(n, 3);
  for (Eigen::Index d = 0; d < 3; ++d) own(at + d, d) = root[at + d];
  if (constraints.jacobian.rows() > 0) {
    const Eigen::MatrixXd s = root.asDiagonal() * constraints.jacobian.transpose();
    own = mbd::outside_range(s, own);
  }
  return own.transpose() * own;  // the projector is its own square
}

/// Largest mobility of a point at `arm` from the centre of mass, along any direction of the plane.
double most_mobile(const Eigen::Matrix3d& p, const Vec3& arm) {
  Eigen::Matrix<double, 2, 3> j;
  j << 1, 0, -arm.y, 0, 1, arm.x;
  const Eigen::Matrix2d w = j * p * j.transpose();
  const double half = 0.5 * (w(0, 0) - w(1, 1));
  return 0.5 * (w(0, 0) + w(1, 1)) + std::hypot(half, w(0, 1));
}

double mass_of(double mobility) { return mobility > 0 ? 1 / mobility : kInfinite; }

}  // namespace

std::vector<YieldingBody> yielding_bodies(const World& world, const Scenario& scenario, double sphere_mass) {
  std::vector<YieldingBody> out;
  if (!world.machine || !world.bed) return out;
  const mbd::System& system = world.machine->system();
  for (const SurfaceRecord& s : world.surfaces) {
    if (s.owner != SurfaceRecord::Owner::machine) continue;
    if (is_beam_node(scenario.machine, system.body_name(s.body))) continue;
    const dem::Boundary& b = world.bed->boundary(s.boundary);
    std::vector<Vec3> arms{{}};
    if (!std::holds_alternative<dem::Plane>(b.shape)) {
      const auto meshes = dem::drawing(b.shape, 1.0);
      for (const Vec3& v : meshes[s.mesh].vertices()) arms.push_back(b.pose.attitude.rotate(v));
    }
    const mbd::Body& body = system.model().bodies[static_cast<std::size_t>(s.body - 1)];
    const auto least = [&](const Eigen::Matrix3d& p) {
      double most = 0;
      for (const Vec3& arm : arms) most = std::max(most, most_mobile(p, arm));
      return mass_of(most);
    };
    YieldingBody one{.body = s.body, .material = b.material};
    const Eigen::Matrix3d free = Eigen::Vector3d(1 / body.mass, 1 / body.mass, 1 / body.inertia).asDiagonal();
    one.free_mass = least(free);
    if (!(one.free_mass < yielding_ratio * sphere_mass)) continue;
    const Eigen::Matrix3d held = system.coordinates() <= most_coordinates ? mobility(system, s.body) : free;
    // What rounding leaves of a body that cannot move.
    if (held(0, 0) * body.mass < 1e-9 && held(1, 1) * body.mass < 1e-9 && held(2, 2) * body.inertia < 1e-9) continue;
    one.start_mass = std::max(one.free_mass, least(held));
    Vec3 middle{};
    for (const Vec3& arm : arms) middle += arm * (1 / static_cast<double>(arms.size()));
    one.middle_mass = mass_of(most_mobile(held, middle));
    const auto same = std::find_if(out.begin(), out.end(), [&](const YieldingBody& y) {
      return y.body == one.body && y.material == one.material;
    });
    if (same == out.end()) {
      out.push_back(one);
    } else {
      same->free_mass = std::min(same->free_mass, one.free_mass);
      same->start_mass = std::min(same->start_mass, one.start_mass);
      same->middle_mass = std::min(same->middle_mass, one.middle_mass);
    }
  }
  return out;
}

}  // namespace subsoil::sim
