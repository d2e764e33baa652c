#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "apps/commands/commands.hpp"
#include "libmbd/forces/ground_element.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/impact/ground_fit.hpp"
#include "libsim/studies/impact/report.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

/// `subsoil impact`: reading, tables and files, closed forms of the ground element, and fits that find what made the
/// data. The models themselves: tests/unit/libdem/impact_models.cpp.
namespace subsoil::sim::impact_test {
namespace {

using subsoil::test::message_of;

const std::vector<std::string> ball{"model=hunt-crossley", "c=1.7135e10 N/m^1.5", "b=0.1 s/m", "first.mass=0.1 kg"};

std::vector<std::string> with(std::vector<std::string> sets, std::initializer_list<std::string> more) {
  sets.insert(sets.end(), more);
  return sets;
}

TEST(ImpactStudy, RefusalsNamePlaceRuleAndCure) {
  const auto says = [](const std::string& text) {
    const test::RunDirectory directory;
    const std::string file = directory.scenario(text);
    const std::string message = message_of([&] { static_cast<void>(strike_all(load_study(file, {}))); });
    const std::size_t at = message.find("case.yaml");
    return at == std::string::npos ? message : message.substr(at);
  };
  const std::string head = "subsoil: 1\nspeeds: 2 m/s\nfirst: {mass: 0.1 kg}\n";
  EXPECT_EQ(says(head + "model: hunt-crosley\n"),
            "case.yaml:4:8 model = hunt-crosley: unknown model; did you mean `hunt-crossley`?");
  EXPECT_EQ(says(head + "model: hunt-crossley\nc: 1e10 N/m^1.5\n"),
            "case.yaml:4:8 model: needs b, or restitution and at speed; for no damping b: 0");
  EXPECT_EQ(
      says(head + "model: hertz\n"),
      "case.yaml:4:8 model: needs the bodies' elasticity and shape: give young and poisson of both bodies and the "
      "radius of one at least");
  EXPECT_EQ(says("subsoil: 1\nmodel: hertz\nspeeds: 1 m/s\nfirst: {radius: 5 mm}\n"),
            "case.yaml:4:8 first.mass: is missing: mass of the body that strikes; give it, or density and radius");
  EXPECT_EQ(says(head + "model: hertz\nsecond: {young: 1 GPa}\n"),
            "case.yaml:5:9 second: has one of young and poisson; give both, or neither for a rigid body");
  EXPECT_EQ(says(head + "model: jkr\nw: 50 mJ/m^2\nb: 0.1 s/m\n").substr(0, 36),
            "case.yaml:6:1 b = 0.1 s/m: unknown k");
}

TEST(ImpactStudy, BodiesMakeThePair) {
  const LoadedStudy two = load_study(
      "", {"model=hertz", "speeds=1 m/s", "first={density: 2800 kg/m^3, radius: 10 mm, young: 48 GPa, poisson: 0.2}",
           "second={mass: 20 g, radius: 30 mm, young: 48 GPa, poisson: 0.2}"});
  const dem::impact::Pair pair = pair_of(two.study);
  const double m1 = 2800 * 4.0 / 3 * std::acos(-1.0) * 1e-6;
  EXPECT_NEAR(pair.mass, m1 * 0.02 / (m1 + 0.02), 1e-15);
  EXPECT_NEAR(pair.radius, 7.5e-3, 1e-15);
  EXPECT_NEAR(pair.E_eff, 48e9 / (2 * 0.96), 1e-3);
  // The bed goes through the same event; two spheres, Hertz-Mindlin's law, 1000 steps: second order.
  const ImpactRow row = strike_all(two).front();
  ASSERT_TRUE(row.stepped.has_value());
  EXPECT_NEAR(row.stepped->peak_force / row.closed.peak_force, 1, 1e-5);
  EXPECT_NEAR(row.stepped->duration() / row.closed.duration(), 1, 1e-4);
}

TEST(ImpactCommand, FlagsGiveTheTableOfTheSource) {
  const test::RunDirectory directory;
  ImpactRequest request;
  request.words = {"--model", "hunt-crossley", "--c=1.7135e10 N/m^1.5", "--b", "0.1 s/m", "--mass", "0.1 kg",
                   "--speed", "0.5 2 5 m/s"};
  request.out = (directory / "out").string();
  testing::internal::CaptureStdout();
  ASSERT_EQ(impact_command(request), exit_ok);
  const std::string printed = testing::internal::GetCapturedStdout();
  EXPECT_NE(printed.find("0.8821899862"), std::string::npos) << printed;
  const Series table = read_series(directory / "out/impact.csv");
  EXPECT_NEAR(table.at("peak force")[1], 7709.8673681, 1e-7);
  EXPECT_NEAR(table.at("duration")[2], 7.7655384043e-5, 1e-15);
  EXPECT_NEAR(table.at("lost energy")[0], 7.9352554529e-4, 1e-14);
  // 1000 steps of compression: first order in the damping, nu dt/T ~ 1e-3.
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(table.at("stepped restitution")[k], table.at("restitution")[k], 5e-4);
  const Series course = read_series(directory / "out/course-2.csv");
  EXPECT_EQ(course.rows(), 401U);
  EXPECT_GT(read_series(directory / "out/stepped-2.csv").rows(), 2000U);
  EXPECT_TRUE(!std::filesystem::exists("/usr/bin/gnuplot") || std::filesystem::exists(directory / "out/loop.svg"));
  request.words.push_back("--c");
  EXPECT_NE(message_of([&] { impact_command(request); }).find("--c has no value"), std::string::npos);
}

/// Everything that the tables and courses say stands in one HDF5 file too, with its unit.
TEST(ImpactCommand, ResultsFileHoldsTableCoursesAndParameters) {
  const test::RunDirectory directory;
  ImpactRequest request;
  request.words = {"--model",  "hysteretic", "--restitution",          "0.6",     "--mass",  "1 g",
                   "--radius", "5 mm",       "--first.yield strength", "588 kPa", "--speed", "0.5 2 m/s",
                   "--steps",  "200"};
  request.out = (directory / "out").string();
  testing::internal::CaptureStdout();
  ASSERT_EQ(impact_command(request), exit_ok);
  testing::internal::GetCapturedStdout();
  const auto file = h5::open_file(directory / "out/impact.h5");
  const auto number = [&](const char* name) { return h5::read<double>(file, name).at(0); };
  const auto unit = [&](const char* name) {
    const h5::Handle set(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, name);
    const h5::Handle attribute(H5Aopen(set, "unit", H5P_DEFAULT), H5Aclose, name);
    const h5::Handle type(H5Aget_type(attribute), H5Tclose, name);
    std::string text(H5Tget_size(type), '\0');
    H5Aread(attribute, type, text.data());
    return std::string(text.c_str());
  };
  EXPECT_EQ(h5::read<double>(file, "table/speed"), (std::vector<double>{0.5, 2}));
  const Series table = read_series(directory / "out/impact.csv"), course = read_series(directory / "out/course-2.csv");
  for (const ImpactQuantity& q : impact_quantities(load_study("", {"model=hertz", "first.mass=1 g"}).study)) {
    const std::string path = std::string("table/") + q.name;
    EXPECT_EQ(h5::read<double>(file, path), table.at(q.name)) << path;
    EXPECT_EQ(unit(path.c_str()), q.unit);
    EXPECT_EQ(h5::read<double>(file, std::string("table/stepped ") + q.name),
              table.at(std::string("stepped ") + q.name));
  }
  for (const char* column : {"time", "indentation", "speed", "force"})
    EXPECT_EQ(h5::read<double>(file, std::string("courses/001/") + column), course.at(column)) << column;
  EXPECT_EQ(unit("courses/001/force"), "N");
  EXPECT_EQ(h5::read<double>(file, "courses/001/stepped/time").size(),
            read_series(directory / "out/stepped-2.csv").rows());
  EXPECT_EQ(number("parameters/restitution"), 0.6);
  EXPECT_EQ(number("parameters/first.yield strength"), 588e3);
  EXPECT_EQ(unit("parameters/first.yield strength"), "Pa");
  EXPECT_EQ(number("parameters/pair.radius"), 5e-3);
  EXPECT_FALSE(h5::exists(file, "parameters/K2"));
}

TEST(ImpactCommand, FilesInConfigsRun) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(subsoil::test::source_dir() + "/configs/impact")) {
    SCOPED_TRACE(entry.path());
    const std::vector<ImpactRow> rows = strike_all(load_study(entry.path().string(), {"steps=100"}));
    EXPECT_GE(rows.size(), 4U);
    for (const ImpactRow& row : rows) EXPECT_GT(row.closed.peak_force, 0);
    ++files;
  }
  EXPECT_EQ(files, 3);
}

