#include "libsim/scenario/sections/bed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/keys/either_quantity.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

void describe(Fields& v, Settle& s) {
  v.quantity("for", s.duration, "s", "(0, inf)", "settle for this long");
  v.quantity("until", s.until_speed, "m/s", "(0, inf)", "settle until the spheres' rms speed is below this");
  v.quantity("at most", s.at_most, "s", "(0, inf)", "a bed that is not at rest by then stops the run");
  EitherQuantity to("kg/m^3", s.density, "Pa", s.pressure, "a density (1450 kg/m^3) or a pressure (20 kPa)");
  v.visit_value({"to",
                 "a density: the bed is poured with all its friction and compacted with less until it has this bulk "
                 "density; a pressure: a plate of the container's size presses on the bed, layer by layer, until it is "
                 "at rest, and is taken off; left out: as it comes to rest"},
                to);
  v.choice("stages", s.stages, {{"auto", Stages::automatic}, {"yes", Stages::yes}, {"no", Stages::no}},
           "first without attraction and with lowered friction and rolling, then both raised, then at rest again; "
           "auto: for random fill");
  v.quantity("lowered", s.lowered, "1", "[0, 1]", "factor on friction and rolling in the first stage");
  v.quantity("ramp", s.ramp, "s", "(0, inf)", "time over which attraction, friction and rolling come back");
}

void describe(Fields& v, Particle& p) {
  v.vector("position", p.position, "m", "of the centre, beside the container as given: `soil.surface` shifts both");
  v.vector("velocity", p.velocity, "m/s", "at the start");
  v.vector("angular velocity", p.spin, "rad/s", "at the start");
  v.quantity("radius", p.radius, "m", "(0, inf)", "radius");
  v.quantity("density", p.density, "kg/m^3", "(0, inf)", "left out: of its material");
  v.optional_reference("material", p.material, Family::material, "left out: the bed's");
  v.text(
      "fixed", p.fixed,
      "a name: the sphere keeps its velocity and spin (none: its place) whatever acts on it; the force on all spheres "
      "of one name are columns of the series, NAME.Fx ...; left out: it moves");
}

void describe(Fields& v, Layer& l) {
  v.quantity("thickness", l.thickness, "m", "(0, inf)", "left out in the lowest layer: down to the floor");
  v.vector("depth", l.depth, "m", "in place of the thickness: where it begins and ends below the surface");
  v.reference("material", l.material, Family::material, "of its spheres");
  v.optional_form("radius", l.radius, "radius of its spheres, or a distribution; left out: the bed's");
  v.list("clumps", l.clumps, "random fill: how many of its grains are clumps");
}

