#include "libsim/io/state_file.hpp"
#include "tests/tools/program_runs.hpp"

/// Unconfined compression of a bonded block (configs/cemented-block.yaml).
/// Oracle: counts and energies that must agree between table, series and summary; a first break not before the stress
/// in a bond can reach its strength; strength lost by breaking.
namespace subsoil::sim::cemented_block {
namespace {

TEST(CementedBlock, BreaksAndSaysWhereWhenAndHow) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("cemented-block"), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const nlohmann::json summary = test::summary_of(dir / "out"), bonds = summary["bonds"];
  const auto count = [&](const char* name) { return bonds[name].get<double>(); };
  const double broken = count("broken in tension") + count("broken in shear");
  EXPECT_GT(broken, 0.05 * count("formed"));
  EXPECT_GT(count("intact"), 0.05 * count("formed"));
  EXPECT_EQ(count("formed"), count("intact") + broken + count("removed with spheres"));
  EXPECT_EQ(series.at("soil.bonds").back(), count("intact"));
  EXPECT_EQ(series.at("soil.bonds").front(), count("formed"));

  const auto file = h5::open_file(dir / "out" / "run.h5");
  const std::vector<double> time = h5::read<double>(file, "/broken bonds/time"),
                            energy = h5::read<double>(file, "/broken bonds/energy"),
                            position = h5::read<double>(file, "/broken bonds/position");
  ASSERT_EQ(static_cast<double>(time.size()), broken);
  EXPECT_EQ(position.size(), 3 * time.size());
  EXPECT_TRUE(std::is_sorted(time.begin(), time.end()));
  double sum = 0;
  for (const double e : energy) sum += e;
  // The series has nine digits; events and the balance add the same numbers in the same order.
  EXPECT_NEAR(series.at("soil.broken").back(), sum, 1e-8 * sum);
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 0.01);
  // Of the frames: half of what all spheres hold is the number of bonds.
  const auto held = [&](const char* frame) {
    double all = 0;
    for (const std::int32_t n : h5::read<std::int32_t>(file, std::string("/frames/") + frame + "/bonds")) all += n;
    return all / 2;
  };
  EXPECT_EQ(held("000000"), count("formed"));
  EXPECT_EQ(held("000016"), count("intact"));

  // The plate bears most before the bonds go: what it bears at the end is friction.
  const std::vector<double>& load = series.at("load");
  const auto peak = std::max_element(load.begin(), load.end()) - load.begin();
  double last = 0;
  for (std::size_t i = load.size() - 50; i < load.size(); ++i) last += load[i] / 50;
  EXPECT_LT(last, 0.5 * load[static_cast<std::size_t>(peak)]);
}

/// A state in the middle of breaking, through its file.
TEST(CementedBlock, GoesOnFromAState) {
  const test::RunDirectory dir;
  const std::vector<std::string> small = {"soil.bed.depth=40 mm", "soil.container.size=40 60 40 mm",
                                          "soil.container.at=-20 0 -20 mm", "boundaries[0].at=0 46 0 mm"};
  const auto with = [&](const std::string& set) {
    std::vector<std::string> sets = small;
    sets.push_back(set);
    return sets;
  };
  ASSERT_EQ(test::run_scenario(test::config("cemented-block"), dir / "straight", with("time.end=40 ms")), exit_ok);
  std::vector<std::string> half = with("time.end=30 ms");
  half.push_back("output.state=full");
  ASSERT_EQ(test::run_scenario(test::config("cemented-block"), dir / "half", half), exit_ok);
  ASSERT_EQ(test::run_scenario(test::config("cemented-block"), dir / "rest", with("time.end=40 ms"),
                               latest_state(dir / "half").value()),
            exit_ok);
  const nlohmann::json straight = test::summary_of(dir / "straight")["bonds"],
                       first = test::summary_of(dir / "half")["bonds"], rest = test::summary_of(dir / "rest")["bonds"];
  const auto broken = [](const nlohmann::json& b) {
    return b["broken in tension"].get<double>() + b["broken in shear"].get<double>();
  };
  EXPECT_GT(broken(first), 5);
  EXPECT_GT(broken(rest), broken(first));
  EXPECT_EQ(rest["formed"], straight["formed"]);
  // Sums run in another order from the state on: in 10 ms rounding may move a break or two.
  EXPECT_NEAR(broken(rest), broken(straight), 2);
  const auto file = h5::open_file(dir / "rest" / "run.h5");
  EXPECT_EQ(static_cast<double>(h5::read<double>(file, "/broken bonds/time").size()), broken(rest))
      << "with those from before the state";
}

}  // namespace
}  // namespace subsoil::sim::cemented_block
