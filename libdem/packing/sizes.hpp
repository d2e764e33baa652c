#pragma once
#include <cstdint>
#include <random>
#include <variant>
#include <vector>

#include "libdem/base/vec3.hpp"

/// Sizes of the spheres of a bed.
namespace subsoil::dem {

/// Random numbers of the bed makers. The engine is fixed by the C++ standard, the distributions of the standard library
/// are not: the same seed would give another bed with another library, so the transforms are our own.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }  ///< [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal();      ///< mean 0, deviation 1 (Box and Muller 1958, one of the two)
  Vec3 in_unit_ball();  ///< even density

 private:
  std::mt19937_64 engine_;
};

struct EqualRadius {
  double radius = 0;  ///< m
};
/// Normal distribution cut off: values outside [minimum, maximum] are drawn again.
struct NormalRadius {
  double mean = 0, deviation = 0, least = 0, largest = 0;  ///< m
};
struct UniformRadius {
  double least = 0, largest = 0;  ///< m
};
struct TableRadius {
  std::vector<double> radius;  ///< m
  std::vector<double> share;   ///< any sum
};
using RadiusDistribution = std::variant<EqualRadius, NormalRadius, UniformRadius, TableRadius>;

/// What a share of the distribution counts: spheres, or their mass (what a sieve curve gives).
enum class ShareOf { number, mass };

double least_radius(const RadiusDistribution& sizes);
double largest_radius(const RadiusDistribution& sizes);

/// Draws radii. Shares by mass become shares by number with weight 1/r^3.
class RadiusSampler {
 public:
  /// Throws std::invalid_argument for a distribution without sense.
  RadiusSampler(RadiusDistribution sizes, ShareOf shares);
  double draw(RandomNumbers& random) const;

 private:
  double draw_from(const EqualRadius& d, RandomNumbers& random) const;
  double draw_from(const NormalRadius& d, RandomNumbers& random) const;
  double draw_from(const UniformRadius& d, RandomNumbers& random) const;
  double draw_from(const TableRadius& d, RandomNumbers& random) const;
  bool keep(double radius, double least, RandomNumbers& random) const;

  RadiusDistribution sizes_;
  ShareOf shares_;
  std::vector<double> cumulative_;  ///< of a table, by number, ends at 1
};

/// Radius of a sphere of mean volume, m: so many of it take the room of as many of the distribution. Of 20,000 that are
/// drawn, the same each time.
double radius_of_mean_volume(const RadiusDistribution& sizes, ShareOf shares);
/// Solid fraction of a random packing over that of equal spheres,
///     1 + (0.0658 delta + 0.0857 S delta^2)/0.634
/// delta deviation over mean and S skewness of the radii by number, of the same 20,000. Source: Desmond & Weeks 2014,
/// Phys. Rev. E 90, 022204.
double denser_than_equal(const RadiusDistribution& sizes, ShareOf shares);

}  // namespace subsoil::dem
