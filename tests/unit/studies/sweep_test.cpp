#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <set>
#include <thread>

#include "libsim/io/csv.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/post/run_folder.hpp"
#include "libsim/run/output_folder.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/sweep/effects.hpp"
#include "libsim/studies/sweep/slurm.hpp"
#include "libsim/studies/sweep/tables.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// `subsoil sweep`: the points of a plan, what is refused before anything runs, a sweep that is killed and goes on, and
/// effects of numbers that are known.
namespace subsoil::sim::sweep_test {
namespace {

using test::message_of;
using test::Scratch;

/// A mass on a spring, a tenth of a second of wall time. `slack` tells the scenario not to assemble itself: with the
/// mass off its rail such a run fails.
constexpr const char* oscillator = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {mass: {mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m}}
  joints: {rail: {translational: [ground, mass], points: [0 0 m, 0 0 m], along: 0 1}}
  forces: {spring: {spring-damper: [ground, mass], ends: [0 1 m, 0 0 m], stiffness: 400 N/m, free length: 1 m, damping: 0 N s/m}}
time: {end: 2 s}
output: {every: 1 s, series every: 2 ms, monitor: {height: mass.y}}
)";

constexpr const char* plan_text = R"(subsoil: 1
title: sag of a mass on a spring
scenario: mass.yaml
parameters:
  mass: {keys: machine.bodies.mass.mass, values: [1 kg, 2 kg, 4 kg]}
  stiffness: {keys: machine.forces.spring.stiffness, factors: [1, 2]}
numbers:
  sag: {column: height, take: least}
  wall: {summary: "run/wall time [s]"}
best: largest sag
)";

struct SweepFolder : Scratch {
  SweepFolder() { test::write_file(*this / "mass.yaml", oscillator); }
  std::string plan(const std::string& text) const {
    test::write_file(*this / "plan.yaml", text);
    return (*this / "plan.yaml").string();
  }
  std::string refusal(const std::string& text) const {
    const std::string file = plan(text);
    return message_of([&] { sweep_points(file, load_sweep(file)); });
  }
};

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(SweepPlan, EveryCombinationRunsOnce) {
  const SweepFolder folder;
  const std::string file = folder.plan(plan_text);
  const std::vector<SweepPoint> points = sweep_points(file, load_sweep(file));
  ASSERT_EQ(points.size(), 6U);
  std::set<std::vector<std::string>> seen;
  for (const SweepPoint& p : points) seen.insert(p.values);
  EXPECT_EQ(seen.size(), 6U);
  // A factor multiplies what the scenario has, and the scenario takes it.
  const Scenario s = load_scenario((folder / "mass.yaml").string(), points.back().sets).scenario;
  EXPECT_EQ(s.machine->bodies[0].mass, 4);
  EXPECT_NE(points.back().sets.back().find("=800"), std::string::npos) << points.back().sets.back();
}

TEST(SweepPlan, RefusesWithPlaceAndCureBeforeAnythingRuns) {
  const SweepFolder folder;
  const auto refuses = [&](const std::string& from, const std::string& to, const std::string& words) {
    const std::string message = folder.refusal(changed(plan_text, from, to));
    EXPECT_NE(message.find(words), std::string::npos) << message;
    EXPECT_NE(message.find("plan.yaml"), std::string::npos) << message;
  };
  refuses("machine.bodies.mass.mass", "machine.bodies.mass.mess", "did you mean `mass`");
  refuses("4 kg", "-4 kg", "mass = -4 kg");
  refuses("values: [1 kg, 2 kg, 4 kg]", "vallues: [1 kg]", "did you mean `values`");
  refuses("values: [1 kg, 2 kg, 4 kg]", "between: 4 1", "the least first");
  refuses("values: [1 kg, 2 kg, 4 kg]", "", "needs one of `values`, `factors`, `between` and `seeds`");
  refuses("column: height, ", "", "needs one of `column`");
  refuses("column: height, ", "column: height, from: 100 s, ", "100 s is not before the end of the runs");
  refuses("largest sag", "largest sack", "did you mean `sag`");
  refuses("largest sag", "most sag", "must be `least NUMBER` or `largest NUMBER`");
  refuses("machine.forces.spring.stiffness", "machine.forces.spring", "no single value");
  // Its own numbers are left out: `height` of the scenario's monitors, and no other.
  const auto without_numbers = [&](const std::string& best) {
    std::string text = changed(plan_text, "largest sag", best);
    const std::size_t from = text.find("numbers:"), until = text.find("best:");
    return text.erase(from, until - from);
  };
  EXPECT_EQ(folder.refusal(without_numbers("largest height")), "accepted");
  EXPECT_NE(folder.refusal(without_numbers("largest sag")).find("`sag` is no number of this plan"), std::string::npos);
  const std::string message = folder.refusal(std::string(plan_text) + "points: 0\n");
  EXPECT_NE(message.find("plan.yaml:11:9"), std::string::npos) << message;
}

