#include "libmbd/integrators/stiffness_monitor.hpp"

#include <gtest/gtest.h>

namespace subsoil::mbd {
namespace {

constexpr long unknowns = 2, window = 2000, trial = 300;

void steps(StiffnessMonitor& monitor, long count, double advance) {
  for (long i = 0; i < count; ++i) monitor.count(advance, 2, unknowns);
}

/// A window of steps of length h with a fastest decay of 1/s.
void window_of(StiffnessMonitor& monitor, double h, long factor = 1) {
  steps(monitor, factor * window - 1, h);
  EXPECT_FALSE(monitor.asks_for_spectrum());
  steps(monitor, 1, h);
  ASSERT_TRUE(monitor.asks_for_spectrum());
  monitor.see({.decay = 1, .radius = 1});
}

TEST(StiffnessMonitor, StepsFarBelowTheLimitOfStabilityStayExplicit) {
  StiffnessMonitor monitor;
  for (int i = 0; i < 5; ++i) window_of(monitor, 1e-3);
  EXPECT_FALSE(monitor.wants_change());
  EXPECT_FALSE(monitor.implicit());
}

TEST(StiffnessMonitor, AnImplicitTrialThatAdvancesFartherStays) {
  StiffnessMonitor monitor;
  window_of(monitor, 0.1);
  EXPECT_TRUE(monitor.wants_change() && monitor.implicit());
  monitor.begun();
  steps(monitor, trial, 10);
  EXPECT_FALSE(monitor.wants_change());
  window_of(monitor, 10);
  EXPECT_FALSE(monitor.wants_change());
  EXPECT_TRUE(monitor.implicit());
  // Steps that the explicit method bears, and a trial of it that is not worth it: backward differences continue.
  window_of(monitor, 0.1);
  EXPECT_TRUE(monitor.wants_change() && !monitor.implicit());
  monitor.begun();
  steps(monitor, trial, 0.15);
  EXPECT_TRUE(monitor.wants_change() && monitor.implicit());
  monitor.begun();
  window_of(monitor, 0.1, 2);
  steps(monitor, trial, 0.25);
  EXPECT_FALSE(monitor.implicit());
}

// The first half of a trial is of low order and does not count; what is not twice as good is given up, and the windows
// double.
TEST(StiffnessMonitor, ATrialInVainReturnsAndIsRarerFromThenOn) {
  StiffnessMonitor monitor;
  window_of(monitor, 0.1);
  monitor.begun();
  steps(monitor, trial / 2, 100);
  steps(monitor, trial / 2, 0.19);
  EXPECT_TRUE(monitor.wants_change() && !monitor.implicit());
  monitor.begun();
  window_of(monitor, 0.1, 2);
  EXPECT_TRUE(monitor.wants_change() && monitor.implicit());
}

// Eigenvalues of n unknowns cost n^3: the window grows with their share of the work.
TEST(StiffnessMonitor, AWindowOfManyUnknownsIsLonger) {
  StiffnessMonitor monitor;
  for (int i = 0; i < 2 * 100 * 100 - 1; ++i) monitor.count(1, 2, 100);
  EXPECT_FALSE(monitor.asks_for_spectrum());
  monitor.count(1, 2, 100);
  EXPECT_TRUE(monitor.asks_for_spectrum());
}

}  // namespace
}  // namespace subsoil::mbd
