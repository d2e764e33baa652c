#include "libsim/setup/fibre_facts.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>

#include "libdem/packing/measure.hpp"
#include "libmbd/base/dense.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

/// Where the soil ends upward: its highest point on a vertical line. Columns of the mean surface would not do: they are
/// as high as their highest sphere, and fibres that lie between such spheres would be below them. A grain in flight,
/// farther than a tenth of its radius from any other sphere, is no soil that covers: at rest a gap is a few overlaps
/// wide, and a grain thrown by a tool is over the straw for a moment.
class SoilFromAbove {
 public:
  explicit SoilFromAbove(const World& world) : cell_(world.bed->options().periodic) {
    for (const dem::Sphere& s : world.bed->spheres()) largest_ = std::max(largest_, s.r);
    for (const bool soil : {true, false}) {
      for (const dem::Sphere& s : world.bed->spheres())
        if (is_of_fibres(world, s.id) != soil) add(s);
      if (soil) soil_ = spheres_.size();
    }
    sort();
  }
  double diameter() const { return 2 * dem::mean_radius(soil()); }
  double lowest() const {
    double low = std::numeric_limits<double>::infinity();
    for (const dem::Sphere& s : soil()) low = std::min(low, s.x.y - s.r);
    return low;
  }
  /// Of the soil above a point, or below it where negative; none there: -infinity.
  double depth_of(const Vec3& point) const {
    const Vec3 x = cell_.wrapped(point);
    double top = -std::numeric_limits<double>::infinity();
    each_near(x, [&](std::uint32_t e) {
      const Top& s = sorted_[e];
      const double dx = s.x.x - x.x, dz = s.x.z - x.z, square = s.r * s.r - dx * dx - dz * dz;
      if (s.soil && square > 0 && s.x.y + std::sqrt(square) > top && !flies(e)) top = s.x.y + std::sqrt(square);
    });
    return top - x.y;
  }

 private:
  std::span<const dem::Sphere> soil() const { return std::span(spheres_).first(soil_); }
  /// use(e) for what may lie over a point or touch what does.
  template <class Use>
  void each_near(const Vec3& x, const Use& use) const {
    if (sorted_.empty()) return;
    const long i = bin(0, x), k = bin(2, x), first = std::max(k - 1, 0L), last = std::min(k + 1, count_[2] - 1);
    for (long n = std::max(i - 1, 0L); n <= std::min(i + 1, count_[0] - 1); ++n)
      // Bins side by side along z are one after the other.
      for (std::uint32_t e = start_[place(n, first)]; e < start_[place(n, last) + 1]; ++e) use(e);
  }
  bool flies(std::uint32_t e) const {
    const Top& s = sorted_[e];
    bool alone = true;
    each_near(s.x, [&](std::uint32_t other) {
      const double reach = sorted_[other].r + (1 + kInFlight) * s.r;
      if (other != e) alone = alone && dem::norm(sorted_[other].x - s.x) > reach;
    });
    return alone;
  }
  /// With its images beyond periodic sides, as far as they may touch what is inside.
  void add(const dem::Sphere& s) {
    const std::size_t first = spheres_.size();
    const double margin = (2 + kInFlight) * largest_;
    spheres_.push_back(s);
    spheres_.back().x = cell_.wrapped(s.x);
    for (const int d : {0, 2})
      if (cell_.length[d] > 0)
        for (std::size_t n = first, count = spheres_.size(); n < count; ++n)
          for (const double shift : {-cell_.length[d], cell_.length[d]}) {
            dem::Sphere image = spheres_[n];
            image.x[d] += shift;
            const double low = cell_.low[d] - margin, high = cell_.low[d] + cell_.length[d] + margin;
            if (image.x[d] > low && image.x[d] < high) spheres_.push_back(image);
          }
  }
  /// By bin of their plan, whose sides are a diameter of the largest sphere or more: a column of nine holds all that
  /// reaches over a point, and what touches a sphere there. Bins cover two standard deviations to either side of the
  /// mean, all of an even bed, and those at the rim whatever lies beyond: one sphere that has flown far leaves the
  /// others in bins of their own.
  void sort() {
    if (spheres_.empty()) return;
    const auto number = static_cast<double>(spheres_.size());
    Vec3 size;
    for (const int d : {0, 2}) {
      double low = spheres_.front().x[d], high = low, sum = 0, squares = 0;
      for (const dem::Sphere& s : spheres_) low = std::min(low, s.x[d]), high = std::max(high, s.x[d]), sum += s.x[d];
      for (const dem::Sphere& s : spheres_) squares += (s.x[d] - sum / number) * (s.x[d] - sum / number);
      const double far = 2 * std::sqrt(squares / number);
      low_[d] = std::max(low, sum / number - far);
      size[d] = std::max(std::min(high, sum / number + far) - low_[d], 0.0);
    }
    side_ = (2 + kInFlight) * largest_;
    while ((size.x / side_ + 1) * (size.z / side_ + 1) > number && (size.x > side_ || size.z > side_)) side_ *= 2;
    for (const int d : {0, 2}) count_[d] = static_cast<long>(size[d] / side_) + 1;
    start_.assign(static_cast<std::size_t>(count_[0] * count_[2]) + 1, 0);
    const auto of = [&](const dem::Sphere& s) { return place(bin(0, s.x), bin(2, s.x)); };
    for (const dem::Sphere& s : spheres_) ++start_[of(s) + 1];
    for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    sorted_.resize(spheres_.size());
    for (std::size_t n = 0; n < spheres_.size(); ++n) {
      const dem::Sphere& s = spheres_[n];
      sorted_[next[of(s)]++] = {s.x, s.r, n < soil_};
    }
  }
  long bin(int d, const Vec3& x) const {
    const double of = std::floor((x[d] - low_[d]) / side_);
    return static_cast<long>(std::clamp(of, 0.0, static_cast<double>(count_[d] - 1)));
  }
  std::size_t place(long i, long k) const { return static_cast<std::size_t>(i * count_[2] + k); }