TEST(SweepPlan, ConfigsHavePointsThatTheirScenariosTake) {
  int plans = 0;
  for (const auto& entry : std::filesystem::directory_iterator(subsoil::test::source_dir() + "/configs/sweep")) {
    EXPECT_GE(sweep_points(entry.path(), load_sweep(entry.path())).size(), 3U) << entry.path();  // a trend
    ++plans;
  }
  EXPECT_GE(plans, 3);
}

TEST(SweepPlan, RangesAreFilledByALatinHypercube) {
  const auto u = latin_hypercube(10, 3, 7);
  for (std::size_t d = 0; d < 3; ++d) {
    std::set<int> strata;
    for (const auto& point : u) strata.insert(static_cast<int>(10 * point[d]));
    EXPECT_EQ(strata.size(), 10U) << "each tenth of dimension " << d << " holds one point";
  }
  EXPECT_EQ(u, latin_hypercube(10, 3, 7));
  EXPECT_NE(u, latin_hypercube(10, 3, 8));
  const SweepFolder folder;
  const std::string file =
      folder.plan(changed(plan_text, "values: [1 kg, 2 kg, 4 kg]", "between: 1 100, unit: kg, scale: log"));
  SweepPlan plan = load_sweep(file);
  plan.points = 4;
  const std::vector<SweepPoint> points = sweep_points(file, plan);
  EXPECT_EQ(points.size(), 8U);
  int below_ten = 0;
  for (const SweepPoint& p : points) below_ten += p.places[0] < 10 ? 1 : 0;
  EXPECT_EQ(below_ten, 4) << "half of a logarithmic range lies below its geometric mean";
}

/// The numbers of the first parameter, whose list this is.
std::vector<double> numbers_of(const SweepFolder& folder, const std::string& list) {
  const std::string file = folder.plan(changed(plan_text, "values: [1 kg, 2 kg, 4 kg]", list));
  std::vector<double> out;
  for (const SweepPoint& p : sweep_points(file, load_sweep(file)))
    if (p.values[1] == "1") out.push_back(p.places[0]);
  return out;
}

// 500 g and 0.5 kg are one mass.
TEST(SweepPlan, NumbersOfAListAreInTheUnitOfItsFirst) {
  const SweepFolder folder;
  EXPECT_EQ(numbers_of(folder, "values: [500 g, 1 kg, 1500 g, 0.002 t]"), (std::vector<double>{500, 1000, 1500, 2000}));
  EXPECT_EQ(numbers_of(folder, "values: [1 kg, 500 g]"), (std::vector<double>{1, 0.5}));
  EXPECT_EQ(numbers_of(folder, "values: [8 kg, 16 kg]"), (std::vector<double>{8, 16}));
  EXPECT_EQ(numbers_of(folder, "between: 1 3, levels: 3, unit: kg"), (std::vector<double>{1, 2, 3}));
  EXPECT_TRUE(std::isnan(numbers_of(folder, "values: [1 kg, 2*1 kg]")[1])) << "it is worth 2 kg, and no number";
}

// A parameter may be made of others: what it stands for is multiplied, all of it.
TEST(SweepPlan, FactorsMultiplyParametersOfTheScenario) {
  const SweepFolder folder;
  const std::string mass = changed(oscillator, "mass: 2 kg", "mass: load");
  test::write_file(folder / "mass.yaml", mass + "parameters: {half: 1 kg, load: half + 1 kg}\n");
  const std::string file = folder.plan(changed(plan_text, "machine.bodies.mass.mass, values: [1 kg, 2 kg, 4 kg]",
                                               "parameters.load, factors: [0.5, 1, 3]"));
  std::set<double> masses;
  for (const SweepPoint& p : sweep_points(file, load_sweep(file)))
    masses.insert(load_scenario((folder / "mass.yaml").string(), p.sets).scenario.machine->bodies[0].mass);
  EXPECT_EQ(masses, (std::set<double>{1, 2, 6}));
}

