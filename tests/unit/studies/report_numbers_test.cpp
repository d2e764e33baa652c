#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "libsim/base/replicates.hpp"
#include "libsim/post/statistics.hpp"
#include "libsim/report/draft_models.hpp"
#include "libsim/report/numbers.hpp"

/// The numbers of a report against what is known of made-up records and of the wedge models' limits.
namespace subsoil::sim::report_numbers_test {
namespace {

struct Record {
  std::vector<double> time, values;
};

/// x_{i+1} = a x_i + noise of unit variance: correlation time (1 + a)/(1 - a) rows.
Record correlated(double a, std::size_t rows, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  Record r;
  double x = noise(random) / std::sqrt(1 - a * a);
  for (std::size_t i = 0; i < rows; ++i) {
    r.time.push_back(1e-3 * static_cast<double>(i));
    r.values.push_back(x);
    x = a * x + noise(random);
  }
  return r;
}

TEST(Statistics, AreThoseOfTheWindowAlone) {
  Record r;
  for (int i = 0; i <= 10; ++i) r.time.push_back(0.1 * i), r.values.push_back(i);
  const WindowStatistics s = statistics(r.time, r.values, {0.3, 0.6, ""}, RowKind::equal);
  EXPECT_EQ(s.rows, 4U);
  EXPECT_DOUBLE_EQ(s.mean, 4.5);
  EXPECT_DOUBLE_EQ(s.least, 3);
  EXPECT_DOUBLE_EQ(s.largest, 6);
  EXPECT_DOUBLE_EQ(s.largest_time, 0.6);
  EXPECT_NEAR(s.deviation, std::sqrt(5.0 / 3), 1e-12);  // of 3, 4, 5, 6
  EXPECT_EQ(statistics(r.time, r.values, {2, 3, ""}, RowKind::equal).rows, 0U);
  EXPECT_TRUE(std::isnan(statistics(r.time, r.values, {2, 3, ""}, RowKind::equal).mean));
}

/// x = t over a window of length T: deviation T/sqrt(12). By the trapezium rule over n intervals the mean square is
/// T^2/12 (1 + 2/n^2).
TEST(Statistics, TheDeviationIsOverTime) {
  for (const int intervals : {4, 150}) {
    Record r;
    for (int i = 0; i <= 2 * intervals; ++i) r.time.push_back(1.5 * i / intervals), r.values.push_back(r.time.back());
    const WindowStatistics s = statistics(r.time, r.values, {0, 1.5, ""}, RowKind::instant);
    EXPECT_NEAR(s.deviation, 1.5 / std::sqrt(12) * std::sqrt(1 + 2.0 / (intervals * intervals)), 1e-12);
  }
}

/// The interval must hold the true mean 0 in about 95 % of records, also where rows are correlated; one that took rows
/// as independent would hold it in less than half of these.
TEST(Statistics, IntervalHoldsTheMeanOfCorrelatedRows) {
  int held = 0;
  constexpr int records = 300;
  for (unsigned seed = 1; seed <= records; ++seed) {
    const Record r = correlated(0.9, 2000, seed);
    const WindowStatistics s = statistics(r.time, r.values, {}, RowKind::equal);
    held += std::abs(s.mean) <= s.half_width ? 1 : 0;
  }
  // 285 expected, and up to 2 % more, since the largest error of all levels counts; chance 4 records.
  EXPECT_GT(held, 270);
  EXPECT_LT(held, 300);
}

/// A memory of a tenth of the record: rows as they are would hold the mean in a seventh of records.
TEST(Statistics, IntervalHoldsTheMeanOfALongMemory) {
  int held = 0;
  constexpr int records = 300;
  for (unsigned seed = 1; seed <= records; ++seed) {
    const Record r = correlated(0.95, 800, seed);
    const WindowStatistics s = statistics(r.time, r.values, {}, RowKind::equal);
    held += std::abs(s.mean) <= s.half_width ? 1 : 0;
  }
  EXPECT_GT(held, 265);  // 285 expected of an infinite record; 20 memories in it cost some per cent
}

/// Independent rows 1 ms apart, but for a tenth of the time in which there are fifty in a millisecond: these count with
/// their time, which is little, and an interval that counted rows would hold the mean in 60 % of records.
TEST(Statistics, IntervalHoldsTheMeanOfUnevenRows) {
  int held = 0;
  constexpr int records = 300;
  for (unsigned seed = 1; seed <= records; ++seed) {
    Record r = correlated(0, 5900, seed);
    for (std::size_t i = 0; i < r.time.size(); ++i) {
      const auto k = static_cast<double>(i);
      r.time[i] = i < 5000 ? 2e-5 * k : 0.1 + 1e-3 * (k - 5000);
    }
    const WindowStatistics s = statistics(r.time, r.values, {}, RowKind::instant);
    held += std::abs(s.mean) <= s.half_width ? 1 : 0;
  }
  EXPECT_GT(held, 265);  // 285 expected, chance 4 records
  EXPECT_LT(held, 300);
}

TEST(Statistics, ConstantHasNoWidthAndOneRowNoInterval) {
  const std::vector<double> time{0, 1, 2}, seven{7, 7, 7};
  EXPECT_EQ(statistics(time, seven, {}, RowKind::equal).half_width, 0);
  EXPECT_TRUE(std::isnan(statistics(time, seven, {0.5, 1.5, ""}, RowKind::equal).half_width));
}

/// Rows of unequal length: means since the row before add up to the integral whatever the rows are; instants of a
/// straight line have its mean by the trapezium rule.
TEST(Statistics, WeighRowsWithTheirTime) {
  const std::vector<double> time{0, 0.1, 0.4, 0.5, 1};
  std::vector<double> line, means{0};
  for (const double t : time) line.push_back(3 - 2 * t);
  const auto integral = [](double t) { return std::sin(7 * t); };
  for (std::size_t i = 1; i < time.size(); ++i)
    means.push_back((integral(time[i]) - integral(time[i - 1])) / (time[i] - time[i - 1]));
  EXPECT_NEAR(statistics(time, line, {}, RowKind::instant).mean, 2, 1e-15);
  EXPECT_NEAR(statistics(time, line, {0.1, 0.5, ""}, RowKind::instant).mean, 3 - 0.6, 1e-15);
  EXPECT_NEAR(statistics(time, means, {}, RowKind::mean).mean, integral(1), 1e-15);
  EXPECT_NEAR(statistics(time, means, {0.4, 1, ""}, RowKind::mean).mean, (integral(1) - integral(0.4)) / 0.6, 1e-14);
  // A window that begins within a row's interval takes what of it lies inside.
  EXPECT_NEAR(statistics(time, means, {0.45, 1, ""}, RowKind::mean).mean, (0.05 * means[3] + 0.5 * means[4]) / 0.55,
              1e-14);
  // So does one that ends there, and instants follow their straight line to both ends of the window.
  EXPECT_NEAR(statistics(time, means, {0.45, 0.7, ""}, RowKind::mean).mean, (0.05 * means[3] + 0.2 * means[4]) / 0.25,
              1e-14);
  const std::vector<double> high{0, 1, 9, 2, 3};
  EXPECT_EQ(statistics(time, high, {0.4, 1, ""}, RowKind::mean).largest, 3) << "the mean of 9 lies before";
  EXPECT_EQ(statistics(time, high, {0.4, 1, ""}, RowKind::instant).largest, 9);
  const WindowStatistics part = statistics(time, line, {0.2, 0.8, ""}, RowKind::instant);
  EXPECT_NEAR(part.mean, 3 - 2 * 0.5, 1e-14);
  EXPECT_EQ(part.largest, line[2]) << "extremes are those of rows in the window";
}

TEST(Spectrum, FindsTheLineUnderATrend) {
  Record r;
  for (int i = 0; i < 2000; ++i) {
    const double t = 1e-3 * i;
    r.time.push_back(t);
    r.values.push_back(100 * t + 3 * std::sin(2 * std::numbers::pi * 8 * t) + std::sin(2 * std::numbers::pi * 31 * t));
  }
  const SpectralLine line = strongest_line(r.time, r.values, {}, RowKind::instant);
  // The other sine, a third as strong and 46 lines away, pulls the fitted one by less than a hundredth of a line.
  EXPECT_NEAR(line.period, 0.125, 0.125 / 16 / 100);
  EXPECT_NEAR(line.amplitude, 3, 0.05);
  EXPECT_TRUE(std::isnan(strongest_line(r.time, r.values, {0, 0.01, ""}, RowKind::instant).period))
      << "ten rows tell no period";
}

// A window of any number of periods, whole or not, under a trend: the sine itself is found.
TEST(Spectrum, NeedsNoWholePeriods) {
  for (const double periods : {2.3, 3.5, 3.99, 10.07}) {
    Record r;
    const double period = 0.198692, step = periods * period / 700;
    for (int i = 0; i < 700; ++i) {
      r.time.push_back(0.1 + step * i);
      r.values.push_back(0.7 - 2 * r.time.back() +
                         0.2025 * std::sin(2 * std::numbers::pi * r.time.back() / period + 1));
    }
    const SpectralLine line = strongest_line(r.time, r.values, {}, RowKind::instant);
    EXPECT_NEAR(line.period, period, 1e-6 * period) << periods;
    EXPECT_NEAR(line.amplitude, 0.2025, 1e-6) << periods;
  }
}

/// Between two whole numbers of periods a line keeps 64 % of its amplitude: the weaker one was taken for it.
TEST(Spectrum, FindsTheStrongerOfTwoLines) {
  Record r, slow;
  for (int i = 0; i <= 1000; ++i) {
    const double t = 1e-3 * i, turns = 2 * std::numbers::pi * t;
    r.time.push_back(t), slow.time.push_back(t);
    r.values.push_back(13 * std::sin(10.5 * turns) + 10 * std::sin(6 * turns));
    slow.values.push_back(13 * std::sin(1.4 * turns));
  }
  // The other sine, 4.5 lines away, moves the fitted one by less than a tenth of a line.
  const SpectralLine line = strongest_line(r.time, r.values, {}, RowKind::instant);
  EXPECT_NEAR(line.period, 1 / 10.5, 0.1 / (10.5 * 10.5));
  EXPECT_NEAR(line.amplitude, 13, 0.5);
  EXPECT_TRUE(std::isnan(strongest_line(slow.time, slow.values, {}, RowKind::instant).period))
      << "1.4 periods are no two";
}

/// Rows 2 ms apart and later 10 ms: the driver's force of a body that swings at 7.3 and 3.1 Hz, F = m x''. Instants are
/// the sines themselves; means over a row are x' differences over its time.
TEST(Spectrum, RowsNeedNotBeEvenlySpaced) {
  const double w = 2 * std::numbers::pi * 7.3, slow = 2 * std::numbers::pi * 3.1, mass = 2;
  const auto velocity = [&](double t) {
    return 0.03 * w * std::cos(w * t + 0.4) + 0.01 * slow * std::cos(slow * t) + 0.2;
  };
  const auto force = [&](double t) {
    return -mass * (0.03 * w * w * std::sin(w * t + 0.4) + 0.01 * slow * slow * std::sin(slow * t));
  };
  std::vector<double> time, instants, means;
  for (int i = 0; i <= 400; ++i) {
    time.push_back(i <= 250 ? 2e-3 * i : 0.5 + 1e-2 * (i - 250));
    instants.push_back(force(time.back()));
    const double gap = i > 0 ? time.back() - time[time.size() - 2] : 0;
    means.push_back(i > 0 ? mass * (velocity(time.back()) - velocity(time.back() - gap)) / gap : 0);
  }
  // The other sine, 6 % as strong and 8 lines away, moves the fitted one by less than a hundredth of a line of 2 s.
  const double amplitude = mass * 0.03 * w * w, period = 1 / 7.3;
  const SpectralLine line = strongest_line(time, instants, {}, RowKind::instant);
  EXPECT_NEAR(line.period, period, 0.01 * period * period / 2);
  EXPECT_NEAR(line.amplitude, amplitude, 0.005 * amplitude);
  // Means of 10 ms are smaller than the sine by (w 10 ms)^2/24 = 0.9 %.
  const SpectralLine of_means = strongest_line(time, means, {}, RowKind::mean);
  EXPECT_NEAR(of_means.period, period, 0.01 * period * period / 2);
  EXPECT_NEAR(of_means.amplitude, amplitude, 0.015 * amplitude);
}

/// Columns of a drum that turns steadily in place: what is left beside the trend is rounding, which has no period.
TEST(Spectrum, OfAConstantOrAStraightLineThereIsNone) {
  Record still, held, turning, swinging;
  for (int i = 0; i <= 300; ++i) {
    const double t = 1e-3 * i;
    for (Record* r : {&still, &held, &turning, &swinging}) r->time.push_back(t);
    still.values.push_back(-0.02);
    held.values.push_back((i % 7 - 3) * 1e-17);  // a coordinate that a guide holds at 0
    turning.values.push_back(-5 * t * (1 + (i % 3) * 2e-16));
    swinging.values.push_back(-5 * t + 1e-9 * std::sin(2 * std::numbers::pi * 20 * t));
  }
  for (const Record& r : {still, held, turning})
    EXPECT_TRUE(std::isnan(strongest_line(r.time, r.values, {}, RowKind::instant).period));
  EXPECT_NEAR(strongest_line(swinging.time, swinging.values, {}, RowKind::instant).period, 0.05, 1e-6);
}

TEST(Student, HasTheTablesValues) {
  EXPECT_NEAR(student_t(2), 4.302652730, 1e-8);
  EXPECT_NEAR(student_t(1e6), 1.959966, 1e-5);
}

/// A wide, smooth, vertical plate: Rankine's passive pressure, Kp = tan^2(45 deg + phi/2), rupture at 45 deg - phi/2.
TEST(McKyesAli, IsRankineForAWideSmoothPlate) {
  const double phi = 30 * std::numbers::pi / 180, kp = std::pow(std::tan(std::numbers::pi / 4 + phi / 2), 2);
  const double width = 1e6, depth = 0.3, up = std::numbers::pi / 2;
  const WedgeSoil heavy{.density = 1500, .friction = phi};
  // The rupture angle is sought in steps of 0.045 deg, and the force is flat about its minimum.
  EXPECT_NEAR(mckyes_ali(heavy, width, depth, up) / width, 0.5 * kp * 1500 * 9.81 * depth * depth, 0.01);
  EXPECT_NEAR(mckyes_ali_rupture(heavy, width, depth, up), std::numbers::pi / 4 - phi / 2, 1e-3);
  const WedgeSoil sticky{.density = 1e-9, .cohesion = 1000, .friction = phi};
  EXPECT_NEAR(mckyes_ali(sticky, width, depth, up) / width, 2 * 1000 * depth * std::sqrt(kp), 0.1);
}

constexpr double degree = std::numbers::pi / 180;

/// A wide tool in soil without cohesion: Coulomb's passive force at delta to the tool's normal,
///   P = K rho g d^2/2,  K = sin^2(a - phi)/(sin^2 a sin(a + delta) (1 - sqrt(sin(phi + delta) sin phi/(sin(a + delta)
///   sin a)))^2).
TEST(McKyesAli, IsCoulombForAWideTool) {
  const double width = 1e6, depth = 0.05, weight = 1461 * 9.81 * depth * depth;
  for (const double rake : {60 * degree, 75 * degree, 90 * degree})
    for (const double phi : {25 * degree, 32 * degree})
      for (const double delta : {0.0, 18 * degree, 25 * degree}) {
        const double root =
            std::sqrt(std::sin(phi + delta) * std::sin(phi) / (std::sin(rake + delta) * std::sin(rake)));
        const double k = std::pow(std::sin(rake - phi) / (std::sin(rake) * (1 - root)), 2) / std::sin(rake + delta);
        const double horizontal = 0.5 * k * weight * std::sin(rake + delta);
        const WedgeSoil soil{.density = 1461, .friction = phi, .wall_friction = delta};
        // The force is flat about its least, and steps of the rupture angle are 8e-4 rad.
        EXPECT_NEAR(mckyes_ali(soil, width, depth, rake) / width, horizontal, 1e-5 * horizontal)
            << rake / degree << ' ' << phi / degree << ' ' << delta / degree;
      }
}

/// Draft from the balance of the wedge's forces, horizontal and vertical, solved for the tool's force and the ground's;
/// crescents make weight larger by 1 + 2 s/(3 w) and cohesion by 1 + s/w.
double draft_by_statics(const WedgeSoil& soil, double width, double depth, double rake) {
  const double a = rake + soil.wall_friction, weight = soil.density * soil.gravity;
  // P (sin a, cos a) + R (-sin b, cos b) = -(along, up): of what else pushes the wedge, b = rupture + phi.
  const auto tool = [&](double rupture, double along, double up) {
    const double b = rupture + soil.friction;
    return -(along * std::cos(b) + up * std::sin(b)) / (std::sin(a) * std::cos(b) + std::cos(a) * std::sin(b));
  };
  double least = 1e300, force = 0;
  for (int i = 1; i < 100000; ++i) {
    const double rupture = 0.5 * std::numbers::pi * i / 100000;
    const double foot = depth / std::tan(rake), length = foot + depth / std::tan(rupture);
    const double aside = std::sqrt(std::fmax(0.0, length * length - foot * foot)) / width;
    const double by_weight = tool(rupture, 0, -0.5 * weight * depth * length) * (1 + 2 * aside / 3);
    if (length <= 0 || by_weight < 0 || by_weight >= least) continue;
    least = by_weight;
    const double cohesion = soil.cohesion * depth, adhesion = soil.adhesion * depth;
    force = by_weight + tool(rupture, -cohesion / std::tan(rupture), -cohesion) * (1 + aside) +
            tool(rupture, adhesion / std::tan(rake), -adhesion);
  }
  return width * (force * std::sin(a) + soil.adhesion * depth / std::tan(rake));
}

TEST(McKyesAli, BalancesTheForcesOnTheWedge) {
  struct Case {
    double cohesion, phi, delta, adhesion, rake, draft;  // Pa, deg, deg, Pa, deg, N; 0: none given
  };
  for (const Case& c :
       {Case{0.1, 32, 0, 0, 90, 4.57420}, Case{0.1, 32, 18, 0, 90, 12.0196}, Case{0.1, 20, 20, 0, 90, 5.71959},
        Case{0.1, 32, 31, 0, 90, 30.3573}, Case{2e3, 32, 25, 0, 90, 184.831}, Case{4e6, 32, 18, 0, 90, 202128},
        Case{2e3, 32, 20, 500, 65, 0}, Case{3e3, 25, 15, 1000, 110, 0}}) {
    const WedgeSoil soil{.density = 1461,
                         .cohesion = c.cohesion,
                         .friction = c.phi * degree,
                         .wall_friction = c.delta * degree,
                         .adhesion = c.adhesion};
    const double draft = draft_by_statics(soil, 0.03, 0.05, c.rake * degree);
    // Cohesion's part follows the rupture angle, which is right to half a step, 4e-4 rad.
    EXPECT_NEAR(mckyes_ali(soil, 0.03, 0.05, c.rake * degree), draft, 5e-4 * draft) << c.phi << ' ' << c.delta;
    if (c.draft > 0) {
      EXPECT_NEAR(draft, c.draft, 1e-4 * c.draft);
    }
  }
}

TEST(McKyesAli, CrescentsMakeANarrowToolHeavierPerWidth) {
  const WedgeSoil soil{.density = 1500, .cohesion = 5e3, .friction = 0.5, .wall_friction = 0.3};
  EXPECT_GT(mckyes_ali(soil, 0.05, 0.3, 1.0) / 0.05, 2 * mckyes_ali(soil, 5, 0.3, 1.0) / 5);
  WedgeSoil stronger = soil;
  stronger.cohesion *= 2;
  EXPECT_GT(mckyes_ali(stronger, 0.05, 0.3, 1.0), mckyes_ali(soil, 0.05, 0.3, 1.0));
}

/// D497 for a depth of 30 cm at 5 km/h: 30 (226 + 1.8 25) = 8130 N in fine soil.
TEST(Asabe, SpansItsSoilsAndItsScatter) {
  const Band band = asabe_subsoiler(0.30, 5 / 3.6);
  EXPECT_NEAR(band.high, 1.5 * 8130, 1e-6);
  EXPECT_NEAR(band.low, 0.5 * 0.45 * 8130, 1e-6);
}

/// A derivative has no value at its first row: mean and extremes are of the others.
TEST(Statistics, RowsWithoutAValueDoNotCount) {
  const double nan = std::nan("");
  const std::vector<double> time{0, 1, 2, 3}, slope{nan, 1, 3, 2}, nothing{nan, nan, nan, nan};
  for (const RowKind kind : {RowKind::instant, RowKind::mean, RowKind::equal}) {
    const WindowStatistics s = statistics(time, slope, {0, 3, ""}, kind);
    EXPECT_EQ(s.rows, 3U);
    EXPECT_EQ(s.least, 1);
    EXPECT_EQ(s.largest, 3);
    EXPECT_EQ(s.largest_time, 2);
    EXPECT_NEAR(s.mean, 2, 1e-15) << "(1 + 3 + 2)/3, and by trapezia (1 + 3 + 2/2)/2.5";
    EXPECT_EQ(statistics(time, nothing, {0, 3, ""}, kind).rows, 0U);
  }
}

/// Formulas of draft stand beside that of a tool that is drawn along, and not of one that turns in place.
TEST(ModelBands, AreOfToolsThatTravel) {
  RunFolder run;
  run.series = Series{{{"time", "s"}, {"draft", "N"}}, {{0, 0.1, 0.2}, {1, 2, 3}}};
  run.summary = Json{{"soil", {{"bulk density [kg/m3]", 1461.0}}}};
  ToolPath tool;
  tool.depth = {0.05, 0.05}, tool.width = 0.03;
  tool.rake_low = tool.rake_high = std::numbers::pi / 2;
  tool.shanks = {{.from = 0, .until = 0.03, .depth = 0.05, .rake_low = tool.rake_low, .rake_high = tool.rake_low}};
  const SoilStrength strength{.cohesion = 100, .friction = 32 * degree, .wall_friction = {}};
  for (const double travel : {0.002, 0.3}) {
    tool.travel = travel, tool.speed = travel / 0.2;
    const std::vector<ModelBand> bands = model_bands(run, tool, strength);
    ASSERT_EQ(bands.size(), 2U);
    for (const ModelBand& m : bands) {
      EXPECT_EQ(m.band.has_value(), travel > 0.05) << m.name;
      EXPECT_EQ(m.text.find("a tool that travels") != std::string::npos, travel < 0.05) << m.text;
    }
  }
}

/// Boxes on one body whose vertices are known at every sample.
class Boxes final : public SurfaceSamples {
 public:
  using Place = std::function<std::array<double, 3>(double t, std::array<double, 3> corner)>;
  Boxes(std::vector<double> times, const std::vector<std::array<double, 6>>& boxes, Place place)
      : times_(std::move(times)), place_(std::move(place)) {
    for (const auto& b : boxes) {
      FrameSurface& s = surfaces_.emplace_back();
      s.name = "box" + std::to_string(surfaces_.size()), s.moves = true;
      for (int k = 0; k < 8; ++k)
        for (std::size_t d = 0; d < 3; ++d) s.vertices.push_back(static_cast<float>(b[2 * d + ((k >> d) & 1)]));
      for (const auto& q :
           {std::array{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}})
        s.triangles.push_back({q[0], q[1], q[2]}), s.triangles.push_back({q[0], q[2], q[3]});
    }
  }
  const std::vector<double>& times() const override { return times_; }
  const std::vector<FrameSurface>& surfaces() const override { return surfaces_; }
  std::vector<double> surface(std::size_t sample, const FrameSurface& s) const override {
    std::vector<double> out;
    for (std::size_t i = 0; i + 2 < s.vertices.size(); i += 3)
      for (const double x : place_(times_[sample], {s.vertices[i], s.vertices[i + 1], s.vertices[i + 2]}))
        out.push_back(x);
    return out;
  }

