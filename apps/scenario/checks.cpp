#include "apps/scenario/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "apps/scenario/printer.hpp"
#include "libmbd/forces/ground_element.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/measures/force.hpp"
#include "libmbd/measures/reaction.hpp"

namespace subsoil::app {

Place place_of(const Places& places, std::string path) {
  for (;;) {
    const auto found = places.find(path);
    if (found != places.end()) return found->second;
    if (path.empty()) return {};
    const std::size_t cut = path.find_last_of(".[");
    path.resize(cut == std::string::npos ? 0 : cut);
  }
}

namespace {

using Names = std::vector<std::string>;

template <class T>
Names names_of(const std::vector<T>& values) {
  Names names;
  for (const T& value : values) names.push_back(value.name);
  return names;
}
bool holds(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

struct Checker {
  Scenario& s;
  const Places& places;
  Problems& problems;

  void refuse(const std::string& path, const std::string& rule) { problems.add(place_of(places, path), path, rule); }
  void refuse(const std::string& path, const std::string& value, const std::string& rule) {
    problems.add(place_of(places, path), path, value, rule);
  }
  void refer(const std::string& path, const std::string& name, const Names& known, const char* what) {
    if (name.empty() || holds(known, name)) return;
    refuse(path, name, fmt::format("there is no {} of this name{}", what, suggestion(name, known)));
  }
  void positive(const std::string& path, const Vec3& size) {
    if (size.x <= 0 || size.y <= 0 || size.z <= 0) refuse(path, "all lengths must be above zero");
  }
  void direction(const std::string& path, const Vec3& d) {
    if (d == Vec3{}) refuse(path, "a direction must not be the zero vector");
  }
  void material(const std::string& path, const std::string& name) {
    refer(path, name, names_of(s.materials), "material");
  }

  void all() {
    if (!s.soil && !s.machine && s.boundaries.empty()) {
      refuse("scenario", "there is nothing to simulate; give `soil`, `machine` or both");
    }
    if (s.soil) soil();
    boundaries();
    if (s.machine) machine();
    contacts();
    time();
    output();
  }

  // -- soil --

  void soil() {
    if (s.soil->container) container(*s.soil->container);
    if (s.soil->bed) bed(*s.soil->bed);
    if (s.soil->surface && !(s.soil->bed && s.soil->container)) {
      refuse("soil.surface", "needs a container and a bed, which are shifted so that the bed's surface is there");
    }
  }

  void container(const Container& c) {
    positive("soil.container.size", c.size);
    material("soil.container.material", c.material);
    for (std::size_t i = 0; i < 6; ++i) {
      if (c.open[i] && c.open_after_settling[i]) {
        refuse("soil.container.open after settling",
               fmt::format("the face {} is open from the start; take it out of one of the lists", face_names[i]));
      }
    }
  }

  /// A key that a fill needs, or that would have no effect with it.
  void fits(bool given, bool needed, bool allowed, const char* key, const std::string& fill) {
    const std::string path = std::string("soil.bed.") + key;
    if (needed && !given) refuse(path, fmt::format("is missing; `fill: {}` needs it", fill));
    if (given && !allowed) refuse(path, fmt::format("has no effect with `fill: {}`; leave it out", fill));
  }

  void bed(const Bed& b) {
    static constexpr std::array<const char*, 5> words{"lattice", "rest-lattice", "random", "particles", "file"};
    const std::string fill = words[static_cast<std::size_t>(b.fill)];
    const bool made = b.fill <= Fill::random, grid = b.fill <= Fill::rest_lattice;
    const bool each = !b.layers.empty() && std::all_of(b.layers.begin(), b.layers.end(), has_radius);
    const bool equal = (each || std::holds_alternative<EqualRadius>(b.radius)) &&
                       std::all_of(b.layers.begin(), b.layers.end(),
                                   [](const Layer& l) { return std::holds_alternative<EqualRadius>(l.radius); });
    const auto given = [&](const char* key) { return places.contains(std::string("soil.bed.") + key); };
    fits(given("radius"), made && !each, made, "radius", fill);
    fits(given("file"), b.fill == Fill::file, b.fill == Fill::file, "file", fill);
    fits(given("particles"), b.fill == Fill::particles, b.fill == Fill::particles, "particles", fill);
    fits(given("count"), false, b.fill == Fill::random, "count", fill);
    fits(given("depth"), false, made, "depth", fill);
    fits(given("region"), made && !s.soil->container, made, "region", fill);
    fits(given("pitch"), b.fill == Fill::lattice && !equal, grid, "pitch", fill);
    fits(b.jitter != 0, false, grid, "jitter", fill);
    if (b.fill == Fill::rest_lattice && !equal) {
      refuse("soil.bed.radius", "a rest-lattice needs spheres of one size; take `fill: random` for a distribution");
    }
    if (given("count") && given("depth")) refuse("soil.bed.count", "stands beside `depth`; keep one of them");
    if (b.region) positive("soil.bed.region.size", b.region->size);
    const bool own = b.fill == Fill::particles && std::none_of(b.particles.begin(), b.particles.end(),
                                                               [](const Particle& p) { return p.material.empty(); });
    if (b.material.empty() && !own && b.layers.empty())
      refuse("soil.bed.material", "is missing: the material of the spheres");
    material("soil.bed.material", b.material);
    for (std::size_t i = 0; i < b.particles.size(); ++i) {
      material(fmt::format("soil.bed.particles[{}].material", i), b.particles[i].material);
    }
    distribution("soil.bed.radius", b.radius);
    if (!b.layers.empty()) layers(b, made, each);
    if (b.settle && b.settle->duration.has_value() == b.settle->until_speed.has_value()) {
      refuse("soil.bed.settle", "needs either `for` (a time) or `until` (a speed)");
    }
  }

  static bool has_radius(const Layer& l) {
    const auto* equal = std::get_if<EqualRadius>(&l.radius);
    return equal == nullptr || !std::isnan(equal->radius);
  }

  static double largest_radius(const RadiusDistribution& radius) {
    if (const auto* equal = std::get_if<EqualRadius>(&radius)) return equal->radius;
    if (const auto* normal = std::get_if<NormalRadius>(&radius)) return normal->largest;
    if (const auto* uniform = std::get_if<UniformRadius>(&radius)) return uniform->largest;
    const auto& table = std::get<TableRadius>(radius).radius;
    return *std::max_element(table.begin(), table.end());
  }

  void layers(const Bed& b, bool made, bool each) {
    if (!b.material.empty())
      refuse("soil.bed.material", "stands beside `layers`, which give the materials; leave it out");
    if (b.count) refuse("soil.bed.count", "stands beside `layers`, whose thicknesses say how much; leave it out");
    if (each && places.contains("soil.bed.radius"))
      refuse("soil.bed.radius", "has no effect: every layer has a radius of its own; leave it out");
    for (std::size_t i = 0; i < b.layers.size(); ++i) {
      const Layer& l = b.layers[i];
      const std::string path = fmt::format("soil.bed.layers[{}]", i);
      material(path + ".material", l.material);
      if (has_radius(l) && !made)
        refuse(path + ".radius", "has no effect with spheres that are given one by one; leave it out");
      distribution(path + ".radius", l.radius);
      const bool last = i + 1 == b.layers.size(), one_form = b.layers[0].depth.has_value() == l.depth.has_value();
      if (l.thickness && l.depth)
        refuse(path + ".depth", "stands beside `thickness`; keep one of them");
      else if (!l.thickness && !l.depth && !last)
        refuse(path, "needs `thickness` or `depth`; only the lowest layer may leave both out");
      else if ((l.thickness || l.depth) && !one_form)
        refuse(path, "gives its place in another way than the first layer; take `thickness` for all, or `depth`");
    }
    if (problems.empty()) extents(b, made);
  }

  /// Thicknesses that are known, against each other and against the bed.
  void extents(const Bed& b, bool made) {
    double end = 0;
    for (std::size_t i = 0; i < b.layers.size(); ++i) {
      const Layer& l = b.layers[i];
      const std::string path = fmt::format("soil.bed.layers[{}]", i);
      if (l.depth && std::abs((*l.depth)[0] - end) > 1e-9)
        refuse(path + ".depth", fmt::format("must begin where the layer above ends, at {:.6g} mm", end * 1e3));
      if (l.depth && (*l.depth)[1] <= (*l.depth)[0]) refuse(path + ".depth", "must end deeper than it begins");
      end = l.depth ? (*l.depth)[1] : end + l.thickness.value_or(0);
    }
    if (!made) return;  // how deep they reach is seen when the spheres are there
    const bool open = !b.layers.back().thickness && !b.layers.back().depth;
    const double room = b.region ? b.region->size.y : s.soil->container ? s.soil->container->size.y : end;
    const double depth = b.depth.value_or(open ? room : end), last = open ? depth - end : 0;
    if (b.depth && !open && std::abs(end - depth) > 1e-9)
      refuse("soil.bed.depth",
             fmt::format("the layers are {:.6g} mm deep together, not {:.6g} mm; change one, or leave "
                         "the depth or the lowest layer's thickness out",
                         end * 1e3, depth * 1e3));
    else if (depth > room + 1e-9)
      refuse("soil.bed.layers",
             fmt::format("are {:.6g} mm deep together, the region holds {:.6g} mm; make them thinner "
                         "or the region higher",
                         depth * 1e3, room * 1e3));
    else
      sphere_fits(b, last);
  }

  /// @param last thickness of a lowest layer that takes the rest, m
  void sphere_fits(const Bed& b, double last) {
    for (std::size_t i = 0; i < b.layers.size(); ++i) {
      const Layer& l = b.layers[i];
      const double thick = l.depth ? (*l.depth)[1] - (*l.depth)[0] : l.thickness.value_or(last);
      const double diameter = 2 * largest_radius(has_radius(l) ? l.radius : b.radius);
      if (thick >= diameter * (1 - 1e-9)) continue;
      refuse(
          fmt::format("soil.bed.layers[{}]", i),
          fmt::format("is {:.6g} mm thick, less than its largest sphere's diameter {:.6g} mm; make it thicker, or its "
                      "spheres smaller",
                      thick * 1e3, diameter * 1e3));
    }
  }

  void distribution(const std::string& path, const RadiusDistribution& radius) {
    if (const auto* n = std::get_if<NormalRadius>(&radius)) {
      if (n->least > n->mean || n->mean > n->largest || n->least >= n->largest) {
        refuse(path, "must have least <= normal <= largest, and least below largest");
      }
    } else if (const auto* t = std::get_if<TableRadius>(&radius)) {
      double sum = 0;
      for (std::size_t i = 0; i < t->radius.size(); ++i) {
        if (t->radius[i] <= 0 || t->share[i] < 0) {
          refuse(path + ".table", "must have radii above zero and shares of zero or more");
          return;
        }
        sum += t->share[i];
      }
      if (!(sum > 0)) refuse(path + ".table", "must have a share above zero");
    }
  }

  // -- boundaries and surfaces --

  void shape(const std::string& path, const Shape& shape) {
    if (const auto* plane = std::get_if<PlaneShape>(&shape)) direction(path + ".plane.normal", plane->normal);
    if (const auto* box = std::get_if<BoxShape>(&shape)) positive(path + ".box", box->size);
    if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) direction(path + ".cylinder.axis", cylinder->axis);
  }

  void boundaries() {
    Names names;
    for (std::size_t i = 0; i < s.boundaries.size(); ++i) {
      const Boundary& b = s.boundaries[i];
      const std::string path = fmt::format("boundaries[{}]", i);
      if (!b.name.empty() && holds(names, b.name)) refuse(path + ".name", b.name, "stands twice; names must differ");
      names.push_back(b.name);
      material(path + ".material", b.material);
      shape(path + ".shape", b.shape);
      direction(path + ".rotation.axis", b.rotation.axis);
      for (std::size_t k = 0; k < b.moves.size(); ++k) {
        if (b.moves[k].from >= b.moves[k].until) {
          refuse(fmt::format("{}.moves[{}].until", path, k), "must be later than `from`");
        }
      }
    }
  }

  // -- machine --

  void machine() {
    Machine& m = *s.machine;
    if (m.bodies.empty()) refuse("machine.bodies", "is missing: a machine has at least one body");
    unique_names(m);
    const Names bodies = names_of(m.bodies);
    for (Surface& surface : m.surfaces) {
      const std::string path = "machine.surfaces." + surface.name;
      refer(path + ".body", surface.body, bodies, "body");
      const auto found = std::find(bodies.begin(), bodies.end(), surface.body);
      surface.body_index = found == bodies.end() ? 0 : static_cast<int>(found - bodies.begin()) + 1;
      material(path + ".material", surface.material);
      shape(path, surface.shape);
      direction(path + ".rotation.axis", surface.rotation.axis);
      if (s.soil && surface.touches_soil && surface.material.empty()) {
        refuse(path + ".material", "is missing; a surface in soil needs a material, or `touches soil: no`");
      }
    }
    measures(m);
    for (const NamedForce& force : m.forces)
      if (const auto* friction = force.element.get_if<mbd::JointFriction>())
        refer("machine.forces." + force.name + ".joint friction", friction->joint, names_of(m.joints), "joint");
    wheels(m);
  }

  void measures(const Machine& m) {
    for (const NamedMeasure& measure : m.measures) {
      const std::string path = "machine.measures." + measure.name;
      if (const auto* reaction = measure.element.get_if<mbd::ReactionMeasure>())
        refer(path + ".reaction", reaction->element, names_of(m.joints), "joint");
      if (const auto* force = measure.element.get_if<mbd::ForceMeasure>())
        refer(path + ".force", force->element, names_of(m.forces), "force");
      for (const Watch& watch : s.output.watch)
        if (watch.name == measure.name)
          refuse("output.watch." + watch.name, "is a measure of the machine, which is a column by itself; drop one");
      if (measure.name == "time") refuse(path, "the name is that of the first column; take another");
    }
  }

  /// Names become columns: one thing per name, over bodies, markers, joints, drivers, forces, measures and boundaries.
  void unique_names(const Machine& m) {
    std::map<std::string, std::string> taken;
    for (const Boundary& b : s.boundaries) taken.emplace(b.name, "boundaries");
    const auto take = [&](const Names& names, const char* family) {
      for (const std::string& name : names) {
        const auto [there, fresh] = taken.emplace(name, family);
        if (!fresh) {
          refuse(fmt::format("machine.{}.{}", family, name),
                 fmt::format("the name stands among the {} too; names in the results must differ", there->second));
        }
      }
    };
    take(names_of(m.bodies), "bodies");
    take(names_of(m.markers), "markers");
    take(names_of(m.joints), "joints");
    take(names_of(m.drivers), "drivers");
    take(names_of(m.forces), "forces");
    take(names_of(m.measures), "measures");
  }

  void wheels(const Machine& m) {
    if (!s.soil || !s.soil->bed) return;
    for (const NamedForce& force : m.forces) {
      const auto* wheel = force.element.get_if<mbd::WheelOnSoil>();
      const auto* ground = force.element.get_if<mbd::GroundElement>();
      if (wheel == nullptr && ground == nullptr) continue;
      for (const Surface& surface : m.surfaces) {
        if (surface.body_index != (wheel ? wheel->body : ground->body) || !surface.touches_soil) continue;
        refuse("machine.forces." + force.name,
               fmt::format("the {} carries `{}`, and so would the spheres under its surface `{}`; leave the law "
                           "out, or give the surface `touches soil: no`",
                           wheel ? "wheel law" : "ground element", surface.body, surface.name));
      }
    }
  }

  // -- contacts --

  static std::pair<std::string, std::string> ordered(const std::string& a, const std::string& b) {
    return a < b ? std::pair{a, b} : std::pair{b, a};
  }

  void contacts() {
    std::map<std::pair<std::string, std::string>, std::size_t> given;
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
      const auto& [a, b] = s.contacts[i].between;
      const std::string path = fmt::format("contacts[{}]", i);
      material(path + ".between", a);
      if (a != b) material(path + ".between", b);
      const auto [there, fresh] = given.emplace(ordered(a, b), i);
      if (!fresh && !a.empty()) {
        refuse(path + ".between", fmt::format("[{}, {}]", a, b),
               fmt::format("this pair has a law already, in line {}; keep one of them",
                           place_of(places, fmt::format("contacts[{}]", there->second)).line));
      }
      elastic(path, s.contacts[i]);
    }
    for (const auto& [pair, meet] : meetings()) {
      if (given.contains(pair)) continue;
      refuse("contacts", fmt::format("{} and {} can meet ({}) but have no law; add `- between: [{}, {}]`", pair.first,
                                     pair.second, meet, pair.first, pair.second));
    }
  }