/// A path has `/` between its keys, and units in keys have one too.
TEST(SweepNumber, APathOfTheSummaryMayHoldUnitsWithASlash) {
  RunFolder run;
  run.summary = {{"soil", {{"mass [kg]", 12.5}, {"bulk density [kg/m3]", 1432.0}}},
                 {"columns", {{"tine.vx [m/s]", {{"mean", 0.5}}}}}};
  const auto at = [&](const char* path) {
    SweepNumber number;
    number.summary = path;
    return take_number(run, number).value;
  };
  EXPECT_EQ(at("soil/mass [kg]"), 12.5);
  EXPECT_EQ(at("soil/bulk density [kg/m3]"), 1432.0);
  EXPECT_EQ(at("columns/tine.vx [m/s]/mean"), 0.5);
  for (const char* none : {"soil/bulk density [kg/m", "soil", "soil/bulk density [kg m-3]", "tools/tine/depth [m]"})
    EXPECT_TRUE(std::isnan(at(none))) << none;
}

/// Points of a path are lengths, in whatever unit the path's columns are; a column and what is taken off it have one
/// unit.
TEST(SweepNumber, AColumnMayHaveAUnitOfItsOwn) {
  RunFolder run;
  run.series =
      Series{.columns = {{"time", "s"}, {"x", "mm"}, {"y", "m"}}, .values = {{0, 1, 2}, {0, 300, 600}, {0, 0, 0}}};
  run.window = {0, 2, "all"};
  SweepNumber path;
  path.path_text = "x;y", path.points = {0.3, 0.04};
  EXPECT_NEAR(take_number(run, path).value, 0.04, 1e-12);
  EXPECT_EQ(unit_of(run, path), "m");
  SweepNumber off;
  off.column = "x", off.off_text = "300*t", off.take = SweepNumber::Take::largest;
  EXPECT_NEAR(take_number(run, off).value, 0, 1e-9);
  EXPECT_EQ(unit_of(run, off), "mm");
}

/// Mean, interval and extremes over the run's own window are the summary's, which has every step; other windows have
/// rows.
TEST(SweepNumber, OverTheWindowOfTheRunIsTheSummarys) {
  RunFolder run;
  run.series = Series{.columns = {{"time", "s"}, {"draft", "N"}}, .values = {{0, 1, 2, 3, 4}, {2, 4, 6, 4, 2}}};
  run.summary = {{"columns",
                  {{"draft",
                    {{"mean in window", 4.25},
                     {"interval of the mean, 95 %", 0.5},
                     {"steps in window", {{"min", 1.5}, {"max", 7.5}}}}}}}};
  run.summary["window"] = {{"from [s]", 0.0}, {"until [s]", 4.0}};
  run.window = {0, 4, "all"};
  SweepNumber number;
  number.column = "draft";
  const auto taken = [&](SweepNumber::Take take) {
    number.take = take;
    return take_number(run, number).value;
  };
  EXPECT_EQ(taken(SweepNumber::Take::mean), 4.25);
  EXPECT_EQ(take_number(run, number).half_width, 0.5);
  EXPECT_EQ(taken(SweepNumber::Take::least), 1.5);
  EXPECT_EQ(taken(SweepNumber::Take::largest), 7.5);
  EXPECT_EQ(taken(SweepNumber::Take::span), 6.0);
  EXPECT_EQ(taken(SweepNumber::Take::last), 2.0);
  number.from = 1, number.until = 3;  // trapezium: (4 + 6) / 2 + (6 + 4) / 2 over 2 s
  EXPECT_EQ(taken(SweepNumber::Take::mean), 5.0);
  EXPECT_EQ(taken(SweepNumber::Take::largest), 6.0);
  number.from.reset(), number.until.reset(), run.summary["window"]["until [s]"] = 3.5;
  EXPECT_EQ(taken(SweepNumber::Take::mean), 4.0);  // 3 + 5 + 5 + 3 over 4 s
}

