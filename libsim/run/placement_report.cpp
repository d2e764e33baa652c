#include "libsim/run/placement_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "libdem/packing/measure.hpp"
#include "libmbd/elements.hpp"
#include "libsim/scenario/sections/soil.hpp"

namespace subsoil::sim {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr int kPlaces = 400;  ///< of a way

/// What moves through soil: all surfaces of a body, or one boundary.
struct MovingThing {
  std::string name;
  std::vector<Vec3> points;                 ///< of its surfaces, in the world at the start
  std::function<Vec3(double)> travelled{};  ///< m, from the start on; empty: not known beforehand

  dem::Bounds box(double t) const {
    const Vec3 offset = travelled ? travelled(t) : Vec3{};
    dem::Bounds out;
    for (const Vec3& p : points) out.include(p + offset);
    return out;
  }
};

/// The only driver of an x or y in the world that the machine has: what is towed goes with it.
const mbd::CoordinateDriver* only_driver(const World& world, mbd::Coordinate coordinate) {
  const mbd::CoordinateDriver* found = nullptr;
  int count = 0;
  for (const auto& d : world.machine->system().model().drivers)
    if (const auto* c = d.element.get_if<mbd::CoordinateDriver>(); c != nullptr && c->coordinate == coordinate)
      found = c, ++count;
  return count == 1 ? found : nullptr;
}

std::function<Vec3(double)> way_of_machine(const World& world) {
  const auto* x = only_driver(world, mbd::Coordinate::x);
  const auto* y = only_driver(world, mbd::Coordinate::y);
  if (x == nullptr && y == nullptr) return {};
  return [x, y](double t) {
    const auto gone = [t](const mbd::CoordinateDriver* d) {
      return d == nullptr ? 0.0 : d->motion.value(t) - d->motion.value(0);
    };
    return Vec3{gone(x), gone(y), 0};
  };
}

/// Of planes, which have no end, nothing is known.
std::vector<MovingThing> moving_things(const World& world) {
  std::vector<MovingThing> out;
  for (const SurfaceRecord& r : world.surfaces) {
    if (r.owner == SurfaceRecord::Owner::container || !r.moves) continue;
    const dem::Boundary& b = world.bed->boundary(r.boundary);
    if (std::holds_alternative<dem::Plane>(b.shape)) continue;
    const bool of_machine = r.owner == SurfaceRecord::Owner::machine;
    const std::string name = of_machine ? world.machine->system().body_name(r.body) : r.name;
    auto at = std::find_if(out.begin(), out.end(), [&](const MovingThing& m) { return m.name == name; });
    if (at == out.end()) {
      at = out.insert(out.end(), {name, {}, {}});
      if (of_machine) at->travelled = way_of_machine(world);
      for (const coupling::GivenMotion& m : world.motions)
        if (!of_machine && m.boundary == r.boundary && !m.servo)
          at->travelled = [pose = m.pose](double t) { return pose(t).position - pose(0).position; };
    }
    const dem::TriangleMesh mesh = dem::drawing(b.shape, 1.0)[r.mesh];
    for (const Vec3& v : mesh.vertices()) at->points.push_back(b.pose.to_world(v));
  }
  return out;
}

bool overlap_along(const dem::Bounds& a, const dem::Bounds& b, int d) {
  return a.low[d] < b.high[d] && b.low[d] < a.high[d];
}

/// The container as the run has it: at its datum.
struct Bin {
  const Container& container;
  dem::Bounds box;
  double radius;  ///< smallest of a sphere: what reaches into a wall by less is taken to touch it

