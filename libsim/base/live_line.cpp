#include "libsim/base/live_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace subsoil::sim {

LiveLine::LiveLine() : terminal_(isatty(fileno(stdout)) != 0) {}

bool LiveLine::due() const {
  return std::chrono::duration<double>(Clock::now() - shown_).count() > (terminal_ ? 0.5 : 10.0);
}

void LiveLine::show(const std::string& text) {
  shown_ = Clock::now();
  if (terminal_) {
    fmt::print("\r{:<{}}", text, width_);
    width_ = text.size();
  } else {
    fmt::print("{}\n", text);
  }
  std::fflush(stdout);
}

void LiveLine::close() {
  if (terminal_ && width_ > 0) fmt::print("\n");
  width_ = 0;
  std::fflush(stdout);
}

double LiveLine::elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

double RecentRate::remaining(double wall, double simulated, double end) {
  past_.emplace_back(wall, simulated);
  while (past_.size() > 2 && past_[1].first < wall - 30) past_.pop_front();
  const auto [then, was] = past_.size() > 1 ? past_.front() : std::pair{0.0, 0.0};
  return (end - simulated) * (wall - then) / (simulated - was);
}

std::string clock_text(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const long s = std::lround(seconds);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace subsoil::sim
