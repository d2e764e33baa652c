#include "libdem/packing/measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <vector>

#include "libdem/particles/fixed.hpp"

namespace subsoil::dem {
namespace {

/// Weights along one axis.
class Window {
 public:
  Window(double from, double to, double diameter) : low_(from), high_(to) {
    const double diameters = (to - from) / diameter;
    kind_ = diameters < kThin ? Kind::whole : diameters < kShallow ? Kind::few : Kind::middle;
    if (kind_ != Kind::whole) low_ += diameter, high_ -= diameter;
  }
  static Window period(double length) { return Window(length); }

  double operator()(double x, double r) const {
    switch (kind_) {
      case Kind::period:
        return 1;
      case Kind::whole:
        return share_above((x - low_) / r) + share_above((high_ - x) / r) - 1;
      case Kind::few:
        return mean_in_sphere(x, r);
      case Kind::middle:
        break;
    }
    return weight(x);
  }
  double integral() const { return (kind_ == Kind::middle || kind_ == Kind::few ? 0.5 : 1) * (high_ - low_); }

 private:
  static constexpr double kThin = 4, kShallow = 6;  // diameters
  explicit Window(double length) : low_(0), high_(length), kind_(Kind::period) {}
  double weight(double x) const {
    if (!(x > low_ && x < high_)) return 0;
    const double s = std::sin(std::numbers::pi * (x - low_) / (high_ - low_));
    return s * s;
  }
  /// Of a sphere's volume beyond a plane, its centre `height` radii beyond it.
  static double share_above(double height) {
    const double s = std::clamp(height, -1.0, 1.0);
    return 0.25 * (2 + 3 * s - s * s * s);
  }
  /// Mean of the weight over the sphere's volume, by Gauss's rule over what of it lies inside.
  double mean_in_sphere(double x, double r) const {
    constexpr std::array<double, 4> nodes{0.18343464249564980, 0.52553240991632899, 0.79666647741362674,
                                          0.96028985649753623};
    constexpr std::array<double, 4> weights{0.36268378337836198, 0.31370664587788729, 0.22238103445337447,
                                            0.10122853629037626};
    const double from = std::max(x - r, low_), to = std::min(x + r, high_), half = 0.5 * (to - from);
    if (!(half > 0)) return 0;
    double sum = 0;
    for (std::size_t k = 0; k < nodes.size(); ++k)
      for (const double sign : {-1.0, 1.0}) {
        const double at = 0.5 * (from + to) + sign * nodes[k] * half, off = (at - x) / r;
        sum += weights[k] * weight(at) * 0.75 * (1 - off * off) / r;
      }
    return half * sum;
  }

  double low_, high_;
  enum class Kind { middle, few, whole, period } kind_;
};

/// Cells of one diameter with the spheres in them, for neighbour counts.
class Cells {
 public:
  Cells(std::span<const Sphere> spheres, double side) : side_(side) {
    for (const Sphere& s : spheres) box_.include(s.x);
    // A sphere that flew far off must not cost a grid of its distance: coarser cells are only slower.
    const double enough = 8 * static_cast<double>(spheres.size()) + 1000;
    for (;; side_ *= 2) {
      double total = 1;
      for (int d = 0; d < 3; ++d) total *= std::floor((box_.high[d] - box_.low[d]) / side_) + 1;
      if (total <= enough) break;
    }
    for (int d = 0; d < 3; ++d) n_[d] = 1 + static_cast<long>((box_.high[d] - box_.low[d]) / side_);
    start_.assign(static_cast<std::size_t>(n_[0] * n_[1] * n_[2]) + 1, 0);
    for (const Sphere& s : spheres) ++start_[index(s.x) + 1];
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    std::vector<std::uint32_t> fill(start_.begin(), start_.end() - 1);
    order_.resize(spheres.size());
    for (std::uint32_t i = 0; i < spheres.size(); ++i) order_[fill[index(spheres[i].x)]++] = i;
  }

