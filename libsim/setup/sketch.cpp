#include "libsim/setup/sketch.hpp"

#include <algorithm>
#include <boost/geometry/algorithms/convex_hull.hpp>
#include <boost/geometry/geometries/multi_point.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/strategies/agnostic/hull_graham_andrew.hpp>
#include <boost/geometry/strategies/cartesian/side_by_triangle.hpp>
#include <cmath>
#include <concepts>
#include <map>
#include <numbers>

#include "libmbd/elements.hpp"
#include "libmbd/system/bodies_of.hpp"
#include "libsim/setup/shapes.hpp"

namespace subsoil::sim {
namespace {

namespace geometry = boost::geometry;
using Point = geometry::model::d2::point_xy<double>;

std::vector<Vec2> hull_of(const std::vector<Vec2>& points) {
  geometry::model::multi_point<Point> cloud;
  for (const Vec2& p : points) cloud.push_back({p[0], p[1]});
  geometry::model::polygon<Point> hull;
  geometry::convex_hull(cloud, hull);
  std::vector<Vec2> corners;
  for (const Point& p : hull.outer()) corners.push_back({p.x(), p.y()});
  corners.pop_back();  // the first again
  return corners;
}

/// Outlines of a surface seen along z: the edges around its triangles that face the reader.
std::vector<std::vector<Vec2>> silhouette(const dem::TriangleMesh& mesh) {
  std::map<std::uint32_t, std::uint32_t> next;  // edges without a neighbour that faces the reader too, head by tail
  const auto facing = [&](std::size_t t) { return mesh.normal(t).z > 1e-6; };
  std::map<std::pair<std::uint32_t, std::uint32_t>, bool> edges;
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t)
    for (std::size_t k = 0; k < 3 && facing(t); ++k)
      edges[{mesh.triangles()[t][k], mesh.triangles()[t][(k + 1) % 3]}] = true;
  for (const auto& [edge, there] : edges)
    if (!edges.contains({edge.second, edge.first})) next[edge.first] = edge.second;
  std::vector<std::vector<Vec2>> loops;
  while (!next.empty()) {
    std::vector<Vec2> loop;
    for (auto at = next.begin(); at != next.end();) {
      const Vec3& corner = mesh.vertices()[at->first];
      loop.push_back({corner.x, corner.y});
      const std::uint32_t head = at->second;
      next.erase(at);
      at = next.find(head);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

double distance(const Vec2& a, const Vec2& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

/// The point of the line from a to b that is nearest to p.
Vec2 foot_on(const Vec2& a, const Vec2& b, const Vec2& p) {
  const double ex = b[0] - a[0], ey = b[1] - a[1], square = ex * ex + ey * ey;
  const double share = square > 0 ? std::clamp(((p[0] - a[0]) * ex + (p[1] - a[1]) * ey) / square, 0.0, 1.0) : 0.0;
  return {a[0] + share * ex, a[1] + share * ey};
}

/// Whether a ray from p to the right crosses the polygon an odd number of times.
bool holds(const std::vector<Vec2>& polygon, const Vec2& p) {
  bool odd = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a[1] > p[1]) == (b[1] > p[1])) continue;
    if (a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > p[0]) odd = !odd;
  }
  return odd;
}

/// A force that holds on to one point of a body.
template <class Force>
concept ActsAtPoint = requires(const Force& f) {
  { f.body } -> std::convertible_to<int>;
  { f.point } -> std::convertible_to<Vec2>;
};

class Draughtsman {
 public:
  explicit Draughtsman(const Scenario& s) : s_(s), machine_(*s.machine), poses_(start_poses(s)) {
    points_.resize(poses_.size());
    shaped_.resize(poses_.size());
    sketch_.names = {"ground"};
    for (const BodySection& b : machine_.bodies) sketch_.names.push_back(b.name);
    sketch_.markers = machine_.markers;
    for (const NamedJoint& j : machine_.joints)
      element_ = "machine.joints." + j.name, visit([&](const auto& joint) { take(joint); }, j.element);
    for (const NamedForce& f : machine_.forces)
      element_ = "machine.forces." + f.name, visit([&](const auto& force) { take(force); }, f.element);
    for (const NamedDriver& d : machine_.drivers)
      if (element_ = "machine.drivers." + d.name; const auto* ram = d.element.get_if<mbd::DistanceDriver>())
        add_link(Sketch::Link::Kind::rod, ram->first, ram->second, ram->p_a, ram->p_b);
    for (const mbd::Marker& m : machine_.markers) point(m.body, m.p);
    if (s.soil && s.soil->surface) sketch_.sides.push_back({mbd::ground, {0, *s.soil->surface}, 0});
  }

