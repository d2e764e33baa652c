#include "libsim/run/input_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "libdem/geometry/world_box.hpp"
#include "libdem/laws/contact.hpp"
#include "libdem/packing/carve.hpp"
#include "libdem/particles/fixed.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/joints/gear_pair.hpp"
#include "libmbd/joints/rack_and_pinion.hpp"
#include "libmbd/system/deep_start.hpp"
#include "libsim/document/library.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/run/exchange_advice.hpp"
#include "libsim/run/surface_meeting.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/scenario/shapes/mesh_file.hpp"
#include "libsim/setup/approach_speed.hpp"
#include "libsim/setup/container.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/shown_area.hpp"
#include "libsim/setup/travel_direction.hpp"

namespace subsoil::sim {
namespace {

using Texts = std::vector<std::string>;

void look_at_mesh(const std::string& name, const Shape& shape, Texts& out) {
  const auto* mesh = std::get_if<MeshShape>(&shape);
  if (mesh == nullptr) return;
  const MeshFile file = load_mesh(mesh->file, mesh->unit);
  const std::size_t count = file.mesh.triangles().size();
  if (file.repeated > 0)
    out.push_back(
        fmt::format("{}: {} of the {} triangles of its file stand there already and were dropped; export it once", name,
                    file.repeated, count + file.repeated + file.flat));
  if (file.flat > 0)
    out.push_back(fmt::format("{}: {} of the {} triangles of its file have no area and were dropped", name, file.flat,
                              count + file.repeated + file.flat));
  if (file.mesh.closed() && file.turned > 0)
    out.push_back(
        file.turned == count
            ? fmt::format("{}: its file is inside out (all {} normals point inward); it was turned", name, count)
            : fmt::format("{}: {} of {} triangles of its file are wound the other way than their neighbours; "
                          "they were turned",
                          name, file.turned, count));
}

void look_at_meshes(const Scenario& s, Texts& out) {
  for (const BoundarySection& b : s.boundaries) look_at_mesh(b.name, b.shape, out);
  if (!s.machine) return;
  for (const Surface& surface : s.machine->surfaces) look_at_mesh(surface.name, surface.shape, out);
}

/// From snow to steel.
void look_at_densities(const Loaded& loaded, Texts& out) {
  constexpr double light = 100, heavy = 25000;
  for (const Material& m : loaded.scenario.materials)
    if (m.density < light || m.density > heavy)
      out.push_back(fmt::format("{} = {:.3g} kg/m^3: no soil or tool is so {}; 1.8 g/cm^3 are 1800 kg/m^3",
                                loaded.where("materials." + m.name + ".density"), m.density,
                                m.density < light ? "light" : "heavy"));
}

/// A saved bed keeps the densities it was filled with. Fibres are laid on it; their spheres weigh what the rod does.
void look_at_densities_of_file(const Loaded& loaded, const World& world, Texts& out) {
  constexpr double rounding = 1e-6;
  const Scenario& s = loaded.scenario;
  if (!s.soil || !s.soil->bed || s.soil->bed->fill != Fill::file) return;
  for (std::size_t k = 0; k < s.materials.size(); ++k) {
    const Material& m = s.materials[k];
    double count = 0, least = std::numeric_limits<double>::infinity(), most = 0;
    for (const dem::Sphere& one : world.bed->spheres()) {
      const double density = dem::density(one);
      // Of a clump that a rough floor holds the spheres that it is made of are left, which share its mass.
      if (dem::is_fixed(one) && !world.bed->clump_shapes().empty()) continue;
      if (one.id >= world.soil.fibres_from || one.kind == dem::SphereKind::member ||
          one.material != static_cast<int>(k) || std::abs(density / m.density - 1) < rounding)
        continue;
      ++count, least = std::min(least, density), most = std::max(most, density);
    }
    if (count == 0) continue;
    const std::string of_file =
        most / least - 1 < rounding ? fmt::format("{:.6g}", least) : fmt::format("{:.6g} to {:.6g}", least, most);
    out.push_back(
        fmt::format("{}: {:.0f} spheres of `{}` have the {} kg/m^3 of the file, not the {:.6g} kg/m^3 of "
                    "`materials.{}.density`: give the material the file's density, or fill and save the bed with the "
                    "material's (in a CSV file leave the column out)",
                    loaded.where("soil.bed.file"), count, m.name, of_file, m.density, m.name));
  }
}

void look_at_container(const Loaded& loaded, const World& world, Texts& out) {
  const Scenario& s = loaded.scenario;
  if (!s.soil || !s.soil->container || !s.soil->bed || world.bed->spheres().empty()) return;
  const Vec3& size = s.soil->container->size;
  double volume = 0;
  for (const dem::Sphere& one : world.bed->spheres()) volume += dem::sphere_volume(one.r);
  const double layer = size.x * size.z * 2 * world.bed->spheres().front().r;
  if (volume < 0.05 * layer)
    out.push_back(
        fmt::format("{}: the bed covers {:.2g} of the container's floor of {:.4g} by {:.4g} m; is the unit right?",
                    loaded.where("soil.container.size"), volume / layer, size.x, size.z));
  Faces walls{}, open{};
  for (std::size_t f = 0; f < walls.size(); ++f) {
    open[f] = s.soil->container->open_after_settling[f];
    walls[f] = keeps_wall(*s.soil->container, f);
  }
  const Vec3 low = s.soil->container->at + Vec3{0, world.container_shift, 0}, high = low + size;
  if (const std::size_t count = spheres_beyond(walls, s, world, open); count > 0)
    out.push_back(fmt::format(
        "{}: {} of {} spheres start beyond a wall of the container, which holds ({:.4g}, {:.4g}, "
        "{:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m: are their places and units right?",
        loaded.where("soil.bed"), count, world.bed->spheres().size(), low.x, low.y, low.z, high.x, high.y, high.z));
}

/// Where an inlet's grains come: the box, or that of the disk.
dem::Bounds region_of(const InletSection& inlet) {
  if (inlet.box) return {inlet.box->at, inlet.box->at + inlet.box->size};
  const Vec3 n = dem::normalized(inlet.disk->normal);
  Vec3 half;
  for (int d = 0; d < 3; ++d) half[d] = inlet.disk->radius * std::sqrt(std::max(0.0, 1 - n[d] * n[d]));
  return {inlet.disk->at - half, inlet.disk->at + half};
}

void look_at_inlets(const Loaded& loaded, const World& world, Texts& out) {
  const Scenario& s = loaded.scenario;
  if (!s.soil || !s.soil->container) return;
  const Vec3 low = s.soil->container->at + Vec3{0, world.container_shift, 0}, high = low + s.soil->container->size;
  const double rounding = 1e-9 * dem::norm(s.soil->container->size);
  for (const InletSection& inlet : s.soil->inlets) {
    const dem::Bounds region = region_of(inlet);
    for (std::size_t f = 0; f < std::tuple_size_v<Faces>; ++f) {
      const auto d = static_cast<int>(f / 2);
      const bool upper = f % 2 != 0;
      const double beyond = upper ? region.high[d] - high[d] : low[d] - region.low[d];
      if ((d == 1 && upper) || !keeps_wall(*s.soil->container, f) || beyond <= rounding) continue;
      out.push_back(
          fmt::format("{}: reaches {:.4g} mm beyond the {} of the container, {} = {:.4g} m: grains that come "
                      "there miss the bin; is its place right?",
                      loaded.where("soil.inlets." + inlet.name), beyond * 1e3, d == 1 ? "floor" : "wall", "xyz"[d],
                      upper ? high[d] : low[d]));
    }
  }
}

/// A region of the frames without a sphere, and motions that begin when the run has ended.
void look_at_places(const Loaded& loaded, const World& world, Texts& out) {
  const Scenario& s = loaded.scenario;
  if (const auto& region = s.output.region; region && world.inlets.empty()) {
    const Vec3 low = region->at, high = region->at + region->size;
    const bool any = std::any_of(world.bed->spheres().begin(), world.bed->spheres().end(), [&](const dem::Sphere& one) {
      const Vec3& p = one.x;
      return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z && p.z <= high.z;
    });
    if (!any)
      out.push_back(loaded.where("output.region") +
                    ": none of the spheres is in it at the start; frames hold those that come into it, if any do");
  }
  for (const BoundarySection& b : s.boundaries)
    for (const Move& m : b.moves)
      if (m.from >= s.time.end)
        out.push_back(fmt::format("{}: a motion begins at {:.4g} s, when the run has ended at {:.4g} s",
                                  loaded.where("boundaries." + b.name + ".moves"), m.from, s.time.end));
}

void look_at_carved(const Loaded& loaded, const World& world, Texts& out) {
  const double taken = static_cast<double>(world.soil.carved), left = static_cast<double>(world.bed->spheres().size());
  if (taken > left)
    out.push_back(
        fmt::format("{}: {:.0f} of {:.0f} spheres lay inside tools or boundaries and were removed: are their sizes and "
                    "places right?",
                    loaded.where("soil.bed.inside machine"), taken, taken + left));
  if (world.soil.unsettled_inside > 0)
    out.push_back(
        fmt::format("{}: {} spheres of the bed as it is poured lie where a tool or boundary stands; settled it lies "
                    "lower, and the run is refused if any still does",
                    loaded.where("soil.bed"), world.soil.unsettled_inside));
}

/// Outlines, which are drawn and may touch each other, against the soil beside them.
void look_at_outlines(const Loaded& loaded, const World& world, Texts& out) {
  const Scenario& s = loaded.scenario;
  if (!s.machine || world.bed->spheres().empty()) return;
  dem::Bounds soil;
  for (const dem::Sphere& one : world.bed->spheres()) soil.include(one.x);
  if (s.soil && s.soil->container)
    soil.include(s.soil->container->at), soil.include(s.soil->container->at + s.soil->container->size);
  for (const BodySection& b : s.machine->bodies) {
    dem::Bounds box;
    for (const Vec2& p : b.outline) box.include(Vec3{p[0], p[1], 0});
    if (b.outline.empty() || box.diagonal() < 100 * soil.diagonal()) continue;
    out.push_back(fmt::format("{} is {:.3g} m large, the soil {:.3g} m: is the unit of its numbers right?",
                              loaded.where("machine.bodies." + b.name + ".outline"), box.diagonal(), soil.diagonal()));
  }
}

/// A bed that hangs above its floor or did not come to rest falls in the run, and a tool meets other soil than was
/// meant.
void look_at_rest(const Loaded& loaded, const World& world, Texts& out) {
  const Scenario& s = loaded.scenario;
  if (!s.soil || !s.soil->bed || world.bed->spheres().empty()) return;
  double lowest = std::numeric_limits<double>::infinity(), radius = 0;
  for (const dem::Sphere& one : world.bed->spheres())
    lowest = std::min(lowest, one.x.y - one.r), radius = std::max(radius, one.r);
  const bool open_below = s.soil->container && s.soil->container->open[2];
  const double gravity = dem::norm(s.gravity), rest = std::sqrt(0.2 * gravity * radius);
  if (s.soil->container && !open_below && s.soil->bed->fill == Fill::file && gravity > 0 && acts_down(s.gravity)) {
    const double gap = lowest - s.soil->container->at.y - world.container_shift;
    if (gap > radius)
      out.push_back(fmt::format(
          "{}: this bed hangs {:.3g} mm above the container's floor and falls on it; put `soil.container.at` "
          "where the bed was saved",
          loaded.where("soil.bed.file"), gap * 1e3));
  }
  if (world.soil.settled_for > 0 && !world.soil.stopped && gravity > 0 && world.soil.rms_speed > rest)
    out.push_back(
        fmt::format("{}: the bed is not at rest when the run begins: rms speed {:.3g} m/s, above {:.3g} m/s, "
                    "that of a fall by a tenth of a radius; let it settle longer",
                    loaded.where("soil.bed.settle"), world.soil.rms_speed, rest));
}

/// Names of the scenario's materials with those of the library that they are.
std::vector<std::pair<std::string, std::string>> library_names(const std::string& file, const Texts& sets,
                                                               const std::string* text) {
  Problems problems;
  const Node document =
      text != nullptr ? parse_document(*text, file, sets, problems) : read_document(file, sets, problems);
  std::vector<std::pair<std::string, std::string>> out;
  const Node::Entry* materials = document.find("materials");
  if (materials == nullptr) return out;
  for (const Node::Entry& e : materials->value.entries)
    if (const Node::Entry* library = e.value.find("library")) out.emplace_back(e.key, library->value.scalar);
  return out;
}

void look_at_library(const Loaded& loaded, const World& world, const std::string& file, const Texts& sets,
                     const std::string* text, Texts& out) {
  for (const auto& [name, of] : library_names(file, sets, text)) {
    const LibraryMaterial& material = library_material(of);
    if (material.radius.empty()) continue;
    const int index = material_index(loaded.scenario, name);
    double sum = 0, count = 0;
    for (const dem::Sphere& s : world.bed->spheres())
      if (s.material == index) sum += s.r, ++count;
    const double wanted = parse_quantity(material.radius, "m"), mean = count > 0 ? sum / count : wanted;
    if (std::abs(mean / wanted - 1) < 0.1) continue;
    out.push_back(
        fmt::format("{}: `{}` of the library was measured with spheres of {}, these have {:.3g} mm: their bed is "
                    "of another strength; measure it (`subsoil test shear`), or calibrate it again",
                    name, of, material.radius, mean * 1e3));
  }
}

/// Gains that let a servo jump over its load: within half of what is stable (coupling/servo.hpp), with as many contacts
/// as spheres lie side by side under it.
void look_at_servos(const Loaded& loaded, const World& world, Texts& out) {
  const auto spheres = world.bed->spheres();
  if (spheres.empty()) return;
  const dem::Sphere& one = spheres.front();
  for (const coupling::GivenMotion& m : world.motions) {
    if (!m.servo) continue;
    const dem::Boundary& b = world.bed->boundary(m.boundary);
    const int law = world.laws.of(one.material, b.material);
    if (law < 0) continue;
    const dem::StiffnessBound of = world.laws.laws[static_cast<std::size_t>(law)]->bound(
        {.m_eff = world.bed->mass_of_body(one), .r_eff = one.r, .r_min = one.r, .speed = world.step.expected_speed});
    const bool plane = std::holds_alternative<dem::Plane>(b.shape);
    const double area = plane ? 0 : shown_area(b, m.servo->along, world.bed->options().periodic);
    const double contacts = plane ? std::pow(static_cast<double>(spheres.size()), 2.0 / 3) : area / (4 * one.r * one.r);
    const double dt = world.step.soil_step, lag = std::max(m.servo->lag, 0.5 * dt), gain = m.servo->gain * contacts;
    const double share = std::max(gain * of.c_n * dt / (2 * lag), gain * of.k_n * dt * dt / (4 * lag));
    if (share > 0.5)
      out.push_back(fmt::format(
          "{}: the servo of {} is too eager for some {:.0f} contacts ({:.2g} of what is stable): it may chatter; lower "
          "`speed limit` or `gain`, or raise `lag`",
          loaded.where("boundaries"), b.name, contacts, share));
  }
}

/// Depth and surface are measured along y.
void look_at_gravity(const Loaded& loaded, const World& world, Texts& out) {
  const Vec3& g = loaded.scenario.gravity;
  if (acts_down(g) || world.bed->spheres().empty()) return;
  out.push_back(fmt::format(
      "{}: gravity acts along ({:.3g}, {:.3g}, {:.3g}) m/s2: bulk density and surface of the bed, and depths below it, "
      "are measured along y and left out or without sense; turn the scenario so that gravity acts along -y",
      loaded.where("gravity"), g.x, g.y, g.z));
}

/// Speed of a fall over all that spheres and surfaces lie apart along gravity, or over the whole run.
double speed_of_fall(const Scenario& s, const World& world) {
  const double g = dem::norm(s.gravity);
  const Vec3 down = dem::normalized(s.gravity);
  double low = -std::numeric_limits<double>::infinity(), high = -low;  // along gravity
  const auto include = [&](const Vec3& p) {
    low = std::max(low, dem::dot(p, down)), high = std::min(high, dem::dot(p, down));
  };
  for (const dem::Sphere& one : world.bed->spheres()) include(one.x);
  for (int k = 0; k < world.bed->boundary_count(); ++k) {
    const dem::Boundary& b = world.bed->boundary(k);
    const auto* plane = std::get_if<dem::Plane>(&b.shape);
    include(plane != nullptr ? b.pose.to_world(plane->point()) : dem::world_box(dem::bounds(b.shape), b.pose).low);
  }
  return std::min(std::sqrt(2 * g * (low - high)), g * s.time.end);
}

/// A velocity in float grows in each step by g dt rounded to its spacing, 2^-23 of it or down to half of that: N
/// spacings to a step err by up to 1/(2 N) of g, in one direction as long as the speed keeps its order.
void look_at_mixed_precision(const Loaded& loaded, const World& world, Texts& out) {
  constexpr double least = 200;  // spacings: a quarter of a percent
  const Scenario& s = loaded.scenario;
  const double gain = dem::norm(s.gravity) * world.step.soil_step;
  if (s.precision != dem::Precision::mixed || world.bed->spheres().empty() || !(gain > 0)) return;
  const double speed = std::max(world.step.expected_speed, speed_of_fall(s, world));
  const double spacing = std::exp2(std::floor(std::log2(speed)) - 23);
  if (gain >= least * spacing) return;
  out.push_back(
      fmt::format("{}: in a step of {:.3g} s gravity adds {:.2g} m/s, {:.2g} times what float resolves at {:.3g} m/s: "
                  "free falls are "
                  "wrong by up to {:.2g} of g; take `precision: double`, or a longer step",
                  loaded.where("precision"), world.step.soil_step, gain, gain / spacing, speed, 0.5 * spacing / gain));
}

/// The meniscus is a cylinder up to V/R^3 = 0.01 (libdem/laws/cohesion.hpp).
void look_at_bridges(const Loaded& loaded, const World& world, Texts& out) {
  constexpr double valid = 0.01;
  const Scenario& s = loaded.scenario;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    const std::optional<double> volume = liquid_volume(s.contacts[k].law);
    if (!volume) continue;
    const int a = material_index(s, s.contacts[k].between[0]), b = material_index(s, s.contacts[k].between[1]);
    double of_a = 0, of_b = 0;  // the smallest radii
    for (const dem::Sphere& one : world.bed->spheres()) {
      if (one.material == a) of_a = of_a > 0 ? std::min(of_a, one.r) : one.r;
      if (one.material == b) of_b = of_b > 0 ? std::min(of_b, one.r) : one.r;
    }
    if (!(of_a + of_b > 0)) continue;
    const double r = of_a > 0 && of_b > 0 ? of_a * of_b / (of_a + of_b) : std::max(of_a, of_b),
                 share = *volume / (r * r * r);
    if (share > valid)
      out.push_back(
          fmt::format("{}: a bridge of {:.3g} mm3 has {:.2g} of r_eff^3 between the smallest spheres, r_eff = {:.3g} "
                      "mm; its law holds "
                      "to {:g}, {:.3g} mm3",
                      loaded.where(fmt::format("contacts[{}].liquid volume", k)), *volume * 1e9, share, r * 1e3, valid,
                      valid * r * r * r * 1e9));
  }
}

/// A boundary on a given path yields as little as a fixed sphere in it.
void look_at_fixed(const Loaded& loaded, const World& world, Texts& out) {
  const Scenario& s = loaded.scenario;
  constexpr int places = 400;
  if (world.moving) return;  // its fixed spheres hold the ends of the window, which moves on
  for (const coupling::GivenMotion& m : world.motions) {
    if (m.servo) continue;
    const dem::Boundary& b = world.bed->boundary(m.boundary);
    const dem::Sphere* first = nullptr;
    double when = 0;
    for (const dem::Sphere& one : world.bed->spheres()) {
      if (!dem::is_fixed(one) || world.laws.of(one.material, b.material) < 0) continue;
      for (int k = 0; k <= places; ++k) {
        const double t = s.time.end * k / places;
        dem::Boundary there = b;
        there.pose = m.pose(t);
        dem::Sphere now = one;
        now.x += t * one.v;
        if (!dem::inside_or_overlapping(now, there, -s.limits.overlap * one.r)) continue;
        if (first == nullptr || t < when) first = &one, when = t;
        break;
      }
    }
    if (first == nullptr) continue;
    out.push_back(
        fmt::format("{}: `{}` is driven into the fixed sphere {}: at {:.3g} s it is {:.3g} of the radius deep, where "
                    "`limits.overlap` stops the run; both keep their motion whatever acts on them: end it before, move "
                    "the boundary by a servo or a machine, or let the sphere go",
                    loaded.where("boundaries"), b.name, first->id, when, s.limits.overlap));
  }
}

/// Friction that is regularised fades where mu_s would act when its Stribeck speed is not well above that speed.
void look_at_friction(const World& world, Texts& out) {
  if (!world.machine) return;
  for (const auto& f : world.machine->system().model().forces) {
    const auto* const friction = f.element.get_if<mbd::JointFriction>();
    if (friction == nullptr || friction->can_stick() || !(friction->mu_s > friction->mu_k)) continue;
    const double largest = friction->largest_mu();
    if (largest > 0.5 * (friction->mu_s + friction->mu_k)) continue;
    out.push_back(
        fmt::format("{}: its friction is {:.3g} of the normal force at the most, not mu_s = {:g}: it fades below the "
                    "regularisation "
                    "speed of {:g} m/s, and the Stribeck speed of {:g} m/s is not above that; make the first smaller, "
                    "or give a `stick stiffness`",
                    f.name, largest, friction->mu_s, friction->regularisation_speed, friction->stribeck_speed));
  }
}

/// Gears out of mesh. The motion knows the ratio of radii alone, or the radius of a pinion: centres that other joints
/// hold elsewhere, as radii in another unit would have them, give other tooth forces than the radii.
void look_at_gears(const Loaded& loaded, const World& world, Texts& out) {
  if (!world.machine) return;
  constexpr double profile_shift = 0.02;  // of the radii: pitch circles given in place of the rolling ones
  const auto& bodies = world.machine->system().scene().bodies;
  for (const auto& joint : world.machine->system().model().joints) {
    const auto look = [&](const auto* gears, double size) {
      const double room =
          gears->room(bodies[static_cast<std::size_t>(gears->body_a)], bodies[static_cast<std::size_t>(gears->body_b)]);
      if (!(std::abs(room) > profile_shift * size)) return;
      out.push_back(fmt::format(
          "{}: the pitch lines are {:.3g} m {} at the start: the joint turns by the radii, but its "
          "force acts where the centres have it; put the centres at the radii's distance, or "
          "correct the radii",
          loaded.where("machine.joints." + joint.name), std::abs(room), room > 0 ? "apart" : "in each other"));
    };
    if (const auto* const pair = joint.element.get_if<mbd::GearPair>())
      look(pair, std::min(pair->radius_a, pair->radius_b));
    if (const auto* const rack = joint.element.get_if<mbd::RackAndPinion>()) look(rack, rack->radius);
  }
}

/// Contacts, stops and cylinders whose start pose is beyond their range, by what they store there.
void look_at_start(const World& world, Texts& out) {
  if (!world.machine) return;
  for (const mbd::DeepStart& d :
       mbd::deep_starts(world.machine->system(), world.machine->integrator().state().acceleration)) {
    const std::string weight = d.weight > 0 ? fmt::format(", {:.3g} times the machine's weight{}", d.push / d.weight,
                                                          d.angular ? " at the machine's length" : "")
                                            : "";
    out.push_back(
        fmt::format("{}: the machine starts {:.3g} {} beyond where its contact or stop begins; that stores {:.3g} J "
                    "and pushes with {:.3g} {}{}: the motion starts with this blow. Start within its range, or in "
                    "equilibrium (`machine.start: {{towing equilibrium: 0 m/s}}`)",
                    d.force, d.depth, d.angular ? "rad" : "m", d.energy, d.push, d.angular ? "N m" : "N", weight));
  }
}

/// Wheels whose axle begins below the surface: a law of sinkage says nothing there.
void look_at_wheels(const Loaded& loaded, const World& world, Texts& out) {
  if (!world.machine) return;
  for (const auto& f : world.machine->system().model().forces)
    if (const auto* const wheel = f.element.get_if<mbd::WheelOnSoil>()) {
      const double depth = wheel->surface - world.machine->body(wheel->body).r.y;
      if (depth > 0)
        out.push_back(
            fmt::format("{}: the axle begins {:.3g} m below the surface, of a wheel with a radius of {:.3g} m: its law "
                        "is of a wheel that rolls on soil; place the wheel higher, or correct `surface`",
                        loaded.where("machine.forces." + f.name), depth, wheel->radius));
    }
}

/// Events at the force in a joint that shares its load with others: which share it has no constraint says.
void look_at_shared_events(const Loaded& loaded, const World& world, Texts& out) {
  if (!world.machine) return;
  const mbd::AssemblyReport& assembly = world.machine->assembly();
  for (const JointEventSection& e : loaded.scenario.machine->events) {
    if (!e.reaction_above) continue;
    const mbd::PartName joint{mbd::PartName::Kind::joint, e.opens.empty() ? e.closes : e.opens};
    const auto shares = [&](const std::vector<mbd::PartName>& group) {
      return std::find(group.begin(), group.end(), joint) != group.end();
    };
    const auto& groups = assembly.redundant_parts;
    const auto group = std::find_if(groups.begin(), groups.end(), shares);
    if (group == groups.end()) continue;
    out.push_back(
        fmt::format("{}: {}, so the force in '{}' is not determined: the event sees the share of minimum "
                    "norm. Free the constraint that is too many, or open at a measure",
                    loaded.where("machine.events." + e.name + ".reaction above"),
                    assembly.redundant[static_cast<std::size_t>(group - groups.begin())], joint.name));
  }
}

/// Events that nothing brings about as the machine starts: a time after the end, a value that is passed already, a
/// joint that is as the event would leave it.
void look_at_events(const Loaded& loaded, const World& world, Texts& out) {
  if (!world.machine) return;
  const std::vector<std::string>& names = world.machine->column_names();
  std::vector<double> values(names.size());
  world.machine->columns(values);
  const auto column_of = [&](const std::string& name) -> std::optional<std::size_t> {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - names.begin()));
  };
  for (const JointEventSection& e : loaded.scenario.machine->events) {
    const std::string path = "machine.events." + e.name;
    if (e.at && *e.at > loaded.scenario.time.end)
      out.push_back(fmt::format("{}: {:g} s is after the end of the run, {:g} s: the event never comes",
                                loaded.where(path + ".at"), *e.at, loaded.scenario.time.end));
    const bool closes = !e.closes.empty(), starts = !(world.machine->time() > 0);  // else it may have come before
    const std::string& joint = closes ? e.closes : e.opens;
    const auto open = column_of(joint + ".open");
    const bool done = open && values[*open] == (closes ? 0 : 1);
    std::vector<const JointEventSection*> reversing;
    for (const JointEventSection& other : loaded.scenario.machine->events)
      if ((closes ? other.opens : other.closes) == joint) reversing.push_back(&other);
    const bool too_early = std::all_of(reversing.begin(), reversing.end(), [&](const JointEventSection* other) {
      return e.at && other->at && *other->at > *e.at;
    });
    const bool itself = e.at && *e.at <= world.machine->time();  // what has done it
    if (starts && done && e.at && too_early && !itself)
      out.push_back(fmt::format("{}: '{}' is {} then, so the event changes nothing{}", loaded.where(path + ".at"),
                                joint, closes ? "closed" : "open",
                                reversing.empty() ? "" : fmt::format("; `{}` comes later", reversing.front()->name)));
    const auto measure = column_of(e.measure);
    if (!measure) continue;
    const std::string& unit = world.machine->column_units()[*measure];
    const bool above = !e.above.empty();
    const double value = values[*measure], level = parse_quantity(above ? e.above : e.below, unit);
    if (above ? value <= level : value >= level) continue;
    if (done && (!starts || reversing.empty())) continue;
    const std::string advice =
        done     ? fmt::format("After `{}` it comes only then: give another value if it is wanted at once",
                               reversing.front()->name)
        : closes ? "Let the joint start closed (`joint starts: closed`), or give another value"
                 : "Let the joint start open (`joint starts: open`), or give another value";
    out.push_back(fmt::format(
        "{}: `{}` starts at {:.6g} {}, {} {} already: the event comes when it has returned and passes again. {}",
        loaded.where(path + (above ? ".above" : ".below")), e.measure, value, unit, above ? "above" : "below",
        above ? e.above : e.below, advice));
  }
}