  bool wall(int axis, bool upper) const {
    return keeps_wall(container, 2 * static_cast<std::size_t>(axis) + (upper ? 1 : 0));
  }
};

void look_at_start(const MovingThing& m, const Bin& bin, std::vector<std::string>& out) {
  const dem::Bounds box = m.box(0);
  const auto beyond = [&](int axis, bool upper) {
    return upper ? box.high[axis] - bin.box.high[axis] : bin.box.low[axis] - box.low[axis];
  };
  if (bin.wall(1, false) && box.high.y < bin.box.low.y) {
    out.push_back(
        fmt::format("{} lies wholly below the floor of the container at the start, by {:.3g} m, and touches no soil "
                    "there; start it higher",
                    m.name, bin.box.low.y - box.high.y));
    return;
  }
  if (bin.wall(1, false) && beyond(1, false) > bin.radius && overlap_along(box, bin.box, 0) &&
      overlap_along(box, bin.box, 1) && overlap_along(box, bin.box, 2))
    out.push_back(
        fmt::format("{} reaches {:.3g} m below the floor of the container at the start: soil between them is "
                    "pressed beyond its law; start it higher, or make the container deeper",
                    m.name, beyond(1, false)));
  for (const int axis : {0, 2}) {
    if (!bin.wall(axis, false) || !bin.wall(axis, true) || !overlap_along(box, bin.box, 1)) continue;
    if (beyond(axis, false) > bin.radius && beyond(axis, true) > bin.radius)
      out.push_back(
          fmt::format("{} is {:.3g} m wide along {} and passes through both walls of the container, {:.3g} m "
                      "apart: no soil gets past it; make it narrower, or the container wider",
                      m.name, box.high[axis] - box.low[axis], axis_names[static_cast<std::size_t>(axis)],
                      bin.box.high[axis] - bin.box.low[axis]));
  }
}

/// The first wall that something inside the container comes to.
void look_at_way(const MovingThing& m, const Bin& bin, const dem::Bounds& soil, bool window_follows, double end,
                 std::vector<std::string>& out) {
  if (!m.travelled) return;
  const dem::Bounds start = m.box(0);
  for (int k = 1; k <= kPlaces; ++k) {
    const double t = end * k / kPlaces;
    const dem::Bounds box = m.box(t);
    if (!(box.low.y < soil.high.y)) continue;
    for (const int axis : {0, 1, 2})
      for (const bool upper : {false, true}) {
        if ((axis == 1 && upper) || !bin.wall(axis, upper) || (axis == 0 && window_follows)) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        if (!overlap_along(box, bin.box, u) || !overlap_along(box, bin.box, v)) continue;
        const double before = upper ? bin.box.high[axis] - start.high[axis] : start.low[axis] - bin.box.low[axis];
        const double now = upper ? bin.box.high[axis] - box.high[axis] : box.low[axis] - bin.box.low[axis];
        if (!(before > 0) || now > 0) continue;
        const std::size_t face = 2 * static_cast<std::size_t>(axis) + (upper ? 1 : 0);
        out.push_back(
            fmt::format("{} comes to the {} of the container at t = {:.3g} s, {:.3g} m from its start: soil is "
                        "pressed against it from there on; end the run before, or make the container larger",
                        m.name, wall_name(face), t, before));
        return;
      }
  }
}

/// Boxes of bodies by their centres, outlines, surfaces and the joints beside one.
dem::Bounds extent_of_body(const Scenario& s, const World& world, int body, std::size_t without) {
  const mbd::BodyState& state = world.machine->body(body);
  dem::Bounds box;
  box.include(Vec3{state.r.x, state.r.y, 0});
  const std::string& name = world.machine->system().body_name(body);
  for (const BodySection& b : s.machine->bodies)
    if (b.name == name)
      for (const Vec2& p : b.outline) {
        const auto at = state.point_in_world(p);
        box.include(Vec3{at.x, at.y, 0});
      }
  for (const SurfaceRecord& r : world.surfaces)
    if (r.owner == SurfaceRecord::Owner::machine && r.body == body) {
      const dem::Boundary& b = world.bed->boundary(r.boundary);
      if (std::holds_alternative<dem::Plane>(b.shape)) continue;
      const dem::TriangleMesh mesh = dem::drawing(b.shape, 1.0)[r.mesh];
      for (const Vec3& v : mesh.vertices()) {
        const Vec3 p = b.pose.to_world(v);
        box.include(Vec3{p.x, p.y, 0});
      }
    }
  const auto& joints = world.machine->system().model().joints;
  for (std::size_t k = 0; k < joints.size(); ++k)
    if (k != without)
      visit(
          [&](const auto& joint) {
            if constexpr (std::remove_cvref_t<decltype(joint)>::has.points) {
              const auto take = [&](int of, const auto& p) {
                if (of != body) return;
                const auto at = state.point_in_world(p);
                box.include(Vec3{at.x, at.y, 0});
              };
              take(joint.body_a, joint.p_a), take(joint.body_b, joint.p_b);
            }
          },
          joints[k].element);
  return box;
}

double distance_in_plane(const dem::Bounds& box, const Vec3& p) {
  const auto out = [](double low, double high, double x) { return std::max({0.0, low - x, x - high}); };
  return std::hypot(out(box.low.x, box.high.x, p.x), out(box.low.y, box.high.y, p.y));
}

/// A pin that lies farther from both bodies than three times all that is known of the machine without it.
void look_at_pins(const Scenario& s, const World& world, std::vector<std::string>& out) {
  constexpr double far = 3;
  const auto& joints = world.machine->system().model().joints;
  for (std::size_t k = 0; k < joints.size(); ++k)
    visit(
        [&](const auto& joint) {
          using Joint = std::remove_cvref_t<decltype(joint)>;
          if constexpr (Joint::has.points && Joint::has.pin) {
            if (joint.body_a == mbd::ground || joint.body_b == mbd::ground) return;
            dem::Bounds all;
            for (int b = 1; b < world.machine->system().bodies(); ++b) {
              const dem::Bounds one = extent_of_body(s, world, b, k);
              all.include(one.low), all.include(one.high);
            }
            const auto pin = world.machine->body(joint.body_a).point_in_world(joint.p_a);
            const Vec3 at{pin.x, pin.y, 0};
            const double apart = std::min(distance_in_plane(extent_of_body(s, world, joint.body_a, k), at),
                                          distance_in_plane(extent_of_body(s, world, joint.body_b, k), at));
            if (!(apart > far * all.diagonal()) || !(all.diagonal() > 0)) return;
            out.push_back(fmt::format(
                "machine.joints.{}: its pin at ({:.4g}, {:.4g}) m lies {:.3g} m from both bodies, and the machine is "
                "{:.3g} m large without it: is its place right?",
                joints[k].name, at.x, at.y, apart, all.diagonal()));
          }
        },
        joints[k].element);
}

std::optional<Bin> bin_of(const Scenario& s, const World& world) {
  if (!world.bed || world.bed->spheres().empty() || !s.soil || !s.soil->container) return {};
  const Container& c = *s.soil->container;
  double radius = kEndless;
  for (const dem::Sphere& one : world.bed->spheres()) radius = std::min(radius, one.r);
  const Vec3 at = c.at + Vec3{0, world.container_shift, 0};
  return Bin{c, {at, at + c.size}, radius};
}

}  // namespace

