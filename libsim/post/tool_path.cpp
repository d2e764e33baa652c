#include "libsim/post/tool_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace subsoil::sim {
namespace {

constexpr double far = std::numeric_limits<double>::infinity();
constexpr double level_edge = 1e-5;  // m; frames round to some micrometres

double lowest(const std::vector<double>& vertices) {
  double low = far;
  for (std::size_t i = 1; i < vertices.size(); i += 3) low = std::min(low, vertices[i]);
  return low;
}

/// Surfaces that come deep enough, by the deepest point of each over the record.
void choose(const SurfaceSamples& file, const std::map<std::string, std::string>& body_of, ToolPath& tool) {
  std::vector<double> deepest(file.surfaces().size(), far);
  for (std::size_t s = 0; s < file.surfaces().size(); ++s) {
    if (!file.surfaces()[s].moves || file.surfaces()[s].wall || file.surfaces()[s].triangles.empty()) continue;
    for (std::size_t f = 0; f < file.times().size(); ++f)
      deepest[s] = std::min(deepest[s], lowest(file.surface(f, file.surfaces()[s])));
  }
  if (deepest.empty()) return;
  const auto lowest_one = std::min_element(deepest.begin(), deepest.end());
  const double depth = tool.soil_surface - *lowest_one;
  if (!(depth > 0)) return;
  const auto body = [&](std::size_t s) {
    const auto found = body_of.find(file.surfaces()[s].name);
    return found == body_of.end() ? std::string() : found->second;
  };
  const std::string carrier = body(static_cast<std::size_t>(lowest_one - deepest.begin()));
  for (std::size_t s = 0; s < deepest.size(); ++s) {
    const double reach = tool.soil_surface - deepest[s];
    if (reach < 0.5 * depth && !(reach > 0 && !carrier.empty() && body(s) == carrier)) continue;
    tool.surfaces.push_back(s);
    tool.names.push_back(file.surfaces()[s].name);
  }
}

void follow(const SurfaceSamples& file, ToolPath& tool) {
  tool.tip.clear(), tool.depth.clear(), tool.rear.clear(), tool.times = file.times();
  for (std::size_t f = 0; f < file.times().size(); ++f) {
    double low = far, tip = 0, rear = far;
    for (const std::size_t s : tool.surfaces) {
      const std::vector<double> v = file.surface(f, file.surfaces()[s]);
      for (std::size_t i = 0; i + 2 < v.size(); i += 3) {
        // Of a level edge or face the foremost point is the tip.
        const bool level = std::abs(v[i + 1] - low) < level_edge;
        const double place = v[i + tool.axis];
        if (level ? tool.direction * place > tool.direction * tip : v[i + 1] < low) tip = place;
        low = std::min(low, v[i + 1]);
        if (v[i + 1] < tool.soil_surface) rear = std::min(rear, tool.direction * place);
      }
    }
    tool.tip.push_back(tip);
    tool.depth.push_back(tool.soil_surface - low);
    tool.rear.push_back(tool.direction * rear);
  }
}

/// Mean of all vertices along x or z: of a rotor that is its axis, whatever blade is the lowest.
double middle_along(const SurfaceSamples& file, const ToolPath& tool, std::size_t frame, std::size_t axis) {
  double sum = 0, count = 0;
  for (const std::size_t s : tool.surfaces) {
    const std::vector<double> v = file.surface(frame, file.surfaces()[s]);
    for (std::size_t i = 0; i + 2 < v.size(); i += 3) sum += v[i + axis], ++count;
  }
  return sum / count;
}

/// Share of an interval in which a depth that changes linearly is above 0.
double share_below(double first, double second) {
  if (first > 0 && second > 0) return 1;
  const double deeper = std::max(first, second);
  return deeper > 0 ? deeper / std::abs(second - first) : 0;
}

void take_travel(const SurfaceSamples& file, ToolPath& tool) {
  double way = 0, time = 0, before = middle_along(file, tool, 0, tool.axis);
  for (std::size_t f = 1; f < tool.times.size(); ++f) {
    const double now = middle_along(file, tool, f, tool.axis), share = share_below(tool.depth[f - 1], tool.depth[f]);
    way += share * (now - before), time += share * (tool.times[f] - tool.times[f - 1]);
    before = now;
  }
  tool.travel = std::abs(way), tool.speed = time > 0 ? tool.travel / time : 0;
}

/// Across the travel, within the periodic sides.
double within_sides(double place, const ToolPath& tool, const dem::PeriodicCell& cell) {
  const int d = static_cast<int>(tool.across());
  return cell.length[d] > 0 ? std::clamp(place, cell.low[d], cell.low[d] + cell.length[d]) : place;
}

/// A triangle that reaches below the soil's surface, and what it covers across the travel.
struct Face {
  std::array<Vec3, 3> corners;
  double from = far, until = -far;
};
std::vector<Face> faces_in_soil(const SurfaceSamples& file, const ToolPath& tool, std::size_t frame,
                                const dem::PeriodicCell& cell) {
  std::vector<Face> out;
  for (const std::size_t s : tool.surfaces) {
    const std::vector<double> v = file.surface(frame, file.surfaces()[s]);
    for (const auto& t : file.surfaces()[s].triangles) {
      Face face;
      double low = far;
      for (std::size_t e = 0; e < 3; ++e) {
        const std::size_t at = 3 * static_cast<std::size_t>(t[e]);
        face.corners[e] = {v[at], v[at + 1], v[at + 2]};
        const double across = within_sides(v[at + tool.across()], tool, cell);
        low = std::min(low, v[at + 1]);
        face.from = std::min(face.from, across), face.until = std::max(face.until, across);
      }
      if (low < tool.soil_surface) out.push_back(face);
    }
  }
  return out;
}

/// Stretches across the travel that the faces cover.
std::vector<Shank> stretches(std::vector<Face> faces) {
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.from < b.from; });
  std::vector<Shank> out;
  for (const Face& face : faces) {
    if (out.empty() || face.from > out.back().until + level_edge)
      out.push_back({.from = face.from, .until = face.until});
    out.back().until = std::max(out.back().until, face.until);
  }
  std::erase_if(out, [](const Shank& s) { return !(s.until > s.from); });
  return out;
}

