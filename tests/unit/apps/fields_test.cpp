#include "libsim/post/fields.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libdem/bed.hpp"
#include "libsim/base/coarse_graining.hpp"
#include "libsim/io/hdf5.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/program_runs.hpp"

/// Coarse graining against what holds for any kernel of integral 1, and closed forms of a Gaussian.
namespace subsoil::sim::test::fields_test {
namespace {

using std::numbers::pi;
using Kind = FieldKernel::Kind;

double integral_of(const FieldKernel& kernel) {
  constexpr int n = 2000;
  double sum = 0;
  const double h = kernel.reach() / n;
  for (int k = 0; k < n; ++k) {
    const double r = (k + 0.5) * h;
    sum += 4 * pi * r * r * kernel(r * r) * h;
  }
  return sum;
}

/// The midpoint rule errs by h^2 r'' / 24: 1e-7 of smooth curves.
TEST(FieldKernel, HasIntegralOneAndEndsAtItsReach) {
  for (const Kind kind : {Kind::lucy, Kind::gaussian}) {
    const FieldKernel kernel(kind, 0.02);
    EXPECT_NEAR(integral_of(kernel), 1, 1e-6);
    EXPECT_EQ(kernel(kernel.reach() * kernel.reach()), 0);
    EXPECT_GT(kernel(0), kernel(1e-4));
  }
  EXPECT_DOUBLE_EQ(FieldKernel(Kind::lucy, 0.02).reach(), 0.04);
}

/// int exp(-(h^2 + t^2)/(2 w^2)) dt is an error function; Simpson with 2,000 points for Lucy.
TEST(FieldKernel, LineIntegralIsExact) {
  const double w = 0.02;
  const FieldKernel gauss(Kind::gaussian, w), lucy(Kind::lucy, w);
  const Vec3 a{-0.015, 0.004, 0}, b{0.025, 0.004, 0}, r{0, 0, 0.01};
  const double within = std::erf(3 / std::sqrt(2.0)) - 3 * std::sqrt(2 / pi) * std::exp(-4.5);
  const double across = std::exp(-(0.004 * 0.004 + 0.01 * 0.01) / (2 * w * w)) / (2 * pi * w * w);
  const double expected =
      across * 0.5 * (std::erf(0.025 / (w * std::sqrt(2.0))) + std::erf(0.015 / (w * std::sqrt(2.0)))) / 0.04 / within;
  EXPECT_NEAR(gauss.along(r, a, b), expected, 1e-6 * expected);
  double sum = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 apart = a + ((k + 0.5) / 2000) * (b - a) - r;
    sum += lucy(dem::dot(apart, apart)) / 2000;
  }
  EXPECT_NEAR(lucy.along(r, a, b), sum, 1e-5 * sum);
  EXPECT_EQ(lucy.along({1, 0, 0}, a, b), 0);
  EXPECT_NEAR(lucy.along(a, a, a), lucy(0), 1e-9) << "no length: the kernel itself";
}

struct Totals {
  double mass = 0;
  Vec3 momentum;
  Tensor kinetic{}, contact{};
};

Totals totals(const GrainFields& f, double spacing) {
  Totals t;
  const double volume = spacing * spacing * spacing;
  for (std::size_t i = 0; i < f.density.size(); ++i) {
    t.mass += f.density[i] * volume;
    t.momentum += (f.density[i] * volume) * f.velocity[i];
    for (std::size_t k = 0; k < 9; ++k)
      t.kinetic[k] += f.kinetic_stress[i][k] * volume, t.contact[k] += f.contact_stress[i][k] * volume;
  }
  return t;
}

FieldGrid cube(double half, double spacing) {
  FieldGrid grid;
  grid.low = {-half, -half, -half}, grid.spacing = {spacing, spacing, spacing};
  for (std::size_t& n : grid.n) n = static_cast<std::size_t>(std::ceil(2 * half / spacing)) + 1;
  return grid;
}

/// The kernel's integral is one; the sum over a grid of half its width is so within 3e-4 wherever the grain lies, and
/// the error falls with the fourth power or faster (Lucy's second derivative is continuous).
TEST(CoarseGraining, ConservesMassAndMomentum) {
  dem::test::Dice dice(3);
  std::vector<FieldGrain> grains;
  double mass = 0;
  Vec3 momentum;
  for (int k = 0; k < 40; ++k) {
    const FieldGrain g{.position = dice.ball(0.05), .velocity = dice.ball(1), .mass = dice.between(0.01, 0.1)};
    grains.push_back(g);
    mass += g.mass, momentum += g.mass * g.velocity;
  }
  std::vector<double> errors;
  for (const double spacing : {0.01, 0.005}) {
    CoarseGraining coarse(cube(0.1, spacing), FieldKernel(Kind::lucy, 0.02));
    for (const FieldGrain& g : grains) coarse.add(g);
    const Totals t = totals(coarse.finish(), spacing);
    errors.push_back(std::abs(t.mass / mass - 1));
    EXPECT_LT(dem::norm(t.momentum - momentum), 3e-4 * dem::norm(momentum) + 3e-4 * mass);
  }
  EXPECT_LT(errors[0], 3e-4);
  EXPECT_LT(errors[1], 3e-4 / 16);
}

/// Irving and Kirkwood: of two spheres int P dV = F b, whatever the kernel; midway between them a Gaussian has
/// F b erf(|b|/(2 sqrt(2) w))/(2 pi w^2 |b|).
TEST(CoarseGraining, StressOfTwoSpheres) {
  const Vec3 a{0.01, 0.002, 0}, b{-0.01, -0.002, 0.001}, force{30, 5, -2};
  const Vec3 branch = a - b;
  for (const Kind kind : {Kind::lucy, Kind::gaussian}) {
    CoarseGraining coarse(cube(0.09, 0.01), FieldKernel(kind, 0.02));
    coarse.add_contact(a, b, force);
    const GrainFields f = coarse.finish();
    const Totals t = totals(f, 0.01);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        EXPECT_NEAR(t.contact[static_cast<std::size_t>(3 * i + j)], force[i] * branch[j], 2e-3 * 30 * 0.02);
  }
  const double w = 0.02, length = dem::norm(branch);
  const double within = std::erf(3 / std::sqrt(2.0)) - 3 * std::sqrt(2 / pi) * std::exp(-4.5);
  FieldGrid point;
  point.low = 0.5 * (a + b), point.spacing = {1, 1, 1};
  CoarseGraining at(point, FieldKernel(Kind::gaussian, w));
  at.add_contact(a, b, force);
  const double phi = std::erf(length / (2 * std::sqrt(2.0) * w)) / (2 * pi * w * w * length) / within;
  EXPECT_NEAR(at.finish().contact_stress[0][0], force.x * branch.x * phi, 1e-6 * 30 * 0.02 * phi);
}

/// A simple cubic lattice of pitch d has m/d^3 everywhere: Lucy of width 2 d sees it as even within 3e-4.
TEST(CoarseGraining, DensityOfALatticeIsUniform) {
  const double d = 0.02, mass = 0.01;
  FieldGrid grid = cube(0.015, 0.007);
  CoarseGraining coarse(grid, FieldKernel(Kind::lucy, 2 * d));
  for (int i = -6; i <= 6; ++i)
    for (int j = -6; j <= 6; ++j)
      for (int k = -6; k <= 6; ++k)
        coarse.add({.position = {i * d, j * d, k * d}, .mass = mass, .volume = pi / 6 * d * d * d, .contacts = 6});
  const GrainFields f = coarse.finish();
  for (std::size_t k = 0; k < f.density.size(); ++k) {
    EXPECT_NEAR(f.density[k], mass / (d * d * d), 3e-4 * mass / (d * d * d));
    EXPECT_NEAR(f.solid_fraction[k], pi / 6, 3e-4);
    EXPECT_NEAR(f.coordination[k], 6, 1e-12);
  }
}

/// Two streams through each other at +-u: rho u^2 along them and no velocity; all at u: velocity u and no stress.
TEST(CoarseGraining, KineticStressIsOfTheSpreadOfVelocities) {
  for (const bool streams : {true, false}) {
    FieldGrid point;
    point.low = {}, point.spacing = {1, 1, 1};
    CoarseGraining coarse(point, FieldKernel(Kind::lucy, 0.02));
    for (const double side : {-1.0, 1.0})
      coarse.add({.position = {0, 0.01 * side, 0}, .velocity = {streams ? 2 * side : 2, 0, 0}, .mass = 0.1});
    const GrainFields f = coarse.finish();
    EXPECT_NEAR(f.velocity[0].x, streams ? 0 : 2, 1e-12);
    EXPECT_NEAR(f.kinetic_stress[0][0], streams ? 4 * f.density[0] : 0, 1e-9 * f.density[0]);
    EXPECT_NEAR(f.kinetic_stress[0][4], 0, 1e-9 * f.density[0]);
  }
}

/// A column without friction between smooth walls is at rest under rho g: over any level the stress carries the weight
/// of what is above it, int P_yy dA = g int rho dV above, exactly where the kernel does not reach the floor (there it
/// spreads the floor's force, too). Integrals are sums on a grid of half the width: 3e-4; the bed's rest motion and
/// what is left to settle: 0.3 %.
TEST(CoarseGraining, ColumnAtRestCarriesItsWeight) {
  using namespace dem::test;
  const double r = 0.01;
  dem::Bed bed(table(grains(2e5, 0.2, 0, 0)), quiet({0, -9.81, 0}));
  Dice dice(11);
  bed.add(loose_lattice({0, 0, 0}, 4, 12, 4, 2 * r * 1.001, r, 0.05, 0.01, dice));
  add_bin(bed, 8 * r * 1.001, 8 * r * 1.001);
  for (int n = 0; n < 60000; ++n) bed.step(4e-5);
  dem::Snapshot s;
  std::vector<dem::ContactRecord> contacts;
  bed.step(4e-5, {.snapshot = &s, .contacts = &contacts});
  const double w = 2 * r, h = 0.5 * w;
  FieldGrid grid;
  grid.spacing = {h, h, h}, grid.low = {-2 * w, -2 * w, -2 * w};
  grid.n = {17, 34, 17};
  CoarseGraining coarse(grid, FieldKernel(Kind::lucy, w));
  double top = 0, weight = 0;
  for (std::size_t i = 0; i < s.id.size(); ++i) {
    const double m = 1800 * dem::sphere_volume(s.radius[i]);
    coarse.add({.position = s.position[i], .velocity = s.velocity[i], .mass = m});
    top = std::max(top, s.position[i].y), weight += 9.81 * m;
  }
  for (const dem::ContactRecord& c : contacts)  // ids begin at 0 and nobody has left
    coarse.add_contact(s.position[c.i], c.at_surface ? c.point : s.position[c.j], c.force);
  ASSERT_LT(top + 2 * w, grid.low.y + h * 33);
  const GrainFields f = coarse.finish();
  // The stress at a level and the mass above it, both by the sum over points; half of the level's own layer is above.
  double above = 0;
  for (std::size_t j = grid.n[1]; j-- > 0;) {
    double carried = 0, layer = 0;
    for (std::size_t k = 0; k < grid.n[2]; ++k)
      for (std::size_t i = 0; i < grid.n[0]; ++i) {
        const std::size_t at = (k * grid.n[1] + j) * grid.n[0] + i;
        carried += f.contact_stress[at][4] * h * h, layer += f.density[at] * h * h * h;
      }
    above += 0.5 * layer;
    if (grid.low.y + h * static_cast<double>(j) > 2 * w) {
      EXPECT_NEAR(carried, 9.81 * above, 4e-3 * weight) << j;
    }
    above += 0.5 * layer;
  }
  EXPECT_NEAR(9.81 * above, weight, 3e-4 * weight);
}

/// The command over a run: what it writes adds up to the run's mass, and says what is not there.
TEST(Fields, OfARunAddUpToItsMass) {
  const RunDirectory dir;
  const std::string text = dir.scenario(small_pass);
  ASSERT_EQ(run_scenario(text, dir / "out", {"output.contact forces=yes", "output.every=50 ms"}), exit_ok);
  const FieldsReport all = write_fields({.run = dir / "out", .all = true});
  EXPECT_EQ(all.frames, 4U);
  EXPECT_TRUE(all.has_stress && all.has_velocity && all.has_contacts);
  const auto file = h5::open_file(dir / "out" / "fields.h5");
  const double mass = summary_of(dir / "out").at("soil").at("mass [kg]");
  for (const char* frame : {"/frames/000000", "/frames/000003"}) {
    double sum = 0;
    const std::string group = frame;
    for (const float rho : h5::read<float>(file, group + "/bulk density")) sum += rho;
    EXPECT_NEAR(sum * std::pow(all.grid.spacing.x, 3), mass, 1e-3 * mass) << frame;
    EXPECT_EQ(h5::shape(file, group + "/contact stress"),
              (std::vector<hsize_t>{all.grid.n[2], all.grid.n[1], all.grid.n[0], 9}));
  }
  const FieldsReport cut = write_fields({.run = dir / "out", .out = dir / "cut", .section = FieldSection{2, 0.0}});
  EXPECT_EQ(cut.grid.n[2], 1U);
  EXPECT_EQ(cut.frames, 1U);
  EXPECT_TRUE(std::filesystem::exists(dir / "cut.xdmf"));
  EXPECT_THROW(write_fields({.run = dir / "out", .times = {7.0}}), std::invalid_argument);
  EXPECT_EQ(test::message_of<std::invalid_argument>([&] {
              write_fields({.run = dir / "out", .out = dir / "aside", .section = FieldSection{2, 2.0}});
            }).find("--section z=2 m: is outside the bed, whose fields go from "),
            0U);
  EXPECT_THROW(write_fields({.run = dir.path()}), std::invalid_argument);
}

/// A kernel as wide as the spacing sums to the mass within 2 %, of each grain, and one
/// between the points to nothing: it is refused.
TEST(Fields, AKernelNarrowerThanTheGridIsRefused) {
  const RunDirectory dir;
  const std::string text = dir.scenario(small_pass);
  ASSERT_EQ(run_scenario(text, dir / "out", {"time.end=1 ms"}), exit_ok);
  const double mass = summary_of(dir / "out").at("soil").at("mass [kg]");
  const FieldsReport at_limit = write_fields({.run = dir / "out", .width = 10e-3, .spacing = 10e-3});
  double sum = 0;
  for (const float rho : h5::read<float>(h5::open_file(dir / "out" / "fields.h5"), "/frames/000000/bulk density"))
    sum += rho;
  EXPECT_NEAR(sum * std::pow(at_limit.grid.spacing.x, 3), mass, 0.02 * mass);
  const auto refused = [&](const FieldsRequest& request) {
    return test::message_of<std::invalid_argument>([&] { write_fields(request); });
  };
  const std::string narrow = refused({.run = dir / "out", .width = 1e-6});
  EXPECT_EQ(narrow.rfind("--width = 1e-06 m: is narrower than the grid, whose points are ", 0), 0U) << narrow;
  EXPECT_NE(narrow.find("or a --section: the whole bed has 2e+06 points at most"), std::string::npos) << narrow;
  EXPECT_NE(refused({.run = dir / "out", .width = 9e-3, .spacing = 10e-3}).find("or a smaller --spacing"),
            std::string::npos);
}

/// Clumps of three spheres at rest between smooth walls: at every level the stress carries what lies above it. 1 % of
/// the weight for the sum over points at half a width, and what still moves.
TEST(Fields, ClumpsAtRestCarryTheirWeight) {
  const RunDirectory dir;
  const std::string text = dir.scenario(
      "subsoil: 1\nmaterials: {a: {density: 2500 kg/m^3}}\n"
      "contacts: [{between: [a, a], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0}]\n"
      "soil:\n  container: {size: 50 150 50 mm, at: 0 0 0 m, material: a}\n"
      "  clumps: {tri: {spheres: [{at: 0 0 0 mm, radius: 5 mm}, {at: 6 0 0 mm, radius: 4 mm}, {at: 0 5 0 mm, radius: 4 "
      "mm}]}}\n"
      "  bed: {fill: random, material: a, clumps: [{shape: tri}], count: 60}\n"
      "time: {end: 1 ms}\noutput: {every: 1 ms, contact forces: yes, precision: double}\n");
  ASSERT_EQ(run_scenario(text, dir / "out"), exit_ok);
  const FieldsReport f = write_fields({.run = dir / "out", .width = 6e-3});
  const auto file = h5::open_file(dir / "out" / "fields.h5");
  const auto density = h5::read<float>(file, "/frames/000000/bulk density");
  const auto stress = h5::read<float>(file, "/frames/000000/contact stress");
  const double h = f.grid.spacing.x;
  const double weight = 9.81 * summary_of(dir / "out").at("soil").at("mass [kg]").get<double>();
  double above = 0;
  int levels = 0;
  for (std::size_t j = f.grid.n[1]; j-- > 0;) {
    double carried = 0, layer = 0;
    for (std::size_t k = 0; k < f.grid.n[2]; ++k)
      for (std::size_t i = 0; i < f.grid.n[0]; ++i) {
        const std::size_t at = (k * f.grid.n[1] + j) * f.grid.n[0] + i;
        carried += stress[9 * at + 4] * h * h, layer += density[at] * h * h * h;
      }
    above += 0.5 * layer;
    if (f.grid.low.y + h * static_cast<double>(j) > 12e-3) {
      EXPECT_NEAR(carried, 9.81 * above, 0.01 * weight) << j;
      ++levels;
    }
    above += 0.5 * layer;
  }
  EXPECT_GT(levels, 5);
}

/// Sum of a field of the last frame over the volume of its cells.
double integral_over_cells(const FieldsReport& report, const std::filesystem::path& h5, const std::string& field) {
  const auto file = h5::open_file(h5);
  const Vec3& apart = report.grid.spacing;
  double sum = 0;
  for (const float value : h5::read<float>(file, "/frames/000000/" + field))
    sum += (field == "porosity" ? 1 - value : value) * apart.x * apart.y * apart.z;
  return sum;
}

/// Two spheres a tenth of a millimetre apart are one grain of hardly more than a sphere's volume: a lens overlap of
/// depth h = 2 r - a is pi h^2 (6 r - h)/12.
TEST(Fields, MembersOfAClumpShareItsSolidVolume) {
  const RunDirectory dir;
  const std::string text = dir.scenario(
      "subsoil: 1\ngravity: 0 m/s^2\nmaterials: {a: {density: 2500 kg/m^3}}\n"
      "contacts: [{between: [a, a], law: linear, k_n: 5 kN/m, restitution: 0.4, mu: 0.5}]\n"
      "soil:\n  container: {size: 80 80 80 mm, at: 0 0 0 m, material: a}\n"
      "  clumps: {rod: {spheres: [{at: 0 0 0 mm, radius: 5 mm}, {at: 0 0 4 mm, radius: 5 mm}]}}\n"
      "  bed: {fill: particles, material: a, placed: [{shape: rod, position: 40 40 40 mm}]}\n"
      "time: {end: 1 ms}\noutput: {every: 1 ms, precision: double}\n");
  ASSERT_EQ(run_scenario(text, dir / "out"), exit_ok);
  const FieldsReport report = write_fields({.run = dir / "out"});
  const double r = 5e-3, h = 2 * r - 4e-3, solid = 2 * 4.0 / 3 * pi * r * r * r - pi * h * h * (6 * r - h) / 12;
  const std::filesystem::path fields = dir / "out" / "fields.h5";
  EXPECT_NEAR(integral_over_cells(report, fields, "porosity"), solid, 2e-3 * solid);
  EXPECT_NEAR(integral_over_cells(report, fields, "bulk density"), 2500 * solid, 2e-3 * 2500 * solid);
}

/// Between periodic sides the grid has whole parts of the period and each place once: sums are the bed's mass, whether
/// the spacing divides the period or not.
TEST(Fields, OfAPeriodicBedAddUpToItsMass) {
  const RunDirectory dir;
  const std::string text = dir.scenario(
      "subsoil: 1\nmaterials: {a: {density: 2500 kg/m^3}}\n"
      "contacts: [{between: [a, a], law: linear, k_n: 5 kN/m, restitution: 0.4, mu: 0.5}]\n"
      "soil:\n  container: {size: 80 100 80 mm, at: 10 -20 5 mm, material: a, periodic: [x, z]}\n"
      "  bed: {fill: lattice, material: a, radius: 5 mm, pitch: 10 mm, depth: 40 mm}\n"
      "time: {end: 1 ms}\noutput: {every: 1 ms, precision: double}\n");
  ASSERT_EQ(run_scenario(text, dir / "out"), exit_ok);
  const double mass = summary_of(dir / "out").at("soil").at("mass [kg]");
  for (const double spacing : {5e-3, 5.5e-3, 7e-3}) {
    const FieldsReport report = write_fields({.run = dir / "out", .spacing = spacing});
    EXPECT_NEAR(integral_over_cells(report, dir / "out" / "fields.h5", "bulk density"), mass, 5e-3 * mass) << spacing;
    EXPECT_NEAR(static_cast<double>(report.grid.n[0]) * report.grid.spacing.x, 0.08, 1e-12);
  }
}

TEST(Fields, LeaveOutWhatFramesDoNotHold) {
  const RunDirectory dir;
  const std::string text = dir.scenario(small_pass);
  ASSERT_EQ(run_scenario(text, dir / "out", {"time.end=10 ms", "output.columns=position"}), exit_ok);
  const FieldsReport report = write_fields({.run = dir / "out"});
  EXPECT_FALSE(report.has_stress || report.has_velocity || report.has_contacts);
  const auto file = h5::open_file(dir / "out" / "fields.h5");
  EXPECT_TRUE(h5::exists(file, "/frames/000000/porosity"));
  EXPECT_FALSE(h5::exists(file, "/frames/000000/velocity"));
}

}  // namespace
}  // namespace subsoil::sim::test::fields_test
