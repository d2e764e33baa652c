#include <numbers>
#include <set>

#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/verified.hpp"

/// Published cases as a user runs them: scenarios in configs/verification, and what the program writes of them.
namespace subsoil::sim::published_cases {
namespace {

using std::numbers::pi;
using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;

const std::string kField = "Scenarios";

/// A run of configs/verification/NAME.yaml and its frames.
class Finished {
 public:
  explicit Finished(const std::string& name) {
    EXPECT_EQ(test::run_scenario(test::config("verification/" + name), directory_ / "out"), exit_ok) << name;
    times_ = test::frame_times(directory_ / "out");
  }
  Series series() const { return read_series(directory_ / "out" / "series.csv"); }
  const std::vector<double>& times() const { return times_; }
  std::size_t frame_at(double time) const {
    std::size_t best = 0;
    for (std::size_t k = 0; k < times_.size(); ++k)
      if (std::abs(times_[k] - time) < std::abs(times_[best] - time)) best = k;
    EXPECT_NEAR(times_[best], time, 1e-9 + 1e-6 * time);
    return best;
  }
  /// x y z of a quantity of the spheres in a frame.
  std::vector<dem::Vec3> of(const std::string& quantity, std::size_t frame) const {
    char group[32];
    std::snprintf(group, sizeof group, "/frames/%06zu/", frame);
    const std::vector<double> flat = h5::read<double>(h5::open_file(directory_ / "out" / "run.h5"), group + quantity);
    std::vector<dem::Vec3> out;
    for (std::size_t i = 0; i + 2 < flat.size(); i += 3) out.push_back({flat[i], flat[i + 1], flat[i + 2]});
    return out;
  }

 private:
  test::RunDirectory directory_;
  std::vector<double> times_;
};

TEST(PublishedCases, EveryFileIsRunHere) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(subsoil::test::source_dir() + "/configs/verification"))
    files.insert(entry.path().stem());
  EXPECT_EQ(files, (std::set<std::string>{"chung-ooi-4", "cor-lammps", "mfix-dem01", "slip-to-roll", "turntable",
                                          "wet-release"}));
}

TEST(PublishedCases, ChungOoi4) {
  const Finished run("chung-ooi-4");
  const std::size_t last = run.times().size() - 1;
  const std::vector<dem::Vec3> first = run.of("velocity", 0), v = run.of("velocity", last), w = run.of("spin", last);
  ASSERT_EQ(v.size(), 13U);
  struct {
    std::size_t sphere;
    const char* angle;
    double e_t, omega, rebound;
  } const points[] = {{1, "10", .687, -213, -1.6}, {3, "20", .616, -511, -7.5}, {5, "30", .684, -617, -3.5},
                      {7, "40", .781, -545, 11.6}, {9, "60", .893, -357, 47.8}, {11, "80", .966, -126, 78.7}};
  const Verified row(kField, "configs/verification/chung-ooi-4.yaml",
                     "Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0, test 4");
  const char* const why = "as in the table of impacts";
  for (const auto& p : points) {
    const double v_t = first[p.sphere].x, e_t = v[p.sphere].x / v_t, spin = w[p.sphere].z;
    const double part = 0.02, patch = std::atan2(v[p.sphere].x + 2.5e-3 * spin, v[p.sphere].y);
    const std::string at = std::string(" at ") + p.angle + " deg";
    if (p.sphere == 1) {  // another convention than the paper's, as there
      row.compare("tangential restitution" + at, "1", e_t, p.e_t, part * p.e_t, why);
      row.compare("angular velocity" + at, "rad/s", spin, p.omega, 2.5 * part * p.e_t * v_t / 2.5e-3, why);
      row.compare("rebound angle of the contact point" + at, "deg", patch * 180 / pi, p.rebound, 0.5, why);
      continue;
    }
    row.near("tangential restitution" + at, "1", e_t, p.e_t, share(part), why);
    row.near("angular velocity" + at, "rad/s", spin, p.omega, absolute(2.5 * part * p.e_t * v_t / 2.5e-3), why);
    row.near("rebound angle of the contact point" + at, "deg", patch * 180 / pi, p.rebound, absolute(1.5), why);
  }
}

TEST(PublishedCases, SlipToRoll) {
  const Finished run("slip-to-roll");
  const Verified row(kField, "configs/verification/slip-to-roll.yaml",
                     "u = u0 - mu g t, omega = 5 mu g t/(2 r), then 5/7 u0");
  struct {
    double t, u, w;
    const char* at;
  } const points[] = {
      {0.4, 1.24, -160, "0.4"}, {0.7, 1.12, -280, "0.7"}, {1.0, 1.0, -400, "1.0"}, {1.2, 1, -400, "1.2"}};
  for (const auto& p : points) {
    const std::size_t frame = run.frame_at(p.t);
    row.near(std::string("speed at ") + p.at + " s", "m/s", run.of("velocity", frame)[0].x, p.u, absolute(2e-4),
             "first kick on the flat contact");
    row.near(std::string("angular velocity at ") + p.at + " s", "rad/s", run.of("spin", frame)[0].z, p.w, absolute(0.1),
             "moment arm r - delta, 7e-5 of omega");
  }
}

