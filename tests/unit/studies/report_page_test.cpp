#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "libdem/laws/wet.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/post/chains.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/report/page.hpp"
#include "libsim/report/report.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/view/view.hpp"
#include "tests/tools/program_runs.hpp"

/// `subsoil report`: the data of a page against the run's own files, and pages of broken result directories. A browser
/// opens pages in tests/optional.
namespace subsoil::sim::report_page_test {
namespace {

using test::message_of;
using test::RunDirectory;
using Json = nlohmann::ordered_json;

/// One small pass for all tests of this file.
const RunDirectory& pass() {
  static const RunDirectory* directory = [] {
    auto* d = new RunDirectory;
    const std::string sets[] = {"output.window={from: 50 ms, until: 150 ms}"};
    EXPECT_EQ(test::run_scenario(d->scenario(test::small_pass), *d / "run", {sets[0]}), exit_ok);
    return d;
  }();
  return *directory;
}

Json data_of(const std::vector<std::filesystem::path>& runs) {
  ReportRequest request;
  request.runs = runs;
  return report_data(request);
}

const Json* row(const Json& data, const std::string& quantity, const std::string& statistic) {
  for (const Json& r : data["table"])
    if (r["quantity"] == quantity && r["statistic"] == statistic) return &r;
  return nullptr;
}

bool names(const Json& list, const std::string& word) {
  for (const Json& line : list)
    if (line.get<std::string>().find(word) != std::string::npos) return true;
  return false;
}

TEST(Report, TableHoldsTheMeansOfTheSummaryAndTheirWindow) {
  const Json data = data_of({pass() / "run"});
  const nlohmann::json summary = test::summary_of(pass() / "run");
  const Json* draft = row(data, "draft", "mean");
  ASSERT_NE(draft, nullptr);
  const Json& cell = (*draft)["runs"][0];
  // The summary weighs steps, the page rows of 1 ms; the window's ends cut rows: one of 100 at either.
  const double mean = summary["columns"]["soil.draft"]["mean in window"], value = cell["value"];
  EXPECT_NEAR(value, mean, 0.02 * std::abs(mean) + 1e-3);
  EXPECT_EQ(cell["from [s]"], 0.05);
  EXPECT_EQ(cell["until [s]"], 0.15);
  for (const Json& r : data["table"])
    for (const Json& c : r["runs"]) EXPECT_TRUE(c.contains("from [s]") && c.contains("until [s]")) << r;
  EXPECT_EQ(nlohmann::json::parse(data["runs"][0]["energy"].dump()), summary["energy"]);
}

/// Of another window than the run's every number is of its rows.
TEST(Report, WindowThatIsAskedForHoldsForEveryNumber) {
  ReportRequest request;
  request.runs = {pass() / "run"};
  request.from = 0.08, request.until = 0.12;
  const Json data = report_data(request);
  const Series series = read_series(pass() / "run" / "series.csv");
  double sum = 0, least = INFINITY, largest = -INFINITY, rows = 0;
  for (std::size_t k = 0; k < series.at("time").size(); ++k) {
    if (series.at("time")[k] < 0.08 - 1e-9 || series.at("time")[k] > 0.12 + 1e-9) continue;
    const double draft = series.at("soil.draft")[k];
    sum += draft, ++rows, least = std::min(least, draft), largest = std::max(largest, draft);
  }
  const auto value = [&](const char* what) {
    const Json* found = row(data, "draft", what);
    return found == nullptr ? NAN : (*found)["runs"][0]["value"].get<double>();
  };
  ASSERT_GT(rows, 30);
  EXPECT_NEAR(value("mean"), sum / rows, (largest - least) / rows) << "the two rows at the ends may count by half";
  EXPECT_NEAR(value("least of the rows"), least, 1e-5 * std::abs(least)) << "six digits are kept";
  EXPECT_NEAR(value("largest of the rows"), largest, 1e-5 * largest);
}

/// The film is the page of `subsoil view`; still frames lie from the first frame to the end of the window.
TEST(Report, FilmIsTheViewOfTheRun) {
  const Json data = data_of({pass() / "run"});
  ViewRequest request;
  request.run = pass() / "run";
  EXPECT_EQ(data["runs"][0]["scene"], view_scene(request));
  const std::vector<double> times = test::frame_times(pass() / "run"),
                            stills = data["runs"][0]["stills"].get<std::vector<double>>();
  EXPECT_EQ(data["runs"][0]["scene"]["spheres"]["frames"].size(), times.size());
  ASSERT_EQ(stills.size(), 6U);
  EXPECT_DOUBLE_EQ(stills.front(), times.front());
  EXPECT_DOUBLE_EQ(stills.back(), 0.15);
  EXPECT_NEAR(data["runs"][0]["slice"].get<double>(), 0, 1e-6) << "the middle of the blade";
}

TEST(Report, RefusesASectionOutsideTheBed) {
  ReportRequest request;
  request.runs = {pass() / "run"};
  request.slice = 5, request.slice_given = true;
  EXPECT_NE(
      message_of<std::invalid_argument>([&] { report_data(request); }).find("--slice 5 m: is outside the bed of "),
      std::string::npos);
}

/// The window of a moving bed goes with the blade: by whole periods, which are shorter than the window of 0.36 m.
TEST(Report, FilmOfAMovingBedGoesWithIt) {
  const RunDirectory d;
  ASSERT_EQ(test::run_scenario(d.scenario(test::moving_pass), d / "run"), exit_ok);
  const Json data = data_of({d / "run"});
  const Series series = read_series(d / "run" / "series.csv");
  const std::vector<double>& x = series.at("blade.x");
  const Json& frames = data["runs"][0]["scene"]["spheres"]["frames"];
  double before = 0;
  for (const Json& frame : frames) {
    EXPECT_GE(frame["travelled"].get<double>(), before);
    before = frame["travelled"];
  }
  EXPECT_NEAR(before, x.back() - x.front(), 0.18);
}

/// A machine alone has no spheres: its film is that of the series.
TEST(Report, AMachineAloneHasAFilm) {
  const RunDirectory d;
  const std::string scenario = subsoil::test::source_dir() + "/configs/slider-crank.yaml";
  ASSERT_EQ(test::run_scenario(scenario, d / "run", {}), exit_ok);
  const Json data = data_of({d / "run"});
  const Json& run = data["runs"][0];
  EXPECT_GT(run["scene"]["motion"]["times"].size(), 10U);
  EXPECT_TRUE(run["scene"]["spheres"].is_null());
  EXPECT_GE(run["stills"].size(), 2U);
}

/// Chains are the law's forces in newtons: a spring of 10 kN/m pressed by 0.1 mm gives 1 N, and the wet law pulls
/// across a gap by its film. Without the scenario they are overlaps, and the page says so.
TEST(Report, ForceChainsAreTheLawsForces) {
  const Loaded dry = load_scenario_text(R"(subsoil: 1
materials: {a: {density: 2000 kg/m^3}, b: {density: 2000 kg/m^3}}
contacts:
  - &dry {between: [b, a], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.5}
  - {<<: *dry, between: [b, b]}
soil: {container: {size: 1 1 1 m, at: 0 0 0 m, material: a}, bed: {fill: random, material: b, radius: 10 mm}}
time: {end: 1 s}
)",
                                        "dry.yaml");
  const RestForce force(dry.scenario, {"a", "b"});
  const std::vector<ChainSphere> three{{0, 0, 0, 0.01F, 0}, {0.0199F, 0, 0, 0.01F, 1}, {0, 0.0199F, 0, 0.01F, 0}};
  const std::vector<Chain> found = chains(three, force);
  ASSERT_EQ(found.size(), 1U) << "a and a have no law, the others are apart";
  EXPECT_EQ(found[0].a + found[0].b, 1U);
  EXPECT_NEAR(found[0].size, 1, 1e-3);  // coordinates are floats
  ASSERT_EQ(chains(three, RestForce()).size(), 2U);
  EXPECT_NEAR(chains(three, RestForce())[0].size, 0.01, 1e-5);

