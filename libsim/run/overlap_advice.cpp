#include "libsim/run/overlap_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "libdem/geometry/world_box.hpp"
#include "libdem/laws/eepa.hpp"
#include "libdem/laws/hysteretic.hpp"
#include "libdem/laws/linear.hpp"
#include "libdem/laws/luding.hpp"
#include "libdem/laws/variable_restitution.hpp"
#include "libdem/laws/wet.hpp"
#include "libdem/particles/fixed.hpp"
#include "libsim/run/deepest_contact.hpp"
#include "libsim/run/placement_report.hpp"
#include "libsim/scenario/given_law.hpp"

namespace subsoil::sim {
namespace {

/// The parameter that a law's force is in proportion to, as the scenario gives it.
struct Stiffness {
  const char* key;
  double value;
  const char* unit;
  double size;  ///< of the unit
};

std::optional<Stiffness> stiffness_of(const GivenLaw& law) {
  const auto given = [](const char* key, double value, const char* unit, double size) {
    return std::isnan(value) ? std::optional<Stiffness>{} : Stiffness{key, value, unit, size};
  };
  const auto first = [](std::optional<Stiffness> a, std::optional<Stiffness> b) { return a ? a : b; };
  if (const auto* linear = law.get_if<dem::Linear>()) return given("k_n", linear->k_n, "kN/m", 1e3);
  if (const auto* wet = law.get_if<dem::Wet>()) return given("K_X", wet->K_X, "kN/m", 1e3);
  if (const auto* luding = law.get_if<dem::Luding>()) return given("k1", luding->k1, "kN/m", 1e3);
  if (const auto* h = law.get_if<dem::Hysteretic>())
    return first(given("K1", h->K1, "kN/m", 1e3), given("yield strength", h->yield, "kPa", 1e3));
  if (const auto* e = law.get_if<dem::Eepa>())
    return first(e->n == 1 ? given("k1", e->k1, "kN/m", 1e3) : std::nullopt, given("E_eff", e->E_eff, "MPa", 1e6));
  if (const auto* v = law.get_if<dem::VariableRestitution>())
    return first(given("k_n", v->k_n, "kN/m", 1e3), given("E_eff", v->E_eff, "MPa", 1e6));
  return {};
}

/// A contact that is pressed for the first time, slowly.
class Pressed {
 public:
  Pressed(const dem::Law& law, double r_eff, double m_eff) : law_(law), r_eff_(r_eff), root_m_(std::sqrt(m_eff)) {}

  double force(double overlap) const {
    double memory[dem::kOwnMemory] = {};
    return law_->normal({.overlap = overlap, .rate = 0, .root_m = root_m_, .r_eff = r_eff_, .elapsed = 1e-6}, memory)
        .force;
  }
  /// At which it bears a force, m; `most` where it does not before.
  double overlap_under(double force_wanted, double most) const {
    double low = 0, high = most;
    if (force(most) < force_wanted) return most;
    for (int k = 0; k < 60; ++k) (force(0.5 * (low + high)) < force_wanted ? low : high) = 0.5 * (low + high);
    return high;
  }
  /// That it has taken up to an overlap, J.
  double energy(double overlap) const {
    double taken = 0;
    for (int k = 0; k < parts; ++k) taken += energy_of_part(k, overlap);
    return taken;
  }
  /// At which it has taken an energy, m.
  double overlap_after(double energy_taken, double most) const {
    double taken = 0;
    for (int k = 0; k < parts; ++k) {
      taken += energy_of_part(k, most);
      if (taken >= energy_taken) return (k + 1) * most / parts;
    }
    return most;
  }

 private:
  static constexpr int parts = 1000;  // of a way, each by its middle
  double energy_of_part(int k, double way) const { return std::max(0.0, force((k + 0.5) * way / parts)) * way / parts; }

