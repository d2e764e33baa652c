#include "libmbd/base/sparse.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace subsoil::mbd {

void SparseLu::analyse(const std::vector<std::vector<int>>& pattern) {
  const std::size_t n = pattern.size();
  begin_.assign(1, 0), diagonal_.clear(), column_.clear(), target_.clear();
  std::vector<char> marked(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    for (const int j : pattern[i]) marked[static_cast<std::size_t>(j)] = 1;
    marked[i] = 1;
    for (std::size_t k = 0; k < i; ++k)  // fill: row k of U joins every row that it is taken from
      if (marked[k])
        for (Index e = diagonal_[k] + 1; e < begin_[k + 1]; ++e) marked[column_[e]] = 1;
    for (std::size_t j = 0; j < n; ++j) {
      if (!marked[j]) continue;
      if (j == i) diagonal_.push_back(static_cast<Index>(column_.size()));
      column_.push_back(static_cast<Index>(j));
      marked[j] = 0;
    }
    begin_.push_back(static_cast<Index>(column_.size()));
  }
  for (std::size_t i = 0; i < n; ++i)
    for (Index e = begin_[i]; e < diagonal_[i]; ++e) {
      const Index k = column_[e];
      for (Index u = diagonal_[k] + 1; u < begin_[k + 1]; ++u)
        target_.push_back(static_cast<Index>(place(static_cast<int>(i), static_cast<int>(column_[u]))));
    }
  lower_.clear(), upper_.clear();
  for (std::size_t i = 0; i < n; ++i)
    for (Index e = begin_[i]; e < begin_[i + 1]; ++e)
      if (e != diagonal_[i]) (e < diagonal_[i] ? lower_ : upper_).push_back({static_cast<Index>(i), column_[e], e});
  lower_by_rows_.assign(lower_.rbegin(), lower_.rend()), upper_by_rows_ = upper_;
  std::stable_sort(lower_.begin(), lower_.end(), [](const Entry& a, const Entry& b) { return a.column < b.column; });
  std::stable_sort(upper_.begin(), upper_.end(), [](const Entry& a, const Entry& b) { return a.column > b.column; });
  values_.assign(column_.size(), 0.0);
  inverse_.assign(n, 0.0);
}

std::size_t SparseLu::place(int row, int column) const {
  const auto i = static_cast<std::size_t>(row);
  const auto first = column_.begin() + static_cast<std::ptrdiff_t>(begin_[i]);
  const auto last = column_.begin() + static_cast<std::ptrdiff_t>(begin_[i + 1]);
  return static_cast<std::size_t>(std::lower_bound(first, last, static_cast<Index>(column)) - column_.begin());
}

void SparseLu::factor() {
  double *const x = values_.data(), *const inverse = inverse_.data();
  const Index *target = target_.data(), *const begin = begin_.data(), *const diagonal = diagonal_.data();
  for (std::size_t i = 0; i < size(); ++i) {
    for (Index e = begin[i]; e < diagonal[i]; ++e) {
      const Index k = column_[e];
      const double a = x[e];
      x[e] = a * inverse[k];
      for (Index u = diagonal[k] + 1; u < begin[k + 1]; ++u) x[*target++] -= a * x[u];
    }
    inverse[i] = 1 / x[diagonal[i]];
    for (Index u = diagonal[i] + 1; u < begin[i + 1]; ++u) x[u] *= inverse[i];
  }
}

void SparseLu::solve(std::span<double> b) const {
  const double* const x = values_.data();
  for (const Entry& e : lower_) b[e.row] -= x[e.place] * b[e.column];
  for (std::size_t i = 0; i < size(); ++i) b[i] *= inverse_[i];
  for (const Entry& e : upper_) b[e.row] -= x[e.place] * b[e.column];
}

// U^T D L^T x = b.
void SparseLu::solve_transposed(std::span<double> b) const {
  const double* const x = values_.data();
  for (const Entry& e : upper_by_rows_) b[e.column] -= x[e.place] * b[e.row];
  for (std::size_t i = 0; i < size(); ++i) b[i] *= inverse_[i];
  for (const Entry& e : lower_by_rows_) b[e.column] -= x[e.place] * b[e.row];
}

