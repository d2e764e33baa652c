#include "libdem/packing/fibres.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "libdem/packing/sizes.hpp"

namespace subsoil::dem {
namespace {

constexpr int kTries = 2000;    ///< per fibre and height
constexpr double kApart = 0.1;  ///< of a diameter, between the surfaces of fibres that are placed
constexpr double kHigher = 2;   ///< diameters by which a pile may grow when a fibre finds no room
constexpr int kTriesOfAPile = 20;
constexpr int kRises = 200;  ///< of a pile without a fibre that fits: none ever will

std::string in_mm(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g mm", 1e3 * x);
  return text;
}

/// Minimum distance of two segments, each by its centre, direction of unit length and half length.
double axis_distance(const FibrePose& a, double half_a, const FibrePose& b, double half_b) {
  const Vec3 apart = b.centre - a.centre;
  const double c = dot(a.direction, b.direction), along_a = dot(apart, a.direction), along_b = dot(apart, b.direction);
  const double square = 1 - c * c;
  // On both lines nearest; then each end is clamped and the other point follows.
  double s = square > 1e-12 ? std::clamp((along_a - c * along_b) / square, -half_a, half_a) : 0;
  double t = std::clamp(c * s - along_b, -half_b, half_b);
  s = std::clamp(along_a + c * t, -half_a, half_a);
  t = std::clamp(c * s - along_b, -half_b, half_b);
  return norm(apart + t * b.direction - s * a.direction);
}

Vec3 any_fibre_direction(RandomNumbers& random) {
  const double y = random.uniform(-1, 1), angle = random.uniform(0, 2 * std::numbers::pi), r = std::sqrt(1 - y * y);
  return {r * std::cos(angle), y, r * std::sin(angle)};
}

Vec3 direction_of(const FibreField& field, RandomNumbers& random) {
  if (field.orientation == FibreField::Orientation::random) return any_fibre_direction(random);
  if (field.orientation == FibreField::Orientation::horizontal) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    return {std::cos(angle), 0, std::sin(angle)};
  }
  const Vec3 axis = normalized(field.axis);
  const Vec3 any = std::abs(axis.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
  const Vec3 u = normalized(cross(axis, any)), v = cross(axis, u);
  return normalized(axis + std::tan(field.scatter * random.normal()) * u +
                    std::tan(field.scatter * random.normal()) * v);
}

class FibrePlacer {
 public:
  FibrePlacer(const FibreField& field, std::span<const PlacedFibre> taken)
      : field_(field), taken_(taken), random_(field.seed), high_(field.region.high.y) {}

  std::vector<FibrePose> place() {
    std::vector<FibrePose> out;
    int rises = 0;
    while (out.size() < field_.count) {
      if (const auto pose = one(out)) {
        out.push_back(*pose), rises = 0;
      } else if (field_.piles && rises++ < kRises) {
        high_ += kHigher * field_.shape.diameter;
      } else {
        throw std::invalid_argument("only " + std::to_string(out.size()) + " of " + std::to_string(field_.count) +
                                    " fibres of " + in_mm(half_length() * 2) + " find room in " + box() +
                                    "; fewer or shorter ones, or more room");
      }
    }
    return out;
  }

 private:
  double half_length() const { return 0.5 * field_.shape.chain_length(); }
  std::string box() const {
    const Vec3 size = field_.region.high - field_.region.low;
    return in_mm(size.x) + " x " + (field_.piles ? std::string("any height") : in_mm(size.y)) + " x " + in_mm(size.z);
  }

  std::optional<FibrePose> one(const std::vector<FibrePose>& before) {
    for (int n = 0; n < (field_.piles ? kTriesOfAPile : kTries); ++n) {
      FibrePose pose{{}, direction_of(field_, random_)};
      bool fits = true;
      const double r = 0.5 * field_.shape.diameter;
      for (int d = 0; d < 3; ++d) {
        const double reach = field_.cell.length[d] > 0 ? 0 : r + (half_length() - r) * std::abs(pose.direction[d]);
        const double top = d == 1 ? std::max(high_, field_.piles ? field_.region.low.y + 2.001 * reach : high_)
                                  : field_.region.high[d];
        const double room = top - field_.region.low[d] - 2 * reach;
        fits = fits && room >= 0;
        pose.centre[d] = field_.region.low[d] + reach + std::max(room, 0.0) * random_.uniform();
      }
      if (fits && is_clear(pose, before)) return pose;
    }
    return std::nullopt;
  }