  const dem::Law& law_;
  double r_eff_, root_m_;
};

/// `k_n of contacts.soil-steel at least 120 kN/m; step 0.6 times`, and the words of --set.
std::string stiffer(const Contact& contact, double factor) {
  const std::string name = "contacts." + contact.between[0] + "-" + contact.between[1];
  const double step = 1 / std::sqrt(factor);
  const auto k = stiffness_of(contact.law);
  if (!k) return fmt::format("{} {:.2g} times as stiff; step {:.2g} times", name, factor, step);
  const std::string value = fmt::format("{:.3g} {}", factor * k->value / k->size, k->unit);
  return fmt::format("{} of {} at least {} (now {:.3g}); step {:.2g} times: --set \"{}.{}={}\"", k->key, name, value,
                     k->value / k->size, step, name, k->key, value);
}

}  // namespace

namespace {

/// Whether a tool and a wall of the container leave the sphere less room than it needs: "`blade` is 3 mm from wall +x";
/// empty where they do not.
std::string squeezed_between(const dem::Sphere& s, const World& world) {
  for (const SurfaceRecord& w : world.surfaces) {
    if (w.owner != SurfaceRecord::Owner::container || !world.bed->boundary(w.boundary).active) continue;
    const dem::Boundary& wall = world.bed->boundary(w.boundary);
    const dem::Bounds face = dem::world_box(dem::bounds(wall.shape), wall.pose);
    const Vec3 size = face.high - face.low;
    const int axis = size.x <= size.y && size.x <= size.z ? 0 : size.y <= size.z ? 1 : 2;
    if (std::abs(s.x[axis] - face.low[axis]) > 2 * s.r) continue;
    for (const SurfaceRecord& t : world.surfaces) {
      const dem::Boundary& tool = world.bed->boundary(t.boundary);
      if (t.owner == SurfaceRecord::Owner::container || !t.moves || std::holds_alternative<dem::Plane>(tool.shape))
        continue;
      const dem::Bounds box = dem::world_box(dem::bounds(tool.shape), tool.pose);
      if (box.distance_squared(s.x) > 4 * s.r * s.r) continue;
      const double gap = std::max({0.0, box.low[axis] - face.high[axis], face.low[axis] - box.high[axis]});
      if (gap < 2 * s.r) return fmt::format("`{}` is {:.3g} mm from {} there", t.name, gap * 1e3, w.name);
    }
  }
  return {};
}

}  // namespace

std::string overlap_advice(const dem::BedFault& fault, const World& world, const Scenario& scenario) {
  if (!world.bed || fault.facts.kind != dem::BedFault::Kind::overlap) return {};
  const std::uint32_t id = fault.facts.sphere;
  const auto spheres = world.bed->spheres();
  const auto sphere = std::find_if(spheres.begin(), spheres.end(), [&](const dem::Sphere& s) { return s.id == id; });
  if (sphere == spheres.end()) return {};
  const DeepestContact deepest = deepest_contact(*sphere, world);
  if (deepest.material < 0) return {};
  const int law = world.laws.of(sphere->material, deepest.material);
  if (law < 0) return {};
  const Pressed contact(world.laws.laws[static_cast<std::size_t>(law)], deepest.r_eff, deepest.m_eff);
  const double force = contact.force(deepest.overlap);
  std::string text = fmt::format("sphere {} is pressed {:.3g} mm into {} with {:.3g} N", id, deepest.overlap * 1e3,
                                 deepest.other, force);
  if (const std::string wall = squeezed_between(*sphere, world); !wall.empty())
    return text + "; " + wall + ": end the run before, or make the container larger there";
  if (fault.facts.time <= 0)
    return text +
           fmt::format("; it is placed there: move it, or what it overlaps, by {:.3g} mm", deepest.overlap * 1e3);
  const double half = 0.5 * scenario.limits.overlap * sphere->r, wanted = contact.force(half);
  if (!(force > 0) || !(wanted > 0)) return text + "; move slower, or less deep, or make the law stiffer";
  // A soft contact that gives way is pressed on: the stiffer one bears more, so the factor is that of the overlaps too.
  double factor = std::max({2.0, force / wanted});
  // An impact lasts until its energy is taken, which a law in proportion to its stiffness takes within half the
  // limit.
  const double taken = contact.energy(deepest.overlap), moving = std::max(0.0, deepest.approach),
               coming = 0.5 * deepest.m_eff * moving * moving;
  if (coming > taken) factor = std::max(factor, (taken + coming) / contact.energy(half));
  return text + fmt::format("; half the limit takes {}; or move slower, or less deep",
                            stiffer(scenario.contacts[static_cast<std::size_t>(law)], factor));
}

namespace {

/// What is known beforehand of a surface that moves: its box below the soil's surface where it is deepest, and how it
/// goes there.
struct Ploughing {
  double depth = 0, width = 0, speed = 0;
  bool down = false;
};

dem::Bounds box_of(const std::vector<Vec3>& points, const dem::Pose& pose) {
  dem::Bounds box;
  for (const Vec3& p : points) box.include(pose.to_world(p));
  return box;
}

Ploughing ploughing(const dem::Bounds& box, const Vec3& velocity, double surface, double radius) {
  Ploughing out;
  out.depth = surface - box.low.y;
  out.speed = dem::norm(velocity);
  out.down = std::abs(velocity.y) > std::hypot(velocity.x, velocity.z);
  const Vec3 size = box.high - box.low;
  out.width = out.down ? std::min(size.x, size.z) : std::abs(velocity.x) >= std::abs(velocity.z) ? size.z : size.x;
  if (out.depth > 0) out.depth += radius, out.width += 2 * radius;
  return out;
}

double pressure(const Ploughing& p, double density, double gravity) {
  constexpr double phi = 35 * std::numbers::pi / 180;
  const double passive = std::pow(std::tan(std::numbers::pi / 4 + phi / 2), 2);
  const double weight = density * gravity, ram = density * p.speed * p.speed;
  if (p.down) return weight * (33 * p.depth + 0.3 * 48 * p.width) + ram;
  return weight * p.depth * passive * (0.5 + p.depth / p.width) + ram;
}

/// The deepest place that is known: along a given path, else where a body starts, at its speed or a driver's.
/// What lies wholly below the soil, or beside it along z, presses none.
Ploughing deepest_place(const SurfaceRecord& r, const World& world, const Scenario& s, double surface, double radius) {
  const dem::Boundary& b = world.bed->boundary(r.boundary);
  const std::vector<Vec3> points = dem::drawing(b.shape, 1.0)[r.mesh].vertices();
  Ploughing worst;
  const dem::Bounds soil = bed_box(world);
  const auto take = [&](const dem::Bounds& box, const Vec3& velocity) {
    if (box.high.y < soil.low.y || box.high.z < soil.low.z || box.low.z > soil.high.z) return;
    const Ploughing p = ploughing(box, velocity, surface, radius);
    if (p.speed > 0 && p.depth > worst.depth) worst = p;
  };
  if (r.owner == SurfaceRecord::Owner::machine) {
    const mbd::BodyState& body = world.machine->body(r.body);
    take(box_of(points, b.pose), {body.v.x, body.v.y, 0});
    return worst;
  }
  constexpr int places = 100;
  for (const coupling::GivenMotion& m : world.motions)
    for (int k = 1; m.boundary == r.boundary && k <= places; ++k) {
      const double dt = s.time.end / places;
      take(box_of(points, m.pose(k * dt)), (1 / dt) * (m.pose(k * dt).position - m.pose((k - 1) * dt).position));
    }
  return worst;
}

}  // namespace

ExpectedOverlap expected_overlap(const World& world, const Scenario& s) {
  ExpectedOverlap worst;
  if (!world.bed || world.bed->spheres().empty()) return worst;
  constexpr double tail = 10;            // of the largest contact force over the mean
  const dem::Sphere* largest = nullptr;  // fixed ones, such as those at the ends of a moving window, are not pressed
  for (const dem::Sphere& one : world.bed->spheres())
    if (!dem::is_fixed(one) && (largest == nullptr || one.r > largest->r)) largest = &one;
  if (largest == nullptr) return worst;
  const double r = largest->r, m = world.bed->mass_of_body(*largest), g = dem::norm(s.gravity),
               bulk = world.soil.bulk_density;
  for (const SurfaceRecord& record : world.surfaces) {
    const dem::Boundary& b = world.bed->boundary(record.boundary);
    if (record.owner == SurfaceRecord::Owner::container || !record.moves || std::holds_alternative<dem::Plane>(b.shape))
      continue;
    const int law = world.laws.of(largest->material, b.material);
    const Ploughing p = deepest_place(record, world, s, world.soil.surface_mean, r);
    if (law < 0 || !(p.depth > 0) || !(p.width > 0)) continue;
    const Pressed contact(world.laws.laws[static_cast<std::size_t>(law)], r, m);
    const double force = tail * pressure(p, bulk, g) * 4 * r * r, most = 2 * r;
    const double overlap =
        std::max(contact.overlap_under(force, most), contact.overlap_after(0.5 * m * p.speed * p.speed, most));
    if (overlap / r <= worst.share) continue;
    worst = {record.name, overlap / r, std::max(force, contact.force(overlap)), {}};
    const double wanted = contact.force(0.5 * s.limits.overlap * r);
    if (wanted > 0 && wanted < worst.force)
      worst.stiffness = stiffer(s.contacts[static_cast<std::size_t>(law)], worst.force / wanted);
  }
  return worst;
}

std::string overlap_text(const ExpectedOverlap& e, double limit) {
  std::string text = e.share >= 2 ? fmt::format("{} may press single spheres beyond their centres", e.tool)
                                  : fmt::format("{} may press single spheres {:.2g} radii deep", e.tool, e.share);
  text += fmt::format(" ({:.2g} N, within a factor of five); the run stops at {:.3g}", e.force, limit);
  if (e.share > limit && !e.stiffness.empty())
    text += "; half of it takes " + e.stiffness + "; or slower, or less deep";
  return text;
}

}  // namespace subsoil::sim