/// Gravity across the plane in which the machine moves.
void look_at_gravity_across(const Loaded& loaded, const World& world, Texts& out) {
  if (!world.machine || loaded.scenario.gravity.z == 0) return;
  out.push_back(
      fmt::format("{}: its z component of {:g} m/s^2 acts on spheres alone: the machine moves in the x-y plane",
                  loaded.where("gravity"), loaded.scenario.gravity.z));
}

/// Its window never moves.
void look_at_moving_soil(const Loaded& loaded, const World& world, Texts& out) {
  if (!world.moving) return;
  double way = way_of_drivers(loaded.scenario, world);
  for (const coupling::GivenMotion& m : world.motions)
    if (m.boundary == world.moving->boundary) way = m.pose(loaded.scenario.time.end).position.x - m.pose(0).position.x;
  if (way * world.moving->window.plan().direction < 0)
    out.push_back(fmt::format(
        "{}: what it follows goes the other way, so the window never moves; give the direction of its travel",
        loaded.where("soil.moving.towards")));
}

/// From so many parts of a machine step on `ida` is faster: beside soil, and alone, where it may take longer steps.
constexpr double many_parts = 50, many_parts_alone = 1000;

void look_at_beams(const Loaded& loaded, const World& world, Texts& out) {
  const StepReport& step = world.step;
  const Scenario& s = loaded.scenario;
  if (!s.runs_in_time() || !(step.machine_parts > (world.bed ? many_parts : many_parts_alone))) return;
  out.push_back(fmt::format(
      "{}the fastest waves of the beams divide each machine step of {:.3g} s into {:.0f} parts, {:.2g} in the run, "
      "which takes most of the time; `time.machine.integrator: ida` needs none, and fewer elements or less damping ask "
      "for fewer",
      s.time.machine.integrator == IntegratorWord::adams_moulton ? "time.machine.integrator = adams-moulton: " : "",
      step.machine_step, step.machine_parts, step.machine_parts * s.time.end / step.machine_step));
}

}  // namespace

