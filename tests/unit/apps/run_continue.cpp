#include <fmt/format.h>
#include <gtest/gtest.h>

#include "apps/output/state_file.hpp"
#include "apps/run/continuation.hpp"
#include "apps/run/restart.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/unit/apps/trench.hpp"

/// A restart looks at what it continues.
namespace subsoil::app::run_continue {
namespace {

using namespace test;

class RunContinue : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_scenario(dir_.scenario(trench), dir_ / "first", {"time.end=20 ms"}), exit_ok);
    state_ = latest_state(dir_ / "first").value();
  }
  /// What is said against it; "" when it runs.
  std::string refusal(std::vector<std::string> sets, const std::vector<std::string>& changes = {}) {
    if (sets.empty() || sets.back().rfind("time.end", 0) != 0) sets.push_back("time.end=22 ms");
    std::filesystem::remove_all(dir_ / "on");
    try {
      EXPECT_EQ(run({.scenario = dir_.scenario(trench),
                     .out = dir_ / "on",
                     .sets = sets,
                     .threads = 1,
                     .changes = changes,
                     .from = state_}),
                exit_ok);
      return "";
    } catch (const ScenarioError& error) {
      return error.what();
    }
  }
  RunDirectory dir_;
  std::filesystem::path state_;
};

TEST_F(RunContinue, TheSameScenarioAndHarmlessDifferencesPass) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({"limits.speed=40 m/s", "output.every=5 ms", "title=other", "time.threads=1"}), "");
}

TEST_F(RunContinue, PhysicsChangesOnlyWhereItIsSaid) {
  const std::string mu = "contacts.soil-steel.mu=0.1";
  const std::string said = refusal({mu});
  EXPECT_NE(said.find("contacts.soil-steel.mu = 0.5, now 0.1"), std::string::npos) << said;
  EXPECT_NE(said.find("say --change contacts.soil-steel.mu"), std::string::npos) << said;
  EXPECT_EQ(refusal({mu}, {"contacts.soil-steel.mu"}), "");
  EXPECT_EQ(refusal({mu}, {"contacts"}), "") << "a section names all below it";
  EXPECT_NE(refusal({mu, "gravity=5 m/s^2"}, {"contacts"}).find("gravity"), std::string::npos);
  EXPECT_NE(refusal({}, {"gravity"}).find("--change gravity: does not differ"), std::string::npos);
}

TEST_F(RunContinue, WhatTheStateHoldsCannotChange) {
  for (const char* set :
       {"soil.bed.radius=9 mm", "soil.container.size=0.5 0.1 0.08 m", "materials.soil.density=2000 kg/m^3"}) {
    const std::string key = std::string(set).substr(0, std::string(set).find('='));
    EXPECT_NE(refusal({set}, {key}).find("the state holds what was made of it"), std::string::npos) << set;
  }
}

TEST_F(RunContinue, AToolThatWouldJumpIsRefused) {
  // At 20 ms a tool at 0.8 m/s stands 8 mm farther than one at 0.4 m/s.
  const std::string said = refusal({"boundaries.tool.moves[0].velocity=0.8 0 0 m/s"}, {"boundaries"});
  EXPECT_NE(said.find("tool would jump by 0.008"), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(dir_ / "on"));
}

TEST_F(RunContinue, AnEndBeforeTheStateIsRefused) {
  const double time = read_run(state_).time;
  EXPECT_NEAR(time, 0.02, 1e-4) << "the step nearest to the end";
  const std::string said = refusal({"time.end=10 ms"});
  EXPECT_NE(said.find(fmt::format("time.end = 0.01 s: the state is of {:.6g} s; give a later end", time)),
            std::string::npos)
      << said;
}

}  // namespace
}  // namespace subsoil::app::run_continue