  bool is_clear(const FibrePose& pose, const std::vector<FibrePose>& before) const {
    const double d = field_.shape.diameter, half = half_length() - 0.5 * d;
    const auto clear_of_one = [&](const FibrePose& other, const FibreShape& shape) {
      const double sum = 0.5 * (d + shape.diameter) + kApart * d;
      if (norm(pose.centre - other.centre) > half_length() + 0.5 * shape.chain_length() + sum) return true;
      return axis_distance(pose, half, other, 0.5 * (shape.chain_length() - shape.diameter)) > sum;
    };
    // With images beyond periodic sides, also of itself.
    const auto clear_of = [&](const FibrePose& other, const FibreShape& shape) {
      const Vec3& period = field_.cell.length;
      const int nx = period.x > 0 ? 1 : 0, nz = period.z > 0 ? 1 : 0;
      for (int x = -nx; x <= nx; ++x)
        for (int z = -nz; z <= nz; ++z) {
          if (&other == &pose && x == 0 && z == 0) continue;
          FibrePose image = other;
          image.centre += Vec3{x * period.x, 0, z * period.z};
          if (!clear_of_one(image, shape)) return false;
        }
      return true;
    };
    if (!clear_of(pose, field_.shape)) return false;
    return std::all_of(before.begin(), before.end(), [&](const FibrePose& p) { return clear_of(p, field_.shape); }) &&
           std::all_of(taken_.begin(), taken_.end(), [&](const PlacedFibre& p) { return clear_of(p.pose, p.shape); });
  }

  const FibreField& field_;
  std::span<const PlacedFibre> taken_;
  RandomNumbers random_;
  double high_;  ///< m
};

}  // namespace

int FibreShape::spheres() const { return std::max(1, static_cast<int>(std::lround(length / diameter))); }

double FibreShape::mass() const { return of.density * std::numbers::pi / 4 * diameter * diameter * chain_length(); }

std::vector<FibrePose> place_fibres(const FibreField& field, std::span<const PlacedFibre> taken) {
  const FibreShape& shape = field.shape;
  if (!(shape.diameter > 0) || !(shape.of.density > 0))
    throw std::invalid_argument("a fibre needs diameter and density");
  if (shape.spheres() < 2)
    throw std::invalid_argument("a fibre of " + in_mm(shape.length) + " and " + in_mm(shape.diameter) +
                                " diameter is one sphere; make it two diameters long at least");
  // Without this a pile grows for ever.
  const Vec3 size = field.region.high - field.region.low;
  if (std::max(size.x, size.z) < shape.diameter || std::min(size.x, size.z) < shape.diameter)
    throw std::invalid_argument("fibres of " + in_mm(shape.diameter) + " find no room in " + in_mm(size.x) + " x " +
                                in_mm(size.z));
  const bool lies = field.orientation != FibreField::Orientation::random;
  const Vec3 axis = normalized(field.axis);
  const double needed = shape.chain_length() - shape.diameter;
  if (lies && field.scatter == 0 && field.orientation == FibreField::Orientation::along)
    for (int d = 0; d < 3; d += 2)
      if (!(field.cell.length[d] > 0) && needed * std::abs(axis[d]) + shape.diameter > size[d])
        throw std::invalid_argument("fibres of " + in_mm(shape.chain_length()) +
                                    " along this direction find no room in " + in_mm(size.x) + " x " + in_mm(size.z));
  // A fibre may stand: only one that lies is as long as the plan at most.
  const double longest = field.orientation == FibreField::Orientation::horizontal ? std::hypot(size.x, size.z)
                         : field.piles ? std::numeric_limits<double>::infinity()
                                       : norm(size);
  if (needed > longest)
    throw std::invalid_argument("fibres of " + in_mm(shape.chain_length()) + " find no room in " + in_mm(size.x) +
                                " x " + in_mm(size.z) + "; make them shorter, or the bed larger");
  return FibrePlacer(field, taken).place();
}

Bed::State fibres_at(const FibreShape& shape, std::span<const FibrePose> poses, std::uint32_t first_id) {
  Bed::State out;
  const auto n = static_cast<std::uint32_t>(shape.spheres());
  Sphere sphere{};
  sphere.r = 0.5 * shape.diameter;
  sphere.m = shape.mass() / n;
  sphere.material = static_cast<std::uint16_t>(shape.of.material);
  for (const FibrePose& pose : poses)
    for (std::uint32_t k = 0; k < n; ++k) {
      sphere.id = first_id + static_cast<std::uint32_t>(out.spheres.size());
      sphere.x = pose.centre + (k - 0.5 * (n - 1)) * shape.diameter * pose.direction;
      out.spheres.push_back(sphere);
      if (k == 0) continue;
      const Sphere& before = out.spheres[out.spheres.size() - 2];
      BondHistory bond{before.id, sphere.id, {}};
      bond.state.state = kBonded, bond.state.reference = 2 * sphere.r - norm(sphere.x - before.x);
      out.bonds.push_back(bond);
    }
  return out;
}

}  // namespace subsoil::dem
