#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libsim/studies/sweep/study.hpp"

namespace subsoil::sim {

/// A number at one value of a parameter, over all finished points that have it.
struct LevelMean {
  std::string value;
  double place = 0;  ///< the value's number, NaN of a word
  std::size_t count = 0;
  double mean = 0, half_width = 0;  ///< 95 % of the mean by Student's t over the points; NaN of one
};

/// What a parameter does to a number.
struct Effect {
  std::size_t parameter = 0, number = 0;
  std::vector<LevelMean> levels;  ///< empty where every point has a value of its own
  /// Change of the number when the parameter goes from its minimum to its maximum, all other numeric parameters
  /// held: b_k of the least squares plane y = a + sum b_k u_k, u_k in [0, 1] over the values run, with the 95 %
  /// interval by Student's t over the residuals. NaN where words, too few points or dependent columns forbid it.
  double slope = 0, slope_half = 0;
};

/// What a number does from packing to packing, all other parameters held.
struct Scatter {
  std::size_t packings = 0, settings = 0;  ///< finished points, and combinations of the other parameters that they have
  double mean = 0, half_width = 0;         ///< of one combination: 95 % of the mean by Student's t; NaN of several
  double deviation = 0;                    ///< of a single packing, pooled over the combinations
};

/// Of a study with packings; empty without a combination of two finished packings.
std::optional<Scatter> scatter(const Study& study, const std::vector<PointResult>& results, std::size_t number);

/// Effects of all parameters on all numbers, from the finished points.
std::vector<Effect> effects(const Study& study, const std::vector<PointResult>& results);

/// The finished point with the minimum or maximum of a number; empty without.
std::optional<std::size_t> best_point(const std::vector<PointResult>& results, std::size_t number, bool largest);

}  // namespace subsoil::sim
