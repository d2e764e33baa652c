#include "libsim/setup/fibre_facts.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "libdem/packing/measure.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

/// The soil under the fibres: all other spheres.
class SoilSurface {
 public:
  SoilSurface(const World& world, const FibreGroup& group)
      : soil_(dem::spheres_below(world.bed->spheres(), world.soil.fibres_from)),
        region_(region(world, group)),
        columns_(soil_, region_) {}
  double depth_of(const dem::Sphere& s) const { return columns_.height_at(s.x) - s.x.y; }
  double diameter() const { return 2 * dem::mean_radius(soil_); }
  double floor() const { return region_.low.y; }

 private:
  dem::Bounds region(const World& world, const FibreGroup& group) const {
    if (group.container) {
      const Vec3 up{0, world.container_shift, 0};
      return {group.container->low + up, group.container->high + up};
    }
    dem::Bounds box;
    for (const dem::Sphere& s : soil_) {
      box.include(s.x - Vec3{s.r, s.r, s.r});
      box.include(s.x + Vec3{s.r, s.r, s.r});
    }
    return box;
  }

  std::vector<dem::Sphere> soil_;
  dem::Bounds region_;
  dem::SurfaceColumns columns_;
};

/// Bands of two mean diameters of the soil or thicker, of which no more than twelve reach to the floor.
constexpr double kBandDiameters = 2, kMostBands = 12;

void take_depths(const World& world, const FibreGroup& group, FibreFacts& out) {
  const SoilSurface surface(world, group);
  const double deep = world.soil.surface_mean - surface.floor();
  const double bands = std::clamp(std::floor(deep / (kBandDiameters * surface.diameter())), 1.0, kMostBands);
  out.band = deep / bands;
  out.by_depth.assign(static_cast<std::size_t>(bands), 0.0);
  double moment = 0;
  for (const dem::Sphere& s : world.bed->spheres()) {
    if (!group.has(s.id)) continue;
    out.mass += s.m;
    const double depth = surface.depth_of(s);
    if (!(depth > 0)) continue;
    out.buried += s.m, moment += s.m * depth;
    const auto band = static_cast<std::size_t>(std::min(depth / out.band, bands - 1));
    out.by_depth[band] += s.m;
  }
  if (out.buried > 0) out.mean_depth = moment / out.buried;
}

void take_directions(const World& world, const FibreGroup& group, FibreFacts& out) {
  std::unordered_map<std::uint32_t, const dem::Sphere*> sphere;
  for (const dem::Sphere& s : world.bed->spheres())
    if (group.has(s.id)) sphere[s.id] = &s;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& [i, j] : world.bed->bonded_pairs()) {
    if (!group.has(i) || !group.has(j)) continue;
    const Vec3 u = dem::normalized(world.bed->options().periodic.shortest(sphere.at(j)->x - sphere.at(i)->x));
    const Eigen::Vector3d e(u.x, u.y, u.z);
    sum += 1.5 * e * e.transpose() - 0.5 * Eigen::Matrix3d::Identity();
    out.to_horizontal += std::asin(std::min(1.0, std::abs(u.y)));
    out.to_x += std::acos(std::min(1.0, std::abs(u.x)));
    ++out.segments;
  }
  if (out.segments == 0) return;
  const double n = static_cast<double>(out.segments);
  out.to_horizontal /= n, out.to_x /= n;
  out.order = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum / n).eigenvalues().maxCoeff();
}

}  // namespace

std::size_t broken_bonds(const World& world, const FibreGroup& group) {
  const auto all = world.bed->broken_bonds();
  return static_cast<std::size_t>(
      std::count_if(all.begin(), all.end(), [&](const dem::BrokenBond& b) { return group.has(b.ids[0]); }));
}

double buried_share(const World& world, const FibreGroup& group) {
  FibreFacts facts;
  take_depths(world, group, facts);
  return facts.mass > 0 ? facts.buried / facts.mass : 0;
}

std::vector<FibreFacts> fibre_facts(const World& world) {
  std::vector<FibreFacts> out;
  for (const FibreGroup& group : world.fibres) {
    FibreFacts& facts = out.emplace_back();
    take_depths(world, group, facts);
    take_directions(world, group, facts);
    facts.broken = broken_bonds(world, group);
  }
  return out;
}

}  // namespace subsoil::sim