TEST(GroundImpact, ClosedFormsOfTheStamp) {
  GroundImpact model;
  model.stiffness = mbd::PowerStiffness{.K0 = 1e5};
  model.gravity = 0;
  const dem::impact::Pair stamp{.mass = 132};
  const auto e = model.strike(stamp, 1, 200);
  EXPECT_NEAR(e.largest, 34.641016e-3, 5e-10);
  EXPECT_NEAR(e.time_in, 59.855379e-3, 5e-10);
  EXPECT_NEAR(e.at_touch, 6, 1e-12);
  EXPECT_NEAR(e.in_ground, 60, 1e-10);
  EXPECT_NEAR(e.lost, 66, 1e-12);
  EXPECT_NEAR(e.peak_force, 1e5 * e.largest / 1.1, 1e-8);
  model.gravity = 9.81;
  EXPECT_NEAR(model.strike(stamp, 1, 200).largest, 49.931382e-3, 5e-10);
  // F = Q z^n: z_max = ((n+1) M V0^2/(2Q))^(1/(n+1)), here n = 1 + alpha and Q = K0/z0^alpha.
  model.gravity = 0;
  for (const double alpha : {-0.6, 0.3126, 2.0}) {
    model.stiffness = mbd::PowerStiffness{.K0 = 1e5, .z0 = 0.01, .alpha = alpha};
    const double n = 1 + alpha, Q = 1e5 / std::pow(0.01, alpha), v0 = 3.5 / 1.1;
    const double z = std::pow((n + 1) * 145.2 * v0 * v0 / (2 * Q), 1 / (n + 1));
    EXPECT_NEAR(model.strike(stamp, 3.5, 50).largest, z, 1e-9 * z) << alpha;
  }
}

