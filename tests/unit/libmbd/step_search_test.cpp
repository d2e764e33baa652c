// Roots, extrema and integrals of signals over the steps of a machine, against the parabola of a thrown body.

#include "libmbd/search/step_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libmbd/machine.hpp"

namespace subsoil::mbd::step_search_test {
namespace {

using Requests = std::vector<Request>;
constexpr double g = 9.81, up = 1;

/// Height of the body and its excess over `level`, cut off at 0; ends of parts are noted.
struct Height : StepSignals {
  explicit Height(Requests wanted) : requests(std::move(wanted)) {}
  void sample(double, const Instant& at, std::vector<double>& row) override {
    row[0] = at.body(1).r.y;
    row[1] = std::max(0.0, row[0] - level);
  }
  void rounding(const Instant&, std::span<const double>, std::vector<double>& out) override { out.assign(2, 1e-14); }
  void request(double, Requests& out) override { out = requests; }
  bool take_jump(double, std::vector<double>&) override { return false; }
  bool take_part(const StepPart& part) override {
    ends.push_back(part.until);
    integral += (part.until - part.from) / 6 * (part.begin[1] + 4 * part.middle[1] + part.end[1]);
    return part.until >= stop;
  }
  static constexpr double level = 0.04;
  Requests requests;
  std::vector<double> ends;
  double integral = 0, stop = 1;
};

/// Thrown upwards with `up`, in one step of 0.2 s.
struct Thrown {
  Thrown() : machine(model(), {.integrator = IntegratorKind::cvode}) {
    machine.start_from_pose();
    machine.keep_dense_output();
    machine.advance(0.2);
  }
  static Model model() {
    Model m;
    m.add({.name = "ball", .mass = 1, .inertia = 0.1, .velocity = {0, up, 0}});
    return m;
  }
  bool search(Height& height) {
    Evaluation evaluation = machine.evaluation();
    std::vector<double> row{0, 0};
    return StepSearch(height, evaluation).search(machine.dense_output(), 0, 0.2, 1, row);
  }
  Machine machine;
};

double nearest(const std::vector<double>& ends, double t) {
  double best = 1e9;
  for (const double e : ends) best = std::abs(e - t) < std::abs(best - t) ? e : best;
  return best;
}

// A part ends where the body is at its highest, up/g, to 1e-6 of the part; without the request none does.
TEST(StepSearch, EndsAPartAtAnExtremum) {
  Height found(Requests{{0, -1, -1e300, Request::Kind::extremum}}), none(Requests{});
  Thrown thrown;
  EXPECT_FALSE(thrown.search(found));
  EXPECT_NEAR(nearest(found.ends, up / g), up / g, 2e-7);
  EXPECT_DOUBLE_EQ(found.ends.back(), 0.2);
  thrown.search(none);
  EXPECT_GT(std::abs(nearest(none.ends, up / g) - up / g), 1e-4);
}

// level = up t - g t^2/2 on the way up and on the way down; the method errs by some 1e-10 m at 0.5 m/s.
TEST(StepSearch, EndsPartsAtBothRoots) {
  const double root = std::sqrt(up * up - 2 * g * Height::level);
  for (const double sign : {-1.0, 1.0}) {
    Height height(Requests{{0, sign, Height::level, Request::Kind::root}});
    Thrown().search(height);
    const double t = (up + sign * root) / g;
    EXPECT_NEAR(nearest(height.ends, t), t, 1e-8) << sign;
  }
}

// The excess over the level has kinks at both roots: its integral is that of the parabola between them,
// g (t_2 - t_1)^3/12, to the 3e-3 of the sizes that halving allows at each kink.
TEST(StepSearch, HalvesPartsForAnIntegral) {
  const double length = 2 * std::sqrt(up * up - 2 * g * Height::level) / g;
  Height halved(Requests{{1, 1, 0, Request::Kind::integral}}), whole(Requests{});
  Thrown thrown;
  thrown.search(halved), thrown.search(whole);
  const double exact = g * length * length * length / 12;
  EXPECT_NEAR(halved.integral, exact, 6e-3 * exact);
  EXPECT_GT(halved.ends.size(), whole.ends.size());
}

TEST(StepSearch, EndsWithThePartThatEndsIt) {
  Height height(Requests{{0, -1, -1e300, Request::Kind::extremum}});
  height.stop = 0.1;
  EXPECT_TRUE(Thrown().search(height));
  EXPECT_NEAR(height.ends.back(), up / g, 2e-7);
}

}  // namespace
}  // namespace subsoil::mbd::step_search_test