/// Whether an interval across the travel begins in that of a shank.
bool is_of(const Shank& shank, double from) { return from >= shank.from - level_edge && from <= shank.until; }

/// Foremost place along the axis, times direction, of a shank's triangles at a height; -far where none is cut.
double front_at(const std::vector<Face>& faces, const Shank& shank, const ToolPath& tool, double y) {
  double front = -far;
  for (const Face& face : faces) {
    if (!is_of(shank, face.from)) continue;
    for (std::size_t e = 0; e < 3; ++e) {
      const Vec3 &a = face.corners[e], &b = face.corners[(e + 1) % 3];
      if ((a.y - y) * (b.y - y) > 0 || a.y == b.y) continue;
      const double share = (y - a.y) / (b.y - a.y);
      const double from = a[static_cast<int>(tool.axis)], to = b[static_cast<int>(tool.axis)];
      front = std::max(front, tool.direction * (from + share * (to - from)));
    }
  }
  return front;
}

/// Depth of a shank, and its rake from its own tip.
void measure(const std::vector<Face>& faces, const ToolPath& tool, Shank& shank) {
  double low = far, tip = 0;
  for (const Face& face : faces)
    if (is_of(shank, face.from))
      for (const Vec3& corner : face.corners) {
        const double place = tool.direction * corner[static_cast<int>(tool.axis)];
        // Of a level edge or face the foremost point is the tip.
        const bool level = std::abs(corner.y - low) < level_edge;
        if (level ? place > tip : corner.y < low) tip = place;
        low = std::min(low, corner.y);
      }
  shank.depth = tool.soil_surface - low;
  shank.rake_low = std::numbers::pi, shank.rake_high = 0;
  for (int k = 5; k <= 20; ++k) {
    const double up = shank.depth * k / 20.0;
    const double front = front_at(faces, shank, tool, low + up - 1e-9);
    if (front == -far) continue;
    const double rake = std::atan2(up, tip - front);
    shank.rake_low = std::min(shank.rake_low, rake), shank.rake_high = std::max(shank.rake_high, rake);
  }
}

void measure(const SurfaceSamples& file, const dem::PeriodicCell& cell, ToolPath& tool) {
  const auto frame =
      static_cast<std::size_t>(std::max_element(tool.depth.begin(), tool.depth.end()) - tool.depth.begin());
  double low = far, high = -far;
  for (const std::size_t s : tool.surfaces) {
    const std::vector<double> v = file.surface(frame, file.surfaces()[s]);
    for (std::size_t i = 0; i + 2 < v.size(); i += 3)
      if (v[i + 1] < tool.soil_surface) {
        const double across = within_sides(v[i + tool.across()], tool, cell);
        low = std::min(low, across), high = std::max(high, across);
      }
  }
  tool.width = high - low;
  tool.middle = 0.5 * (low + high);
  const std::vector<Face> faces = faces_in_soil(file, tool, frame, cell);
  tool.shanks = stretches(faces);
  tool.rake_low = std::numbers::pi, tool.rake_high = 0;
  for (Shank& shank : tool.shanks) {
    measure(faces, tool, shank);
    tool.rake_low = std::min(tool.rake_low, shank.rake_low), tool.rake_high = std::max(tool.rake_high, shank.rake_high);
  }
}

}  // namespace

double ToolPath::share_out(double from, double until) const {
  double all = 0, below = 0;
  for (std::size_t f = 1; f < times.size(); ++f) {
    const double begin = std::max(from, times[f - 1]), end = std::min(until, times[f]);
    if (!(end > begin)) continue;
    const auto depth_at = [&](double t) {
      const double share = (t - times[f - 1]) / (times[f] - times[f - 1]);
      return depth[f - 1] + share * (depth[f] - depth[f - 1]);
    };
    all += end - begin, below += (end - begin) * share_below(depth_at(begin), depth_at(end));
  }
  return all > 0 ? 1 - below / all : 0;
}

double ToolPath::tip_at(const std::vector<double>& times, double time) const {
  if (time <= times.front()) return tip.front();
  for (std::size_t i = 1; i < times.size(); ++i)
    if (time <= times[i]) {
      const double share = (time - times[i - 1]) / (times[i] - times[i - 1]);
      return tip[i - 1] + share * (tip[i] - tip[i - 1]);
    }
  return tip.back();
}

std::optional<ToolPath> tool_path(const SurfaceSamples& file, double soil_surface,
                                  const std::map<std::string, std::string>& body_of, const dem::PeriodicCell& cell) {
  ToolPath tool;
  tool.soil_surface = soil_surface;
  if (file.times().size() < 2) return {};
  choose(file, body_of, tool);
  if (tool.surfaces.empty()) return {};
  const auto way = [&](std::size_t axis) {
    return middle_along(file, tool, file.times().size() - 1, axis) - middle_along(file, tool, 0, axis);
  };
  tool.axis = std::abs(way(2)) > std::abs(way(0)) ? 2 : 0;
  tool.direction = way(tool.axis) < 0 ? -1 : 1;
  follow(file, tool);
  take_travel(file, tool);
  measure(file, cell, tool);
  return tool;
}

}  // namespace subsoil::sim
