#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace subsoil::mbd {

// Two direct solvers for matrices whose pattern stays while their values change at every step: the pattern is worked
// out once, with its fill, and the elimination then runs along flat lists of places. A general sparse library looks
// its places up at each factorisation, which at 17 rows costs several times the arithmetic; a dense one is cubic.

/// A x = b with pivots on the diagonal, in the order given: A = L D U, unit L and U, row by row.
/// Whoever sets the pattern has ordered rows and columns so that the diagonal can carry the pivots; pivot() states how
/// well it still does.
/// Solving runs along one list of entries without loops over rows, which hold one to four entries and cost more than
/// their arithmetic; by columns, so that only the depth of the elimination waits for one another.
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
  /// A^T x = b.
  void solve_transposed(std::span<double> b) const;
  /// The same A for `count` right sides, which stand row by row.
  template <std::size_t count>
  void solve_rows(std::span<double> b) const;
  std::size_t size() const { return diagonal_.size(); }
  /// Diagonal of D after factor().
  double pivot(std::size_t i) const { return values_[diagonal_[i]]; }

 private:
  using Index = std::uint32_t;
  struct Entry {  // of L or U, off the diagonal
    Index row, column, place;
  };
  std::vector<Index> begin_, diagonal_;  // first entry of a row and its diagonal; L left of it, U right
  std::vector<Index> column_;
  std::vector<Index> target_;         // where each product of the elimination goes, in the order of factor()
  std::vector<Entry> lower_, upper_;  // by columns, of U from the last
  std::vector<Entry> lower_by_rows_, upper_by_rows_;  // of L from the last
  std::vector<double> values_, inverse_;
};

template <std::size_t count>
void SparseLu::solve_rows(std::span<double> b) const {
  // Of a fixed length: the compiler leaves loops of four as loops.
  const auto row = [&](std::size_t i) {
    return Eigen::Map<Eigen::Array<double, static_cast<int>(count), 1>>(b.data() + i * count);
  };
  for (const Entry& e : lower_) row(e.row) -= values_[e.place] * row(e.column);
  for (std::size_t i = 0; i < size(); ++i) row(i) *= inverse_[i];
  for (const Entry& e : upper_) row(e.row) -= values_[e.place] * row(e.column);
}

/// S x = b, S symmetric positive definite: P S P^T = L D L^T, P by minimum degree, column by column.
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
  /// Minimum pivot as a share of its own diagonal entry, up to where factor() came, and its row.
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
