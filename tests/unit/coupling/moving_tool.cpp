#include "tests/unit/coupling/moving_tool.hpp"

#include <gtest/gtest.h>

namespace subsoil::coupling::test::moving_tool {
namespace {

TEST(CoupledRun, HasTheSameBitsForAnyNumberOfThreads) {
  MovingTool one(1, 2);
  one.run(300);
  EXPECT_GT(one.bed->boundary(one.surface).contacts, 4) << "the tool must work";
  EXPECT_GT(dem::norm(one.simulation->soil_on_body(one.tool).force), 1);
  for (const int threads : {2, 3, 8}) {
    MovingTool many(threads, 2);
    many.run(300);
    EXPECT_EQ(many.hash(), one.hash()) << threads;
  }
}

TEST(CoupledRun, EndsTheSameAfterARestartInsideAWindow) {
  for (const auto kind : {mbd::IntegratorKind::adams_moulton, mbd::IntegratorKind::ida}) {
    MovingTool straight(1, 3, kind), first(1, 3, kind), second(1, 3, kind);
    straight.run(400);
    first.run(200);  // 200 = 66 windows and 2 steps
    second.bed->restore(first.bed->save());
    second.machine->restore(first.machine->snapshot());
    second.simulation->restore(first.simulation->save());
    EXPECT_EQ(second.simulation->time(), first.simulation->time());
    second.run(200);
    double apart = 0;
    for (std::uint32_t id = 0; id < 320; ++id)
      apart = std::max(apart, norm(dem::test::sphere(*straight.bed, id).x - dem::test::sphere(*second.bed, id).x));
    // Rounding of 1e-17 m by 200 steps and some collisions; IDA begins anew, so there its tolerance of 1e-8 counts.
    const bool ida = kind == mbd::IntegratorKind::ida;
    EXPECT_LT(apart, ida ? 1e-8 : 1e-12);
    const std::vector<double> a = straight.machine_state(), b = second.machine_state();
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], (ida ? 1e-3 : 1e-7) * (1 + std::abs(a[k]))) << k;
  }
}

TEST(CoupledRun, ARestartBeforeTheFirstStepIsTheRunItself) {
  MovingTool straight, second;
  const MovingTool first;
  second.bed->restore(first.bed->save());
  second.machine->restore(first.machine->snapshot());
  second.simulation->restore(first.simulation->save());
  straight.run(50), second.run(50);
  for (std::uint32_t id = 0; id < 320; ++id)
    EXPECT_LT(norm(dem::test::sphere(*straight.bed, id).x - dem::test::sphere(*second.bed, id).x), 1e-14);
}

TEST(CoupledRun, AStateOfAnotherMachineIsRefused) {
  MovingTool run;
  ExchangeState state = run.simulation->save();
  state.window.pop_back();
  EXPECT_THROW(run.simulation->restore(state), std::invalid_argument);
  state = run.simulation->save();
  state.servos.push_back({});
  EXPECT_THROW(run.simulation->restore(state), std::invalid_argument);
}

// The bits of a restart are those of the value, and a file has those of its fields: none may be left out.
TEST(CoupledRun, AFileKeepsAllOfASnapshot) {
  MovingTool run;
  run.run(50);
  mbd::Snapshot s = run.machine->snapshot();
  s.latched = 0.25, s.switches = {1, -1}, s.events = {{0.5, -1, 1}};
  s.elements.passed = {1}, s.elements.open = {0, 1};
  s.elements.memory.elements = {1, 2, 3};
  s.elements.memory.ruts.emplace_back().press(0, 0.01, 0.02, 0.03);
  s.elements.memory.samplers.emplace_back().start(0.5);
  Archive written;
  mbd::Snapshot(s).archive(written);
  Archive read = written.to_read();
  mbd::Snapshot back;
  back.archive(read);
  read.end();
  EXPECT_GT(s.past.rates.size(), 0u);
  EXPECT_EQ(back, s);
  EXPECT_NE(back, mbd::Snapshot{});
}

TEST(CoupledRun, IdaAndAdamsMoultonAgree) {
  MovingTool a(1, 1, mbd::IntegratorKind::adams_moulton), b(1, 1, mbd::IntegratorKind::ida);
  a.run(300), b.run(300);
  const mbd::BodyState &x = a.machine->body(a.tool), &y = b.machine->body(b.tool);
  // 3 mm of path. IDA is held to 1e-8 and 1e-10 per step; both see the same soil but for what their difference does.
  EXPECT_NEAR(x.r.x, y.r.x, 1e-8);
  EXPECT_NEAR(x.r.y, y.r.y, 1e-8);
  EXPECT_NEAR(x.angle, y.angle, 1e-8);
  EXPECT_NEAR(x.omega, y.omega, 1e-4 * (1 + std::abs(x.omega)));
  const double force = a.simulation->soil_on_body(a.tool).force.x;
  EXPECT_NEAR(force, b.simulation->soil_on_body(b.tool).force.x, 1e-3 * std::abs(force));
}

}  // namespace
}  // namespace subsoil::coupling::test::moving_tool