  /// A law that computes its stiffness needs the materials' elastic constants, one whose bodies yield their strength.
  void elastic(const std::string& path, const Contact& contact) {
    const MaterialNeeds needs = material_needs(contact.law);
    if (needs.in_place_of_elastic != nullptr)
      of_materials(path, contact, needs.law, needs.in_place_of_elastic, "young's modulus and poisson ratio",
                   [](const Material& m) { return m.young && m.poisson; });
    if (needs.in_place_of_yield != nullptr)
      of_materials(path, contact, needs.law, needs.in_place_of_yield, "yield strength",
                   [](const Material& m) { return m.yield.has_value(); });
  }
  template <class Has>
  void of_materials(const std::string& path, const Contact& contact, const std::string& word, const char* instead,
                    const char* what, Has has) {
    for (const std::string& name : std::set<std::string>{contact.between[0], contact.between[1]}) {
      const auto m =
          std::find_if(s.materials.begin(), s.materials.end(), [&](const Material& x) { return x.name == name; });
      if (m == s.materials.end() || has(*m)) continue;
      refuse(path + ".law", word,
             fmt::format("material `{}` has no {}; give {} there, or {} here", name, what,
                         std::string_view(what).find(" and ") == std::string_view::npos ? "it" : "them", instead));
    }
  }

