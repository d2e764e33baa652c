#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "libdem/base/archive.hpp"

namespace subsoil::sim {

/// Times at which something is due: multiples of an interval, and listed ones, from `from` to `until`.
class Schedule {
 public:
  static constexpr double never = std::numeric_limits<double>::infinity();

  Schedule() = default;
  Schedule(double every, std::vector<double> at, double from, double until = never)
      : every_(every), until_(until), at_(std::move(at)) {
    std::sort(at_.begin(), at_.end());
    while (next_at_ < at_.size() && at_[next_at_] < from) ++next_at_;
    if (every_ > 0) count_ = static_cast<long>(std::ceil(from / every_ - 1e-9));
    // 0.3 and not 3 * 0.1, whose last digit is another.
    if (every_ > 0 && std::abs(1 / every_ - std::round(1 / every_)) < 1e-9) rate_ = std::round(1 / every_);
  }
  /// When something is due next; `never` at the end. A listed time is reported before a multiple that is the same.
  double next() const {
    const double listed = next_at_ < at_.size() ? at_[next_at_] : never, multiple = next_multiple();
    const double due = listed <= multiple + 1e-12 * std::abs(multiple) ? listed : multiple;
    return due > until_ ? never : due;
  }
  /// Whether something was due at `time` or before, or will be within `early`; what was is done with.
  bool due(double time, double early) {
    bool is = false;
    while (next_at_ < at_.size() && time >= at_[next_at_] - early) ++next_at_, is = true;
    while (every_ > 0 && time >= next_multiple() - early) ++count_, is = true;
    return is;
  }
  void archive(Archive& a) { a("next at", next_at_)("count", count_); }

 private:
  double next_multiple() const {
    if (!(every_ > 0)) return never;
    const auto count = static_cast<double>(count_);
    return rate_ > 0 ? count / rate_ : count * every_;
  }

  double every_ = 0, rate_ = 0, until_ = never;
  std::vector<double> at_;
  std::size_t next_at_ = 0;
  long count_ = 0;
};

}  // namespace subsoil::sim
