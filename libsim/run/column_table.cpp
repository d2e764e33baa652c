#include "libsim/run/column_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libmbd/elements.hpp"
#include "libmbd/measures/beam.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {
namespace {

/// A wall's place says how far the bed was shifted and has travelled; its moments stay about the world's origin.
dem::Wrench wrench_on(const ColumnSources& from, const SurfaceRecord& s) {
  const dem::Boundary& b = from.world.bed->boundary(s.boundary);
  const Vec3 about = s.owner == SurfaceRecord::Owner::container ? Vec3{} : b.pose.to_world(s.reference);
  return dem::about(b.on_mesh(s.mesh), b.pose.position, about);
}
const dem::Wrench& wrench_on(const ColumnSources& from, const SoilOnBody& b) {
  return from.simulation.soil_on_body(b.body);
}
/// Force and moment about the mean of their centres, which moves with them.
dem::Wrench wrench_on(const ColumnSources& from, const FixedBody& body) {
  const std::span<const dem::FixedSphere> all = from.world.bed->fixed_spheres();
  std::vector<const dem::FixedSphere*> own;
  const auto named = [&](const dem::FixedSphere& f) {
    return std::any_of(from.world.fixed.begin(), from.world.fixed.end(), [&](const FixedBody& other) {
      return std::binary_search(other.ids.begin(), other.ids.end(), f.id);
    });
  };
  if (body.ids.empty())
    for (const dem::FixedSphere& f : all)
      if (!named(f)) own.push_back(&f);
  for (const std::uint32_t id : body.ids) {
    const auto at =
        std::lower_bound(all.begin(), all.end(), id, [](const auto& f, std::uint32_t i) { return f.id < i; });
    if (at != all.end() && at->id == id) own.push_back(&*at);  // not those that fell out of the bed
  }
  dem::Vec3 centre;
  for (const dem::FixedSphere* f : own) centre += f->position * (1 / static_cast<double>(own.size()));
  dem::Wrench sum;
  for (const dem::FixedSphere* f : own)
    sum += dem::Wrench{f->force, f->torque + dem::cross(f->position - centre, f->force)};
  return sum;
}
template <int Axis>
double place(const ColumnSources& from, const SurfaceRecord& s) {
  return from.simulation.surface_pose(s.boundary).position[Axis];
}
template <class Owner, int Axis>
double force(const ColumnSources& from, const Owner& on) {
  return wrench_on(from, on).force[Axis];
}
template <class Owner, int Axis>
double moment(const ColumnSources& from, const Owner& on) {
  return wrench_on(from, on).moment[Axis];
}
template <class Owner>
constexpr ColumnOf<Owner> wrench_of[] = {
    {"Fx", "N", force<Owner, 0>, true},     {"Fy", "N", force<Owner, 1>, true},
    {"Fz", "N", force<Owner, 2>, true},     {"Mx", "N m", moment<Owner, 0>, false},
    {"My", "N m", moment<Owner, 1>, false}, {"Mz", "N m", moment<Owner, 2>, false}};

constexpr ColumnOf<SurfaceRecord> places[] = {{"x", "m", place<0>}, {"y", "m", place<1>}, {"z", "m", place<2>}};

/// A servo answers in the step: its load is that of t_n as its force is.
const coupling::ServoState& servo_of_surface(const ColumnSources& from, const SurfaceRecord& s) {
  const auto& motions = from.world.motions;
  const auto found =
      std::find_if(motions.begin(), motions.end(), [&](const auto& m) { return m.boundary == s.boundary; });
  return from.simulation.servo(static_cast<std::size_t>(found - motions.begin()));
}
constexpr ColumnOf<SurfaceRecord> servos[] = {
    {"load", "N", [](const ColumnSources& f, const SurfaceRecord& s) { return servo_of_surface(f, s).load; }, true},
    {"resistance", "N", [](const ColumnSources& f, const SurfaceRecord& s) { return servo_of_surface(f, s).force; },
     true}};

/// Sum over the bodies that touch soil; each may carry several surfaces.
template <int Axis>
double on_machine(const ColumnSources& from) {
  double sum = 0;
  std::vector<int> seen;
  for (const coupling::BodySurface& s : from.world.body_surfaces) {
    if (std::find(seen.begin(), seen.end(), s.body) != seen.end()) continue;
    seen.push_back(s.body);
    sum += from.simulation.soil_on_body(s.body).force[Axis];
  }
  return sum;
}

using Whole = const SoilAsWhole&;
using From = const ColumnSources&;
constexpr ColumnOf<SoilAsWhole> drafts[] = {
    {"draft", "N", [](From f, Whole) { return -f.world.travel * on_machine<0>(f); }, true},
    {"lift", "N", [](From f, Whole) { return on_machine<1>(f); }, true}};

const dem::BedEnergy& energy(From f) { return f.world.bed->energy(); }
constexpr ColumnOf<SoilAsWhole> bed[] = {
    {"soil.kinetic", "J", [](From f, Whole) { return energy(f).kinetic; }},
    {"soil.spin", "J", [](From f, Whole) { return energy(f).rotational; }},
    {"soil.gravity", "J", [](From f, Whole) { return energy(f).gravity; }},
    {"soil.stored", "J", [](From f, Whole) { return energy(f).stored; }},
    {"soil.damped", "J", [](From f, Whole) { return energy(f).lost.damping; }},
    {"soil.slid", "J", [](From f, Whole) { return energy(f).lost.sliding; }},
    {"soil.rolled", "J", [](From f, Whole) { return energy(f).lost.rolling; }},
    {"soil.boundary work", "J", [](From f, Whole) { return energy(f).boundary_work; }},
    {"soil.removed", "J", [](From f, Whole) { return energy(f).removed; }},
    {"interface.on soil", "J", [](From f, Whole) { return f.simulation.interface_work().on_soil; }},
    {"interface.on machine", "J", [](From f, Whole) { return f.simulation.interface_work().on_machine; }, false, false,
     true},
    {"soil.fastest", "m/s", [](From f, Whole) { return f.world.bed->max_speed(); }}};

double count(std::size_t n) { return static_cast<double>(n); }
constexpr ColumnOf<SoilAsWhole> bonds[] = {
    {"bonds", "1", [](From f, Whole) { return count(f.world.bed->bonds().intact()); }, false, true},
    {"bonds broken in tension", "1", [](From f, Whole) { return count(f.world.bed->bonds().broken_in_tension); }, false,
     true},
    {"bonds broken in shear", "1", [](From f, Whole) { return count(f.world.bed->bonds().broken_in_shear); }, false,
     true},
    {"broken", "J", [](From f, Whole) { return energy(f).lost.breaking; }},
    {"yielded", "J", [](From f, Whole) { return energy(f).lost.yielding; }}};

constexpr ColumnOf<SoilAsWhole> forces[] = {{"force work", "J", [](From f, Whole) { return energy(f).force_work; }}};

constexpr ColumnOf<SoilAsWhole> frozen[] = {
    {"frozen", "J", [](From f, Whole) { return energy(f).frozen; }},
    {"frozen spheres", "1", [](From f, Whole) { return count(f.world.bed->frozen_count()); }, false, true}};

const dem::MovingBed& window(From f) { return f.world.moving->window; }
constexpr ColumnOf<SoilAsWhole> windows[] = {
    {"travelled", "m", [](From f, Whole) { return window(f).way(); }},
    {"entered", "kg", [](From f, Whole) { return window(f).entered().mass; }},
    {"left", "kg", [](From f, Whole) { return window(f).left().mass; }},
    {"left momentum", "N s", [](From f, Whole) { return window(f).left().momentum.x; }},
    {"entered energy", "J", [](From f, Whole) { return window(f).entered().energy(); }},
    {"left energy", "J", [](From f, Whole) { return window(f).left().energy(); }}};

const dem::CarriedSoil& poured(From f, const InletOfWorld& i) { return f.world.inlets[i.index].inlet.poured(); }
constexpr ColumnOf<InletOfWorld> inlets[] = {
    {"poured", "kg", [](From f, const InletOfWorld& i) { return poured(f, i).mass; }},
    {"spheres", "1", [](From f, const InletOfWorld& i) { return count(poured(f, i).spheres); }, false, true},
    {"energy", "J", [](From f, const InletOfWorld& i) { return poured(f, i).energy(); }}};

const FibreGroup& group(From f, const FibresOfWorld& g) { return f.world.fibres[g.index]; }
constexpr ColumnOf<FibresOfWorld> fibres[] = {
    {"buried", "1", [](From f, const FibresOfWorld& g) { return f.buried.share(g.index); }},
    {"broken bonds", "1", [](From f, const FibresOfWorld& g) { return count(broken_bonds(f.world, group(f, g))); },
     false, true},
    {"cut bonds", "1", [](From f, const FibresOfWorld& g) { return count(cut_bonds(f.world, group(f, g))); }, false,
     true}};

}  // namespace

