#pragma once
#include <array>
#include <cmath>

namespace subsoil::dem {

template <int N>
using SquareMatrix = std::array<std::array<double, N>, N>;

/// Eigenvalues of a symmetric matrix A and its eigenvectors, the columns of V: A V = V diag(values).
template <int N>
struct SymmetricEigen {
  std::array<double, N> values{};
  SquareMatrix<N> vectors{};
};

/// Cyclic Jacobi rotations (Golub & Van Loan, Matrix Computations, section 8.5) until the elements off the diagonal are
/// below rounding. A matrix that is diagonal keeps its order and its axes.
template <int N>
SymmetricEigen<N> symmetric_eigen(SquareMatrix<N> a) {
  SymmetricEigen<N> out;
  auto& v = out.vectors;
  for (int i = 0; i < N; ++i) v[i][i] = 1;
  constexpr int sweeps = 60;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double off = 0, all = 0;
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j) all += a[i][j] * a[i][j], off += i == j ? 0 : a[i][j] * a[i][j];
    if (off <= 1e-34 * all) break;
    for (int p = 0; p < N; ++p)
      for (int q = p + 1; q < N; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < N; ++k) {
          const double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y, a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < N; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
        }
        for (int k = 0; k < N; ++k) {
          const double x = v[k][p], y = v[k][q];
          v[k][p] = c * x - s * y, v[k][q] = s * x + c * y;
        }
      }
  }
  for (int i = 0; i < N; ++i) out.values[i] = a[i][i];
  return out;
}

}  // namespace subsoil::dem