void describe(Fields& v, BedSection& b) {
  v.choice("fill", b.fill,
           {{"lattice", Fill::lattice},
            {"rest-lattice", Fill::rest_lattice},
            {"random", Fill::random},
            {"particles", Fill::particles},
            {"file", Fill::file}},
           "lattice: cubic grid of the given pitch; rest-lattice: cubic grid of the pitch at which the law is at rest; "
           "random: rained down; particles: listed here; file: a saved bed");
  v.optional_reference("material", b.material, Family::material, "of the spheres");
  v.list("layers", b.layers,
         "in place of the material: layers from the surface down; without `depth` they decide how deep the bed is");
  v.optional_form("radius", b.radius, "radius of the spheres, or a distribution; not for particles and file");
  v.choice("shares", b.shares, {{"number", ShareOf::number}, {"mass", ShareOf::mass}},
           "what the distribution of radii counts");
  v.quantity("pitch", b.pitch, "m", "(0, inf)",
             "of the lattice; left out: 2.02 radii, or for rest-lattice from the law");
  v.section("region", b.region, "box that is filled; left out: the container");
  v.count("count", b.count, "[1, 100000000]", "random fill: number of spheres");
  v.quantity("depth", b.depth, "m", "(0, inf)",
             "fill up to this height above the lower side of the region; left out: the region's height");
  v.count("seed", b.seed, "[0, inf)", "of the random numbers; the same seed gives the same bed");
  v.quantity("jitter", b.jitter, "1", "[0, 0.5]", "largest random shift of a lattice site, share of the radius");
  v.section("settle", b.settle, "let the bed come to rest before time 0; left out: it starts as filled");
  v.output_file("save", b.save, "HDF5 file that keeps the bed after settling");
  v.optional_file(
      "file", b.file,
      "saved bed: HDF5, or CSV whose first line names columns and units: x [m],y [m],z [m],radius [mm], and "
      "where wanted id,material,density [kg/m^3],vx [m/s],...,wx [rad/s],...; spheres are numbered by id. A "
      "density in the file comes before that of the material");
  v.list("particles", b.particles,
         "the spheres, one by one; beside random fill and lattices: fixed ones, stones in the bed. Grains of a lattice "
         "that overlap them are left out");
  v.list("clumps", b.clumps,
         "random fill and lattice: how many of the grains are clumps, each in an attitude of its own by the seed");
  v.list("placed", b.placed, "fill: particles: clumps, one by one; they are numbered after the particles");
  v.named("fibres", b.fibres,
          "flexible fibres by name, straw or roots: rows of bonded spheres that are laid on the bed once it lies; the "
          "bed then settles again, where it settles");
  v.quantity(
      "rough floor", b.rough_floor, "m", "(0, inf)",
      "spheres whose centres lie lower than this above the container's floor when the run begins keep their place: "
      "a floor as rough as the bed; the force on them are the columns `rough floor.Fx` ...; left out: none");
  v.choice("inside machine", b.inside_machine, {{"refuse", Overlap::refuse}, {"carve", Overlap::carve}},
           "spheres inside a machine's surface at the start: refuse the run, or take them out");
}

bool any_clumps(const BedSection& bed) {
  return !bed.clumps.empty() ||
         std::any_of(bed.layers.begin(), bed.layers.end(), [](const Layer& l) { return !l.clumps.empty(); });
}

namespace {

struct BedChecks : Checks {
  const Scenario& s;

  void bed(const BedSection& b) {
    static constexpr std::array<const char*, 5> words{"lattice", "rest-lattice", "random", "particles", "file"};
    const std::string fill = words[static_cast<std::size_t>(b.fill)];
    const bool made = b.fill <= Fill::random, grid = b.fill <= Fill::rest_lattice;
    const bool each = !b.layers.empty() && std::all_of(b.layers.begin(), b.layers.end(), needs_no_radius);
    const bool equal = (each || std::holds_alternative<EqualRadius>(b.radius)) &&
                       std::all_of(b.layers.begin(), b.layers.end(),
                                   [](const Layer& l) { return std::holds_alternative<EqualRadius>(l.radius); });
    const auto given = [&](const char* key) { return places.contains(std::string("soil.bed.") + key); };
    const bool spheres = made && !only_clumps(b.clumps);
    fits(given("radius"), spheres && !each, made, "radius", fill);
    if (made && !spheres && given("radius"))
      refuse("soil.bed.radius", "has no effect: all grains are clumps; leave it out, or lower their shares");
    fits(given("file"), b.fill == Fill::file, b.fill == Fill::file, "file", fill);
    fits(given("particles"), b.fill == Fill::particles && b.placed.empty(), b.fill != Fill::file, "particles", fill);
    if (given("particles") && b.particles.empty() && b.placed.empty())
      refuse("soil.bed.particles", "is empty; list a sphere at least, or leave `soil` out");
    fits(given("count"), false, b.fill == Fill::random, "count", fill);
    fits(given("depth"), false, made, "depth", fill);
    fits(given("region"), made && !s.soil->container, made, "region", fill);
    fits(given("pitch"), b.fill == Fill::lattice && !equal, grid, "pitch", fill);
    fits(b.jitter != 0, false, grid, "jitter", fill);
    if (b.fill == Fill::rest_lattice && !equal && b.clumps.empty()) {
      refuse("soil.bed.radius", "a rest-lattice needs spheres of one size; take `fill: random` for a distribution");
    }
    if (b.fill == Fill::random && !acts_down(s.gravity)) poured_along_y(s);
    if (given("count") && given("depth")) refuse("soil.bed.count", "stands beside `depth`; keep one of them");
    if (b.region) positive("soil.bed.region.size", b.region->size);
    const bool own =
        b.fill == Fill::particles &&
        std::none_of(b.particles.begin(), b.particles.end(), [](const Particle& p) { return p.material.empty(); }) &&
        std::none_of(b.placed.begin(), b.placed.end(), [](const PlacedClump& c) { return c.material.empty(); });
    if (b.material.empty() && !own && b.layers.empty())
      refuse("soil.bed.material", "is missing: the material of the spheres");
    material("soil.bed.material", b.material);
    for (std::size_t i = 0; i < b.particles.size(); ++i) {
      material(fmt::format("soil.bed.particles[{}].material", i), b.particles[i].material);
      if (!b.particles[i].fixed.empty())
        fixed(b, i);
      else if (made)
        refuse(fmt::format("soil.bed.particles[{}]", i),
               "moves: beside a bed that is made particles are fixed; give it `fixed: NAME`, or list all spheres with "
               "`fill: particles`");
    }
    const auto is_fixed = [](const Particle& p) { return !p.fixed.empty(); };
    if (!b.save.empty() && std::any_of(b.particles.begin(), b.particles.end(), is_fixed))
      refuse("soil.bed.save", "would keep fixed particles as spheres that move; leave one of them out");
    if (made && !b.particles.empty() && s.soil->moving)
      refuse("soil.bed.particles", "stands beside `soil.moving`; leave one of them out");
    if (b.rough_floor) rough_floor(b);
    if (!only_clumps(b.clumps)) check_distribution(*this, "soil.bed.radius", b.radius);
    if (!b.layers.empty()) layers(b, made, each);
    if (b.settle) settle(b, *b.settle);
    if (b.settles() && dem::norm(s.gravity) == 0) without_gravity(b);
  }