TEST(GroundImpact, FormsOfStiffnessInAScenario) {
  const auto element = [](const std::string& stiffness) {
    const Loaded loaded = load_scenario(test::config("stamp"), {"machine.forces.clay.stiffness=" + stiffness});
    return loaded.scenario.machine->forces[0].element.get<mbd::GroundElement>();
  };
  const auto force = [&](const std::string& stiffness) {
    return mbd::plastic_force(element(stiffness).stiffness, 0.02, 2, 132);
  };
  EXPECT_NEAR(force("{power: 100 kN/m, depth exponent: 1}"), 1e5 * 2 * 0.02, 1e-9);
  EXPECT_NEAR(force("{table: [[10 mm, 90 kN/m], [30 mm, 120 kN/m]], speed exponent: 1}"), 105e3 * 2 * 0.02, 1e-9);
  EXPECT_NEAR(force("{formula: \"1e5*(z/0.01)^2*v*m/132\"}"), 1e5 * 4 * 2 * 0.02, 1e-6);
  const auto says = [&](const std::string& stiffness) { return message_of([&] { element(stiffness); }); };
  EXPECT_NE(says("{formula: \"1e5*x\"}").find("`x` is no name of a formula in z, v, m"), std::string::npos);
  EXPECT_NE(says("{power: 100 kN/m, depth exponent: -2}").find("must be in (-1, inf)"), std::string::npos);
  EXPECT_NE(says("{powr: 100 kN/m}").find("did you mean `power`"), std::string::npos);
}