  static constexpr double kInFlight = 0.1;  ///< of a radius

  struct Top {
    Vec3 x;
    double r;
    bool soil;
  };
  dem::PeriodicCell cell_;
  std::vector<dem::Sphere> spheres_;  ///< soil, then fibres
  std::size_t soil_ = 0;
  double largest_ = 0, side_ = 1;
  Vec3 low_;
  long count_[3] = {0, 0, 0};         ///< of bins along x and z
  std::vector<std::uint32_t> start_;  ///< of each bin in
  std::vector<Top> sorted_;
};

/// Without what is held beyond the ends of a moving bed, which no sum counts.
bool counts(const World& world, const FibreGroup& group, const dem::Sphere& s) {
  return group.has(s.id) && !(world.moving && dem::is_fixed(s));
}

double buried_share(const World& world, const SoilFromAbove& soil, const FibreGroup& group) {
  double mass = 0, buried = 0;
  for (const dem::Sphere& s : world.bed->spheres()) {
    if (!counts(world, group, s)) continue;
    mass += s.m;
    if (soil.depth_of(s.x) > 0) buried += s.m;
  }
  return mass > 0 ? buried / mass : 0;
}

/// Bands of two mean diameters of the soil or thicker, of which no more than twelve reach to the floor.
constexpr double kBandDiameters = 2, kMostBands = 12;

void take_depths(const World& world, const SoilFromAbove& soil, const FibreGroup& group, FibreFacts& out) {
  const double deep = std::max(world.soil.surface_mean - soil.lowest(), soil.diameter());
  const double bands = std::clamp(std::floor(deep / (kBandDiameters * soil.diameter())), 1.0, kMostBands);
  out.band = deep / bands;
  out.by_depth.assign(static_cast<std::size_t>(bands), 0.0);
  double moment = 0;
  for (const dem::Sphere& s : world.bed->spheres()) {
    if (!counts(world, group, s)) continue;
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

std::size_t cut_bonds(const World& world, const FibreGroup& group) {
  const auto all = world.bed->broken_bonds();
  return static_cast<std::size_t>(std::count_if(
      all.begin(), all.end(), [&](const dem::BrokenBond& b) { return b.by_edge && group.has(b.ids[0]); }));
}

const std::vector<double>& BuriedFibres::shares() {
  if (!shares_.empty()) return shares_;
  const SoilFromAbove soil(world_);
  for (const FibreGroup& group : world_.fibres) shares_.push_back(buried_share(world_, soil, group));
  return shares_;
}

std::vector<FibreFacts> fibre_facts(const World& world) {
  std::vector<FibreFacts> out;
  if (world.fibres.empty()) return out;
  const SoilFromAbove soil(world);
  for (const FibreGroup& group : world.fibres) {
    FibreFacts& facts = out.emplace_back();
    take_depths(world, soil, group, facts);
    take_directions(world, group, facts);
    facts.broken = broken_bonds(world, group), facts.cut = cut_bonds(world, group);
  }
  return out;
}

}  // namespace subsoil::sim