std::vector<std::string> input_warnings(const Loaded& loaded, const World& world, const std::string& file,
                                        const std::vector<std::string>& sets, const std::string* text) {
  Texts out;
  look_at_meshes(loaded.scenario, out);
  look_at_friction(world, out);
  look_at_start(world, out);
  look_at_wheels(loaded, world, out);
  look_at_gears(loaded, world, out);
  look_at_shared_events(loaded, world, out);
  look_at_events(loaded, world, out);
  look_at_beams(loaded, world, out);
  look_at_gravity_across(loaded, world, out);
  if (!world.bed) return out;
  look_at_densities(loaded, out);
  look_at_densities_of_file(loaded, world, out);
  look_at_container(loaded, world, out);
  look_at_moving_soil(loaded, world, out);
  look_at_inlets(loaded, world, out);
  look_at_places(loaded, world, out);
  look_at_carved(loaded, world, out);
  look_at_outlines(loaded, world, out);
  look_at_rest(loaded, world, out);
  look_at_library(loaded, world, file, sets, text, out);
  look_at_servos(loaded, world, out);
  look_at_gravity(loaded, world, out);
  look_at_mixed_precision(loaded, world, out);
  look_at_bridges(loaded, world, out);
  look_at_fixed(loaded, world, out);
  for (const std::string& text : exchange_warnings(loaded, world)) out.push_back(text);
  if (world.machine)
    for (const std::string& text : SurfaceMeeting(world).may_meet(world, loaded.scenario.time.end)) out.push_back(text);
  return out;
}

}  // namespace subsoil::sim
