#include "libsim/post/furrow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "libsim/base/coarse_graining.hpp"
#include "libsim/base/periodic_images.hpp"

namespace subsoil::sim {
namespace {

/// Spheres before and after, by their row before.
struct Displaced {
  FrameSpheres before, after;
  std::vector<std::ptrdiff_t> row_after;  ///< -1: gone
};

/// Without fibres, which lie on the surface and are none of it.
FrameSpheres soil_of(const FramesFile& file, std::size_t frame) {
  FrameSpheres all = file.spheres(frame, false);
  if (file.fibre().empty()) return all;
  FrameSpheres out;
  for (std::size_t i = 0; i < all.index.size(); ++i) {
    if (file.fibre()[all.index[i]] >= 0) continue;
    out.index.push_back(all.index[i]);
    out.position.insert(out.position.end(), &all.position[3 * i], &all.position[3 * i] + 3);
  }
  return out;
}

Displaced displaced(const FramesFile& file) {
  const std::size_t last = file.times().size() - 1;
  if (file.is_moving_bed()) {  // what the window held at first is gone
    Displaced d{file.undisturbed(last), file.spheres(last, false), {}};
    for (std::size_t i = 0; i < d.before.index.size(); ++i) d.row_after.push_back(static_cast<std::ptrdiff_t>(i));
    return d;
  }
  Displaced d{soil_of(file, 0), soil_of(file, file.times().size() - 1), {}};
  std::vector<std::ptrdiff_t> row(file.particles(), -1);
  for (std::size_t i = 0; i < d.after.index.size(); ++i) row[d.after.index[i]] = static_cast<std::ptrdiff_t>(i);
  for (const std::uint32_t index : d.before.index) d.row_after.push_back(row[index]);
  return d;
}

/// What lies along z along x, and the other way round: a mirror image, of which a cross-section says the same.
void swap_axes(FrameSpheres& s) {
  for (std::size_t i = 0; i + 2 < s.position.size(); i += 3) std::swap(s.position[i], s.position[i + 2]);
}
dem::PeriodicCell swapped(dem::PeriodicCell cell) {
  std::swap(cell.low.x, cell.low.z), std::swap(cell.length.x, cell.length.z);
  return cell;
}

/// Those that have come in on the other side are where they would be beyond their own.
Displaced unwrapped(Displaced d, const dem::PeriodicCell& cell) {
  if (!cell.any()) return d;
  for (std::size_t i = 0; i < d.before.index.size(); ++i) {
    if (d.row_after[i] < 0) continue;
    const float* p = &d.before.position[3 * i];
    float* q = &d.after.position[3 * static_cast<std::size_t>(d.row_after[i])];
    const Vec3 way = cell.shortest({double{q[0]} - p[0], double{q[1]} - p[1], double{q[2]} - p[2]});
    for (int k = 0; k < 3; ++k) q[k] = static_cast<float>(double{p[k]} + way[k]);
  }
  return d;
}

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double v) { low = std::min(low, v), high = std::max(high, v); }
};

/// Height of the surface per column of z, mean over columns of x.
std::vector<double> heights(const FramesFile& file, const FrameSpheres& s, const Furrow& f) {
  const auto nx = static_cast<std::size_t>(std::max(1.0, std::floor((f.until - f.from) / f.cell)));
  const double dx = (f.until - f.from) / static_cast<double>(nx);
  std::vector<double> top(nx * f.columns, -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < s.index.size(); ++i) {
    const double x = s.position[3 * i], z = s.position[3 * i + 2];
    if (x < f.from || x >= f.until) continue;
    if (z < f.z0) continue;
    const auto column = std::min(f.columns - 1, static_cast<std::size_t>((z - f.z0) / f.column));
    const auto ix = std::min(nx - 1, static_cast<std::size_t>((x - f.from) / dx));
    double& t = top[ix * f.columns + column];
    t = std::max(t, static_cast<double>(s.position[3 * i + 1]) + file.radius()[s.index[i]]);
  }
  std::vector<double> mean(f.columns, none);
  for (std::size_t c = 0; c < f.columns; ++c) {
    double sum = 0;
    int count = 0;
    for (std::size_t ix = 0; ix < nx; ++ix)
      if (const double t = top[ix * f.columns + c]; std::isfinite(t)) sum += t, ++count;
    if (count > 0) mean[c] = sum / count;
  }
  return mean;
}

