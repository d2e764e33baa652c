#include "libsim/studies/laboratory/repose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::sim {
namespace {

using std::numbers::pi;
constexpr double cell = 1.5;  // diameters

/// As many equal cells as go into a length, of 1.5 diameters or nearly so: a rest at the end would hold fewer grains
/// than the others, and its highest lies lower.
double cell_of(double length, double diameter) {
  return length / std::max(1.0, std::round(length / (cell * diameter)));
}

/// Highest top of each cell over the base; `along` turns its middle into a distance along the slope.
Tops tops_of(std::span<const dem::Sphere> spheres, double size_x, double size_z,
             const std::function<double(double x, double z)>& along) {
  std::map<std::pair<long, long>, double> highest;
  for (const dem::Sphere& s : spheres) {
    const std::pair key{std::lround(std::floor(s.x.x / size_x)), std::lround(std::floor(s.x.z / size_z))};
    const auto [place, fresh] = highest.emplace(key, s.x.y + s.r);
    if (!fresh) place->second = std::max(place->second, s.x.y + s.r);
  }
  Tops tops;
  for (const auto& [key, top] : highest) {
    tops.s.push_back(
        along((static_cast<double>(key.first) + 0.5) * size_x, (static_cast<double>(key.second) + 0.5) * size_z));
    tops.height.push_back(top);
  }
  return tops;
}

/// The sides over which grains run off, between two heights.
std::vector<dem::TriangleMesh> sides_of(const Tray& tray, double from, double to) {
  const auto upright = [&](const Vec3& corner, const Vec3& u) {
    return dem::rectangle_mesh(corner + Vec3{0, from, 0}, u, {0, to - from, 0});
  };
  const Vec3 along{tray.length, 0, 0}, across{0, 0, tray.width};
  std::vector<dem::TriangleMesh> out{upright(along, across)};
  if (!tray.heap) return out;
  out.push_back(upright({}, across));
  out.push_back(upright({}, along));
  out.push_back(upright(across, along));
  return out;
}

/// Lifts the gate clear of the grains and lets the slope come to rest.
void release(Specimen& specimen, int gate, double speed) {
  const double clear = specimen.top() * 1.05;
  for (double y = 0; y < clear; y += speed * specimen.dt()) {
    specimen.step();
    specimen.move(gate, {0, speed, 0});
  }
  specimen.bed().boundary(gate).active = false;
  specimen.bed().surfaces_changed();
  specimen.rest();
}

/// Where the mean tops at equal distance go from 0.15 to 0.8 of the height between foot and crest.
std::pair<double, double> flank_of(const Tops& tops, double foot, double bin) {
  std::map<long, std::pair<double, int>> profile;
  for (std::size_t i = 0; i < tops.s.size(); ++i) {
    auto& [sum, count] = profile[std::lround(std::floor(tops.s[i] / bin))];
    sum += tops.height[i], ++count;
  }
  const auto mean = [](const auto& entry) { return entry.second.first / entry.second.second; };
  double crest = foot;
  for (const auto& entry : profile) crest = std::max(crest, mean(entry));
  double from = 0, to = 0;
  for (const auto& entry : profile) {
    const double share = (mean(entry) - foot) / (crest - foot), s = static_cast<double>(entry.first) * bin;
    if (share > 0.8) break;  // the crest begins: what lies behind may be a plateau
    if (share < 0.15) from = s + bin;
    to = s + bin;
  }
  return {from, to};
}

/// How many of these places differ.
int distances_of(std::vector<double> s) {
  std::sort(s.begin(), s.end());
  const double apart = rounding_of_places(s);
  int count = s.empty() ? 0 : 1;
  for (std::size_t i = 1; i < s.size(); ++i) count += s[i] - s[i - 1] > apart ? 1 : 0;
  return count;
}

Outcome outcome_of(const Tops& tops, double from, double to) {
  Line line;
  Outcome out;
  out.values = {slope_of(tops, from, to, &line)};
  out.curve.columns = {{"distance", "m"}, {"height", "m"}, {"line", "m"}, {"counts", "1"}};
  for (std::size_t i = 0; i < tops.s.size(); ++i) {
    const bool counts = tops.s[i] >= from && tops.s[i] <= to;
    out.curve.rows.push_back({tops.s[i], tops.height[i], line.a + line.b * tops.s[i], counts ? 1.0 : 0.0});
  }
  std::sort(out.curve.rows.begin(), out.curve.rows.end());
  return out;
}

Outcome run_tray(const Repose& test, const Sample& sample, std::size_t packing) {
  const bool heap = test.form == Repose::Form::heap;
  const double d = sample.diameter, length = test.length.value_or((heap ? 20 : 18) * d);
  const Tray tray{length, heap ? length : test.width.value_or(6 * d), d, heap};
  const double depth = test.depth.value_or((heap ? 0.5 : 0.75) * length), high = 6 * depth + 40 * d;
  Specimen specimen(sample, std::sqrt(2 * sample.gravity * depth));
  specimen.surface("floor", dem::rectangle_mesh({}, {0, 0, tray.width}, {length, 0, 0}), Wall::rough);
  specimen.surface("edge", sides_of(tray, 0, tray.edge), Wall::rough);
  const int gate = specimen.surface("gate", sides_of(tray, tray.edge, high), Wall::smooth);
  if (!heap) {
    specimen.plane("back", {0, 0, 0}, {1, 0, 0}, Wall::smooth);
    specimen.plane("wall -z", {}, {0, 0, 1}, Wall::smooth);
    specimen.plane("wall +z", {0, 0, tray.width}, {0, 0, -1}, Wall::smooth);
  }
  specimen.bed().set_floor_drop(-d);  // what is below the tray does not come back
  specimen.fill({{0, 0, 0}, {length, depth, tray.width}}, depth, sample.seed + packing);
  specimen.cement();
  release(specimen, gate, test.lift.value_or(0.25 * sample.fall_speed()));
  return slope_on(tray, specimen.bed().spheres(), d);
}

constexpr int drum_sides = 24;

/// Inner face of a drum about the z axis, corners on the radius.
dem::TriangleMesh shell(double radius, double width) {
  std::vector<Vec3> corners;
  std::vector<dem::Triangle> triangles;
  for (int k = 0; k < drum_sides; ++k) {
    const double angle = 2 * pi * k / drum_sides;
    for (const double z : {-0.1 * width, 1.1 * width})
      corners.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    const auto a = static_cast<std::uint32_t>(2 * k), b = static_cast<std::uint32_t>(2 * ((k + 1) % drum_sides));
    triangles.push_back({a, b, b + 1});
    triangles.push_back({a, b + 1, a + 1});
  }
  return {std::move(corners), std::move(triangles)};
}

/// Loose grains inside the drum, from below, as many as fill its share once they lie.
dem::Grains loose_in_drum(const Sample& sample, double radius, double width, double share, std::uint64_t seed) {
  const double half = radius * std::cos(pi / drum_sides) - 0.6 * sample.diameter;
  dem::LoosePlacer placer({{-radius, -radius, 0}, {radius, radius, width}}, sample.sizes, sample.shares, seed,
                          {sample.density, sample.grain}, sample.clumps);
  // Space enough for several times the drum; from it those inside are taken, from the lowest up.
  const dem::Grains all = placer.grains_of_volume(2 * radius * 2 * radius * width, -radius);
  const double wanted = 0.6 * share * pi * radius * radius * width;
  dem::Grains in;
  double volume = 0;
  const auto is_inside = [&](const Vec3& at, double reach) {
    return std::hypot(at.x, at.y) + reach - 0.5 * sample.diameter <= half && volume <= wanted;
  };
  auto sphere = all.spheres.begin();
  auto clump = all.clumps.begin();
  while (sphere != all.spheres.end() || clump != all.clumps.end()) {
    if (clump == all.clumps.end() || (sphere != all.spheres.end() && sphere->position.y < clump->position.y)) {
      if (is_inside(sphere->position, sphere->radius))
        volume += dem::sphere_volume(sphere->radius), in.spheres.push_back(*sphere);
      ++sphere;
    } else {
      const dem::ClumpShape& shape = sample.shapes[static_cast<std::size_t>(clump->shape)];
      if (is_inside(clump->position, shape.reach)) volume += shape.volume, in.clumps.push_back(*clump);
      ++clump;
    }
  }
  return in;
}

Outcome run_drum(const Repose& test, const Sample& sample, std::size_t packing) {
  const double d = sample.diameter, radius = test.radius.value_or(8 * d), width = test.width.value_or(6 * d);
  const double speed = test.speed.value_or(std::sqrt(0.002 * sample.gravity / radius));
  Specimen specimen(sample, speed * radius);
  const int drum = specimen.surface("drum", shell(radius, width), Wall::rough);
  specimen.plane("wall -z", {}, {0, 0, 1}, Wall::smooth);
  specimen.plane("wall +z", {0, 0, width}, {0, 0, -1}, Wall::smooth);
  dem::add(specimen.bed(), loose_in_drum(sample, radius, width, test.share, sample.seed + packing));
  specimen.rest();
  specimen.cement();
  const double period = 2 * pi / speed, begin = test.lead * period, end = begin + test.turns * period;
  const int looks = std::max(8, static_cast<int>(test.turns * 120));
  Tops all;
  Outcome out;
  double sum = 0, next = begin;
  int count = 0;
  for (double t = 0; t < end; t += specimen.dt()) {
    specimen.step();
    specimen.turn(drum, {0, 0, speed});
    if (t < next) continue;
    next += (end - begin) / looks;
    const Tops now = tops_of(specimen.bed().spheres(), cell * d, cell_of(width, d), [](double x, double) { return x; });
    sum += slope_of(now, -0.5 * radius, 0.5 * radius), ++count;
    all = now;
  }
  out = outcome_of(all, -0.5 * radius, 0.5 * radius);
  out.values = {sum / count};
  return out;
}

}  // namespace

