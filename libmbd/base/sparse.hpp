#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace subsoil::mbd {

// Two direct solvers for matrices whose pattern stays while their values change at every step: the pattern is worked
// out once, with its fill, and the elimination then runs along flat lists of places. A general sparse library looks
// its places up at each factorisation, which at 17 rows costs several times the arithmetic; a dense one is cubic.

/// A x = b with pivots on the diagonal, in the order given: A = L U, unit L, row by row.
/// Whoever sets the pattern has ordered rows and columns so that the diagonal can carry the pivots; pivot() says how
/// well it still does.
class SparseLu {
 public:
  /// Columns of the nonzeros of each row. Throws nothing; a row may lack its diagonal, which then is fill.
  void analyse(const std::vector<std::vector<int>>& pattern);
  /// Place of the nonzero (row, column) for set().
  std::size_t place(int row, int column) const;
  /// All values; places of fill must be 0.
  std::vector<double>& values() { return values_; }

  void factor();
  /// b becomes x.
  void solve(std::span<double> b) const;
  std::size_t size() const { return diagonal_.size(); }
  /// Diagonal of U after factor().
  double pivot(std::size_t i) const { return values_[diagonal_[i]]; }

 private:
  std::vector<std::size_t> begin_, diagonal_;  // first entry of a row and its diagonal; L left of it, U right
  std::vector<int> column_;
  std::vector<std::size_t> target_;  // where each product of the elimination goes, in the order of factor()
  std::vector<double> values_, inverse_;
};

/// S x = b, S symmetric positive definite: P S P^T = L D L^T, P by least degree, column by column.
class SparseLdl {
 public:
  /// Neighbours of each row: the places of the nonzeros of the full pattern, diagonal left out.
  void analyse(const std::vector<std::vector<int>>& neighbours);
  /// Place of the nonzero (i, j) = (j, i).
  std::size_t place(int i, int j) const;
  std::vector<double>& values() { return values_; }

  /// Returns false when a pivot is not above rounding of its own diagonal entry: S is singular.
  bool factor();
  void solve(std::span<double> b) const;
  std::size_t size() const { return order_.size(); }
  /// Least pivot as a share of its own diagonal entry, up to where factor() came, and its row.
  double least_share() const { return least_share_; }
  int least_row() const { return least_row_; }

 private:
  std::vector<int> order_, position_;  // row at each position of the elimination, and back
  std::vector<std::size_t> begin_;     // first entry of a column: its diagonal, then below it
  std::vector<int> row_;               // position of each entry
  std::vector<std::size_t> target_;
  std::vector<double> values_, inverse_, column_;
  mutable std::vector<double> x_;
  double least_share_ = 1;
  int least_row_ = 0;
};

}  // namespace subsoil::mbd