  /// Calls visit(j) for all spheres in the 27 cells around x.
  template <class Visit>
  void around(const Vec3& x, Visit&& visit) const {
    long from[3], to[3];
    for (int d = 0; d < 3; ++d) {
      const long c = coordinate(x, d);
      from[d] = std::max(0L, c - 1), to[d] = std::min(n_[d] - 1, c + 1);
    }
    for (long i = from[0]; i <= to[0]; ++i)
      for (long j = from[1]; j <= to[1]; ++j) {
        const auto row = static_cast<std::size_t>((i * n_[1] + j) * n_[2]);
        const std::size_t a = row + static_cast<std::size_t>(from[2]), b = row + static_cast<std::size_t>(to[2]);
        for (std::uint32_t k = start_[a]; k < start_[b + 1]; ++k) visit(order_[k]);
      }
  }

 private:
  long coordinate(const Vec3& x, int d) const {
    return std::min(n_[d] - 1, static_cast<long>((x[d] - box_.low[d]) / side_));
  }
  std::size_t index(const Vec3& x) const {
    return static_cast<std::size_t>((coordinate(x, 0) * n_[1] + coordinate(x, 1)) * n_[2] + coordinate(x, 2));
  }
  double side_;
  Bounds box_;
  long n_[3];
  std::vector<std::uint32_t> start_, order_;
};

/// With images of those near a side, beyond the other.
std::vector<Sphere> with_images(std::span<const Sphere> spheres, const PeriodicCell& cell, double near) {
  std::vector<Sphere> out(spheres.begin(), spheres.end());
  for (Sphere& s : out) s.x = cell.wrapped(s.x);
  for (int d = 0; d < 3; ++d) {
    if (cell.length[d] == 0) continue;
    for (std::size_t k = 0, count = out.size(); k < count; ++k)
      for (const double shift : {-cell.length[d], cell.length[d]}) {
        Sphere image = out[k];
        image.x[d] += shift;
        if (image.x[d] > cell.low[d] - near && image.x[d] < cell.low[d] + cell.length[d] + near) out.push_back(image);
      }
  }
  return out;
}

}  // namespace

double mean_radius(std::span<const Sphere> spheres) {
  double sum = 0;
  for (const Sphere& s : spheres) sum += s.r;
  return spheres.empty() ? 0 : sum / static_cast<double>(spheres.size());
}

double highest_top(std::span<const Sphere> spheres, double otherwise) {
  double top = otherwise;
  for (const Sphere& s : spheres) top = std::max(top, s.x.y + s.r);
  return top;
}

SurfaceHeight surface_height(std::span<const Sphere> spheres, const Bounds& region) {
  double sum = 0, count = 0;
  for (const Sphere& s : spheres)
    if (!is_fixed(s)) sum += s.r, ++count;
  return surface_height(spheres, region, 4 * (count > 0 ? sum / count : mean_radius(spheres)));
}

namespace {
/// Whole columns of that width; the order in which a mean radius was summed must not take one off.
double columns_along(double length, double across) { return std::max(1.0, std::floor(length / across * (1 + 1e-9))); }
}  // namespace

SurfaceHeight surface_height(std::span<const Sphere> spheres, const Bounds& region, double across) {
  const double floor = region.low.y;
  if (spheres.empty()) return {floor, 0, floor, floor};
  const Vec3 size = region.high - region.low;
  // A few small spheres in a large region must not cost a column for each of their diameters.
  const double enough = 8 * static_cast<double>(spheres.size()) + 1e6;
  while (columns_along(size.x, across) * columns_along(size.z, across) > enough) across *= 2;
  const long nx = static_cast<long>(columns_along(size.x, across)),
             nz = static_cast<long>(columns_along(size.z, across));
  std::vector<double> top(static_cast<std::size_t>(nx * nz), floor);
  for (const Sphere& s : spheres) {
    const double u = (s.x.x - region.low.x) / size.x, w = (s.x.z - region.low.z) / size.z;
    if (!(u >= 0 && u < 1 && w >= 0 && w < 1)) continue;
    double& t = top[static_cast<std::size_t>(static_cast<long>(u * static_cast<double>(nx)) * nz +
                                             static_cast<long>(w * static_cast<double>(nz)))];
    t = std::max(t, s.x.y + s.r);
  }
  const double n = static_cast<double>(top.size());
  SurfaceHeight out{.mean = 0, .spread = 0, .lowest = top[0], .highest = top[0]};
  for (const double t : top) {
    out.mean += t / n;
    out.lowest = std::min(out.lowest, t), out.highest = std::max(out.highest, t);
  }
  for (const double t : top) out.spread += (t - out.mean) * (t - out.mean) / n;
  out.spread = std::sqrt(out.spread);
  return out;
}

SurfaceHeight surface_height(std::span<const Sphere> spheres, Bounds region, double x_from, double x_to) {
  region.low.x = x_from, region.high.x = x_to;
  return surface_height(spheres, region);
}

double bulk_density(std::span<const Sphere> spheres, const Bounds& region, const PeriodicCell& cell) {
  const double diameter = 2 * mean_radius(spheres), surface = surface_height(spheres, region).mean;
  const auto along = [&](int d) {
    if (cell.length[d] > 0) return Window::period(cell.length[d]);
    return Window(region.low[d], d == 1 ? surface : region.high[d], diameter);
  };
  const Window x = along(0), y = along(1), z = along(2);
  double mass = 0;
  for (const Sphere& s : spheres) mass += s.m * x(s.x.x, s.r) * y(s.x.y, s.r) * z(s.x.z, s.r);
  const double volume = x.integral() * y.integral() * z.integral();
  return volume > 0 ? mass / volume : 0;
}

namespace {

/// @param one(a, b) whether both spheres are of one rigid grain
template <class OfOneGrain>
double touching_per_sphere(std::span<const Sphere> all, const PeriodicCell& cell, const OfOneGrain& one) {
  if (all.empty()) return 0;
  double largest = 0;
  for (const Sphere& s : all) largest = std::max(largest, s.r);
  const std::vector<Sphere> around = cell.any() ? with_images(all, cell, 2 * largest) : std::vector<Sphere>{};
  const std::span<const Sphere> spheres = cell.any() ? std::span<const Sphere>(around) : all;
  const Cells cells(spheres, 2 * largest);
  std::size_t touching = 0, free = 0;
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    if (is_fixed(all[i])) continue;
    ++free;
    cells.around(spheres[i].x, [&](std::uint32_t j) {
      const Vec3 between = spheres[i].x - spheres[j].x;
      const double touching_distance = spheres[i].r + spheres[j].r;
      if (j != i && dot(between, between) < touching_distance * touching_distance && !one(spheres[i], spheres[j]))
        ++touching;
    });
  }
  return free == 0 ? 0 : static_cast<double>(touching) / static_cast<double>(free);
}

}  // namespace