  void without_gravity(const BedSection& b) {
    const Settle to = b.settle.value_or(Settle{});
    if (to.compacts())
      refuse("soil.bed.settle.to", "needs gravity; leave it out");
    else if (!b.settle)
      refuse("soil.bed.fill", "random",
             "pours spheres and lets them come to rest, which needs gravity; give `gravity`, or take `fill: lattice`");
    else if (to.staged(b.fill))
      refuse("soil.bed.settle", "needs gravity to settle in stages; give `stages: no`");
  }

  void settle(const BedSection& b, const Settle& to) {
    const bool both = to.duration && to.until_speed;
    const bool rained = b.fill == Fill::random;  // until it is at rest, where nothing is said
    if (both || (!rained && !to.compacts() && !to.duration && !to.until_speed))
      refuse("soil.bed.settle",
             "needs `for` (a time), `until` (a speed) or `to` (a density or a pressure); `for` and `until` exclude "
             "each other");
    if (!to.compacts()) return;
    const char* const path = "soil.bed.settle.to";
    if (!acts_down(s.gravity)) refuse(path, "needs gravity along -y; leave it out");
    if (!s.soil->container) refuse(path, "needs a container, whose walls hold the bed while it is compacted; give one");
    if (to.density && !b.layers.empty())
      refuse(path, "is one density for several layers; give a pressure, which compacts them one by one");
    for (const Material& m : s.materials)
      if (to.density && m.name == b.material && *to.density >= m.density)
        refuse(path, fmt::format("{:.4g} kg/m^3", *to.density),
               fmt::format("must be below the density of the grains, {:.4g} kg/m^3; a bed has about 0.6 of it",
                           m.density));
  }

  void fixed(const BedSection& b, std::size_t i) {
    const Particle& p = b.particles[i];
    const std::string path = fmt::format("soil.bed.particles[{}].fixed", i);
    if (p.fixed.find('.') != std::string::npos || p.fixed.find(',') != std::string::npos)
      refuse(path, p.fixed, "is no name: its columns would be read as others; leave out dots and commas");
    if (b.settles() && dem::dot(p.velocity, p.velocity) + dem::dot(p.spin, p.spin) > 0)
      refuse(path, p.fixed,
             b.settle ? "moves while the bed settles; leave `settle` or its velocity out"
                      : "moves while the bed settles, as every random one does; leave its velocity out, or let a "
                        "boundary move in its place");
  }