  Sketch finish() {
    add_given_shapes();
    for (Sketch::Slide& s : sketch_.slides)
      if (s.block && shaped_[static_cast<std::size_t>(s.b)]) lay_under(s);
    measure();
    for (std::size_t i = 1; i < poses_.size(); ++i)
      if (shaped_[i])
        add_bars(static_cast<int>(i));
      else
        add_body_from_points(static_cast<int>(i));
    return std::move(sketch_);
  }

 private:
  void point(int body, const Vec2& p) {
    std::vector<Vec2>& known = points_[static_cast<std::size_t>(body)];
    const auto same = [&](const Vec2& q) { return distance(p, q) < 1e-9; };
    if (std::none_of(known.begin(), known.end(), same)) known.push_back(p);
  }
  Sketch::Pair pair(int a, int b, const Vec2& p_a, const Vec2& p_b) {
    point(a, p_a), point(b, p_b);
    return {a, b, p_a, p_b, element_};
  }
  void add_link(Sketch::Link::Kind kind, int a, int b, const Vec2& p_a, const Vec2& p_b) {
    sketch_.links.push_back({pair(a, b, p_a, p_b), kind});
  }
  void disk(int body, const Vec2& centre, double radius) {
    if (!(radius > 0)) return;
    const auto same = [&](const Sketch::Disk& d) {
      return d.body == body && distance(d.centre, centre) < 1e-9 && std::abs(d.radius - radius) < 1e-9;
    };
    if (std::none_of(sketch_.disks.begin(), sketch_.disks.end(), same)) sketch_.disks.push_back({body, centre, radius});
    if (body != mbd::ground) shaped_[static_cast<std::size_t>(body)] = 1;
  }
  void curve(int body, const Vec2& origin, const mbd::Curve& curve, double from, double to, bool closed) {
    std::vector<Vec2> points;
    constexpr int pieces = 120;
    for (int i = 0; i < pieces + (closed ? 0 : 1); ++i) {
      const mbd::Vec2 p = curve.at(from + (to - from) * i / pieces).point;
      points.push_back({origin[0] + p.x, origin[1] + p.y});
    }
    sketch_.outlines.push_back({body, std::move(points), closed});
    if (body != mbd::ground && closed) shaped_[static_cast<std::size_t>(body)] = 1;
  }