  /// Pairs of materials that can touch, and how; only of names that exist.
  std::map<std::pair<std::string, std::string>, std::string> meetings() {
    std::map<std::pair<std::string, std::string>, std::string> pairs;
    if (!s.soil || !s.soil->bed) return pairs;
    const Names known = names_of(s.materials);
    std::set<std::string> spheres{s.soil->bed->material};
    for (const Particle& p : s.soil->bed->particles) {
      if (!p.material.empty()) spheres.insert(p.material);
    }
    for (const Layer& l : s.soil->bed->layers) spheres.insert(l.material);
    const auto meet = [&](const std::string& other, const std::string& how) {
      for (const std::string& sphere : spheres) {
        if (holds(known, sphere) && holds(known, other)) pairs.emplace(ordered(sphere, other), how);
      }
    };
    for (const std::string& sphere : spheres) meet(sphere, "spheres with each other");
    if (s.soil->container) meet(s.soil->container->material, "spheres and the container's walls");
    for (const Boundary& b : s.boundaries) meet(b.material, fmt::format("spheres and the boundary `{}`", b.name));
    if (s.machine) {
      for (const Surface& surface : s.machine->surfaces) {
        if (surface.touches_soil) meet(surface.material, fmt::format("spheres and the surface `{}`", surface.name));
      }
    }
    return pairs;
  }