/// Normal numbers with a fixed seed.
class Noise {
 public:
  explicit Noise(unsigned seed) : random_(seed) {}
  double times(double value, double spread) {  // Box and Muller: the same numbers with every library
    const auto uniform = [&] { return (static_cast<double>(random_()) + 0.5) / 4294967296.0; };
    return value * (1 + spread * std::sqrt(-2 * std::log(uniform())) * std::cos(2 * std::acos(-1.0) * uniform()));
  }

 private:
  std::mt19937 random_;
};

const double none = std::numeric_limits<double>::quiet_NaN();

TEST(ImpactFit, HuntCrossleyFromForcesAndRestitution) {
  const LoadedStudy truth = load_study("", with(ball, {"speeds=0.5 1 2 3 5 m/s"}));
  const LoadedStudy start = load_study("", {"model=hunt-crossley", "first.mass=0.1 kg"});
  for (const double spread : {0.0, 0.01}) {
    Noise noise(5);
    std::vector<Measured> data;
    for (const ImpactRow& row : strike_all(truth)) {
      const auto& e = row.closed;
      data.push_back({e.speed, noise.times(e.restitution, spread), noise.times(e.peak_force, spread), none,
                      noise.times(e.duration(), spread)});
    }
    const ImpactFit fit = fit_impact(start, data, {});
    ASSERT_EQ(fit.parameters.size(), 3U);
    const double exact[] = {0.1, 1.7135e10, 1.5};
    for (std::size_t k = 0; k < 3; ++k) {
      const FittedParameter& p = fit.parameters[k];
      SCOPED_TRACE(p.name);
      // Without noise to what the course of 24 samples leaves in the duration; with it within three half widths (99.99
      // %).
      if (spread == 0) {
        EXPECT_NEAR(p.value / exact[k], 1, 1e-6);
      }
      if (spread > 0) {
        EXPECT_LT(std::abs(std::log(p.value / exact[k])), 1.5 * std::log(p.high / p.low));
      }
    }
    EXPECT_LT(fit.spread, 2 * spread + 1e-6);
  }
}

/// An interval of 95 % holds the truth in 95 of 100 repetitions: 400 of them, standard deviation 1.1 %.
TEST(ImpactFit, IntervalsCoverTheTruthAsOftenAsTheySay) {
  const LoadedStudy start = load_study("", {"model=hunt-crossley", "first.mass=0.1 kg", "c=1e9 N/m^1.5"});
  int covered = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    Noise noise(seed);
    std::vector<Measured> data;
    for (const double v : {0.5, 1.0, 2.0, 3.0, 4.0, 5.0})
      data.push_back({v, noise.times(dem::impact::hunt_crossley_restitution(0.1 * v), 0.005), none, none, none});
    const FittedParameter b = fit_impact(start, data, {}).parameters[0];
    EXPECT_EQ(b.name, "b");
    covered += b.low < 0.1 && 0.1 < b.high ? 1 : 0;
  }
  EXPECT_NEAR(covered, 380, 18);  // four standard deviations
}

TEST(ImpactFit, MapOfTheEnergyEquivalentFollowsALaw) {
  const LoadedStudy loaded =
      load_study("", {"model=energy-equivalent", "S_y=200 MPa", "nu=0.3", "speeds=0.01 0.02 0.05 0.1 0.2 0.5 1 2 5 m/s",
                      "first={radius: 5 mm, density: 7800 kg/m^3, young: 100 GPa, poisson: 0}",
                      "fit to={model: jackson-green, S_y: 200 MPa, nu: 0.3}"});
  const ImpactFit fit = fit_impact(loaded, measured_of(loaded), {});
  // The two laws differ in form, most at the highest speed, 1500 V_c; the fitted map is nearer than the default.
  double usual = 0;
  for (const Measured& m : measured_of(loaded)) {
    const auto& map = std::get<dem::impact::EnergyEquivalent>(loaded.study.model);
    usual = std::max(usual, std::abs(map.restitution_at(pair_of(loaded.study), m.speed) / m.restitution - 1));
  }
  EXPECT_LT(fit.worst, 0.6 * usual);
  EXPECT_LT(fit.worst, 0.06);
  EXPECT_LT(fit.parameters[1].low, fit.parameters[1].value);
}