namespace {

/// Rows in the order of least degree; `columns` gets, for each, its neighbours that are not eliminated yet.
/// The plain algorithm: at most some hundred rows, and only when the machine chooses its coordinates.
std::vector<int> least_degree_order(std::vector<std::vector<int>> neighbours, std::vector<std::vector<int>>& columns) {
  const std::size_t n = neighbours.size();
  std::vector<int> order;
  std::vector<char> gone(n, 0);
  columns.assign(n, {});
  for (std::size_t step = 0; step < n; ++step) {
    std::size_t best = n;
    for (std::size_t i = 0; i < n; ++i)
      if (!gone[i] && (best == n || neighbours[i].size() < neighbours[best].size())) best = i;
    gone[best] = 1;
    order.push_back(static_cast<int>(best));
    auto& clique = columns[best];
    clique = std::move(neighbours[best]);
    for (const int i : clique) {
      auto& own = neighbours[static_cast<std::size_t>(i)];
      std::vector<int> joined;
      std::set_union(own.begin(), own.end(), clique.begin(), clique.end(), std::back_inserter(joined));
      std::erase_if(joined, [&](int j) { return j == i || j == static_cast<int>(best); });
      own = std::move(joined);
    }
  }
  return order;
}

}  // namespace

void SparseLdl::analyse(const std::vector<std::vector<int>>& neighbours) {
  const std::size_t n = neighbours.size();
  std::vector<std::vector<int>> sorted = neighbours, columns;
  for (auto& list : sorted) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  order_ = least_degree_order(std::move(sorted), columns);
  position_.resize(n);
  for (std::size_t i = 0; i < n; ++i) position_[static_cast<std::size_t>(order_[i])] = static_cast<int>(i);

  begin_.assign(1, 0), row_.clear(), target_.clear();
  for (std::size_t k = 0; k < n; ++k) {
    row_.push_back(static_cast<int>(k));
    const auto first = static_cast<std::ptrdiff_t>(row_.size());
    for (const int i : columns[static_cast<std::size_t>(order_[k])])
      row_.push_back(position_[static_cast<std::size_t>(i)]);
    std::sort(row_.begin() + first, row_.end());
    begin_.push_back(row_.size());
  }
  std::size_t longest = 0;
  for (std::size_t k = 0; k < n; ++k) {
    longest = std::max(longest, begin_[k + 1] - begin_[k]);
    for (std::size_t b = begin_[k] + 1; b < begin_[k + 1]; ++b)
      for (std::size_t a = b; a < begin_[k + 1]; ++a)
        target_.push_back(place(order_[static_cast<std::size_t>(row_[a])], order_[static_cast<std::size_t>(row_[b])]));
  }
  values_.assign(row_.size(), 0.0);
  inverse_.assign(n, 0.0);
  column_.assign(longest, 0.0);
  x_.assign(n, 0.0);
}

std::size_t SparseLdl::place(int i, int j) const {
  const auto [low, high] = std::minmax(position_[static_cast<std::size_t>(i)], position_[static_cast<std::size_t>(j)]);
  const auto k = static_cast<std::size_t>(low);
  const auto first = row_.begin() + static_cast<std::ptrdiff_t>(begin_[k]);
  const auto last = row_.begin() + static_cast<std::ptrdiff_t>(begin_[k + 1]);
  return static_cast<std::size_t>(std::lower_bound(first, last, high) - row_.begin());
}

bool SparseLdl::factor() {
  double* const s = values_.data();
  const std::size_t n = size(), *target = target_.data();
  for (std::size_t k = 0; k < n; ++k) x_[k] = s[begin_[k]];
  least_share_ = 1;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t diagonal = begin_[k], first = diagonal + 1, last = begin_[k + 1];
    if (s[diagonal] < least_share_ * x_[k]) least_share_ = s[diagonal] / x_[k], least_row_ = order_[k];
    if (!(s[diagonal] > 1e-15 * x_[k])) return false;
    const double inverse = inverse_[k] = 1 / s[diagonal];
    const std::size_t count = last - first;
    for (std::size_t a = 0; a < count; ++a) column_[a] = s[first + a], s[first + a] *= inverse;
    for (std::size_t b = 0; b < count; ++b) {
      const double factor = column_[b];
      for (std::size_t a = first + b; a < last; ++a) s[*target++] -= s[a] * factor;
    }
  }
  return true;
}

void SparseLdl::solve(std::span<double> b) const {
  const double* const s = values_.data();
  const std::size_t n = size();
  for (std::size_t k = 0; k < n; ++k) x_[k] = b[static_cast<std::size_t>(order_[k])];
  for (std::size_t k = 0; k < n; ++k) {
    const double x = x_[k];
    for (std::size_t e = begin_[k] + 1; e < begin_[k + 1]; ++e) x_[static_cast<std::size_t>(row_[e])] -= s[e] * x;
  }
  for (std::size_t k = n; k-- > 0;) {
    double sum = x_[k] * inverse_[k];
    for (std::size_t e = begin_[k] + 1; e < begin_[k + 1]; ++e) sum -= s[e] * x_[static_cast<std::size_t>(row_[e])];
    x_[k] = sum;
    b[static_cast<std::size_t>(order_[k])] = sum;
  }
}

}  // namespace subsoil::mbd
