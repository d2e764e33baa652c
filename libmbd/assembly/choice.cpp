#include "libmbd/assembly/choice.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "libmbd/assembly/assembly.hpp"

namespace subsoil::mbd {

namespace {

constexpr double pivot_share = 0.2;
// Of the largest weight in a dependency: less is rounding.
constexpr double least_weight = 1e-6;
// An equation that keeps less of itself is weak: beside a singular configuration it is about the angle to it.
constexpr double weak = 0.3;
// So much stronger is the weakest equation of another order, for that order to be taken.
constexpr double stronger = 2;
constexpr int most_orders = 4;

/// Number of joints between each body and the ground (or the first body of a part that hangs on nothing).
std::vector<int> distances(const System& system) {
  const auto bodies = static_cast<std::size_t>(system.bodies());
  std::vector<std::vector<int>> neighbours(bodies);
  for (int row = 0; row < system.equations(); ++row) {
    const auto first = system.first_block(row), last = system.first_block(row + 1);
    if (last - first == 1) {  // against the ground
      neighbours[ground].push_back(system.blocks()[first].body);
      continue;
    }
    for (auto i = first; i < last; ++i)
      for (auto j = first; j < last; ++j)
        if (i != j) neighbours[static_cast<std::size_t>(system.blocks()[i].body)].push_back(system.blocks()[j].body);
  }
  std::vector<int> distance(bodies, -1), queue;
  for (std::size_t root = 0; root < bodies; ++root) {
    if (distance[root] >= 0) continue;
    distance[root] = 0;
    queue.assign(1, static_cast<int>(root));
    for (std::size_t next = 0; next < queue.size(); ++next)
      for (const int body : neighbours[static_cast<std::size_t>(queue[next])]) {
        auto& own = distance[static_cast<std::size_t>(body)];
        if (own >= 0) continue;
        own = distance[static_cast<std::size_t>(queue[next])] + 1;
        queue.push_back(body);
      }
  }
  return distance;
}

struct Entry {
  int column;
  double value;
};

/// So much of an eliminated row, by its place.
struct Share {
  std::size_t of;
  double factor;
};

/// Elimination with one dense work row; rows of L and U are kept sparse.
class Elimination {
 public:
  /// @param last equations that come behind all others
  Elimination(const System& system, const SparseConstraints& c, const std::vector<int>& last)
      : system_(system),
        c_(c),
        distance_(distances(system)),
        rows_(row_scale(system)),
        columns_(coordinate_scale(system)),
        work_(static_cast<std::size_t>(system.coordinates()), 0.0),
        pivoted_(work_.size(), 0) {
    std::vector<int> order(static_cast<std::size_t>(system_.equations()));
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](int row) {
      return std::pair(std::find(last.begin(), last.end(), row) != last.end(), farthest(row));
    };
    std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return place(i) < place(j); });
    for (const int row : order) eliminate(row);
    std::sort(choice_.redundant.begin(), choice_.redundant.end());
    for (int i = 0; i < system_.coordinates(); ++i)
      if (!pivoted_[static_cast<std::size_t>(i)]) choice_.independent.push_back(i);
  }

  Choice& choice() { return choice_; }
  /// Equations that keep little of themselves behind those before them, and the minimum share that one keeps.
  const std::vector<int>& weak_rows() const { return weak_; }
  double least_share() const { return least_share_; }

 private:
  int distance_of(int column) const { return distance_[static_cast<std::size_t>(column / 3 + 1)]; }
  int farthest(int row) const {
    int most = 0;
    for (auto i = system_.first_block(row); i < system_.first_block(row + 1); ++i)
      most = std::max(most, distance_[static_cast<std::size_t>(system_.blocks()[i].body)]);
    return most;
  }

  void eliminate(int row) {
    double size = 0;
    for (auto i = system_.first_block(row); i < system_.first_block(row + 1); ++i)
      for (int k = 0; k < 3; ++k) {
        const int column = 3 * (system_.blocks()[i].body - 1) + k;
        const double value = rows_[row] * c_.jacobian[i][static_cast<std::size_t>(k)] / columns_[column];
        work_[static_cast<std::size_t>(column)] = value;
        size = std::max(size, std::abs(value));
      }
    std::vector<Share> lower;
    for (std::size_t k = 0; k < upper_.size(); ++k) {
      double& entry = work_[static_cast<std::size_t>(choice_.dependent[k])];
      if (entry == 0) continue;
      const double factor = entry / upper_[k].front().value;
      for (const Entry& e : upper_[k]) work_[static_cast<std::size_t>(e.column)] -= factor * e.value;
      entry = 0;
      lower.push_back({k, factor});
    }
    take(row, size, std::move(lower));
  }

  /// Pivots on what is left in the work row, and clears it.
  void take(int row, double size, std::vector<Share> lower) {
    std::vector<Entry> left;
    double most = 0;
    for (std::size_t i = 0; i < work_.size(); ++i) {
      if (work_[i] == 0) continue;
      if (!pivoted_[i]) left.push_back({static_cast<int>(i), work_[i]}), most = std::max(most, std::abs(work_[i]));
      work_[i] = 0;
    }
    if (!(most > rank_share * size)) {
      choice_.redundant.push_back(row);
      if (size > 0) list_dependency(row, lower);
      return;
    }
    if (most < weak * size) weak_.push_back(row);
    least_share_ = std::min(least_share_, most / size);
    const auto better = [&](const Entry& x, const Entry& y) {
      const bool x_turns = x.column % 3 == 2, y_turns = y.column % 3 == 2;
      if (x_turns != y_turns) return y_turns;
      const int dx = distance_of(x.column), dy = distance_of(y.column);
      if (dx != dy) return dx > dy;
      return std::abs(x.value) > std::abs(y.value);
    };
    auto pivot = left.end();
    for (auto i = left.begin(); i != left.end(); ++i)
      if (std::abs(i->value) >= pivot_share * most && (pivot == left.end() || better(*i, *pivot))) pivot = i;
    std::iter_swap(left.begin(), pivot);
    pivoted_[static_cast<std::size_t>(left.front().column)] = 1;
    choice_.rows.push_back(row);
    choice_.dependent.push_back(left.front().column);
    upper_.push_back(std::move(left));
    lower_.push_back(std::move(lower));
  }

  /// L^T w = l: the redundant row is l^T U, and the independent ones are L U.
  void list_dependency(int row, const std::vector<Share>& l) {
    std::vector<double> w(lower_.size(), 0.0);
    for (const Share& s : l) w[s.of] = s.factor;
    double most = 1;  // its own
    for (std::size_t k = w.size(); k-- > 0;) {
      for (const Share& s : lower_[k]) w[s.of] -= s.factor * w[k];
      most = std::max(most, std::abs(w[k]));
    }
    Dependency dependency{row, {}};
    for (std::size_t k = 0; k < w.size(); ++k)
      if (std::abs(w[k]) > least_weight * most) dependency.on.push_back(choice_.rows[k]);
    choice_.dependencies.push_back(std::move(dependency));
  }

  const System& system_;
  const SparseConstraints& c_;
  std::vector<int> distance_;
  Eigen::VectorXd rows_, columns_;
  std::vector<double> work_;
  std::vector<char> pivoted_;
  std::vector<std::vector<Entry>> upper_;
  std::vector<std::vector<Share>> lower_;
  std::vector<int> weak_;
  double least_share_ = 1;
  Choice choice_;
};

}  // namespace

Choice choose_coordinates(const System& system, const SparseConstraints& c) {
  std::vector<int> last;
  std::optional<Elimination> best(std::in_place, system, c, last);
  for (int orders = 1; orders < most_orders && !best->choice().dependencies.empty(); ++orders) {
    if (best->weak_rows().empty()) break;
    last.insert(last.end(), best->weak_rows().begin(), best->weak_rows().end());
    Elimination other(system, c, last);
    if (!(other.least_share() > stronger * best->least_share())) break;
    best.emplace(std::move(other));
  }
  return std::move(best->choice());
}

}  // namespace subsoil::mbd