const ColumnFamily<SoilOnBody> soil_on_body_columns{
    "BODY.soil", Taken::step, wrench_of<SoilOnBody>,
    "soil on the body, about its centre of mass, world axes. Fz, Mx, My do no work on a planar body: they are what its "
    "guide takes"};
const ColumnFamily<SurfaceRecord> surface_columns{
    "SURFACE", Taken::step, wrench_of<SurfaceRecord>,
    "soil on one surface (container walls, `boundaries`, every named surface of a body), world axes. Moments are "
    "about: "
    "the body's centre of mass for a body's surface; `reference`, else its place, for a boundary (both move along); "
    "the world's origin for container walls"};
const ColumnFamily<FixedBody> fixed_columns{"FIXED", Taken::step, wrench_of<FixedBody>,
                                            "other spheres on those of one name in `fixed`, world axes, without "
                                            "gravity; moments about the mean of their centres, "
                                            "which moves with them"};
const ColumnFamily<SurfaceRecord> path_columns{"BOUNDARY", Taken::instant, places,
                                               "place of a boundary on a given path, world axes"};
const ColumnFamily<SurfaceRecord> servo_columns{"BOUNDARY", Taken::step, servos,
                                                "of a boundary with a `servo`: the load it is to meet, what the "
                                                "spheres resist along its line, how far it has come"};