/// Windows end between rows: the integral is mean times length, and the last value lies on the line between two rows.
TEST(SweepNumber, WindowsThatEndBetweenRowsLoseNothingThere) {
  RunFolder run;
  run.series = Series{.columns = {{"time", "s"}, {"draft", "N"}}, .values = {{0, 1, 2, 3, 4}, {0, 10, 20, 30, 40}}};
  run.summary = {{"columns", {{"draft", {{"mean in window", 21.0}}}}}};
  run.summary["window"] = {{"from [s]", 0.5}, {"until [s]", 3.25}};
  run.window = {0.5, 3.25, "stated"};
  SweepNumber number;
  number.column = "draft";
  const auto taken = [&](SweepNumber::Take take) {
    number.take = take;
    return take_number(run, number).value;
  };
  EXPECT_NEAR(taken(SweepNumber::Take::last), 32.5, 1e-12);
  EXPECT_NEAR(taken(SweepNumber::Take::integral), 21.0 * 2.75, 1e-12);
  number.from = 0.5, number.until = 3.25;  // the same window, and what is known of it
  EXPECT_EQ(taken(SweepNumber::Take::mean), 21.0);
  EXPECT_NEAR(taken(SweepNumber::Take::integral), 21.0 * 2.75, 1e-12);
  number.until = 3.5;  // another one: rows on a line
  EXPECT_NEAR(taken(SweepNumber::Take::integral), (5 + 35) / 2.0 * 3, 1e-12);
  EXPECT_NEAR(taken(SweepNumber::Take::last), 35, 1e-12);
  number.until = 9;  // the record's end
  EXPECT_EQ(taken(SweepNumber::Take::last), 40.0);
}

