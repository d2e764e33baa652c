#pragma once
#include <chrono>
#include <filesystem>

namespace subsoil::sim {

/// Time on the wall since the last checkpoint.
class CheckpointClock {
 public:
  bool due() const;  ///< the interval has passed
  void restart() { last_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;  // a clock on the wall may be set back
  Clock::time_point last_ = Clock::now();
};

/// States that a run writes by wall time, to restart from after a kill. The two last ones stay: the one
/// before in case that the disk damages the last. A run that reaches its end takes them away.
class Checkpoints {
 public:
  explicit Checkpoints(std::filesystem::path folder) : folder_(std::move(folder)) {}
  bool due() const { return clock_.due(); }
  /// Path of the next one, of this simulated time (s).
  std::filesystem::path next(double time) const;
  /// To be called when it is written: takes away all but the two last, and that of the settling.
  void keep_two();
  void remove() const;  ///< all of the folder, half written ones too

 private:
  std::filesystem::path folder_;
  CheckpointClock clock_;
};

}  // namespace subsoil::sim
