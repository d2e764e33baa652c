#include "libsim/run/surface_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libdem/packing/measure.hpp"
#include "libdem/particles/fixed.hpp"
#include "libsim/scenario/gravity.hpp"

namespace subsoil::sim {
namespace {

dem::Bounds box_at(const std::vector<Vec3>& points, const dem::Pose& pose) {
  dem::Bounds box;
  for (const Vec3& p : points) box.include(pose.to_world(p));
  return box;
}

double between(const dem::Bounds& a, const dem::Bounds& b) {
  Vec3 gap;
  gap.x = std::max({0.0, a.low.x - b.high.x, b.low.x - a.high.x});
  gap.y = std::max({0.0, a.low.y - b.high.y, b.low.y - a.high.y});
  gap.z = std::max({0.0, a.low.z - b.high.z, b.low.z - a.high.z});
  return dem::norm(gap);
}

double largest(const Vec3& v) { return std::max({v.x, v.y, v.z}); }

/// Of the sizes that are asked for: `check` looks at a lattice of spheres of mean size.
double smallest_radius(const World& world) {
  double radius = world.bed->spheres().front().r;
  for (const dem::Sphere& s : world.bed->spheres()) radius = std::min(radius, s.r);
  for (const PossibleImpact& i : world.step.impacts) radius = std::min(radius, i.question.smallest_radius);
  return radius;
}

/// Largest length of a wall of the container; 0 without one.
double widest_wall(const World& world) {
  double width = 0;
  for (const SurfaceRecord& r : world.surfaces)
    if (r.owner == SurfaceRecord::Owner::container) {
      const dem::Bounds box = dem::bounds(world.bed->boundary(r.boundary).shape);
      width = std::max(width, largest(box.high - box.low));
    }
  return width;
}

bool is_from_file(const Scenario& scenario, const SurfaceRecord& record) {
  const auto is = [&](const auto& all) {
    return std::any_of(all.begin(), all.end(), [&](const auto& one) {
      return one.name == record.name && std::holds_alternative<MeshShape>(one.shape);
    });
  };
  if (record.owner == SurfaceRecord::Owner::given) return is(scenario.boundaries);
  return scenario.machine && is(scenario.machine->surfaces);
}

}  // namespace

std::vector<SurfaceFacts> surface_facts(const World& world, const Scenario& scenario, double end) {
  std::vector<SurfaceFacts> out;
  if (!world.bed) return out;
  const bool soil = !world.bed->spheres().empty();
  const dem::Bounds bed = soil ? dem::box_of(world.bed->spheres()) : dem::Bounds{};
  // Soil that is poured, or driven by fixed spheres, comes to a surface that stands still.
  const bool comes = !world.inlets.empty() ||
                     std::any_of(world.bed->spheres().begin(), world.bed->spheres().end(), [](const dem::Sphere& s) {
                       return dem::is_fixed(s) && (s.v != Vec3{} || s.w != Vec3{});
                     });
  for (const SurfaceRecord& r : world.surfaces) {
    if (r.owner == SurfaceRecord::Owner::container) continue;
    const dem::Boundary& b = world.bed->boundary(r.boundary);
    SurfaceFacts facts{r.name, {}, {}};
    facts.from_file = is_from_file(scenario, r);
    if (std::holds_alternative<dem::Plane>(b.shape)) {
      facts.low = Vec3{-INFINITY, -INFINITY, -INFINITY}, facts.high = -facts.low;
      out.push_back(facts);
      continue;
    }
    const dem::TriangleMesh mesh = dem::drawing(b.shape, 1.0)[r.mesh];
    if (std::holds_alternative<dem::MeshSurface>(b.shape))
      facts.triangles = mesh.triangles().size(), facts.closed = mesh.closed();
    const dem::Bounds start = box_at(mesh.vertices(), b.pose);
    facts.low = start.low, facts.high = start.high;
    facts.path_known = r.owner == SurfaceRecord::Owner::given && !comes;
    facts.from_soil = soil ? between(start, bed) : 0;
    facts.below = soil && acts_down(scenario.gravity) && start.high.y <= bed.low.y;
    for (const coupling::GivenMotion& m : world.motions) {
      if (m.boundary != r.boundary) continue;
      facts.servo = m.servo.has_value();  // the load decides where it stops, its speed limit how far it may come
      for (int k = 1; soil && k <= 100; ++k) {
        dem::Pose pose = m.pose(end * k / 100);
        if (m.servo) pose.position += (m.servo->limit * end * k / 100) * m.servo->along;
        facts.from_soil = std::min(facts.from_soil, between(box_at(mesh.vertices(), pose), bed));
      }
    }
    out.push_back(facts);
  }
  return out;
}

std::string surface_text(const SurfaceFacts& f, const World& world) {
  if (!std::isfinite(f.low.x)) return f.name + ": a plane";
  const Vec3 size = f.high - f.low;
  std::string text = fmt::format("{}: {:.3g} x {:.3g} x {:.3g} m", f.name, size.x, size.y, size.z);
  if (f.triangles > 0) text += fmt::format(", {} triangles, {}", f.triangles, f.closed ? "closed" : "open");
  if (world.bed->spheres().empty()) return text;
  const char* when = !f.path_known ? " at the start" : f.servo ? ", where its servo goes at its speed limit" : "";
  return text + (f.from_soil > 0 ? fmt::format(", {:.3g} m from the soil{}", f.from_soil, when)
                                 : fmt::format(", in reach of the soil{}", when));
}

std::vector<std::string> surface_warnings(const std::vector<SurfaceFacts>& facts, const World& world) {
  std::vector<std::string> out;
  if (!world.bed || world.bed->spheres().empty()) return out;
  const dem::Bounds bed = dem::box_of(world.bed->spheres());
  const double width = largest(bed.high - bed.low);
  const double radius = smallest_radius(world), walls = widest_wall(world);
  for (const SurfaceFacts& f : facts) {
    if (!std::isfinite(f.low.x)) continue;
    const double size = largest(f.high - f.low);
    // A number with its unit beside it is wrong less often than a file's, and a wide plate may stand below little soil.
    const double most = f.from_file ? 30 * width : 100 * std::max(width, walls);
    if (size > most || size < 0.5 * radius)
      out.push_back(fmt::format(
          "{} is {:.3g} m large, the soil {:.3g} m, its smallest sphere has a diameter of {:.3g} m: is the "
          "unit of its numbers right?{}",
          f.name, size, width, 2 * radius, f.from_file ? " `unit: mm` takes them as a thousandth of `unit: m`" : ""));
    if (!f.closed)
      out.push_back(f.name +
                    ": its mesh is open: it has no inside, and both its sides act; close its holes if it is a "
                    "solid");
    if (f.path_known && f.from_soil > 0 && !f.below)
      out.push_back(f.servo
                        ? fmt::format("{} comes no nearer than {:.3g} m to the soil, even where its servo goes at its "
                                      "speed limit throughout",
                                      f.name, f.from_soil)
                        : fmt::format("{} comes no nearer than {:.3g} m to the soil on its path", f.name, f.from_soil));
  }
  for (std::string& text : restitution_warnings(world.step)) out.push_back(std::move(text));
  return out;
}

}  // namespace subsoil::sim