double slope_of(const Tops& tops, double from, double to, Line* line) {
  std::vector<double> s, height;
  for (std::size_t i = 0; i < tops.s.size(); ++i)
    if (tops.s[i] >= from && tops.s[i] <= to) s.push_back(tops.s[i]), height.push_back(tops.height[i]);
  if (s.size() < 6)
    throw std::runtime_error(fmt::format(
        "only {} places make the slope: it has run off, or stands upright; a larger base shows slopes of few grains, "
        "and what stands upright has no angle of repose",
        s.size()));
  if (const int distances = distances_of(s); distances < 3)
    throw std::runtime_error(
        fmt::format("the slope is seen at {} distance{} from its foot, cells of 1.5 diameters apart; a slope needs 3: "
                    "give a larger base or more depth",
                    distances, distances == 1 ? "" : "s"));
  const Line found = fit_robust_line(s, height);
  if (line) *line = found;
  return std::atan(found.b);
}

Outcome slope_on(const Tray& tray, std::span<const dem::Sphere> spheres, double diameter) {
  const double l = tray.length, w = tray.width, size = cell_of(l, diameter);
  const auto from_edge = [&](double x, double z) { return tray.heap ? std::min({x, l - x, z, w - z}) : l - x; };
  const Tops tops = tops_of(spheres, size, cell_of(w, diameter), from_edge);
  const auto [from, to] = flank_of(tops, tray.edge, size);
  return outcome_of(tops, from, to);
}