void take_profile(const ToolPath& tool, const dem::PeriodicCell& cell, Furrow& f) {
  const auto beside = [&](std::size_t c) { return cell.shortest({0, 0, f.z[c] - tool.middle}).z; };
  std::size_t left = f.columns, right = f.columns;  // the highest columns beside the tool
  for (std::size_t c = 0; c < f.columns; ++c) {
    f.z.push_back(f.z0 + (static_cast<double>(c) + 0.5) * f.column);
    const double rise = f.after[c] - f.before[c];
    if (!std::isfinite(rise)) continue;
    (rise < 0 ? f.furrow_area : f.heap_area) += std::abs(rise) * f.column;
    f.heave = std::max(f.heave, rise);
    f.depth = std::max(f.depth, -rise);
    if (-rise > 0.1 * f.cell) f.width += f.column;
    std::size_t& ridge = beside(c) < 0 ? left : right;
    if (rise > 0 && (ridge == f.columns || rise > f.after[ridge] - f.before[ridge])) ridge = c;
  }
  f.ridge_to_ridge = left < f.columns && right < f.columns ? beside(right) - beside(left) : none;
}

/// Solid fraction at the middle of every cell, mean along the stretch.
std::vector<double> solid_fraction(const FramesFile& file, const FrameSpheres& s, const dem::PeriodicCell& cell,
                                   const Furrow& f) {
  const auto nx = static_cast<std::size_t>(std::max(1.0, std::floor((f.until - f.from) / f.cell)));
  FieldGrid grid;
  grid.spacing = {f.cell, f.cell, f.column};
  grid.low = {0.5 * (f.from + f.until) - 0.5 * static_cast<double>(nx - 1) * f.cell, f.y0 + 0.5 * f.cell,
              f.z0 + 0.5 * f.column};
  grid.n = {nx, f.rows, f.columns};
  const FieldKernel kernel(FieldKernel::Kind::lucy, f.cell);
  CoarseGraining coarse(grid, kernel);
  dem::PeriodicCell across = cell;
  across.length.x = across.length.y = 0;
  for (std::size_t i = 0; i < s.index.size(); ++i) {
    const double r = file.radius()[s.index[i]];
    const float* p = &s.position[3 * i];
    const Vec3 x{p[0], p[1], p[2]};
    each_image(x, x, across, kernel.reach(),
               [&](const Vec3& shift) { coarse.add({.position = x + shift, .volume = 4.0 / 3.0 * M_PI * r * r * r}); });
  }
  const GrainFields fields = coarse.finish();
  std::vector<double> mean(f.rows * f.columns, 0.0);
  for (std::size_t column = 0; column < f.columns; ++column)
    for (std::size_t row = 0; row < f.rows; ++row)
      for (std::size_t ix = 0; ix < nx; ++ix)
        mean[row * f.columns + column] +=
            fields.solid_fraction[(column * f.rows + row) * nx + ix] / static_cast<double>(nx);
  return mean;
}

void take_loosened(const FramesFile& file, const Displaced& d, const dem::PeriodicCell& cell, Furrow& f) {
  const std::vector<double> before = solid_fraction(file, d.before, cell, f),
                            after = solid_fraction(file, d.after, cell, f);
  f.loosened.assign(before.size(), none);
  for (std::size_t k = 0; k < before.size(); ++k) {
    const std::size_t column = k % f.columns;
    const double y = f.y0 + (static_cast<double>(k / f.columns) + 0.5) * f.cell;
    if (!(y + f.cell < std::min(f.before[column], f.after[column]))) continue;
    f.loosened[k] = before[k] - after[k];
    if (f.loosened[k] > Furrow::loosening) f.loosened_area += f.cell * f.column;
  }
}

/// What of a cell's height lies below the surface before the pass. The uppermost row holds all that is above it.
double height_in_soil(const Furrow& f, std::size_t row, std::size_t column) {
  if (!std::isfinite(f.before[column])) return f.cell;
  const double height = std::max(0.0, f.before[column] - f.y0 - static_cast<double>(row) * f.cell);
  return row + 1 < f.rows ? std::min(height, f.cell) : height;
}

