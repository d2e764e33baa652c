#include "libmbd/base/slope.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace subsoil::mbd {

namespace {
struct Ridders {
  static constexpr int most_levels = 22, columns = 4;
  static constexpr double ratio = 4;
  static constexpr double settled = 1e-10, small_share = 1e-6;
  static constexpr double resolutions = 1e4;  // of the argument in the shortest step: its differences have four digits
  static constexpr int levels_of_growth = 3;  // of the error, after which rounding is seen to have taken over
};

/// Errors that fall no more where they are small enough, or are nothing.
bool is_settled(const Slope& best, const Eigen::VectorXi& level_of, int level) {
  const double largest = best.value.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < best.value.size(); ++i) {
    const double error = best.error[i];
    if (error <= Ridders::settled * std::abs(best.value[i])) continue;
    if (level - level_of[i] >= Ridders::levels_of_growth && error <= Ridders::small_share * largest) continue;
    return false;
  }
  return true;
}
}  // namespace

Slope slope_at_zero(const Curve1& f, double far, double resolution) {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  const Eigen::VectorXd f_0 = f(0);
  const Eigen::Index n = f_0.size();
  Slope best{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity())};
  if (n == 0) return best;
  Eigen::VectorXi level_of = Eigen::VectorXi::Zero(n);
  std::array<Eigen::VectorXd, Ridders::columns> row, before;
  Eigen::VectorXd bend_before, corner_before = Eigen::VectorXd::Zero(n), corner_two_before = corner_before;
  Eigen::Array<bool, Eigen::Dynamic, 1> moves = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(n, false);
  const double shortest = Ridders::resolutions * resolution;
  double h = far;
  for (int level = 0; level < Ridders::most_levels && h > shortest; ++level, h /= Ridders::ratio) {
    const Eigen::VectorXd plus = f(h), minus = f(-h);
    const Eigen::VectorXd bend = (plus + minus - 2 * f_0) / h;
    row[0] = (plus - minus) / (2 * h);
    const int last = std::min(level, Ridders::columns - 1);
    moves = moves || plus.array() != f_0.array() || minus.array() != f_0.array();
    double weight = 1;
    for (int c = 1; c <= last; ++c) {
      weight *= Ridders::ratio * Ridders::ratio;
      const auto k = static_cast<std::size_t>(c);
      row[k] = row[k - 1] + (row[k - 1] - before[k - 1]) / (weight - 1);
    }
    for (Eigen::Index i = 0; level > 0 && i < n; ++i) {
      // Rounding in it is four times as large at each level. That of the two levels before is there, at a half and a
      // quarter of this, so that a difference that is small by chance is not taken for a small error.
      const double bends = 0.5 * std::abs(bend[i] - bend_before[i] / Ridders::ratio);
      const double corner = std::max({bends, 2 * corner_before[i], 4 * corner_two_before[i]});
      corner_two_before[i] = std::exchange(corner_before[i], bends);
      const double rounding =
          ((moves[i] ? eps * std::max(std::abs(plus[i]), std::abs(minus[i])) : 0) + resolution * std::abs(row[0][i])) /
          h;
      for (int c = 1; c <= last; ++c) {
        const auto k = static_cast<std::size_t>(c);
        const double error =
            std::max({std::abs(row[k][i] - row[k - 1][i]), std::abs(row[k][i] - before[k - 1][i]), corner, rounding});
        if (error < best.error[i]) best.error[i] = error, best.value[i] = row[k][i], level_of[i] = level;
      }
    }
    if (level > 1 && is_settled(best, level_of, level)) break;
    before = row, bend_before = bend;
  }
  return best;
}

Eigen::VectorXd rough_slope(const Curve1& f, const Eigen::VectorXd& f_0, double step) {
  constexpr int most = 5;
  constexpr double corner = 0.1;
  Eigen::VectorXd first;
  for (int turn = 0; turn < most; ++turn, step *= 0.1) {
    const Eigen::VectorXd ahead = (f(step) - f_0) / step, behind = (f_0 - f(-step)) / step;
    if (turn == 0) first = 0.5 * (ahead + behind);
    const Eigen::VectorXd size = ahead.cwiseAbs().cwiseMax(behind.cwiseAbs());
    const double floor = Ridders::small_share * size.maxCoeff();
    bool bends = false;
    for (Eigen::Index i = 0; i < size.size(); ++i)
      bends = bends || (size[i] > floor && std::abs(ahead[i] - behind[i]) > corner * size[i]);
    if (!bends) return 0.5 * (ahead + behind);
  }
  return first;  // a corner at 0 itself, or nearer than the shortest step
}

}  // namespace subsoil::mbd