  // -- time and output --

  void time() {
    if (s.runs_in_time() && !places.contains("time.end")) refuse("time.end", "is missing: simulated time, in s");
    if (s.analysis != Analysis::dynamics && (s.has_bed() || !s.machine)) {
      refuse("analysis", analysis_names[static_cast<std::size_t>(s.analysis)],
             "looks at a machine without soil and boundaries; take `dynamics`, or leave soil and boundaries out");
    }
    if (s.soil && s.machine && s.time.machine.step) {
      refuse("time.machine.step",
             "has no effect with soil, where it is the soil step times `soil steps per machine step`");
    }
    if (!s.soil && s.time.soil_step) refuse("time.soil step", "has no effect without soil; leave it out");
  }

  void output() {
    const Output& o = s.output;
    for (std::size_t i = 0; i < o.at.size(); ++i) {
      if (o.at[i] > s.time.end) {
        refuse("output.at", fmt::format("{} s", o.at[i]),
               fmt::format("is after the end of the run at {} s", s.time.end));
      }
    }
    if (o.region) positive("output.region.size", o.region->size);
    if (o.window.from && o.window.until && *o.window.from >= *o.window.until) {
      refuse("output.window.until", "must be later than `from`");
    }
    for (const Watch& watch : o.watch) this->watch("output.watch." + watch.name, watch);
  }