void take_disturbed(const Displaced& d, Furrow& f) {
  std::vector<double> sum(f.rows * f.columns, 0.0);
  std::vector<int> count(f.rows * f.columns, 0);
  for (std::size_t i = 0; i < d.before.index.size(); ++i) {
    const float* p = &d.before.position[3 * i];
    if (p[0] < f.from || p[0] >= f.until || d.row_after[i] < 0) continue;
    const auto row = std::min(f.rows - 1, static_cast<std::size_t>(std::max(0.0, (p[1] - f.y0) / f.cell))),
               column = std::min(f.columns - 1, static_cast<std::size_t>(std::max(0.0, (p[2] - f.z0) / f.column)));
    const float* q = &d.after.position[3 * static_cast<std::size_t>(d.row_after[i])];
    sum[row * f.columns + column] += std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]);
    ++count[row * f.columns + column];
  }
  f.moved.assign(sum.size(), none);
  for (std::size_t k = 0; k < sum.size(); ++k) {
    if (count[k] == 0) continue;
    f.moved[k] = sum[k] / count[k];
    if (f.moved[k] <= f.threshold) continue;
    f.disturbed_area += height_in_soil(f, k / f.columns, k % f.columns) * f.column;
  }
}

/// A layer: its name and the heights it spans before the pass.
struct Layer {
  std::string name;
  double low = 0, high = 0;
};

/// Materials where there are several, else five equal ranges of depth; from above.
std::vector<Layer> layers_of(const FramesFile& file, const FrameSpheres& before, const Extent& y, double surface) {
  std::map<std::int32_t, std::vector<float>> by_material;
  for (std::size_t i = 0; i < before.index.size(); ++i)
    by_material[file.material()[before.index[i]]].push_back(before.position[3 * i + 1]);
  std::vector<Layer> layers;
  if (by_material.size() < 2) {
    for (int k = 0; k < 5; ++k) {
      const double high = y.high - (y.high - y.low) * k / 5, low = y.high - (y.high - y.low) * (k + 1) / 5;
      layers.push_back(
          {fmt::format("{:.0f} to {:.0f} mm deep", 1e3 * std::max(0.0, surface - high), 1e3 * (surface - low)), low,
           high});
    }
    return layers;
  }
  for (auto& [material, heights] : by_material) {
    std::sort(heights.begin(), heights.end());
    const auto m = static_cast<std::size_t>(material);
    layers.push_back({m < file.materials().size() ? file.materials()[m] : fmt::format("material {}", material),
                      heights[heights.size() / 50], heights[heights.size() - 1 - heights.size() / 50]});
  }
  std::sort(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) { return a.high > b.high; });
  for (std::size_t k = 0; k + 1 < layers.size(); ++k)
    layers[k].low = layers[k + 1].high = 0.5 * (layers[k].low + layers[k + 1].high);
  layers.front().high = y.high, layers.back().low = y.low;
  return layers;
}

void take_layers(const FramesFile& file, const ToolPath& tool, const Displaced& d, const Extent& y, Furrow& f) {
  const double deepest = *std::max_element(tool.depth.begin(), tool.depth.end());
  const double reach = 0.5 * tool.width + deepest;
  const std::vector<Layer> layers = layers_of(file, d.before, y, tool.soil_surface);
  // The surface has no layer above it: heaved soil of the top layer stays its own; likewise at the floor.
  const auto layer_at = [&](double height) {
    std::size_t k = 0;
    while (k + 1 < layers.size() && height < layers[k].low) ++k;
    return k;
  };
  for (const Layer& layer : layers) {
    LayerMotion motion{layer.name};
    motion.into.assign(layers.size(), 0.0);
    for (std::size_t i = 0; i < d.before.index.size(); ++i) {
      const float* p = &d.before.position[3 * i];
      if (p[1] < layer.low || p[1] > layer.high || p[0] < f.from || p[0] >= f.until || d.row_after[i] < 0) continue;
      if (std::abs(p[2] - tool.middle) > reach) continue;
      const float* q = &d.after.position[3 * static_cast<std::size_t>(d.row_after[i])];
      ++motion.spheres;
      motion.rise += q[1] - p[1];
      motion.forward += tool.direction * (q[0] - p[0]);
      motion.aside += (p[2] < tool.middle ? -1 : 1) * (q[2] - p[2]);
      const std::size_t there = layer_at(q[1]);
      motion.into[there] += 1;
      motion.moved_out += &layers[there] != &layer ? 1 : 0;
    }
    if (motion.spheres > 0) {
      const auto n = static_cast<double>(motion.spheres);
      motion.rise /= n, motion.forward /= n, motion.aside /= n, motion.moved_out /= n;
      for (double& share : motion.into) share /= n;
    }
    f.layers.push_back(motion);
  }
}

}  // namespace

