#pragma once
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>

namespace subsoil::dem {

/// Time that a thread takes for its part of a step: the median of the last ones, for now and then the system takes the
/// core away.
class WorkerTimer {
 public:
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  void add(double seconds) { taken_[count_++ % kKept] = seconds; }
  void begin() { count_ = 0; }
  double median() {
    const auto middle = taken_.begin() + std::min(count_, kKept) / 2;
    std::nth_element(taken_.begin(), middle, taken_.begin() + std::min(count_, kKept));
    return count_ > 0 ? *middle : 0;
  }

 private:
  static constexpr std::ptrdiff_t kKept = 64;
  std::array<double, kKept> taken_{};
  std::ptrdiff_t count_ = 0;
};

}  // namespace subsoil::dem