  void watch(const std::string& path, const Watch& watch) {
    const Machine none, &m = s.machine ? *s.machine : none;
    Names bodies = names_of(m.bodies), joints = names_of(m.joints), drivers = names_of(m.drivers),
          forces = names_of(m.forces), measures = names_of(m.measures);
    Names touched = bodies;
    for (const Boundary& b : s.boundaries) touched.push_back(b.name);
    for (const Surface& surface : m.surfaces)
      if (surface.touches_soil) touched.push_back(surface.name);
    if (s.soil && s.soil->container) touched.push_back("container");
    switch (watch.kind) {
      case Watch::Kind::driver:
        refer(path, watch.of, drivers, "driver");
        break;
      case Watch::Kind::force:
        refer(path, watch.of, forces, "force");
        break;
      case Watch::Kind::joint:
        refer(path, watch.of, joints, "joint");
        break;
      case Watch::Kind::soil_force:
      case Watch::Kind::soil_moment:
        refer(path, watch.of, touched, "body or boundary");
        break;
      case Watch::Kind::column: {
        const std::size_t dot = watch.of.find('.');
        if (dot == std::string::npos) break;  // a column of the whole run, such as an energy
        Names all = touched;
        for (const Names* more : {&joints, &drivers, &forces, &measures})
          all.insert(all.end(), more->begin(), more->end());
        const std::string owner = watch.of.substr(0, dot);
        if (!holds(all, owner)) {
          refuse(path, watch.of, fmt::format("nothing is named `{}`{}", owner, suggestion(owner, all)));
        }
        break;
      }
    }
  }
};

}  // namespace

void check(Scenario& scenario, const Places& places, Problems& problems) { Checker{scenario, places, problems}.all(); }

}  // namespace subsoil::app