  void take(const mbd::Revolute& j) { sketch_.pins.push_back(pair(j.body_a, j.body_b, j.p_a, j.p_b)); }
  void take(const mbd::Fixed& j) { sketch_.welds.push_back(pair(j.body_a, j.body_b, j.p_a, j.p_b)); }
  /// The line is drawn on the ground where one of the two is it: the bodies do not turn against each other.
  void take(const mbd::Translational& j) {
    if (j.body_b == mbd::ground) {
      const double angle = j.angle_a + poses_[static_cast<std::size_t>(j.body_a)].angle;
      sketch_.slides.push_back({{j.body_b, j.body_a, j.p_b, j.p_a, element_}, angle, true});
    } else {
      sketch_.slides.push_back({{j.body_a, j.body_b, j.p_a, j.p_b, element_}, j.angle_a, true});
    }
    point(sketch_.slides.back().b, sketch_.slides.back().p_b);
  }
  void take(const mbd::PointOnLine& j) {
    sketch_.slides.push_back({{j.body_a, j.body_b, j.p_a, j.p_b, element_}, j.angle_a, false, true});
    point(j.body_b, j.p_b);
  }
  void take(const mbd::Distance& j) { add_link(Sketch::Link::Kind::rod, j.body_a, j.body_b, j.p_a, j.p_b); }
  template <class Joint>
  requires std::derived_from<Joint, mbd::DiskAndLine>
  void take(const Joint& j) {
    disk(j.body_b, j.p_b, j.radius);
    sketch_.sides.push_back({j.body_a, j.p_a, j.angle_a, element_});
  }
  template <class Joint>
  requires std::derived_from<Joint, mbd::TwoDisks>
  void take(const Joint& j) { disk(j.body_a, j.p_a, j.radius_a), disk(j.body_b, j.p_b, j.radius_b); }
  void take(const mbd::GearRatio&) {}
  void take(const mbd::Coupler&) {}
  template <std::size_t rows>
  void take(const mbd::OwnJoint<rows>&) {}  // no scenario names one
  void take(const mbd::CamFollower& j) {
    profile(j, j.closed);
    point(j.body_b, j.p_b);
    if (j.roller > 0) sketch_.disks.push_back({j.body_b, j.p_b, j.roller});
  }
  void take(const mbd::FlatFacedCam& j) {
    profile(j, true);
    point(j.body_b, j.p_b);
  }
  template <class Cam>
  void profile(const Cam& j, bool closed) {
    const double from = j.angles.front(), to = closed ? from + 2 * std::numbers::pi : j.angles.back();
    curve(j.body_a, j.p_a, mbd::Curve::polar(j.angles, j.radii, closed), from, to, closed);
  }
  void take(const mbd::PointOnCurve& j) {
    std::vector<char> before = shaped_;
    path(j.body_a, j.points, j.closed);
    shaped_ = before;
    point(j.body_b, j.p_b);
  }
  void path(int body, const std::vector<Vec2>& points, bool closed) {
    double length = 0;
    const std::size_t pieces = points.size() - (closed ? 0 : 1);
    for (std::size_t i = 0; i < pieces; ++i) length += distance(points[i], points[(i + 1) % points.size()]);
    curve(body, {0, 0}, mbd::Curve::through(points, closed), 0, length, closed);
  }

  void take(const mbd::SpringDamper& f) {
    const bool only_damps = f.stiffness == 0 && !f.spring_curve.is_set();
    add_link(only_damps ? Sketch::Link::Kind::damper : Sketch::Link::Kind::spring, f.body_a, f.body_b, f.p_a, f.p_b);
  }
  void take(const mbd::HydraulicCylinder& f) { add_link(Sketch::Link::Kind::damper, f.body_a, f.body_b, f.p_a, f.p_b); }
  void take(const mbd::Bushing& f) { sketch_.pins.push_back(pair(f.body_a, f.body_b, f.p_a, f.p_b)); }
  void take(const mbd::BeamElement& f) {  // elements of a beam are drawn as its nodes
    if (!f.placed) add_link(Sketch::Link::Kind::rod, f.body_a, f.body_b, f.p_a, f.p_b);
  }
  void take(const mbd::DistanceStop& f) { point(f.body_a, f.p_a), point(f.body_b, f.p_b); }
  void take(const mbd::LineContact& f) {
    disk(f.body_b, f.p_b, f.radius);
    point(f.body_b, f.p_b);
    sketch_.sides.push_back({f.body_a, f.p_a, f.angle_a, element_});
  }
  void take(const mbd::DiskContact& f) { disk(f.body_a, f.p_a, f.radius_a), disk(f.body_b, f.p_b, f.radius_b); }
  void take(const mbd::OutlineContact& f) {
    for (const auto& [body, form] : {std::pair(f.body_a, &f.first), {f.body_b, &f.second}})
      std::visit([this, body = body](const auto& outline) { draw(body, outline); }, *form);
  }
  void draw(int body, const mbd::DiskOutline& o) { disk(body, o.centre, o.radius); }
  void draw(int body, const mbd::PolygonOutline& o) {
    sketch_.outlines.push_back({body, o.points});
    if (body != mbd::ground) shaped_[static_cast<std::size_t>(body)] = 1;
  }
  void draw(int body, const mbd::ProfileOutline& o) {
    curve(body, o.centre, *o.curve(), o.angles.front(), o.angles.front() + 2 * std::numbers::pi, true);
  }
  void draw(int body, const mbd::FlankOutline& o) { path(body, o.points, o.closed); }
  void draw(int body, const mbd::FlatOutline& o) {
    sketch_.sides.push_back({body, o.point, o.angle, element_});
    point(body, o.point);
  }
  void take(const mbd::WheelOnSoil& f) {
    disk(f.body, {0, 0}, f.radius);
    const auto same = [&](const Sketch::Side& side) { return side.body == mbd::ground && side.point[1] == f.surface; };
    if (std::none_of(sketch_.sides.begin(), sketch_.sides.end(), same))
      sketch_.sides.push_back({mbd::ground, {0, f.surface}, 0, element_});
  }
  template <class Force>
  void take(const Force& f) {  // a load, drag, friction, a stop: what it holds on to is a point of its body
    if constexpr (ActsAtPoint<Force>) point(f.body, f.point);
  }