  const Loaded wet = load_scenario_text(test::small_pass, "pass.yaml");
  const dem::Wet law = *wet.scenario.contacts[0].law.get_if<dem::Wet>();
  const RestForce film(wet.scenario, {"soil", "steel"});
  const auto gap = static_cast<float>(0.5 * law.dB);
  const std::vector<Chain> pulled = chains({{0, 0, 0, 0.01F, 0}, {0.02F + gap, 0, 0, 0.01F, 0}}, film);
  ASSERT_EQ(pulled.size(), 1U);
  EXPECT_NEAR(pulled[0].size, -0.5 * law.K_B * law.dB, 0.02 * law.K_B * law.dB);  // half of its largest pull

  // In space as in the plane: the nearest pairs of a cube's corners are its edges, whatever cells they lie in.
  std::vector<ChainSphere> cube;
  for (int k = 0; k < 8; ++k)
    cube.push_back({-0.03F + 0.0199F * static_cast<float>(k & 1), 0.0199F * static_cast<float>(k >> 1 & 1),
                    0.0199F * static_cast<float>(k >> 2), 0.01F, 1});
  EXPECT_EQ(chains(cube, force).size(), 12U);

  const Json spheres = data_of({pass() / "run"})["runs"][0]["scene"]["spheres"];
  EXPECT_GT(spheres["chainTop"].get<double>(), 0);
  EXPECT_TRUE(spheres["frames"].back().contains("chains"));
  EXPECT_NE(spheres["chainNote"].get<std::string>().find("at rest"), std::string::npos);
  const test::Scratch scratch;
  std::filesystem::copy(pass() / "run", scratch / "run", std::filesystem::copy_options::recursive);
  std::filesystem::remove(scratch / "run/scenario.yaml");
  const Json without = data_of({scratch / "run"});
  EXPECT_FALSE(without["runs"][0].contains("scene"));
  EXPECT_TRUE(names(without["runs"][0]["missing"], "no film"));
}

TEST(Report, ToolIsMeasuredInTheFrames) {
  const Json data = data_of({pass() / "run"});
  const Json *width = row(data, "tool", "width in the soil"), *depth = row(data, "tool", "greatest depth of the tip"),
             *speed = row(data, "tool", "mean speed of travel");
  ASSERT_TRUE(width && depth && speed);
  // The blade is a box of 20 x 90 x 30 mm whose middle stays at y = 0; coordinates are rounded to some micrometres.
  EXPECT_NEAR((*width)["runs"][0]["value"].get<double>(), 0.030, 1e-5);
  EXPECT_NEAR((*depth)["runs"][0]["value"].get<double>(), 0.045, 1e-5);
  const Series series = read_series(pass() / "run" / "series.csv");
  const std::vector<double>&x = series.at("tine.x"), &t = series.at("time");
  // The blade does not turn, so its tip goes as its middle does.
  EXPECT_NEAR((*speed)["runs"][0]["value"].get<double>(), (x.back() - x.front()) / (t.back() - t.front()), 1e-3);
}

TEST(Report, RunsSideBySideHaveDifferences) {
  const Json data = data_of({pass() / "run", pass() / "run"});
  ASSERT_EQ(data["runs"].size(), 2U);
  EXPECT_NE(data["runs"][0]["name"], data["runs"][1]["name"]);
  const Json* draft = row(data, "draft", "mean");
  ASSERT_NE(draft, nullptr);
  EXPECT_EQ((*draft)["runs"][1]["difference"], 0);
  const double half = (*draft)["runs"][0]["half width"], both = (*draft)["runs"][1]["difference half width"];
  EXPECT_NEAR(both, std::sqrt(2.0) * half, 1e-4 * both);
}

/// A monitor in mm beside the same in cm is no difference; one in m/s is another quantity.
TEST(Report, RunsSideBySideAreInOneUnit) {
  const RunDirectory dir;
  const auto run = [&](const std::string& name, const std::string& column, const std::string& unit) {
    const std::string file = dir.scenario(R"(subsoil: 1
machine:
  bodies: {mass: {mass: 2 kg, inertia: 1 kg m^2, at: 0.1 0 m}}
  joints: {rail: {translational: [ground, mass], at: 0 0 m, along: 1 0}}
  forces: {spring: {spring-damper: [ground, mass], ends: [-1 0 m, 0.1 0 m], stiffness: 400 N/m, free length: 1 m}}
time: {end: 1 s}
output: {series every: 10 ms, monitor: {way: {formula: x, of: {x: )" +
                                          column + "}, unit: " + unit + "}}}\n");
    EXPECT_EQ(test::run_scenario(file, dir / name), exit_ok);
  };
  run("mm", "mass.x", "mm"), run("cm", "mass.x", "cm"), run("other", "mass.vx", "m/s");
  const Json data = data_of({dir / "mm", dir / "cm", dir / "other"});
  const Json* most = row(data, "way", "largest");
  ASSERT_NE(most, nullptr) << data["table"];
  EXPECT_EQ((*most)["unit"], "mm");
  EXPECT_NEAR((*most)["runs"][1]["value"].get<double>(), 100, 0.5);
  EXPECT_NEAR((*most)["runs"][1]["difference"].get<double>(), 0, 1e-3);
  EXPECT_FALSE((*most)["runs"][2].contains("value"));
  EXPECT_NE(row(data, "way", "largest in m/s"), nullptr);
  for (const Json& curve : data["runs"][1]["curves"]["columns"])
    if (curve["key"] == "way") {
      EXPECT_EQ(curve["unit"], "mm");
      EXPECT_NEAR(curve["values"][0].get<double>(), 100, 1e-3);
    }
}

TEST(Report, BrokenFoldersSayWhatIsMissingAndGiveTheRest) {
  const test::Scratch scratch;
  const auto copy = scratch / "run";
  std::filesystem::copy(pass() / "run", copy, std::filesystem::copy_options::recursive);
  std::filesystem::remove(copy / "summary.json");
  std::filesystem::resize_file(copy / "run.h5", std::filesystem::file_size(copy / "run.h5") / 3);
  Json data = data_of({copy});
  EXPECT_TRUE(names(data["runs"][0]["missing"], "summary.json"));
  EXPECT_TRUE(names(data["runs"][0]["missing"], "run.h5"));
  EXPECT_NE(row(data, "draft", "mean"), nullptr) << "the series is whole";
  EXPECT_TRUE(data["runs"][0]["scene"]["spheres"].is_null());

  test::write_file(copy / "series.csv", "name,colour\napple,red\n");
  data = data_of({copy});
  EXPECT_TRUE(names(data["runs"][0]["missing"], "series.csv"));
  EXPECT_TRUE(data["table"].empty());

  std::filesystem::copy_file(pass() / "run" / "run.h5", copy / "run.h5",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_FALSE(data_of({copy})["runs"][0]["scene"]["spheres"].is_null()) << "frames are drawn without a series";
}

/// The header of a group in it is broken so that HDF5 1.10.8 reads at address 0; found by scripts/fuzz.
TEST(Report, AFileThatTheHdf5LibraryFailsAtIsRefused) {
  const std::string path = subsoil::test::source_dir() + "/tests/unit/studies/broken_group.h5";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(FramesFile{path}, testing::ExitedWithCode(exit_bad_input), path + ": .*it is damaged");
}

/// Two bytes of the heap that holds a state's texts make its first object one of no bytes: HDF5 1.10.8 looks for the
/// next one there for ever; found by scripts/fuzz.
TEST(Report, AFileThatTheHdf5LibraryComesToNoEndWithIsRefused) {
  const test::Scratch scratch;
  std::string bytes = test::text_of(subsoil::test::source_dir() + "/tests/fuzz/corpus/state/whole.h5");
  ASSERT_EQ(bytes.at(4552), 7);
  bytes.at(4552) = 0, bytes.at(4560) = 0;
  const std::string path = (scratch / "state.h5").string();
  test::write_file(path, bytes);
  setenv("SUBSOIL_LIMITS", "read-seconds=1", 1);
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(StateReader(path).texts("run/texts"), testing::ExitedWithCode(exit_bad_input),
              "comes to no end with this file: it is damaged");
  unsetenv("SUBSOIL_LIMITS");
}

#ifndef __SANITIZE_ADDRESS__  // whose own memory counts, so that the guard sets no bound
/// HDF5 1.10.8 takes 1.9 GB for a chunk of this state of 85 kB before it finds it damaged; found by scripts/fuzz. By
/// the process's own account, of which the test binary is some 50 MB.
TEST(Report, AFileThatAsksForGigabytesIsRefusedWithoutThem) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      StateReader(subsoil::test::source_dir() + "/tests/fuzz/corpus/state/asks-for-gigabytes.h5")
          .get<double>("run/sums");
    } catch (const std::exception&) {
      ::_exit(exit_bad_input);
    }
    ::_exit(0);
  }
  int status = -1;
  rusage usage{};
  ASSERT_EQ(::wait4(child, &status, 0, &usage), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), exit_bad_input);
  EXPECT_LT(usage.ru_maxrss, 1'200'000) << "kB";
}
#endif

/// A crash of our own stays a crash: what the guard has set is gone behind it.
TEST(Report, OnlyReadingIsGuarded) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto crash_after_reading = [] {
    FramesFile{pass() / "run" / "run.h5"};
    std::abort();
  };
  EXPECT_EXIT(crash_after_reading(), testing::KilledBySignal(SIGABRT), "");
}

