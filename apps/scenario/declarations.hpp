#pragma once
#include <algorithm>
#include <cmath>

#include "apps/scenario/scenario.hpp"

/// Every key of a scenario, once: name, unit, range, meaning, and by the struct's own value the default. The reader,
/// the writer of the explicit copy, `explain`, `new` and docs/scenario.md are visitors of these functions. Laws,
/// joints, drivers and forces declare themselves in their own files in the same vocabulary.
///
/// Vocabulary: `quantity` (NaN: required; optional<>: may be left out), `vector`, `count`, `flag`, `text`, `choice`,
/// `section` (a mapping), `list` (of mappings), `named` (mapping of name -> mapping), `kind` (a variant chosen by the
/// word under the key), `form` (a variant chosen by which word is present), `reference` (a name declared elsewhere);
/// `optional_*`: may be left out.
/// A range may carry its cure: "(0, 1]; for no damping use 1".
namespace subsoil::app {

enum class Family { material, body, joint, driver, force };

/// A property of materials that the entry of a pair may combine from both: the law's own key, unit and range.
struct Combinable {
  const char* key;
  std::optional<double> Material::*value;
  const char *unit, *range, *meaning;
};
inline constexpr std::array<Combinable, 6> combinables{
    {{"restitution", &Material::restitution, "1", "(0, 1]", "for pairs that `combine` it"},
     {"mu", &Material::mu, "1", "[0, inf)", "static friction coefficient, for pairs that `combine` it"},
     {"mu_d", &Material::mu_d, "1", "[0, inf)", "sliding friction coefficient, for pairs that `combine` it"},
     {"mu_r", &Material::mu_r, "1", "[0, inf)", "rolling friction coefficient, for pairs that `combine` it"},
     {"mu_t", &Material::mu_t, "1", "[0, inf)", "twisting friction coefficient, for pairs that `combine` it"},
     {"work of adhesion", &Material::adhesion, "J/m^2", "(0, inf)", "for pairs that `combine` it"}}};

inline constexpr std::array<const char*, 5> rule_words{"arithmetic-mean", "geometric-mean", "harmonic-mean", "minimum",
                                                       "maximum"};
inline double combined(CombinationRule rule, double a, double b) {
  switch (rule) {
    case CombinationRule::arithmetic_mean:
      return 0.5 * (a + b);
    case CombinationRule::geometric_mean:
      return std::sqrt(a * b);
    case CombinationRule::harmonic_mean:
      return a + b > 0 ? 2 * a * b / (a + b) : 0;
    case CombinationRule::minimum:
      return std::min(a, b);
    case CombinationRule::maximum:
      return std::max(a, b);
  }
  return a;
}

template <class V>
void describe(V& v, Material& m) {
  v.quantity("density", m.density, "kg/m^3", "(0, inf)", "density of the material itself, not of the bulk");
  v.quantity("young's modulus", m.young, "Pa", "(0, inf)", "needed by laws that compute their stiffness from it");
  v.quantity("poisson ratio", m.poisson, "1", "(-1, 0.5]", "needed by laws that compute their stiffness from it");
  v.quantity("yield strength", m.yield, "Pa", "(0, inf)",
             "needed by laws that leave theirs out; of two bodies the one of less strength yields");
  for (const Combinable& c : combinables) v.quantity(c.key, m.*c.value, c.unit, c.range, c.meaning);
}

template <class V>
void describe(V& v, Contact& c) {
  v.pair("between", c.between, Family::material, "the two materials that meet; any order");
  v.combinations("combine", c.between, c.combine,
                 "values of the law by a named rule from those of the two materials: {mu: minimum, restitution: "
                 "geometric-mean}; each may be restitution, mu, mu_d, mu_r, mu_t or work of adhesion");
  v.kind("law", c.law, "contact law; its parameters stand beside it");
}

// ---- shapes --------------------------------------------------------------------------------------------------------

template <class V>
void describe(V& v, PlaneShape& s) {
  v.card("plane", "half-space behind an infinite plane");
  v.group("plane", "half-space behind an infinite plane", [&](auto& g) {
    g.vector("point", s.point, "m", "a point of the plane");
    g.vector("normal", s.normal, "1", "points to the free side; any length");
  });
}
template <class V>
void describe(V& v, BoxShape& s) {
  v.card("box", "box with edges along its axes");
  v.vector("box", s.size, "m", "edge lengths x y z; the box is centred on its place");
}
template <class V>
void describe(V& v, CylinderShape& s) {
  v.card("cylinder", "circular cylinder");
  v.group("cylinder", "circular cylinder, centred on its place", [&](auto& g) {
    g.quantity("radius", s.radius, "m", "(0, inf)", "radius");
    g.quantity("length", s.length, "m", "(0, inf)", "length along the axis");
    g.vector("axis", s.axis, "1", "direction of the axis; any length");
  });
}
template <class V>
void describe(V& v, MeshShape& s) {
  v.card("mesh", "triangles of an STL file");
  v.file("mesh", s.file, "STL file (binary or text) beside the scenario");
  v.unit("unit", s.unit, "m", "unit of the file's numbers");
}
template <class V>
void describe(V& v, ExtrudeShape& s) {
  v.card("extrude", "outline in x-y, extruded");
  v.outline("extrude", s.outline, "points `x y` of the outline, or a CSV file of them whose header names the unit");
  v.quantity("width", s.width, "m", "(0, inf)", "width across, symmetric about z = 0");
}

template <class V>
void describe(V& v, Rotation& r) {
  v.vector("axis", r.axis, "1", "axis of the rotation; any length");
  v.quantity("angle", r.angle, "rad", "(-inf, inf)", "angle about it, right-handed");
  v.turns("turns", r, "instead of both: angles about the world's x, then y, then z axis");
}

template <class V>
void describe(V& v, Box& b) {
  v.vector("size", b.size, "m", "edge lengths x y z");
  v.vector("at", b.at, "m", "its corner of least coordinates");
}

// ---- soil ----------------------------------------------------------------------------------------------------------

template <class V>
void describe(V& v, Container& c) {
  v.vector("size", c.size, "m", "inner lengths x y z (y is up)");
  v.vector("at", c.at, "m", "its corner of least coordinates");
  v.faces("open", c.open, "faces without a wall");
  v.faces("open after settling", c.open_after_settling,
          "walls that stand while the bed settles and are then taken away");
  v.reference("material", c.material, Family::material, "of the walls");
}

template <class V>
void describe(V& v, EqualRadius& r) {
  v.card("equal", "all spheres alike; the radius may stand directly: `radius: 10 mm`");
  v.quantity("equal", r.radius, "m", "(0, inf)", "radius of every sphere");
}
template <class V>
void describe(V& v, NormalRadius& r) {
  v.card("normal", "normal distribution by number, cut off");
  v.quantity("normal", r.mean, "m", "(0, inf)", "mean radius");
  v.quantity("deviation", r.deviation, "m", "(0, inf)", "standard deviation");
  v.quantity("least", r.least, "m", "(0, inf)", "smaller radii are drawn again");
  v.quantity("largest", r.largest, "m", "(0, inf)", "larger radii are drawn again");
}
template <class V>
void describe(V& v, UniformRadius& r) {
  v.card("uniform", "all radii between two values equally likely, by number");
  v.span("uniform", r.least, r.largest, "m", "(0, inf)", "least and largest radius");
}
template <class V>
void describe(V& v, TableRadius& r) {
  v.card("table", "given radii with given shares");
  v.table("table", r.radius, r.share, "m", "1", "radius and its share; the shares need not sum to one");
}

template <class V>
void describe(V& v, Settle& s) {
  v.quantity("for", s.duration, "s", "(0, inf)", "settle for this long");
  v.quantity("until", s.until_speed, "m/s", "(0, inf)", "settle until the spheres' rms speed is below this");
  v.quantity("at most", s.at_most, "s", "(0, inf)", "a bed that is not at rest by then stops the run");
  v.choice("stages", s.stages, {{"auto", Stages::automatic}, {"yes", Stages::yes}, {"no", Stages::no}},
           "first without attraction and with lowered friction and rolling, then both raised, then at rest again; "
           "auto: for random fill");
  v.quantity("lowered", s.lowered, "1", "[0, 1]", "factor on friction and rolling in the first stage");
  v.quantity("ramp", s.ramp, "s", "(0, inf)", "time over which attraction, friction and rolling come back");
}

template <class V>
void describe(V& v, Particle& p) {
  v.vector("position", p.position, "m", "of the centre");
  v.vector("velocity", p.velocity, "m/s", "at the start");
  v.vector("spin", p.spin, "rad/s", "at the start");
  v.quantity("radius", p.radius, "m", "(0, inf)", "radius");
  v.quantity("density", p.density, "kg/m^3", "(0, inf)", "left out: of its material");
  v.optional_reference("material", p.material, Family::material, "left out: the bed's");
}

template <class V>
void describe(V& v, Layer& l) {
  v.quantity("thickness", l.thickness, "m", "(0, inf)", "left out in the lowest layer: down to the floor");
  v.vector("depth", l.depth, "m", "in place of the thickness: where it begins and ends below the surface");
  v.reference("material", l.material, Family::material, "of its spheres");
  v.optional_form("radius", l.radius, "radius of its spheres, or a distribution; left out: the bed's");
}

template <class V>
void describe(V& v, Bed& b) {
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
  v.choice("shares", b.shares, {{"number", ShareOf::number}, {"mass", ShareOf::mass}}, "what a table's shares count");
  v.quantity("pitch", b.pitch, "m", "(0, inf)",
             "of the lattice; left out: 2.02 radii, or for rest-lattice from the law");
  v.section("region", b.region, "box that is filled; left out: the container");
  v.count("count", b.count, "[1, inf)", "random fill: number of spheres");
  v.quantity("depth", b.depth, "m", "(0, inf)",
             "fill up to this height above the floor; left out: the region's height");
  v.count("seed", b.seed, "[0, inf)", "of the random numbers; the same seed gives the same bed");
  v.quantity("jitter", b.jitter, "1", "[0, 0.5]", "largest random shift of a lattice site, share of the radius");
  v.section("settle", b.settle, "let the bed come to rest before time 0; left out: it starts as filled");
  v.output_file("save", b.save, "HDF5 file that keeps the bed after settling");
  v.optional_file(
      "file", b.file,
      "saved bed: HDF5, or CSV whose first line names columns and units: x [m],y [m],z [m],radius [mm], and "
      "where wanted id,material,density [kg/m^3],vx [m/s],...,wx [rad/s],...; spheres are numbered by id");
  v.list("particles", b.particles, "the spheres, one by one");
  v.choice("inside machine", b.inside_machine, {{"refuse", Overlap::refuse}, {"carve", Overlap::carve}},
           "spheres inside a machine's surface at the start: refuse the run, or take them out");
}

template <class V>
void describe(V& v, Soil& s) {
  v.section("container", s.container, "box of flat walls that act on spheres only");
  v.quantity("surface", s.surface, "m", "(-inf, inf)",
             "height y of the mean surface after settling: bed and container are shifted to it; left out: no shift");
  v.section("bed", s.bed, "the spheres");
  v.quantity("remove below", s.removal_below, "m", "(0, inf)",
             "spheres this far below the container's floor are taken out and counted");
}

// ---- boundaries ----------------------------------------------------------------------------------------------------

template <class V>
void describe(V& v, Move& m) {
  v.vector("velocity", m.velocity, "m/s", "of the boundary's place");
  v.vector("spin", m.spin, "rad/s", "angular velocity, world axes");
  v.vector("about", m.about, "m", "point of the spin at the start; moves along; left out: the boundary's place");
  v.function("profile", m.profile, "1", "factor on velocity and spin over time");
  v.quantity("from", m.from, "s", "[0, inf)", "time at which this motion begins");
  v.quantity("until", m.until, "s", "(0, inf]", "time at which it ends");
}

template <class V>
void describe(V& v, Boundary& b) {
  v.name("name", b.name, "appears in the results");
  v.reference("material", b.material, Family::material, "of the surface");
  v.form("shape", b.shape, "its shape");
  v.vector("at", b.at, "m", "its place: origin of the shape");
  v.section("rotation", b.rotation, "turns the shape about its place");
  v.list("moves", b.moves, "given motion; several stretches add up; left out: fixed");
  v.vector("reference", b.reference, "m", "point of the reported moment, moves along; left out: its place");
}

// ---- machine -------------------------------------------------------------------------------------------------------

template <class V>
void describe(V& v, Body& b) {
  v.quantity("mass", b.mass, "kg", "(0, inf)", "mass");
  v.quantity("inertia", b.inertia, "kg m^2", "(0, inf)", "moment of inertia about the centre of mass");
  v.vector("at", b.at, "m", "centre of mass in the start pose, x y");
  v.quantity("angle", b.angle, "rad", "(-inf, inf)", "of the body's axes in the start pose, counter-clockwise");
  v.vector("velocity", b.velocity, "m/s", "of the centre of mass at the start");
  v.quantity("spin", b.spin, "rad/s", "(-inf, inf)", "at the start, counter-clockwise");
  v.choice(
      "pose is", b.pose_is,
      {{"given", mbd::StartMark::given}, {"exact", mbd::StartMark::exact}, {"about", mbd::StartMark::about}},
      "given: a run is refused where the joints move the body by more than 1 % of its size; exact: it is not moved "
      "at all, others are; about: a guess, moved as far as need be");
  v.choice("velocity is", b.velocity_is,
           {{"given", mbd::StartMark::given}, {"exact", mbd::StartMark::exact}, {"about", mbd::StartMark::about}},
           "given: what is not 0 stays and the rest follows, a run is refused where the joints change it by more than "
           "1e-3; exact: zeros stay too; about: a guess, changed as far as need be");
  v.optional_outline(
      "outline", b.outline,
      "points `x y` of its outline in pictures, in its own axes, or a CSV file of them whose header names "
      "the unit; left out: drawn from its surfaces, else from its joints");
}

template <class V>
void describe(V& v, Surface& s) {
  v.reference("body", s.body, Family::body, "the body that carries it");
  v.optional_reference("material", s.material, Family::material, "of the surface; left out when it touches no soil");
  v.inline_form(s.shape);
  v.choice("placed in", s.placed_in, {{"body", PlacedIn::body}, {"world", PlacedIn::world}},
           "axes of `at` and `rotation`: the body's, about its centre of mass, or the world's in the start pose");
  v.vector("at", s.at, "m", "origin of the shape");
  v.section("rotation", s.rotation, "turns the shape about its origin");
  v.flag("touches soil", s.touches_soil, "no: it is drawn only");
}

template <class V>
void describe(V& v, Machine& m) {
  v.named("bodies", m.bodies, "rigid bodies in the x-y plane; `ground` is always there");
  v.named("markers", m.markers, "points with axes on bodies or the ground, for measures and pictures");
  v.elements("joints", m.joints, "constraints between bodies");
  v.elements("drivers", m.drivers, "motions given as functions of time");
  v.elements("forces", m.forces, "springs, dampers, loads, wheels");
  v.elements("measures", m.measures, "columns of your own: what is measured of markers, joints, forces and bodies");
  v.named("surfaces", m.surfaces, "what of the bodies meets the soil, or is drawn");
  v.start("start", m.start, "`pose` as given, or {towing equilibrium: speed}: the steady state found by the program");
  v.choice("redundant", m.redundant,
           {{"minimum-norm", mbd::Redundancy::minimum_norm}, {"refuse", mbd::Redundancy::refuse}},
           "constraints that depend on each other: share their reaction with least norm, or stop and name them");
  v.flag("assemble", m.assemble, "move the bodies until the joints close; no: refuse a pose that is off");
}

// ---- time, output, limits ------------------------------------------------------------------------------------------

template <class V>
void describe(V& v, MachineTime& t) {
  v.choice(
      "integrator", t.integrator,
      {{"auto", IntegratorWord::automatic},
       {"adams-moulton", IntegratorWord::adams_moulton},
       {"cvode", IntegratorWord::cvode},
       {"ida", IntegratorWord::ida}},
      "auto: cvode for a machine alone, adams-moulton with soil and where `step` or `order` is given; adams-moulton: "
      "fixed step on partitioned coordinates, its error watched; cvode: SUNDIALS CVODE on the same, steps and orders "
      "of "
      "its own for smooth motion; ida: SUNDIALS IDA on the whole system, also for stiff forces");
  v.count("order", t.order, "[1, 6]", "of adams-moulton");
  v.quantity("rtol", t.rtol, "1", "(0, 0.1]",
             "relative tolerance of cvode and ida; left out: 1e-12 of cvode, 1e-8 of ida");
  v.quantity("atol", t.atol, "1", "(0, 0.1]",
             "absolute tolerance of cvode and ida, in m, rad, m/s and rad/s; left out: 1e-12 of cvode, 1e-10 of ida");
  v.choice("formulation", t.formulation,
           {{"stabilised index 2", mbd::IdaFormulation::stabilised_index_2}, {"index 1", mbd::IdaFormulation::index_1}},
           "equations of ida: constraints on position and velocity level, or on the level of accelerations");
  v.flag("locate events", t.locate_events,
         "contacts that close or open are located in time and the integration begins anew there; no: steps pass over "
         "them");
  v.count("soil steps per machine step", t.soil_steps, "[1, 1000]", "the machine step with soil is so many soil steps");
  v.quantity("step", t.step, "s", "(0, inf)",
             "machine step without soil, fixed, of cvode and ida their output interval; left out: steps of the "
             "integrator's own, for adams-moulton a whole part of the series interval of 1 ms at most");
}

template <class V>
void describe(V& v, Time& t) {
  v.derived("end", t.end, "s", "(0, inf)", "simulated time; needed by dynamics and kinematics");
  v.quantity_or("soil step", t.soil_step, "auto", "s", "(0, inf)",
                "auto: the smaller of `safety` times the stable step, from the stiffest contact, and the accurate one, "
                "by `accuracy`; a step above the stable limit is refused");
  v.quantity("safety", t.safety, "1", "(0, 1)", "the automatic step over the stable limit");
  v.quantity("accuracy", t.accuracy, "1", "(0, 1]",
             "error of the restitution of an impact that the automatic step allows, at the speed at which bodies may "
             "meet; a contact gets 0.4/accuracy steps at least. Large for beds that only creep: stability alone");
  v.section("machine", t.machine, "integration of the machine");
  v.count("threads", t.threads, "[0, 1024]", "0: as many as there are; results do not depend on it");
}

template <class V>
void describe(V& v, Window& w) {
  v.quantity("from", w.from, "s", "[0, inf)", "left out: the tool has travelled its length plus its depth in soil");
  v.quantity("until", w.until, "s", "(0, inf)", "left out: the tool's tip is one depth from the end wall");
}

template <class V>
void describe(V& v, Output& o) {
  v.quantity("every", o.every, "s", "(0, inf)", "interval of frames; left out: a 200th of the end, or none with `at`");
  v.quantities("at", o.at, "s", "[0, inf)", "further times of frames");
  v.quantity("series every", o.series_every, "s", "(0, inf)", "interval of the rows of series.csv");
  v.count("book every", o.book_every, "[0, 1000]",
          "soil steps from one reading of what contacts between spheres and on flat faces lose to the next, which "
          "stands for all between; 0: every step up to 5,000 spheres, else every 32nd, some of the bed in each");
  v.choice(
      "forces", o.forces,
      {{"auto", ForceColumns::automatic}, {"mean", ForceColumns::mean}, {"instant", ForceColumns::instant}},
      "columns of forces and moments in series.csv: means over the interval since the row before, or the values at "
      "its instant; auto: mean with soil, instant without");
  v.words("columns", o.columns,
          {{"position", Column::position},
           {"velocity", Column::velocity},
           {"spin", Column::spin},
           {"force", Column::force},
           {"torque", Column::torque},
           {"contacts", Column::contacts}},
          "what a frame holds of each sphere");
  v.choice("precision", o.precision, {{"single", Precision::single}, {"double", Precision::full}}, "of the frames");
  v.count("compression", o.compression, "[0, 9]", "0: none, 9: smallest and slowest");
  v.section("region", o.region, "only spheres in this box; left out: all");
  v.quantity("state every", o.state_every, "s", "(0, inf)",
             "interval of full states to start again from; left out: none");
  v.choice("state", o.state, {{"full", State::full}, {"none", State::none}}, "full state at the end");
  v.watches("watch", o.watch,
            "named columns of the series: shovel.angle, {driver: H10}, {soil force: shovel, along: -1 0}");
  v.section("window", o.window, "time over which the summary takes means");
}

template <class V>
void describe(V& v, Limits& l) {
  v.quantity("overlap", l.overlap, "1", "(0, 2]", "share of a radius; a deeper contact stops the run");
  v.quantity("speed", l.speed, "m/s", "(0, inf)", "a faster sphere stops the run");
  v.quantity("energy", l.energy, "1", "(0, inf)",
             "a machine whose energy balance is off by a larger share of the energy there or moved stops the run");
}

template <class V>
void describe(V& v, Scenario& s) {
  v.version("subsoil", s.version, "version of the scenario format: 1");
  v.text("title", s.title, "one line about what this is");
  v.choice("analysis", s.analysis,
           {{"dynamics", Analysis::dynamics},
            {"kinematics", Analysis::kinematics},
            {"equilibrium", Analysis::equilibrium},
            {"modes", Analysis::modes},
            {"assembly", Analysis::assembly}},
           "dynamics: motion under forces; kinematics: motion and driving forces of a machine that is driven in every "
           "coordinate; equilibrium: the state of rest (or of towing) and its stability; modes: small oscillations "
           "about it; assembly: how the pose closes. All but dynamics: without soil");
  v.downward("gravity", s.gravity, "m/s^2", "one number acts downward (-y); or a vector");
  v.text("simd", s.simd, "instruction set of the soil kernel; auto: the best of this processor");
  v.choice(
      "precision", s.precision, {{"double", dem::Precision::doubles}, {"mixed", dem::Precision::mixed}},
      "of the soil; mixed: positions and forces on surfaces in double; velocities, the force on a sphere, springs and "
      "laws between spheres in float (docs/performance.md says what it changes)");
  v.named("materials", s.materials, "what soil, tools and walls are made of");
  v.list("contacts", s.contacts, "the law of each pair of materials that can meet");
  v.section("soil", s.soil, "container and bed; left out: a machine only");
  v.list("boundaries", s.boundaries, "surfaces that are no machine's: fixed or on a given path");
  v.section("machine", s.machine, "planar multibody system; left out: soil only");
  v.section("time", s.time, "end, steps, integrator");
  v.section("output", s.output, "what is written, and how often");
  v.section("limits", s.limits, "beyond these the run stops with exit 3");
}

}  // namespace subsoil::app