TEST(ImpactFit, RefusesWhatTheDataCannotTell) {
  const LoadedStudy start = load_study("", {"model=hunt-crossley", "first.mass=0.1 kg", "c=1e9 N/m^1.5", "b=0.1 s/m"});
  const std::vector<Measured> data{{1, 0.95, none, none, none}, {2, 0.9, none, none, none}};
  const auto says = [&](std::vector<std::string> free) { return message_of([&] { fit_impact(start, data, free); }); };
  EXPECT_NE(says({"b", "c"}).find("the data do not depend on c"), std::string::npos);
  EXPECT_NE(says({"q"}).find("`q` is no parameter"), std::string::npos);
  const test::RunDirectory directory;
  const auto file = [&](const std::string& text) {
    test::write_file(directory / "data.csv", text);
    const std::string message = message_of([&] { read_measured(directory / "data.csv"); });
    const std::size_t at = message.find("data.csv");
    return at == std::string::npos ? message : message.substr(at);
  };
  EXPECT_EQ(file("speed [m/s], restitution [1]\n1, 0.9\n2, 1.2\n"), "data.csv:3: restitution must not be above 1");
  EXPECT_EQ(file("speed [m/s], restitution [1]\n1, x\n").substr(0, 28), "data.csv:2: restitution = x:");
  EXPECT_EQ(file("speed [m], restitution [1]\n").substr(0, 23), "data.csv:1: speed = 1: ");
  EXPECT_NE(file("speed [m/s], force [N]\n")
                .find("data.csv:1: unknown column `force`; known here: speed, restitution, peak force"),
            std::string::npos);
  EXPECT_EQ(file("speed [m/s];restitution [1]\n1;0,9\n").substr(0, 43), "data.csv:1: has its fields separated by `;`");
}

TEST(ImpactFit, StiffnessOfTheGroundFromForces) {
  const LoadedStudy start =
      load_study("", {"model=ground-element", "first.mass=132 kg", "stiffness={power: 10 kN/m, deep from: 30 mm}"});
  GroundImpact truth;
  truth.stiffness =
      mbd::PowerStiffness{.K0 = 9e4, .z0 = 0.01, .v0 = 1, .alpha = 0.4, .beta = 0.06, .z1 = 0.03, .alpha_1 = -0.1};
  for (const double spread : {0.0, 0.02}) {
    Noise noise(3);
    const test::RunDirectory directory;
    std::string text = "speed [m/s], depth [mm], force [kN]\n";
    for (const double v : {1.0, 2.0, 3.0, 3.5})
      for (double z = 4e-3; z < 0.06; z += 4e-3) {
        // (G3) of docs/theory/impact.md: M a = m g - F, and F_s = m (g - a).
        const double spring = mbd::plastic_force(truth.stiffness, z, v, 132), a = (132 * 9.81 - spring) / 145.2;
        text += fmt::format("{}, {}, {}\n", v, 1e3 * z, 1e-3 * noise.times(132 * (9.81 - a), spread));
      }
    test::write_file(directory / "stamp.csv", text);
    const ImpactFit fit = fit_ground(start, directory / "stamp.csv");
    ASSERT_EQ(fit.parameters.size(), 4U) << "gamma is not varied and stays";
    const double exact[] = {9e4, 0.4, -0.1, 0.06};
    for (std::size_t k = 0; k < 4; ++k) {
      const FittedParameter& p = fit.parameters[k];
      SCOPED_TRACE(p.name);
      if (spread == 0) {
        EXPECT_NEAR(p.value, exact[k], 1e-9 * std::max(1.0, exact[k]));
      }
      if (spread > 0) {
        EXPECT_LT(std::abs(p.value - exact[k]), 0.75 * (p.high - p.low));
      }
    }
  }
}

}  // namespace
}  // namespace subsoil::sim::impact_test
