#include "libmbd/base/sparse.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace subsoil::mbd::sparse_test {
namespace {

/// A random pattern with a strong diagonal: well conditioned, so a dense solver agrees to rounding times a few.
std::vector<std::vector<int>> random_pattern(int n, double fill, std::mt19937& dice, bool symmetric) {
  std::uniform_real_distribution<double> chance(0, 1);
  std::vector<std::vector<int>> pattern(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < (symmetric ? i : n); ++j) {
      if (i == j || chance(dice) > fill) continue;
      pattern[static_cast<std::size_t>(i)].push_back(j);
      if (symmetric) pattern[static_cast<std::size_t>(j)].push_back(i);
    }
  return pattern;
}

template <class Solver>
void compare(Solver& solver, const Eigen::MatrixXd& a, std::mt19937& dice) {
  std::uniform_real_distribution<double> value(-1, 1);
  const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(a.rows(), [&] { return value(dice); });
  std::vector<double> x(b.data(), b.data() + b.size());
  solver.solve(x);
  const Eigen::VectorXd exact = a.fullPivLu().solve(b);
  for (Eigen::Index i = 0; i < b.size(); ++i) EXPECT_NEAR(x[static_cast<std::size_t>(i)], exact[i], 1e-13);
}

class Sparse : public testing::TestWithParam<int> {};

TEST_P(Sparse, LuSolvesWhatADenseSolverSolves) {
  std::mt19937 dice(static_cast<unsigned>(GetParam()));
  std::uniform_real_distribution<double> value(-1, 1);
  const auto pattern = random_pattern(GetParam(), 0.15, dice, false);
  SparseLu lu;
  lu.analyse(pattern);
  for (int time = 0; time < 2; ++time) {  // the pattern serves other values
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(GetParam(), GetParam());
    std::fill(lu.values().begin(), lu.values().end(), 0.0);
    for (int i = 0; i < GetParam(); ++i) {
      a(i, i) = GetParam();
      for (const int j : pattern[static_cast<std::size_t>(i)]) a(i, j) = value(dice);
      for (int j = 0; j < GetParam(); ++j)
        if (a(i, j) != 0) lu.values()[lu.place(i, j)] = a(i, j);
    }
    lu.factor();
    compare(lu, a, dice);
    const Eigen::MatrixXd b = Eigen::MatrixXd::NullaryExpr(a.rows(), 3, [&] { return value(dice); });
    std::vector<double> rows, column(b.data(), b.data() + b.rows());
    for (Eigen::Index i = 0; i < b.rows(); ++i) rows.insert(rows.end(), {b(i, 0), b(i, 1), b(i, 2)});
    lu.solve_rows<3>(rows);
    lu.solve_transposed(column);
    const Eigen::MatrixXd exact = a.fullPivLu().solve(b), transposed = a.transpose().fullPivLu().solve(b);
    for (Eigen::Index i = 0; i < b.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      for (Eigen::Index j = 0; j < 3; ++j) EXPECT_NEAR(rows[3 * k + static_cast<std::size_t>(j)], exact(i, j), 1e-13);
      EXPECT_NEAR(column[k], transposed(i, 0), 1e-13);
    }
  }
}

TEST_P(Sparse, LdlSolvesWhatADenseSolverSolves) {
  std::mt19937 dice(static_cast<unsigned>(GetParam()) + 100);
  std::uniform_real_distribution<double> value(-1, 1);
  const auto pattern = random_pattern(GetParam(), 0.1, dice, true);
  SparseLdl ldl;
  ldl.analyse(pattern);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(GetParam(), GetParam());
  std::fill(ldl.values().begin(), ldl.values().end(), 0.0);
  for (int i = 0; i < GetParam(); ++i) {
    a(i, i) = ldl.values()[ldl.place(i, i)] = GetParam();
    for (const int j : pattern[static_cast<std::size_t>(i)])
      if (j < i) a(i, j) = a(j, i) = ldl.values()[ldl.place(i, j)] = value(dice);
  }
  ASSERT_TRUE(ldl.factor());
  compare(ldl, a, dice);
}
INSTANTIATE_TEST_SUITE_P(Sizes, Sparse, testing::Values(1, 2, 7, 40));

// [1 1; 1 1 + e]: the second pivot is e of an entry of 1 + e.
TEST(Sparse, LdlSaysHowSingularAndWhere) {
  for (const double e : {1e-6, 0.0}) {
    SparseLdl ldl;
    ldl.analyse({{1}, {0}});
    ldl.values()[ldl.place(0, 0)] = ldl.values()[ldl.place(0, 1)] = 1;
    ldl.values()[ldl.place(1, 1)] = 1 + e;
    EXPECT_EQ(ldl.factor(), e > 0);
    EXPECT_NEAR(ldl.least_share(), e / (1 + e), 1e-15);
    EXPECT_EQ(ldl.least_row(), 1);
  }
}

}  // namespace
}  // namespace subsoil::mbd::sparse_test