const ColumnFamily<SoilAsWhole> draft_columns{
    "soil", Taken::step, drafts,
    "with a machine: the soil's force on all its bodies. Draft is against the travel along x: minus the sum of Fx in a "
    "travel towards +x, the sum in one towards -x. The travel is that of the bodies with surfaces by drivers of an x "
    "and "
    "along slides, net from begin to end. Below a tenth of the way it is that of the velocity at the start, from rest "
    "of the acceleration. Lift is upward, the sum of Fy"};
const ColumnFamily<SoilAsWhole> bed_columns{
    "", Taken::sample, bed,
    "the bed's energy balance: kinetic, of rotation (spin), potential (gravity), stored in contacts, damped, slid, "
    "rolled, work of all surfaces on the spheres, removed with spheres; work at the machine's surfaces as either side "
    "accumulates it, whose sum is what the staggered exchange made or lost; speed of the fastest sphere"};
const ColumnFamily<SoilAsWhole> bond_columns{
    "soil", Taken::sample, bonds,
    "where a law has bonds: intact ones, broken ones since the start, energy that those held, plastic work of bending"};
const ColumnFamily<SoilAsWhole> force_columns{
    "soil", Taken::sample, forces,
    "where a C++ program has added forces on spheres: what these have done on them since the start"};
const ColumnFamily<SoilAsWhole> frozen_columns{
    "soil", Taken::sample, frozen,
    "with `soil.active`: kinetic energy that spheres had when they were frozen, since the start; how many are"};
const ColumnFamily<SoilAsWhole> window_columns{"window", Taken::sample, windows,
                                               "with `soil.moving`, since the start: way of the window; mass that came "
                                               "in ahead and that was left behind, the latter "
                                               "with its momentum along x; their kinetic and potential energy and that "
                                               "of their contacts, whose difference is part "
                                               "of `soil.removed`"};
const ColumnFamily<InletOfWorld> inlet_columns{
    "INLET", Taken::sample, inlets,
    "of an inlet, since the start: mass and number of the grains that came, their kinetic and potential energy, which "
    "is part of `soil.removed` with its sign turned"};

const ColumnFamily<FibresOfWorld> fibre_columns{
    "FIBRES", Taken::sample, fibres,
    "of fibres: share of their mass above which there is soil; bonds that broke since the start, and "
    "those of them that edges cut"};

namespace {

template <class Force>
MachineColumns of_force(const char* owner, const char* meaning) {
  MachineColumns out{owner, {}, meaning};
  for (const auto& column : Force::columns) out.columns.emplace_back(column.name, column.unit);
  return out;
}

template <class Measure>
MachineColumns of_measure(const char* owner, const char* meaning) {
  MachineColumns out{owner, {}, meaning};
  for (const auto& column : Measure{}.columns()) out.columns.emplace_back(column.suffix, column.unit);
  return out;
}

}  // namespace

