#pragma once
#include <chrono>
#include <filesystem>

namespace subsoil::app {

/// States that a run writes by the clock on the wall, to go on from after a kill. The two last ones stay: the one
/// before in case that the disk damages the last. A run that reaches its end takes them away.
class Checkpoints {
 public:
  explicit Checkpoints(std::filesystem::path folder) : folder_(std::move(folder)) {}
  bool due() const;  ///< the interval has passed since the last one
  /// Path of the next one, of this simulated time (s).
  std::filesystem::path next(double time) const;
  /// To be called when it is written: takes away all but the two last.
  void keep_two();
  void remove() const;  ///< all of the folder, half written ones too

 private:
  using Clock = std::chrono::steady_clock;  // a clock on the wall may be set back
  std::filesystem::path folder_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace subsoil::app