/// Of a ball laid down on the table, which moves as the table does there: v' = W e_y x v with W = Omega I/(I + m a^2),
/// at the moment arm a = r - m g/k_n of its friction.
TEST(PublishedCases, Turntable) {
  const Finished run("turntable");
  const Verified row(kField, "configs/verification/turntable.yaml",
                     "circle at 2/7 Omega, Weltner 1979, Am. J. Phys. 47, 984; moment arm r - delta");
  const double r = 0.02, spin = 2, start = 0.1, delta = 7800 * 4 * pi / 3 * r * r * r * 9.81 / 1e6;
  const double rate = spin * 0.4 / (0.4 + (1 - delta / r) * (1 - delta / r)), circle = spin * start / rate;
  for (const std::size_t frame : {6U, 12U, 18U, 22U}) {  // one for each 0.5 s, within a step
    const double t = run.times()[frame];
    const dem::Vec3 x = run.of("position", frame)[0];
    const double off =
        std::hypot(x.x - (start - circle + circle * std::cos(rate * t)), x.z + circle * std::sin(rate * t));
    row.near("distance from the circle's point at " + std::to_string(frame / 2) + " s", "m", off, 0, absolute(2e-6),
             "of second order in the step; an arm half a step late gives 2.6e-5 m at 11 s");
  }
}

TEST(PublishedCases, MfixDem01) {
  const Finished run("mfix-dem01");
  const Series series = run.series();
  const std::vector<double>& energy = series.at("soil.gravity");
  const double m = 2600 * 4.0 / 3 * pi * 1e-3, g = 9.81;
  std::vector<double> crests;
  for (std::size_t k = 1; k + 1 < energy.size(); ++k)
    if (energy[k] >= energy[k - 1] && energy[k] > energy[k + 1]) crests.push_back(energy[k] / (m * g));
  ASSERT_GE(crests.size(), 3U);
  const Verified row(kField, "configs/verification/mfix-dem01.yaml",
                     "MFiX VVUQ manual: hard sphere, (h0 - r) e^(2k) + r");
  // A contact lasts pi/omega, in which gravity adds g/omega to speeds of e^k 2.8 m/s; 6 mm at most.
  const double omega = std::sqrt(4e6 / m);
  for (int k = 1; k <= 3; ++k) {
    const double fall = std::sqrt(2 * g * 0.4) * std::pow(0.8, k);
    row.near("apex " + std::to_string(k), "m", crests[static_cast<std::size_t>(k - 1)],
             0.4 * std::pow(0.8, 2 * k) + 0.1, absolute(k * fall / omega),
             "gravity in contact adds g/omega to the speed, each time");
  }
}

TEST(PublishedCases, WetRelease) {
  const Finished run("wet-release");
  const double rest = 0.018, m_eff = 1800 * 4.0 / 3 * pi * 1e-6 / 2;
  const auto beyond = [&](std::size_t frame, std::size_t pair) {
    const std::vector<dem::Vec3> x = run.of("position", frame);
    return rest - norm(x[2 * pair + 1] - x[2 * pair]);
  };
  const double a = 1e4 / m_eff, b = 20 / m_eff, slow = b / 2 - std::sqrt(b * b / 4 - a), fast = b - slow;
  const Verified row(kField, "configs/verification/wet-release.yaml",
                     "overdamped pair and period of the two half swings, closed form");
  for (const int ms : {1, 2, 5}) {
    const double t = ms * 1e-3;
    row.near("creeping pair, overlap beyond rest after " + std::to_string(ms) + " ms", "m", beyond(run.frame_at(t), 0),
             1e-5 * (fast * std::exp(-slow * t) - slow * std::exp(-fast * t)) / (fast - slow), share(5e-3),
             "damping lags by half a step of 1 us");
  }
  double least = 1;
  for (std::size_t k = 0; k < run.times().size(); ++k) least = std::min(least, beyond(k, 0));
  EXPECT_GE(least, -1e-16) << "no overshoot";
  // Crossings of the rest overlap on the way out, between frames of 0.1 ms: four periods.
  std::vector<double> crossings;
  for (std::size_t k = 1; k < run.times().size(); ++k) {
    const double before = beyond(k - 1, 1), now = beyond(k, 1);
    if (before > 0 && now <= 0) crossings.push_back(run.times()[k] - 1e-4 * now / (now - before));
  }
  ASSERT_GE(crossings.size(), 4U);
  row.near("swinging pair, period", "s", (crossings[3] - crossings[0]) / 3,
           pi * std::sqrt(m_eff) * (1 / std::sqrt(1e4) + 1 / std::sqrt(7e3)), share(5e-4),
           "crossings between frames of 0.1 ms, straight where speed changes by 1 %");
}

TEST(PublishedCases, LammpsRestitution) {
  const Finished run("cor-lammps");
  const Verified row(kField, "configs/verification/cor-lammps.yaml",
                     "LAMMPS examples/granular/in.restitution, log of 4 Feb 2025");
  struct {
    double t, v, f;
    const char* at;
  } const points[] = {
      {3e-4, 0.69263807, -0.22744912, "0.3"}, {6e-4, -0.35144026, -0.2659288, "0.6"}, {1e-3, -0.79999999, 0, "1.0"}};
  for (const auto& p : points) {
    const std::size_t frame = run.frame_at(p.t);
    const char* const why = "damping lags by half a step of 10 ns";
    row.near(std::string("velocity at ") + p.at + " ms", "m/s", run.of("velocity", frame)[0].x, p.v, absolute(1e-5),
             why);
    row.near(std::string("force at ") + p.at + " ms", "N", run.of("force", frame)[0].x, p.f, absolute(1e-5), why);
  }
}

}  // namespace
}  // namespace subsoil::sim::published_cases