double coordination_number(std::span<const Sphere> spheres, const PeriodicCell& cell) {
  return touching_per_sphere(spheres, cell, [](const Sphere&, const Sphere&) { return false; });
}

double bulk_density(const Bed& bed, const Bounds& region) {
  return bulk_density(bed.spheres(), region, bed.options().periodic);
}

std::vector<Sphere> spheres_below(std::span<const Sphere> spheres, std::uint32_t below) {
  std::vector<Sphere> out;
  std::copy_if(spheres.begin(), spheres.end(), std::back_inserter(out), [&](const Sphere& s) { return s.id < below; });
  return out;
}

BedReport report(const Bed& bed, const Bounds& region, std::uint32_t below) {
  const PeriodicCell& cell = bed.options().periodic;
  const std::vector<Sphere> own = below == kAllSpheres ? std::vector<Sphere>{} : spheres_below(bed.spheres(), below);
  const std::span<const Sphere> spheres = below == kAllSpheres ? bed.spheres() : std::span<const Sphere>(own);
  if (bed.clumps().empty()) return report(spheres, region, cell);
  BedReport out = report(spheres, region, cell);
  out.coordination = touching_per_sphere(spheres, cell, [&](const Sphere& a, const Sphere& b) {
    const long of_a = bed.clump_of(a);
    return of_a >= 0 && of_a == bed.clump_of(b);
  });
  return out;
}

BedReport report(std::span<const Sphere> spheres, const Bounds& region, const PeriodicCell& cell) {
  BedReport out;
  out.spheres = spheres.size();
  for (const Sphere& s : spheres) out.mass += s.m;
  out.bulk_density = bulk_density(spheres, region, cell);
  out.surface = surface_height(spheres, region);
  out.coordination = coordination_number(spheres, cell);
  return out;
}

Bounds box_of(std::span<const Sphere> spheres) {
  Bounds box;
  for (const Sphere& s : spheres) {
    const Vec3 around{s.r, s.r, s.r};
    box.include(s.x - around), box.include(s.x + around);
  }
  return box;
}

}  // namespace subsoil::dem