std::vector<MachineColumns> machine_columns() {
  return {
      {"BODY", {{"x", "m"}, {"y", "m"}}, "centre of mass, world axes"},
      {"BODY", {{"angle", "rad"}}, "counter-clockwise about +z; 0 is the body's own axes along the world's"},
      {"BODY", {{"vx", "m/s"}, {"vy", "m/s"}, {"spin", "rad/s"}}, "velocity of the centre of mass, angular velocity"},
      {"BODY",
       {{"ax", "m/s^2"}, {"ay", "m/s^2"}, {"alpha", "rad/s^2"}},
       "acceleration of the centre of mass, angular acceleration"},
      {"JOINT",
       {{"fx", "N"}, {"fy", "N"}, {"moment", "N m"}},
       "what the joint puts on its *first* body, at the joint's point (of disks, cams: the contact; of gears: the "
       "pitch "
       "point), world axes; the second gets the opposite"},
      {"JOINT", {{"open", "1"}}, "of a joint that events open or close: 1 while it is open"},
      {"DRIVER",
       {{"force", "N"}},
       "along the driven coordinate, on the driven (second) body. For a towed trolley: the pull"},
      {"DRIVER", {{"torque", "N m"}}, "the same of a driven angle"},
      of_force<mbd::SpringDamper>("SPRING", "compression positive, damper included"),
      of_force<mbd::RotationalSpringDamper>("ROTATIONAL", "on the second body; angle of the second against the first"),
      of_force<mbd::AppliedForce>("LOAD", "an applied force or drag, world axes"),
      of_force<mbd::Bushing>("BUSHING",
                             "on the second body, in the bushing's axes; how far its point is off the first's"),
      of_force<mbd::BeamElement>(
          "BEAM",
          "a beam between two bodies, or the element `BEAM element 3` of a beam: tension "
          "positive; shear in its middle; bending moments at its ends, positive where they turn "
          "the second counter-clockwise; the larger stress of the two, of axial force and moment"),
      of_measure<mbd::BeamMeasure>("BEAM",
                                   "a beam: its end seen from its start, less the start pose; largest bending moment "
                                   "and axial force with their signs; largest stress, and its place along the beam"),
      of_force<mbd::LineContact>("CONTACT",
                                 "on the second body; friction and slip positive along the side with its free side on "
                                 "the left; gap below 0 is the depth"),
      of_force<mbd::OutlineContact>("CONTACT",
                                    "outlines: sums over the points in contact, on the second body; least gap; slip of "
                                    "the deepest point; how many there are"),
      of_force<mbd::SlideStop>("STOP", "on the second body, along what is measured; room to the nearer stop"),
      of_force<mbd::DistanceStop>("STOP", "the same of a distance"),
      of_force<mbd::RotationalStop>("STOP", "the same of an angle"),
      of_force<mbd::JointFriction>(
          "FRICTION",
          "on the joint's second body: force along a slide or torque in a pin, at the speed of "
          "the sliding surfaces; 1 while it sticks"),
      of_force<mbd::GroundElement>(
          "GROUND",
          "ground element: force on the body, of the plastic spring (differs by the follower), "
          "depth of the lowest point, rut under it"),
      of_force<mbd::HydraulicCylinder>("CYLINDER",
                                       "force that pushes its ends apart, distance of the ends, pressures "
                                       "of cap side and rod side, flow from the pump, opening of the "
                                       "valve"),
      of_force<mbd::ElectricMotor>("MOTOR", "on the second body; current, voltage, electrical power taken in"),
      of_force<mbd::TorqueSpeedMotor>(
          "MOTOR", "torque-speed: on the second body; speed of the shaft, share of the torque, power given off"),
      of_force<mbd::WheelOnSoil>("WHEEL",
                                 "load, rolling resistance, sinkage and the rut under the front of the patch; "
                                 "traction along x, and slip, positive where the wheel drives"),
      {"CONTROLLER",
       {{"output", "OUT"}, {"error", "IN"}},
       "what it gives out, in its own unit; set point less measured value"},
      {"energy",
       {{"kinetic", "J"},
        {"potential", "J"},
        {"stored", "J"},
        {"lost", "J"},
        {"driver work", "J"},
        {"force work", "J"},
        {"external work", "J"},
        {"balance", "J"}},
       "the machine's energy balance; external work is the soil's, balance what does not close"},
  };
}

namespace {

/// One line of the table: names with their units, those of one unit together.
std::string line(const std::string& owner, const std::vector<std::pair<std::string, std::string>>& columns,
                 const std::string& meaning) {
  std::string names;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& [name, unit] = columns[i];
    names += i == 0 && !owner.empty() ? "`" + owner + "." + name + "`"
                                      : (i == 0 ? "`" : " `") + (owner.empty() ? "" : std::string(".")) + name + "`";
    if (i + 1 == columns.size() || columns[i + 1].second != unit)
      names += " [" + unit + "]" + (i + 1 == columns.size() ? "" : ",");
  }
  return fmt::format("| {} | {} |\n", names, meaning);
}

template <class Owner>
std::string line(const ColumnFamily<Owner>& family) {
  std::vector<std::pair<std::string, std::string>> columns;
  for (const ColumnOf<Owner>& c : family.columns) columns.emplace_back(c.name, c.unit);
  return line(family.owner, columns, family.meaning);
}

}  // namespace

std::string columns_markdown() {
  std::string out = "| columns | are |\n|---|---|\n| `time` [s] | of the row |\n";
  for (const MachineColumns& m : machine_columns()) out += line(m.owner, m.columns, m.meaning);
  out += line(soil_on_body_columns) + line(surface_columns) + line(fixed_columns) + line(path_columns) +
         line(servo_columns) + line(draft_columns) + line(bed_columns) + line(bond_columns) + line(force_columns) +
         line(frozen_columns) + line(window_columns) + line(inlet_columns) + line(fibre_columns);
  return out + "| others | your own `machine.measures` and `output.monitor` |\n";
}

}  // namespace subsoil::sim
