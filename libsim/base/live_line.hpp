#pragma once
#include <chrono>
#include <deque>
#include <string>
#include <utility>

namespace subsoil::sim {

/// What a waiting user sees: on a terminal one line that renews itself twice a second, else a plain line every ten.
class LiveLine {
 public:
  LiveLine();
  /// True when it is time to print something.
  bool due() const;
  void show(const std::string& text);
  /// Ends the line on a terminal.
  void close();
  double elapsed() const;  ///< s since the start

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  Clock::time_point start_ = Clock::now(), shown_ = start_;
  std::size_t width_ = 0;
};

/// "1:02:03"
/// How long a run will still take, from its rate over the last half minute: contacts grow and steps with them.
class RecentRate {
 public:
  /// `wall` and `simulated` s so far.
  double remaining(double wall, double simulated, double end);

 private:
  std::deque<std::pair<double, double>> past_;
};

std::string clock_text(double seconds);

}  // namespace subsoil::sim
