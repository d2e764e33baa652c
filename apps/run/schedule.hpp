#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "apps/output/archive.hpp"

namespace subsoil::app {

/// Times at which something is due, a step early or late by no more than half a step.
class Schedule {
 public:
  Schedule() = default;
  Schedule(double every, std::vector<double> at, double from) : every_(every), at_(std::move(at)) {
    std::sort(at_.begin(), at_.end());
    while (next_at_ < at_.size() && at_[next_at_] < from) ++next_at_;
    if (every_ > 0) count_ = static_cast<long>(std::ceil(from / every_ - 1e-9));
  }
  bool due(double time, double half_step) {
    bool is = false;
    while (next_at_ < at_.size() && time >= at_[next_at_] - half_step) ++next_at_, is = true;
    while (every_ > 0 && time >= static_cast<double>(count_) * every_ - half_step) ++count_, is = true;
    return is;
  }
  void archive(Archive& a) { a(next_at_, count_); }

 private:
  double every_ = 0;
  std::vector<double> at_;
  std::size_t next_at_ = 0;
  long count_ = 0;
};

}  // namespace subsoil::app