  void add_given_shapes() {
    for (std::size_t i = 1; i < poses_.size(); ++i) {
      const int body = static_cast<int>(i);
      if (const auto& outline = machine_.bodies[i - 1].outline; !outline.empty()) {
        forget_disks(body);
        sketch_.outlines.push_back({body, outline});
        shaped_[i] = 1;
        continue;
      }
      for (const Surface& surface : machine_.surfaces) {
        if (surface.body_index != body || !is_bounded(surface.shape)) continue;
        forget_disks(body);
        for (auto& loop : silhouette(drawn_mesh(surface, machine_)))
          sketch_.outlines.push_back({body, std::move(loop), true, true});
        shaped_[i] = 1;
      }
    }
  }
  /// A body with a shape of its own is no block: the line of its slide lies along its side.
  void lay_under(Sketch::Slide& s) {
    s.block = false;
    const double turn = poses_[static_cast<std::size_t>(s.a)].angle + s.angle_a -
                        poses_[static_cast<std::size_t>(s.b)].angle;  // of the line in b's axes
    for (const auto& o : sketch_.outlines)
      for (const Vec2& p : o.points)
        if (o.body == s.b)
          s.below = std::max(s.below, (p[0] - s.p_b[0]) * std::sin(turn) - (p[1] - s.p_b[1]) * std::cos(turn));
  }

  /// Bars from the joints that lie outside of what is drawn of a body to its nearest point.
  void add_bars(int body) {
    std::vector<Vec2> joints = points_[static_cast<std::size_t>(body)];
    std::vector<Sketch::Outline> shapes;
    for (const auto& o : sketch_.outlines)
      if (o.body == body && o.closed) shapes.push_back(o);
    for (const auto& d : sketch_.disks)
      if (d.body == body) shapes.push_back({body, Sketch::circle(d.centre, d.radius)});
    for (const Vec2& joint : joints) {
      double least = INFINITY;
      Vec2 nearest{};
      for (const auto& shape : shapes) {
        const std::vector<Vec2>& p = shape.points;
        if (holds(p, joint)) least = 0;
        for (std::size_t i = 0; i < p.size(); ++i) {
          const Vec2 foot = foot_on(p[i], p[(i + 1) % p.size()], joint);
          if (distance(foot, joint) < least) least = distance(foot, joint), nearest = foot;
        }
      }
      if (least > 1e-3 * sketch_.size && std::isfinite(least))
        sketch_.outlines.push_back({body, {nearest, joint}, false});
    }
  }

  /// The wheel that is drawn by its surface needs no circle of the same size beside it.
  void forget_disks(int body) {
    std::erase_if(sketch_.disks, [&](const Sketch::Disk& d) { return d.body == body; });
  }