  /// What it is poured to is measured along y.
  void poured_along_y(const Scenario& of) {
    const auto one = [&](const char* path, const char* cure) {
      if (places.contains(path))
        refuse(path,
               fmt::format("is measured along y, and gravity acts along ({:.3g}, {:.3g}, {:.3g}) m/s2; {}, or turn "
                           "the scenario so that gravity acts along -y",
                           of.gravity.x, of.gravity.y, of.gravity.z, cure));
    };
    one("soil.bed.depth", "give `count` in its place");
    one("soil.bed.layers", "take one material");
    one("soil.surface", "leave it out");
  }

  void rough_floor(const BedSection& b) {
    const char* const path = "soil.bed.rough floor";
    if (!s.soil->container) refuse(path, "needs a container, whose floor it lies on");
    if (b.fill == Fill::particles) refuse(path, "stands beside particles of their own; give those `fixed: NAME`");
  }

  /// A key that a fill needs, or that would have no effect with it.
  void fits(bool given, bool needed, bool allowed, const char* key, const std::string& fill) {
    const std::string path = std::string("soil.bed.") + key;
    if (needed && !given) refuse(path, fmt::format("is missing; `fill: {}` needs it", fill));
    if (given && !allowed) refuse(path, fmt::format("has no effect with `fill: {}`; leave it out", fill));
  }

  static bool has_radius(const Layer& l) {
    const auto* equal = std::get_if<EqualRadius>(&l.radius);
    return equal == nullptr || !std::isnan(equal->radius);
  }

  static bool needs_no_radius(const Layer& l) { return has_radius(l) || only_clumps(l.clumps); }

  void layers(const BedSection& b, bool made, bool each) {
    if (!b.material.empty())
      refuse("soil.bed.material", "stands beside `layers`, which give the materials; leave it out");
    if (b.count) refuse("soil.bed.count", "stands beside `layers`, whose thicknesses give the amount; leave it out");
    if (each && places.contains("soil.bed.radius"))
      refuse("soil.bed.radius", "has no effect: every layer has grains of its own; leave it out");
    for (std::size_t i = 0; i < b.layers.size(); ++i) {
      const Layer& l = b.layers[i];
      const std::string path = fmt::format("soil.bed.layers[{}]", i);
      material(path + ".material", l.material);
      if (has_radius(l) && !made)
        refuse(path + ".radius", "has no effect with spheres that are given one by one; leave it out");
      if (has_radius(l) && only_clumps(l.clumps))
        refuse(path + ".radius",
               "has no effect: all grains of the layer are clumps; leave it out, or lower their shares");
      check_distribution(*this, path + ".radius", l.radius);
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
  void extents(const BedSection& b, bool made) {
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
  void sphere_fits(const BedSection& b, double last) {
    for (std::size_t i = 0; i < b.layers.size(); ++i) {
      const Layer& l = b.layers[i];
      const double thick = l.depth ? (*l.depth)[1] - (*l.depth)[0] : l.thickness.value_or(last);
      if (only_clumps(l.clumps)) continue;  // their size is known with their shape
      const double diameter = 2 * largest_radius(has_radius(l) ? l.radius : b.radius);
      if (std::isnan(diameter) || thick >= diameter * (1 - 1e-9)) continue;
      refuse(
          fmt::format("soil.bed.layers[{}]", i),
          fmt::format("is {:.6g} mm thick, less than its largest sphere's diameter {:.6g} mm; make it thicker, or its "
                      "spheres smaller",
                      thick * 1e3, diameter * 1e3));
    }
  }
};

}  // namespace

void check_bed(Checks& checks, const Scenario& s) { BedChecks{checks, s}.bed(*s.soil->bed); }

}  // namespace subsoil::sim
