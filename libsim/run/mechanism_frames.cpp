#include "libsim/run/mechanism_frames.hpp"

#include "coupling/simulation.hpp"

namespace subsoil::sim {
namespace {

Vec3 in_space(const Vec2& p) { return {p[0], p[1], 0}; }

void add_line(OutputSurface& to, const std::vector<Vec2>& points, bool closed) {
  const int first = static_cast<int>(to.vertices.size()), count = static_cast<int>(points.size());
  for (const Vec2& p : points) to.vertices.push_back(in_space(p));
  for (int i = 0; i + (closed ? 0 : 1) < count; ++i) to.segments.push_back({first + i, first + (i + 1) % count});
}

}  // namespace

MechanismFrames::MechanismFrames(const Scenario& scenario) : sketch_(sketch_of(scenario)) {
  for (std::size_t body = 0; body < sketch_.names.size(); ++body) {  // the ground too: a track, a fixed gear
    OutputSurface lines{sketch_.names[body] + " outline", {}, {}, true};
    for (const auto& o : sketch_.outlines)
      if (o.body == static_cast<int>(body) && !o.from_surface) add_line(lines, o.points, o.closed);
    for (const auto& d : sketch_.disks)
      if (d.body == static_cast<int>(body)) {
        add_line(lines, Sketch::circle(d.centre, d.radius), true);
        add_line(lines, {d.centre, {d.centre[0] + d.radius, d.centre[1]}}, false);
      }
    if (!lines.segments.empty()) outlines_.emplace_back(static_cast<int>(body), std::move(lines));
  }
  gather();
}

void MechanismFrames::gather() {
  Cloud joints{"machine joints", {}, false}, links{"machine links", {}, true}, markers{"machine markers", {}, false};
  for (const auto* list : {&sketch_.pins, &sketch_.welds})
    for (const auto& p : *list) joints.points.emplace_back(p.b, p.p_b);
  for (const auto& s : sketch_.slides) joints.points.emplace_back(s.b, s.p_b);
  for (const auto& l : sketch_.links) {
    links.points.emplace_back(l.a, l.p_a);
    links.points.emplace_back(l.b, l.p_b);
  }
  for (const auto& m : sketch_.markers) markers.points.emplace_back(m.body, m.p);
  for (Cloud* cloud : {&joints, &links, &markers})
    if (!cloud->points.empty()) clouds_.push_back(std::move(*cloud));
}

void MechanismFrames::list(std::vector<OutputSurface>& surfaces) const {
  for (const auto& [body, outline] : outlines_) surfaces.push_back(outline);
  for (const Cloud& cloud : clouds_) {
    OutputSurface block{cloud.name, {}, {}, false};
    block.deforms = true;
    for (const auto& [body, p] : cloud.points) block.vertices.push_back(in_space(p));
    for (int i = 0; cloud.paired && i < static_cast<int>(cloud.points.size()); i += 2)
      block.segments.push_back({i, i + 1});
    surfaces.push_back(std::move(block));
  }
}

void MechanismFrames::take(const Poses& poses, std::vector<dem::Pose>& placed,
                           std::vector<std::vector<Vec3>>& deformed) const {
  for (const auto& [body, outline] : outlines_)
    placed.push_back(coupling::pose_of(poses[static_cast<std::size_t>(body)]));
  placed.resize(placed.size() + clouds_.size());
  deformed.clear();
  for (const Cloud& cloud : clouds_) {
    std::vector<Vec3>& points = deformed.emplace_back();
    for (const auto& [body, p] : cloud.points) {
      const mbd::BodyState& b = poses[static_cast<std::size_t>(body)];
      const mbd::Vec2 w = b.point_in_world(p);
      points.push_back({w.x, w.y, 0});
    }
  }
}

}  // namespace subsoil::sim