  /// The machine's extent in its start pose, which tells how large a dot is.
  void measure() {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    const auto reach = [&](int body, const Vec2& p, double radius) {
      const mbd::BodyState& pose = poses_[static_cast<std::size_t>(body)];
      const mbd::Vec2 w = pose.point_in_world(p);
      low[0] = std::min(low[0], w.x - radius), high[0] = std::max(high[0], w.x + radius);
      low[1] = std::min(low[1], w.y - radius), high[1] = std::max(high[1], w.y + radius);
    };
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (i > 0) reach(static_cast<int>(i), {0, 0}, 0);
      for (const Vec2& p : points_[i]) reach(static_cast<int>(i), p, 0);
    }
    for (const auto& d : sketch_.disks) reach(d.body, d.centre, d.radius);
    for (const auto& o : sketch_.outlines)
      for (const Vec2& p : o.points) reach(o.body, p, 0);
    const double size = std::max(high[0] - low[0], high[1] - low[1]);
    sketch_.size = size > 0 && std::isfinite(size) ? size : 1;
  }

  void add_body_from_points(int body) {
    std::vector<Vec2> points = points_[static_cast<std::size_t>(body)];
    const double dot = 0.02 * sketch_.size;
    const auto carries = [&](const Sketch::Slide& s) { return s.b == body && s.block; };
    if (points.size() < 2 && std::any_of(sketch_.slides.begin(), sketch_.slides.end(), carries)) return;
    if (points.size() < 2) sketch_.disks.push_back({body, {0, 0}, dot});
    if (points.size() == 1) points.push_back({0, 0});
    if (points.size() > 2) {
      if (auto hull = hull_of(points); hull.size() > 2) {
        sketch_.outlines.push_back({body, std::move(hull)});
        return;
      }
    }
    if (points.size() > 1 && distance(points[0], points[1]) > 1e-9)
      sketch_.outlines.push_back({body, std::move(points), false});
  }

  const Scenario& s_;
  const MachineSection& machine_;
  std::vector<mbd::BodyState> poses_;
  std::vector<std::vector<Vec2>> points_;  // by body, in its axes
  std::vector<char> shaped_;               // by body: it has a shape of its own
  std::string element_;                    // path of the element that is taken
  Sketch sketch_;
};

}  // namespace

std::vector<Vec2> Sketch::circle(Vec2 centre, double radius) {
  std::vector<Vec2> points;
  for (int i = 0; i < circle_sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / circle_sides;
    points.push_back({centre[0] + radius * std::cos(angle), centre[1] + radius * std::sin(angle)});
  }
  return points;
}

Sketch sketch_of(const Scenario& scenario) { return Draughtsman(scenario).finish(); }

Poses displaced(const Poses& rest, const std::vector<double>& shape, double factor) {
  Poses poses{rest.front()};
  for (std::size_t i = 1; i < rest.size(); ++i) {
    const double* const move = &shape[3 * (i - 1)];
    poses.emplace_back(rest[i].r + factor * mbd::Vec2{move[0], move[1]}, rest[i].angle + factor * move[2], mbd::Vec2{},
                       0.0);
  }
  return poses;
}

double picture_factor(const Sketch& sketch, const Poses& rest, const std::vector<double>& shape) {
  constexpr double little = 1e-6;  // so little that turns move points along straight lines
  const Poses moved = displaced(rest, shape, little);
  double way = 0;
  const auto take = [&](int body, const Vec2& p) {
    const auto i = static_cast<std::size_t>(body);
    way = std::max(way, mbd::length(moved[i].point_in_world(p) - rest[i].r - rest[i].vector_in_world(p)) / little);
  };
  for (const auto& o : sketch.outlines)
    for (const Vec2& p : o.points) take(o.body, p);
  for (const auto& d : sketch.disks) take(d.body, {d.centre[0] + d.radius, d.centre[1]});
  for (const auto& s : sketch.slides) take(s.b, s.p_b);
  if (!(way > 1e-6)) return 0;  // shapes have a largest entry of 1; what is left is rounding
  const double wanted = 0.1 * sketch.size / way, power = std::pow(10, std::floor(std::log10(wanted)));
  return std::round(wanted / power) * power;
}

Poses start_poses(const Scenario& scenario) {
  Poses poses{mbd::BodyState{}};
  for (const BodySection& b : scenario.machine->bodies)
    poses.emplace_back(mbd::Vec2{b.at[0], b.at[1]}, b.angle, mbd::Vec2{}, 0.0);
  return poses;
}

}  // namespace subsoil::sim