 private:
  std::vector<double> times_;
  Place place_;
  std::vector<FrameSurface> surfaces_;
};

std::map<std::string, std::string> one_body(const SurfaceSamples& of) {
  std::map<std::string, std::string> out;
  for (const FrameSurface& s : of.surfaces()) out[s.name] = "tool";
  return out;
}

/// Of a rotor the forward speed, wherever the record ends: not the way of the blade that is the lowest by then.
TEST(ToolPath, ARotorTravelsAsItsAxis) {
  const double speed = -0.4, turning = 20;
  for (const double end : {0.05, 0.1, 1.1}) {
    const Boxes cross({0, 0.5 * end, end},
                      {{-0.13, 0.13, -0.006, 0.006, -0.03, 0.03}, {-0.006, 0.006, -0.13, 0.13, -0.03, 0.03}},
                      [&](double t, std::array<double, 3> c) {
                        const double a = turning * t;
                        return std::array{c[0] * std::cos(a) - c[1] * std::sin(a) + speed * t,
                                          c[0] * std::sin(a) + c[1] * std::cos(a) + 0.08, c[2]};
                      });
    const auto tool = tool_path(cross, 0, one_body(cross));
    ASSERT_TRUE(tool);
    EXPECT_NEAR(tool->speed, std::abs(speed), 1e-5) << "to the digits of a float";
    EXPECT_EQ(tool->direction, -1);
  }
}

/// Two shanks with a gap are two tools: the formula's draft is the sum of both, and not that of one as wide as all.
TEST(ToolPath, ShanksApartAreToolsOfTheirOwn) {
  const double w = 0.025;
  const auto along = [](double t, std::array<double, 3> c) { return std::array{c[0] + 0.5 * t, c[1], c[2]}; };
  const Boxes two(
      {0, 1}, {{0, 0.03, -0.1, 0.2, -0.05 - w / 2, -0.05 + w / 2}, {0, 0.03, -0.1, 0.2, 0.05 - w / 2, 0.05 + w / 2}},
      along);
  const Boxes one({0, 1}, {{0, 0.03, -0.1, 0.2, -w / 2, w / 2}}, along);
  const auto both = tool_path(two, 0, one_body(two)), single = tool_path(one, 0, one_body(one));
  ASSERT_TRUE(both && single);
  ASSERT_EQ(both->shanks.size(), 2U);
  for (const Shank& shank : both->shanks) EXPECT_NEAR(shank.width(), w, 1e-6);
  EXPECT_NEAR(both->width, 0.1 + w, 1e-6);
  RunFolder run;
  run.series = Series{{{"time", "s"}, {"draft", "N"}}, {{0, 0.5, 1}, {1, 2, 3}}};
  run.summary = Json{{"soil", {{"bulk density [kg/m3]", 1461.0}}}};
  const SoilStrength strength{.cohesion = 100, .friction = 32 * degree, .wall_friction = {}};
  const auto of_two = model_bands(run, both, strength), of_one = model_bands(run, single, strength);
  for (std::size_t k = 0; k < 2; ++k) {
    ASSERT_TRUE(of_two[k].band && of_one[k].band) << of_two[k].text;
    EXPECT_NEAR(of_two[k].band->high, 2 * of_one[k].band->high, 1e-4 * of_two[k].band->high);
    EXPECT_NEAR(of_two[k].band->low, 2 * of_one[k].band->low, 1e-4 * of_two[k].band->low);
  }
}

/// Each has its own depth and rake: the rake of all was taken from the tip of the deeper one to the front of the other.
TEST(ToolPath, AShankBehindHasARakeOfItsOwn) {
  const auto along = [](double t, std::array<double, 3> c) { return std::array{c[0] + 0.5 * t, c[1], c[2]}; };
  const Boxes two({0, 1}, {{0, 0.02, -0.05, 0.2, 0.035, 0.065}, {-0.03, -0.01, -0.06, 0.2, -0.065, -0.035}}, along);
  const auto tool = tool_path(two, 0, one_body(two));
  ASSERT_TRUE(tool);
  ASSERT_EQ(tool->shanks.size(), 2U);
  EXPECT_NEAR(tool->shanks[0].depth, 0.06, 1e-6);
  EXPECT_NEAR(tool->shanks[1].depth, 0.05, 1e-6);
  for (const double rake : {tool->rake_low, tool->rake_high}) EXPECT_NEAR(rake, std::numbers::pi / 2, 1e-4);
  RunFolder run;
  run.series = Series{{{"time", "s"}, {"draft", "N"}}, {{0, 0.5, 1}, {1, 2, 3}}};
  run.summary = Json{{"soil", {{"bulk density [kg/m3]", 1461.0}}}};
  const SoilStrength strength{.cohesion = 100, .friction = 32 * degree, .wall_friction = {}};
  const WedgeSoil soil{.density = 1461,
                       .cohesion = strength.cohesion,
                       .friction = strength.friction,
                       .wall_friction = 2.0 / 3 * strength.friction};
  const auto bands = model_bands(run, tool, strength);
  const auto wedge = std::find_if(bands.begin(), bands.end(),
                                  [](const ModelBand& m) { return m.name.find("McKyes") != std::string::npos; });
  ASSERT_TRUE(wedge != bands.end() && wedge->band);
  const double both =
      mckyes_ali(soil, 0.03, 0.06, std::numbers::pi / 2) + mckyes_ali(soil, 0.03, 0.05, std::numbers::pi / 2);
  EXPECT_NEAR(wedge->band->high, both, 1e-3 * both);
  EXPECT_NE(wedge->text.find("depth 60 + 50 mm"), std::string::npos) << wedge->text;
}

}  // namespace
}  // namespace subsoil::sim::report_numbers_test