TEST(Pool, PlacesShareNoCore) {
  const std::vector<int> cores{0, 1, 2, 3, 8, 9, 10};
  const auto places = pool_places(cores, {.threads = 3});
  ASSERT_EQ(places.size(), 2U);
  EXPECT_EQ(places[0], (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(places[1], (std::vector<int>{3, 8, 9}));
  EXPECT_EQ(pool_places(cores, {.threads = 1, .at_once = 4}).size(), 4U);
  EXPECT_EQ(pool_places(cores, {.threads = 16}), std::vector<std::vector<int>>{cores});
}

pid_t start_sweep(const std::string& plan, const std::filesystem::path& out) {
  const pid_t process = fork();
  if (process != 0) return process;
  const int nothing = open("/dev/null", O_WRONLY);
  dup2(nothing, STDOUT_FILENO), dup2(nothing, STDERR_FILENO);
  execl(subsoil::test::program().c_str(), "subsoil", "sweep", plan.c_str(), "--out", out.c_str(), nullptr);
  _exit(127);
}

int code_of(pid_t process) {
  int status = 0;
  waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::vector<std::filesystem::path> done_points(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> done;
  for (int k = 1; k <= 6; ++k)
    if (const auto p = folder / "points" / ("000" + std::to_string(k)) / "point.json"; std::filesystem::exists(p))
      done.push_back(p);
  return done;
}

/// Everything in a table but the wall times.
std::string without_times(const std::filesystem::path& table) {
  std::istringstream lines(test::text_of(table));
  std::string out;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> fields = csv::split(line);
    // point, mass, stiffness, sag, sag half width, wall, wall half width, end, wall time, cause
    EXPECT_EQ(fields.size(), 10U) << line;
    out += fields[0] + "," + fields[1] + "," + fields[2] + "," + fields[3] + "," + fields[7] + "\n";
  }
  return out;
}

TEST(Sweep, KilledGoesOnWhereItWasAndGivesTheSameTable) {
  const SweepFolder folder;
  // Long enough that a kill after the first point finds others at work.
  const std::string plan = folder.plan(std::string(plan_text) + "set: [time.end=20 s]\n");
  const pid_t killed = start_sweep(plan, folder / "out");
  const auto patience = std::chrono::steady_clock::now() + std::chrono::minutes(3);
  const auto alive = [&] {
    siginfo_t info = {};
    return waitid(P_PID, static_cast<id_t>(killed), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
  };
  while (done_points(folder / "out").empty() && alive() && std::chrono::steady_clock::now() < patience)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  kill(killed, SIGKILL);
  EXPECT_EQ(code_of(killed), 128 + SIGKILL) << "it was done before the kill came";
  const std::vector<std::filesystem::path> before = done_points(folder / "out");
  ASSERT_FALSE(before.empty());
  ASSERT_LT(before.size(), 6U);
  std::vector<std::filesystem::file_time_type> written;
  for (const auto& p : before) written.push_back(std::filesystem::last_write_time(p));

  EXPECT_EQ(code_of(start_sweep(plan, folder / "out")), 0);
  EXPECT_EQ(done_points(folder / "out").size(), 6U);
  for (std::size_t k = 0; k < before.size(); ++k)
    EXPECT_EQ(std::filesystem::last_write_time(before[k]), written[k]) << before[k] << " was run again";
  EXPECT_EQ(code_of(start_sweep(plan, folder / "whole")), 0);
  EXPECT_EQ(without_times(folder / "out" / "sweep.csv"), without_times(folder / "whole" / "sweep.csv"));

  // What the mass sags by: released at the spring's free length it swings between 0 and -2 m g/k.
  const SweepPlan read = load_sweep(plan);
  const h5::Handle table = h5::open_file(folder / "out" / "sweep.h5");
  const std::vector<double> sag = h5::read<double>(table, "numbers/sag"),
                            mass = h5::read<double>(table, "parameters/mass"),
                            factor = h5::read<double>(table, "parameters/stiffness");
  ASSERT_EQ(sag.size(), 6U);
  for (std::size_t k = 0; k < 6; ++k)  // rows every 2 ms of a period of 0.2 s and more miss the turn by 2e-4 of it
    EXPECT_NEAR(sag[k], -2 * mass[k] * 9.81 / (400 * factor[k]), 1e-3 * std::abs(sag[k]));
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "sweep.html"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out" / "points" / "0001" / "run.h5")) << "only numbers are kept";
}

// What a killed sweep leaves at work holds the folder of its point until it has died: the next sweep waits for it.
TEST(Sweep, WaitsForTheRunsOfAKilledOne) {
  const SweepFolder folder;
  const std::string plan = folder.plan(plan_text);
  const std::filesystem::path point = folder / "out" / "points" / "0001";
  std::filesystem::create_directories(point);
  const pid_t left = fork();
  if (left == 0) {
    const FolderLock lock(point);
    while (true) pause();
  }
  while (!reported_progress(point)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const pid_t sweep = start_sweep(plan, folder / "out");
  std::this_thread::sleep_for(std::chrono::seconds(1));
  kill(left, SIGKILL);
  EXPECT_EQ(code_of(left), 128 + SIGKILL);
  EXPECT_EQ(code_of(sweep), 0);
  EXPECT_EQ(done_points(folder / "out").size(), 6U);
  for (const auto& file : done_points(folder / "out"))
    EXPECT_NE(test::text_of(file).find("\"reached\""), std::string::npos) << file << test::text_of(file);
}

TEST(Sweep, FailedPointsStayVisibleWithTheirCause) {
  const SweepFolder folder;
  const std::string plan =
      folder.plan(changed(changed(plan_text, "machine.bodies.mass.mass, values: [1 kg, 2 kg, 4 kg]",
                                  "machine.bodies.mass.at, values: [0 0 m, 0.5 0 m]"),
                          "scenario: mass.yaml", "scenario: mass.yaml\nset: [machine.assemble=no]"));
  EXPECT_EQ(code_of(start_sweep(plan, folder / "out")), 0);
  const SweepPlan read = load_sweep(plan);
  Study study{.title = "",
              .scenario = read.scenario,
              .parameters = {"mass", "stiffness"},
              .points = sweep_points(plan, read),
              .numbers = read.numbers};
  const std::vector<PointResult> results = read_results(study, folder / "out");
  ASSERT_EQ(results.size(), 4U);
  EXPECT_EQ(results[0].end, PointResult::End::reached);
  EXPECT_EQ(results[2].end, PointResult::End::failed);
  EXPECT_NE(results[2].cause.find("rail"), std::string::npos) << results[2].cause;
  EXPECT_TRUE(std::isnan(results[2].value[0]));
  EXPECT_NE(sweep_text(study, results, {}).find("2 failed"), std::string::npos);
  EXPECT_NE(test::text_of(folder / "out" / "sweep.html").find("rail"), std::string::npos);
  // Nothing is open; asked to, failed points run again.
  EXPECT_TRUE(open_points(study, folder / "out", false).empty());
  EXPECT_EQ(open_points(study, folder / "out", true), (std::vector<std::size_t>{2, 3}));
}

/// Before the first run, of columns that only the series knows too.
TEST(Sweep, RefusesAColumnThatTheSeriesHasNot) {
  const SweepFolder folder;
  const std::string plan = folder.plan(changed(plan_text, "column: height", "column: heigth"));
  EXPECT_EQ(code_of(start_sweep(plan, folder / "out")), 2);
  EXPECT_TRUE(done_points(folder / "out").empty());
}

TEST(Sweep, AnotherPlanMayNotUseTheFolder) {
  const SweepFolder folder;
  const std::string plan = folder.plan(changed(plan_text, "values: [1 kg, 2 kg, 4 kg]", "values: [1 kg]"));
  EXPECT_EQ(code_of(start_sweep(plan, folder / "out")), 0);
  folder.plan(changed(plan_text, "values: [1 kg, 2 kg, 4 kg]", "values: [3 kg]"));
  EXPECT_EQ(code_of(start_sweep(plan, folder / "out")), 2);
  const StudyLock lock(folder / "out");
  EXPECT_NE(message_of([&] { const StudyLock second(folder / "out"); }).find("another subsoil works in it"),
            std::string::npos);
}

constexpr const char* rod_in_balls = R"(subsoil: 1
gravity: 0 m/s^2
materials: {a: {density: 2000 kg/m^3}}
contacts: [{between: [a, a], law: linear, k_n: 10 kN/m, restitution: 0.3, mu: 0.5}]
soil: {bed: {fill: particles, particles: [{material: a, radius: 5 mm, position: 0 0 0 m}]}}
boundaries: [{name: rod, material: a, shape: {mesh: rod.obj, unit: m}, at: 0 -6 0 mm, moves: [{velocity: 0 0.05 0 m/s}]}]
time: {end: 1 ms}
output: {monitor: {push: {soil force: rod, along: 0 -1}}}
)";

// A mesh is no part of the scenario's text: a file that has changed is another scenario all the same.
TEST(Sweep, AnotherMeshUnderTheSameNameMayNotUseTheFolder) {
  const SweepFolder folder;
  const auto mesh = [&](double side) {
    test::write_file(folder / "rod.obj", fmt::format("v {0} 0 {0}\nv {0} 0 -{0}\nv -{0} 0 0\nf 1 2 3\n", side));
  };
  test::write_file(folder / "mass.yaml", rod_in_balls);
  const std::string plan = folder.plan(R"(subsoil: 1
scenario: mass.yaml
parameters: {k: {keys: "contacts[0].k_n", values: [10 kN/m]}}
numbers: {push: {column: push, take: last}}
)");
  mesh(0.01);
  EXPECT_EQ(code_of(start_sweep(plan, folder / "out")), 0);
  const SweepPlan read = load_sweep(plan);
  const Study study{.title = "",
                    .scenario = read.scenario,
                    .parameters = {"k"},
                    .points = sweep_points(plan, read),
                    .numbers = read.numbers};
  EXPECT_TRUE(open_points(study, folder / "out", false).empty());
  mesh(0.02);
  EXPECT_NE(message_of([&] { open_points(study, folder / "out", false); }).find("other contents of a file"),
            std::string::npos);
}

/// y = 5 + 3 a - 2 b over a grid: level means and the plane give back 3 times the range of a and -2 times that of b.
TEST(Effects, GiveBackAPlane) {
  Study study;
  study.parameters = {"a", "b"};
  study.numbers.resize(1);
  std::vector<PointResult> results;
  for (const double a : {0.0, 1.0, 4.0})
    for (const double b : {10.0, 20.0}) {
      study.points.push_back({{std::to_string(a), std::to_string(b)}, {a, b}, {}});
      PointResult r;
      r.end = PointResult::End::reached;
      r.value = {5 + 3 * a - 2 * b}, r.half_width = {0};
      results.push_back(r);
    }
  results.push_back({}), study.points.push_back({{"9", "9"}, {9, 9}, {}});
  results.back().end = PointResult::End::failed;
  results.back().value = {std::nan("")};
  const std::vector<Effect> found = effects(study, results);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].slope, 12, 1e-9);
  EXPECT_NEAR(found[1].slope, -20, 1e-9);
  EXPECT_NEAR(found[0].slope_half, 0, 1e-6);
  ASSERT_EQ(found[0].levels.size(), 3U);
  EXPECT_NEAR(found[0].levels[1].mean, 5 + 3 - 30, 1e-9);
  EXPECT_EQ(found[0].levels[1].count, 2U);
  // Two values 20 apart: mean +- t_1 20/2, t_1 = 12.706.
  EXPECT_NEAR(found[0].levels[1].half_width, 12.7062 * 10, 1e-2);
  EXPECT_EQ(best_point(results, 0, true), 4U);
  EXPECT_EQ(best_point(results, 0, false), 1U);
}

/// Numbers of packings are names: they have no slope, and take none of the freedom of the others.
TEST(Effects, PackingsScatter) {
  Study study;
  study.parameters = {"a", "packing"};
  study.packings = 1;
  study.numbers.resize(1);
  study.numbers[0].name = "draft";
  std::vector<PointResult> results;
  for (const double a : {0.0, 1.0})
    for (const double seed : {1.0, 2.0, 3.0}) {
      study.points.push_back({{std::to_string(a), std::to_string(seed)}, {a, seed}, {}});
      PointResult r;
      r.end = PointResult::End::reached;
      r.value = {10 + a + (seed - 2)}, r.half_width = {0};
      results.push_back(r);
    }
  const std::vector<Effect> found = effects(study, results);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].slope, 1, 1e-12);
  EXPECT_TRUE(std::isnan(found[1].slope));
  // Residuals -1, 0, 1 twice with 4 degrees of freedom: s = 1, and 2.7764 s sqrt(2/3) for a difference of two means.
  EXPECT_NEAR(found[0].slope_half, 2.776445 * std::sqrt(2.0 / 3), 1e-5);
  const std::optional<Scatter> both = scatter(study, results, 0);
  ASSERT_TRUE(both);
  EXPECT_EQ(both->settings, 2U);
  EXPECT_NEAR(both->deviation, 1, 1e-12);
  results.resize(3), study.points.resize(3);
  const std::optional<Scatter> one = scatter(study, results, 0);
  ASSERT_TRUE(one);
  EXPECT_NEAR(one->mean, 10, 1e-12);
  EXPECT_NEAR(one->half_width, 4.302653 / std::sqrt(3.0), 1e-5);
  EXPECT_NE(sweep_text(study, results, {}).find("draft: 10 +- 2.5 over 3 packings (95 %), standard deviation 1"),
            std::string::npos)
      << sweep_text(study, results, {});
}