TEST(Report, CutShortSeriesIsReadToItsLastWholeRow) {
  const test::Scratch scratch;
  const auto copy = scratch / "run";
  std::filesystem::copy(pass() / "run", copy);
  std::filesystem::resize_file(copy / "series.csv", std::filesystem::file_size(copy / "series.csv") / 2);
  const Json data = data_of({copy});
  const Json& time = data["runs"][0]["curves"]["time"];
  EXPECT_GT(time.size(), 20U);
  EXPECT_LT(time.back().get<double>(), 0.1);
}

TEST(Report, RefusesWhatIsNoResult) {
  const test::Scratch scratch;
  EXPECT_NE(message_of([&] { data_of({scratch / "none"}); }).find("is no directory; name the result directory"),
            std::string::npos);
  EXPECT_NE(message_of([&] { data_of({scratch.path()}); }).find("holds none of scenario.yaml"), std::string::npos);
  ReportRequest backwards;
  backwards.runs = {pass() / "run"};
  backwards.from = 0.1, backwards.until = 0.05;
  EXPECT_NE(message_of([&] { report_data(backwards); }).find("the window ends before it begins"), std::string::npos);
  ReportRequest late;
  late.runs = {pass() / "run"};
  late.until = 5;
  EXPECT_NE(message_of([&] { report_data(late); }).find("--until 5: the record of run ends at 0.15 s"),
            std::string::npos)
      << message_of([&] { report_data(late); });
  EXPECT_NE(message_of([&] { read_strength(scratch.path()); }).find("subsoil test shear"), std::string::npos);
}

TEST(Report, PageIsOneFileThatAsksForNothing) {
  const test::Scratch scratch;
  ReportRequest request;
  request.runs = {pass() / "run"};
  request.out = scratch / "page.html";
  request.source = true;
  write_report(request);
  const std::string page = test::text_of(request.out);
  for (const char* outside : {"src=", "@import", "url(", "fetch(", "XMLHttpRequest", "<link"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  // The data come back from the page as they went in.
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = page.find(open) + open.size(), end = page.find("</script>", begin);
  const Json data = Json::parse(page.substr(begin, end - begin));
  EXPECT_EQ(data, report_data(request));
  EXPECT_EQ(data["source"].size(), 6U);
  EXPECT_LT(page.size(), 15'000'000U);
}

TEST(Page, TextOfUsersCannotLeaveItsPlace) {
  const Json data{{"title", "</script><script>alert(1)</script>"}};
  const std::string page = report_page("<b>", data, "");
  EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
  EXPECT_NE(page.find("<title>&lt;b&gt;</title>"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::report_page_test
