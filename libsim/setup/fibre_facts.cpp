#include "libsim/setup/fibre_facts.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>
#include <utility>

#include "libdem/packing/measure.hpp"
#include "libmbd/base/dense.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

/// Where the soil ends upward: its highest point on a vertical line. Columns of the mean surface would not do: they are
/// as high as their highest sphere, and fibres that lie between such spheres would be below them.
class SoilFromAbove {
 public:
  explicit SoilFromAbove(const World& world) : cell_(world.bed->options().periodic) {
    for (const dem::Sphere& s : world.bed->spheres())
      if (s.id < world.soil.fibres_from) add(s);
    side_ = 2 * largest_;
    for (const dem::Sphere& s : soil_) bins_[bin(s.x.x, s.x.z)].push_back(&s);
  }
  double diameter() const { return 2 * dem::mean_radius(soil_); }
  double lowest() const {
    double low = std::numeric_limits<double>::infinity();
    for (const dem::Sphere& s : soil_) low = std::min(low, s.x.y - s.r);
    return low;
  }
  /// Of the soil above a point, or below it where negative; none there: -infinity.
  double depth_of(const Vec3& point) const {
    const Vec3 x = cell_.wrapped(point);
    const auto [i, k] = bin(x.x, x.z);
    double top = -std::numeric_limits<double>::infinity();
    for (long di = -1; di <= 1; ++di)
      for (long dk = -1; dk <= 1; ++dk) {
        const auto found = bins_.find({i + di, k + dk});
        if (found == bins_.end()) continue;
        for (const dem::Sphere* s : found->second) {
          const double dx = s->x.x - x.x, dz = s->x.z - x.z, square = s->r * s->r - dx * dx - dz * dz;
          if (square > 0) top = std::max(top, s->x.y + std::sqrt(square));
        }
      }
    return top - x.y;
  }

 private:
  /// With its images beyond periodic sides.
  void add(const dem::Sphere& s) {
    largest_ = std::max(largest_, s.r);
    const std::size_t first = soil_.size();
    soil_.push_back(s);
    soil_.back().x = cell_.wrapped(s.x);
    for (const int d : {0, 2})
      if (cell_.length[d] > 0)
        for (std::size_t n = first, count = soil_.size(); n < count; ++n)
          for (const double shift : {-cell_.length[d], cell_.length[d]}) {
            dem::Sphere image = soil_[n];
            image.x[d] += shift;
            const double low = cell_.low[d] - image.r, high = cell_.low[d] + cell_.length[d] + image.r;
            if (image.x[d] > low && image.x[d] < high) soil_.push_back(image);
          }
  }
  std::pair<long, long> bin(double x, double z) const {
    return {static_cast<long>(std::floor(x / side_)), static_cast<long>(std::floor(z / side_))};
  }

  dem::PeriodicCell cell_;
  std::vector<dem::Sphere> soil_;
  double largest_ = 0, side_ = 1;
  std::map<std::pair<long, long>, std::vector<const dem::Sphere*>> bins_;
};

/// Bands of two mean diameters of the soil or thicker, of which no more than twelve reach to the floor.
constexpr double kBandDiameters = 2, kMostBands = 12;

void take_depths(const World& world, const SoilFromAbove& soil, const FibreGroup& group, FibreFacts& out) {
  const double deep = std::max(world.soil.surface_mean - soil.lowest(), soil.diameter());
  const double bands = std::clamp(std::floor(deep / (kBandDiameters * soil.diameter())), 1.0, kMostBands);
  out.band = deep / bands;
  out.by_depth.assign(static_cast<std::size_t>(bands), 0.0);
  double moment = 0;
  for (const dem::Sphere& s : world.bed->spheres()) {
    if (!group.has(s.id)) continue;
    out.mass += s.m;
    const double depth = soil.depth_of(s.x);
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
  out.order = mbd::eigenvalues(sum / n).real().maxCoeff();
}

}  // namespace

std::size_t broken_bonds(const World& world, const FibreGroup& group) {
  const auto all = world.bed->broken_bonds();
  return static_cast<std::size_t>(
      std::count_if(all.begin(), all.end(), [&](const dem::BrokenBond& b) { return group.has(b.ids[0]); }));
}

double buried_share(const World& world, const FibreGroup& group) {
  FibreFacts facts;
  take_depths(world, SoilFromAbove(world), group, facts);
  return facts.mass > 0 ? facts.buried / facts.mass : 0;
}

std::vector<FibreFacts> fibre_facts(const World& world) {
  std::vector<FibreFacts> out;
  if (world.fibres.empty()) return out;
  const SoilFromAbove soil(world);
  for (const FibreGroup& group : world.fibres) {
    FibreFacts& facts = out.emplace_back();
    take_depths(world, soil, group, facts);
    take_directions(world, group, facts);
    facts.broken = broken_bonds(world, group);
  }
  return out;
}

}  // namespace subsoil::sim
