#include "libmbd/search/requests.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

/// What is found in a part of a motion between two instants.
namespace subsoil::mbd::requests_test {
namespace {

/// A part from 0 to 1 of one signal, and how often it was asked for between.
struct Watched {
  explicit Watched(std::function<double(double)> signal, double rounding = 0)
      : of(std::move(signal)), begin{of(0)}, middle{of(0.5)}, end{of(1)}, noise{rounding} {}
  MotionPart part() {
    return {0, 1, begin, middle, end, noise, [this](double t) {
              ++asked, between[0] = of(t);
              return std::span<const double>(between);
            }};
  }
  std::function<double(double)> of;
  std::array<double, 1> begin, middle, end, noise, between{};
  int asked = 0;
};

constexpr std::array<Request, 1> minimum{{{0, 1, 1e300, Request::Kind::extremum}}};
constexpr std::array<Request, 1> integral{{{0, 1, 0, Request::Kind::integral}}};

double saw(double t) { return std::abs(t - 0.4); }

TEST(Requests, LocatesAMinimumToAMillionthOfThePart) {
  Watched w(saw);
  const auto peak = find_first(minimum, w.part());
  ASSERT_TRUE(peak.has_value());
  EXPECT_NEAR(*peak, 0.4, 1e-6);
}

TEST(Requests, LooksNotIntoRounding) {
  Watched w([](double t) { return 5e-13 * saw(t); }, 1e-12);
  EXPECT_FALSE(find_first(minimum, w.part()).has_value());
  EXPECT_FALSE(needs_halving(integral, w.part(), 1e-3));
  EXPECT_EQ(w.asked, 0);
}

// Simpson's rule has a parabola's integral, and 3/4 times a quarter for that of the peak 0.1 wide at the middle.
TEST(Requests, HalvesWhatSimpsonsRuleHasNot) {
  const auto peak = [](double t) { return std::max(0.0, 1 - std::abs(t - 0.5) / 0.05); };
  EXPECT_TRUE(needs_halving(integral, Watched(peak).part(), 3e-3));
  EXPECT_FALSE(needs_halving(integral, Watched([](double t) { return 2 + t - 3 * t * t; }).part(), 1e-14));
}

// Of an integral of 1e7 so far a whole part of size 1 is less than a millionth.
TEST(Requests, HalvesNothingThatIsNothingBesideTheIntegralSoFar) {
  const auto peak = [](double t) { return std::max(0.0, 1 - std::abs(t - 0.5) / 0.05); };
  const std::array<Request, 1> large{{{0, 1, 1e7, Request::Kind::integral}}};
  EXPECT_FALSE(needs_halving(large, Watched(peak).part(), 3e-3));
}

}  // namespace
}  // namespace subsoil::mbd::requests_test