dem::Bounds bed_box(const World& world) { return dem::box_of(world.bed->spheres()); }

std::vector<std::string> placement_warnings(const Scenario& s, const World& world) {
  std::vector<std::string> out;
  if (world.machine && s.machine) look_at_pins(s, world, out);
  if (const std::optional<Bin> bin = bin_of(s, world))
    for (const MovingThing& m : moving_things(world)) look_at_start(m, *bin, out);
  return out;
}

std::vector<std::string> travel_warnings(const Scenario& s, const World& world) {
  std::vector<std::string> out;
  if (!world.bed || world.bed->spheres().empty() || !s.runs_in_time()) return out;
  const dem::Bounds soil = bed_box(world);
  if (const std::optional<Bin> bin = bin_of(s, world))
    for (const MovingThing& m : moving_things(world))
      look_at_way(m, *bin, soil, s.soil->moving.has_value(), s.time.end, out);
  if (s.output.window.from || s.output.window.until) return out;
  const double surface = world.soil.surface_mean, radius = dem::mean_radius(world.bed->spheres());
  for (const MovingThing& m : moving_things(world)) {
    if (!m.travelled) continue;
    const double end = s.time.end;
    const Vec3 all = m.travelled(end);
    const int along = std::abs(all.x) >= std::abs(all.z) ? 0 : 2;
    double entry = kEndless, depth = 0, length = 0, travel = 0;
    for (int k = 0; k <= kPlaces; ++k) {
      const Vec3 gone = m.travelled(end * k / kPlaces);
      dem::Bounds below;
      for (const Vec3& p : m.points)
        if (p.y + gone.y <= surface) below.include(p + gone);
      if (!(below.low.y < surface) || !overlap_along(below, soil, 0) || !overlap_along(below, soil, 1) ||
          !overlap_along(below, soil, 2))
        continue;
      if (entry == kEndless) entry = gone[along];
      depth = std::max(depth, surface - below.low.y), length = std::max(length, below.high[along] - below.low[along]);
      travel = std::max(travel, std::abs(gone[along] - entry));
    }
    if (entry == kEndless || travel <= 2 * radius || travel >= length + depth) continue;
    out.push_back(
        fmt::format("{} travels {:.3g} m in soil, less than its length there plus its depth, {:.3g} m: the "
                    "summary will have no means; let it run longer, or set output.window",
                    m.name, travel, length + depth));
  }
  return out;
}

std::vector<std::string> free_bodies(const Scenario& s, const World& world) {
  std::vector<std::string> out;
  if (!world.machine) return out;
  const mbd::System& system = world.machine->system();
  std::vector<bool> held(static_cast<std::size_t>(system.bodies()), false);
  const auto hold = [&](int body) {
    if (body >= 0) held[static_cast<std::size_t>(body)] = true;
  };
  for (const auto& j : system.model().joints)
    visit(
        [&](const auto& joint) {
          hold(joint.body_a), hold(joint.body_b);
          if constexpr (requires { joint.body_c; }) hold(joint.body_c);
        },
        j.element);
  for (const auto& d : system.model().drivers)
    visit([&](const auto& driver) { hold(driver.body_a()), hold(driver.body_b()); }, d.element);
  for (int b = 1; b < system.bodies(); ++b)
    if (!held[static_cast<std::size_t>(b)] && !is_beam_node(s.machine, system.body_name(b)))
      out.push_back(system.body_name(b));
  return out;
}

}  // namespace subsoil::sim