// Of three points that reach their end the second has no such number; the last fails, and is said as such.
TEST(SweepText, WarnsOfPointsThatGiveNoNumber) {
  Study study;
  study.parameters = {"a"};
  study.numbers.resize(2);
  study.numbers[0].name = "draft", study.numbers[1].name = "late";
  std::vector<PointResult> results(4);
  for (std::size_t k = 0; k < 4; ++k) {
    study.points.push_back({{std::to_string(k)}, {static_cast<double>(k)}, {}});
    results[k].end = k < 3 ? PointResult::End::reached : PointResult::End::failed;
    results[k].value = {k < 3 ? 1.0 : std::nan(""), k % 2 == 0 ? 2.0 : std::nan("")}, results[k].half_width = {0, 0};
  }
  const std::string text = sweep_text(study, results, {});
  EXPECT_NE(text.find("1 of 4 points have no number `late`, first 0002 (a = 1)"), std::string::npos) << text;
  EXPECT_EQ(text.find("no number `draft`"), std::string::npos) << text;
}

TEST(Slurm, ArrayHoldsTheOpenPointsAndTheirCommand) {
  EXPECT_EQ(task_list({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
  const Scratch folder;
  const auto scripts = write_slurm({.name = "it's",
                                    .plan = "/tmp/a plan.yaml",
                                    .sets = {"points=3"},
                                    .folder = folder.path(),
                                    .points = {0, 2},
                                    .threads = 4,
                                    .at_once = 2});
  const std::string array = test::text_of(scripts[0]), gather = test::text_of(scripts[1]);
  EXPECT_NE(array.find("#SBATCH --array=0,2%2\n"), std::string::npos) << array;
  EXPECT_NE(array.find("#SBATCH --cpus-per-task=4\n"), std::string::npos);
  EXPECT_NE(array.find("sweep '/tmp/a plan.yaml' --out"), std::string::npos);
  EXPECT_NE(array.find("--set 'points=3' --point \"$SLURM_ARRAY_TASK_ID\""), std::string::npos);
  EXPECT_NE(gather.find("--gather"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::sweep_test