Outcome Repose::run(const Sample& sample, std::size_t packing) const {
  return form == Form::drum ? run_drum(*this, sample, packing) : run_tray(*this, sample, packing);
}

Findings Repose::findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const {
  Findings found;
  found.test = "repose";
  Number angle = numbers()[0];
  Chart chart;
  chart.x_label = form == Form::drum ? "from the drum's axis [mm]" : "from the edge [mm]";
  chart.y_label = form == Form::drum ? "above the drum's axis [mm]" : "height [mm]";
  chart.equal_scale = true;
  chart.height = 460;
  for (std::size_t p = 0; p < packings; ++p) {
    angle.values.push_back(outcomes[p].values[0]);
    found.curves.push_back(outcomes[p].curve);
    found.curves.back().name = fmt::format("packing-{}", p + 1);
    const SpecimenCurve& curve = outcomes[p].curve;
    const int colour = static_cast<int>(p);
    chart.curves.push_back({fmt::format("packing {}", p + 1), curve.column(0, 1e3), curve.column(1, 1e3),
                            ChartCurve::Style::dots, colour});
    ChartCurve line{
        fmt::format("{:.1f} deg", outcomes[p].values[0] * 180 / pi), {}, {}, ChartCurve::Style::line, colour};
    for (const std::vector<double>& row : curve.rows)
      if (row[3] > 0) line.x.push_back(row[0] * 1e3), line.y.push_back(row[2] * 1e3);
    chart.curves.push_back(std::move(line));
  }
  chart.title = fmt::format("angle of repose {:.1f} deg", angle.mean() * 180 / pi);
  found.numbers = {std::move(angle)};
  found.charts = {{"profile", std::move(chart)}};
  if (form == Form::drum && speed) {
    const double froude = *speed * *speed * radius.value_or(8 * sample.diameter) / sample.gravity;
    // Mellmann, Powder Technology 118 (2001) 251: rolling, with a flat surface, up to 0.01.
    if (froude > 0.01)
      found.diagnostics.push_back(fmt::format(
          "the drum turns at a Froude number of {:.2g}: from 0.01 on the surface curves, from 0.1 on grains "
          "fly, from 1 on they stay at the wall: this is no angle of repose; give a lesser `speed`",
          froude));
  }
  return found;
}

}  // namespace subsoil::sim
