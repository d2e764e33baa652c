#include "libsim/studies/laboratory/penetrate.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::sim {
namespace {

using std::numbers::pi;
constexpr int sides = 32;
constexpr int rows_of_penetration = 300;

/// Closed cone, tip down at the origin's height less `high`; base at the origin.
dem::TriangleMesh cone_mesh(double radius, double high) {
  std::vector<Vec3> corners{{0, -high, 0}, {0, 0, 0}};
  std::vector<dem::Triangle> triangles;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2 * pi * k / sides;
    corners.push_back({radius * std::cos(angle), 0, radius * std::sin(angle)});
    const auto a = static_cast<std::uint32_t>(2 + k), b = static_cast<std::uint32_t>(2 + (k + 1) % sides);
    triangles.push_back({0, a, b});
    triangles.push_back({1, b, a});
  }
  return {std::move(corners), std::move(triangles)};
}

/// Slope of q, and k and n of its power law, over the rows from this depth on.
std::vector<double> fits(const SpecimenCurve& curve, double from) {
  std::vector<double> z, q, log_z, log_q;
  double sum = 0;
  for (const auto& row : curve.rows) {
    if (row[0] < from) continue;
    z.push_back(row[0]), q.push_back(row[2]), sum += row[2];
    if (row[0] > 0 && row[2] > 0) log_z.push_back(std::log(row[0])), log_q.push_back(std::log(row[2]));
  }
  if (log_z.size() < 2)
    throw std::runtime_error(fmt::format(
        "only {} rows of the curve below the depth `from` = {:.4g} m show a resistance: no means, no slope; a "
        "lesser `from` or a longer `path`",
        log_z.size(), from));
  const Line power = fit_line(log_z, log_q);
  return {sum / static_cast<double>(q.size()), fit_line(z, q).b, std::exp(power.a), power.b};
}

}  // namespace

Outcome Penetrate::run(const Sample& sample, std::size_t packing) const {
  const double d = sample.diameter, wide = diameter.value_or(4 * d), side = length.value_or(4 * wide);
  const double deep = depth.value_or(4 * wide), v = speed.value_or(0.5 * sample.fall_speed());
  const double way = path.value_or(1.5 * wide), begin = from.value_or(way / 3);
  const double high = tool == Tool::cone ? 0.5 * wide / std::tan(0.5 * angle) : 0.5 * wide;
  if (begin >= way)
    throw std::invalid_argument(
        fmt::format("`from` = {:.4g} m must be less than the path of {:.4g} m: means begin there", begin, way));
  if (wide >= side)
    throw std::invalid_argument(fmt::format(
        "the tool of {:.4g} m does not fit into the box of {:.4g} m: a lesser `diameter` or a greater `length`, four "
        "diameters for walls that do not matter",
        wide, side));
  if (way + (tool == Tool::cone ? high : 0.0) > deep - d)
    throw std::invalid_argument(
        fmt::format("the tool would come nearer than a diameter to the floor: base at {:.4g} m, bed "
                    "{:.4g} m deep, tool {:.4g} m high; a shorter path or a deeper bed",
                    way, deep, high));
  Specimen specimen(sample, v);
  specimen.box(side, side);
  specimen.fill({{}, {side, deep, side}}, deep, sample.seed + packing);
  specimen.cement();
  const double surface = dem::surface_height(specimen.bed().spheres(), {{}, {side, deep, side}}).mean;
  // The plate is a thick disk whose lower face is at its place.
  const int index =
      specimen.surface("tool",
                       tool == Tool::cone ? cone_mesh(0.5 * wide, high)
                                          : dem::cylinder_mesh({0, 0.5 * high, 0}, {0, 1, 0}, 0.5 * wide, high, sides),
                       Wall::rough);
  const double start = specimen.top() + 0.1 * d + (tool == Tool::cone ? high : 0.0);
  specimen.bed().boundary(index).pose.position = {0.5 * side, start, 0.5 * side};
  specimen.bed().boundary(index).pose_before = specimen.bed().boundary(index).pose;
  Outcome out;
  out.curve.columns = {{"depth", "m"}, {"force", "N"}, {"resistance", "Pa"}};
  const double area = 0.25 * pi * wide * wide;
  const long steps = std::max(1L, std::lround(way / rows_of_penetration / (v * specimen.dt())));
  for (double z = surface - start; z < way;) {
    double force = 0;
    for (long k = 0; k < steps; ++k) {
      specimen.step();
      force += specimen.force(index).y;
      specimen.move(index, {0, -v, 0});
    }
    force /= static_cast<double>(steps);
    const double now = surface - specimen.height(index);
    out.curve.rows.push_back({0.5 * (z + now), force, force / area});
    z = now;
  }
  out.values = fits(out.curve, begin);
  return out;
}

Findings Penetrate::findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const {
  Findings found;
  found.test = "penetrate";
  found.numbers = numbers();
  Chart chart{.title = tool == Tool::cone ? "cone penetration" : "plate sinkage",
              .x_label = "depth [mm]",
              .y_label = "resistance [kPa]",
              .curves = {}};
  for (std::size_t p = 0; p < packings; ++p) {
    for (std::size_t k = 0; k < found.numbers.size(); ++k) found.numbers[k].values.push_back(outcomes[p].values[k]);
    found.curves.push_back(outcomes[p].curve);
    found.curves.back().name = fmt::format("packing-{}", p + 1);
    chart.curves.push_back({fmt::format("packing {}", p + 1), outcomes[p].curve.column(0, 1e3),
                            outcomes[p].curve.column(2, 1e-3), ChartCurve::Style::line, static_cast<int>(p)});
  }
  found.charts = {{"depth-resistance", std::move(chart)}};
  if (diameter && *diameter < 2 * sample.diameter)
    found.diagnostics.push_back(fmt::format(
        "the tool of {:.3g} mm meets one grain of {:.3g} mm at a time: its resistance is that of grains, not "
        "of soil; a tool of 4 grains or more",
        *diameter * 1e3, sample.diameter * 1e3));
  if (const double n = found.numbers[3].mean(); !(n > 0))
    found.diagnostics.push_back(
        fmt::format("n = {:.2g}: the resistance does not rise with depth, so that k and n are no law of sinkage", n));
  return found;
}

}  // namespace subsoil::sim