std::optional<Furrow> furrow(const FramesFile& file, const ToolPath& tool, double steady_from,
                             const dem::PeriodicCell& of_bed, std::string& why) {
  Furrow f;
  Displaced d = displaced(file);
  dem::PeriodicCell cell = of_bed;
  if (tool.axis == 2) {
    f.along = 'z', f.across = 'x', cell = swapped(of_bed);
    swap_axes(d.before), swap_axes(d.after);
  }
  Extent x, y, z;
  double diameter = 0;
  for (std::size_t i = 0; i < d.before.index.size(); ++i) {
    x.take(d.before.position[3 * i]), y.take(d.before.position[3 * i + 1]), z.take(d.before.position[3 * i + 2]);
    diameter += 2 * static_cast<double>(file.radius()[d.before.index[i]]);
  }
  if (d.before.index.empty()) {
    why = "the first frame holds no spheres";
    return {};
  }
  f.cell = diameter / static_cast<double>(d.before.index.size());
  const double depth = *std::max_element(tool.depth.begin(), tool.depth.end());
  // What lies behind the place of a tool that starts in the soil was never passed.
  if (file.is_moving_bed()) {
    // A depth beside the ends: soil that went over the one behind is missing, and spheres are held there.
    const std::array<double, 2> ends = file.window(file.times().size() - 1);
    x.low = std::min(ends[0], ends[1]) + depth, x.high = std::max(ends[0], ends[1]) - depth;
  }
  const double face = tool.direction > 0 ? x.low : -x.high, rear_before = tool.direction * tool.rear.front();
  // Soil around a tool that has come there before the first frame is disturbed in it, up to about a depth ahead.
  const bool came = file.times().front() > 0 && tool.depth.front() > 0;
  const double began = came ? tool.direction * tool.tip.front() + depth : rear_before;
  const double near = std::isfinite(began) ? std::max(face, began) : face;
  const double rear = tool.direction * tool.rear.back(), end = std::min(rear, tool.direction > 0 ? x.high : -x.low);
  const double enough = std::max(2 * f.cell, 0.25 * depth);
  double start = none;
  if (std::isfinite(steady_from)) start = std::max(near, tool.direction * tool.tip_at(file.times(), steady_from));
  f.steady = end - start >= enough;
  if (!f.steady) start = near + 0.5 * depth;
  if (!(end - start >= enough)) {
    why = fmt::format(
        "the tool's rear has passed {:.0f} mm beyond half a depth from the soil's near face, or from where it stood in "
        "the "
        "soil at the start; a furrow needs {:.0f} mm",
        1e3 * std::max(0.0, end - start), 1e3 * enough);
    return {};
  }
  f.from = tool.direction > 0 ? start : -end, f.until = tool.direction > 0 ? end : -start;
  const bool endless = cell.length.z > 0;  // across: columns fill the cell, and its sides are one place
  const double width = endless ? cell.length.z : z.high - z.low + f.cell;
  f.y0 = y.low - 0.5 * f.cell, f.z0 = endless ? cell.low.z : z.low - 0.5 * f.cell;
  // Whole cells, of which the uppermost takes what is left: disturbed soil at a wall must lie in one of them. Across
  // they are as wide as fills the bed, so that a mirror image has the same.
  f.rows = static_cast<std::size_t>(std::max(1.0, std::round((y.high - y.low) / f.cell + 1)));
  f.columns = static_cast<std::size_t>(std::max(1.0, std::round(width / f.cell)));
  f.column = width / static_cast<double>(f.columns);
  f.threshold = 0.5 * f.cell;
  f.before = heights(file, d.before, f);
  f.after = heights(file, d.after, f);
  take_profile(tool, cell, f);
  const Displaced ways = unwrapped(d, cell);
  take_disturbed(ways, f);
  take_loosened(file, d, cell, f);
  if (f.disturbed_area > 0) f.swell = (f.heap_area - f.furrow_area) / f.disturbed_area;
  take_layers(file, tool, ways, y, f);
  return f;
}

}  // namespace subsoil::sim
