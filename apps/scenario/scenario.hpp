#pragma once
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "apps/scenario/given_law.hpp"
#include "libdem/base/vec3.hpp"
#include "libdem/particles/particles.hpp"
#include "libmbd/constraint.hpp"
#include "libmbd/force.hpp"
#include "libmbd/function.hpp"
#include "libmbd/integrator.hpp"
#include "libmbd/measure.hpp"

/// What a scenario file says, as plain structs in SI units, before anything is built from it. A section that the file
/// leaves out is an empty optional or list: soil only and machine only are scenarios. Keys, units, ranges, defaults
/// and meanings stand in `declarations.hpp`, once for reader, writer, `explain` and docs.
namespace subsoil::app {

using dem::Vec3;
using Vec2 = std::array<double, 2>;
inline constexpr double required = std::numeric_limits<double>::quiet_NaN();  ///< the file must say it
inline constexpr double unlimited = std::numeric_limits<double>::infinity();

using Joint = mbd::AnyJoint;
using Driver = mbd::AnyDriver;
using Force = mbd::AnyForce;
using mbd::Function;

struct Material {
  std::string name;
  double density = required;    // kg/m^3
  std::optional<double> young;  // Pa, for laws that compute their stiffness from it
  std::optional<double> poisson;
  std::optional<double> yield{};  // Pa, for laws whose bodies yield
  // What a pair's value may be combined from, by a rule that its entry names.
  std::optional<double> restitution{}, mu{}, mu_d{}, mu_r{}, mu_t{}, adhesion{};
};

enum class CombinationRule { arithmetic_mean, geometric_mean, harmonic_mean, minimum, maximum };
/// A value of a law, by the key of law and material, that follows from those of the two materials.
struct Combination {
  std::string key;
  CombinationRule rule;
};

/// The law between two materials; `between` holds names, in the file's order.
struct Contact {
  std::array<std::string, 2> between;
  GivenLaw law;
  std::vector<Combination> combine{};  // done by the reader: the law holds the values
};

// ---- shapes and placement ------------------------------------------------------------------------------------------

struct PlaneShape {  // half-space; normal points to the free side
  Vec3 point{};
  Vec3 normal{0, 1, 0};
};
struct BoxShape {  // centred on its placement
  Vec3 size{required, required, required};
};
struct CylinderShape {  // centred on its placement
  double radius = required, length = required;
  Vec3 axis{0, 0, 1};
};
struct MeshShape {
  std::string file;        // absolute path
  double unit = required;  // metres per unit of the file's numbers
};
struct ExtrudeShape {  // closed outline in x-y, extruded symmetrically about z = 0
  std::vector<Vec2> outline;
  double width = required;
};
using Shape = std::variant<PlaneShape, BoxShape, CylinderShape, MeshShape, ExtrudeShape>;

struct Rotation {  // about a fixed axis through the placement
  Vec3 axis{0, 0, 1};
  double angle = 0;  // rad
};

// ---- soil ----------------------------------------------------------------------------------------------------------

/// Faces in the order -x, +x, -y, +y, -z, +z.
using Faces = std::array<bool, 6>;
inline constexpr std::array<const char*, 6> face_names{"-x", "+x", "-y", "+y", "-z", "+z"};

struct Box {
  Vec3 size{required, required, required};
  Vec3 at{required, required, required};  // corner of least coordinates
};

struct Container {
  Vec3 size{required, required, required};
  Vec3 at{required, required, required};  // corner of least coordinates
  Faces open{false, false, false, true, false, false};
  Faces open_after_settling{};
  std::string material;
};

struct EqualRadius {
  double radius = required;
};
struct NormalRadius {  // values outside [least, largest] are drawn again
  double mean = required, deviation = required, least = required, largest = required;
};
struct UniformRadius {
  double least = required, largest = required;
};
struct TableRadius {
  std::vector<double> radius, share;  // shares need not sum to one
};
using RadiusDistribution = std::variant<EqualRadius, NormalRadius, UniformRadius, TableRadius>;
enum class ShareOf { number, mass };

enum class Fill { lattice, rest_lattice, random, particles, file };
enum class Overlap { refuse, carve };
enum class Stages { automatic, yes, no };

/// Let the bed come to rest before the run starts (time 0 is after it).
struct Settle {
  std::optional<double> duration;     // `for`
  std::optional<double> until_speed;  // rms speed of the spheres
  double at_most = 5.0;               // s; longer is an error
  Stages stages = Stages::automatic;  // automatic: yes for random fill
  double lowered = 0.1;               // factor on friction and rolling before the ramp
  double ramp = 0.1;                  // s over which attraction, friction and rolling come back
  bool staged(Fill fill) const {
    return stages == Stages::yes || (stages == Stages::automatic && fill == Fill::random);
  }
};

struct Particle {
  Vec3 position{required, required, required};
  Vec3 velocity{}, spin{};
  double radius = required;
  std::optional<double> density;  // of its material unless given
  std::string material;           // of the bed unless given
};

/// One of several layers, from the surface down. The lowest one may leave both lengths out: it takes the rest.
struct Layer {
  std::optional<double> thickness;
  std::optional<Vec2> depth;  // from, to below the surface
  std::string material;
  RadiusDistribution radius;  // of the bed unless given
};

struct Bed {
  Fill fill = Fill::rest_lattice;
  std::string material;
  std::vector<Layer> layers;  // in place of the material
  RadiusDistribution radius;  // not for particles and file
  ShareOf shares = ShareOf::number;
  std::optional<double> pitch;  // lattice; default 2.02 radii (20.2 mm for 10 mm), rest lattice: from the law
  std::optional<Box> region;    // the container unless given
  std::optional<long> count;    // random: this many spheres, or
  std::optional<double> depth;  // fill the region's floor up to this height after settling
  long seed = 1;
  double jitter = 0;  // largest random shift of a lattice site, share of the radius
  std::optional<Settle> settle;
  std::string save, file;  // absolute paths; empty: none
  std::vector<Particle> particles;
  Overlap inside_machine = Overlap::refuse;
};

struct Soil {
  std::optional<Container> container;
  std::optional<double> surface;  // y of the mean surface after settling: bed and container are shifted
  std::optional<Bed> bed;
  double removal_below = 0.5;  // m below the floor
};

// ---- boundaries with given motion ----------------------------------------------------------------------------------

/// One stretch of a given motion; several add up. v(t) = velocity * profile(t), likewise the spin about `about`.
struct Move {
  Vec3 velocity{};            // m/s
  Vec3 spin{};                // rad/s
  std::optional<Vec3> about;  // point of the spin at the start, carried along; the boundary's `at` unless given
  Function profile{1.0};      // factor over time
  double from = 0, until = unlimited;  // s
};

struct Boundary {
  std::string name;
  std::string material;
  Shape shape;
  Vec3 at{};
  Rotation rotation;
  std::vector<Move> moves;
  std::optional<Vec3> reference;  // point of its wrench, carried along; `at` unless given
};

// ---- machine -------------------------------------------------------------------------------------------------------

struct Body {
  std::string name;
  double mass = required, inertia = required;  // about the centre of mass
  Vec2 at{required, required};                 // centre of mass in the start pose
  double angle = 0;
  Vec2 velocity{0, 0};
  double spin = 0;
  mbd::StartMark pose_is = mbd::StartMark::given, velocity_is = mbd::StartMark::given;
  std::vector<Vec2> outline;  // body axes, for pictures; empty: drawn from its surfaces or its joints
};
/// Elements carry body indices: 0 is the ground, i > 0 is bodies[i - 1].
struct NamedJoint {
  std::string name;
  Joint element;
};
struct NamedDriver {
  std::string name;
  Driver element;
};
struct NamedForce {
  std::string name;
  Force element;
};
struct NamedMeasure {
  std::string name;
  mbd::AnyMeasure element;
};

enum class PlacedIn { body, world };
/// A surface that moves with a body. `at` and `rotation` place the shape in the body's axes about its centre of mass
/// or, `placed in: world`, in the world axes of the start pose.
struct Surface {
  std::string name;
  std::string body;
  int body_index = 0;
  std::string material;
  Shape shape;
  PlacedIn placed_in = PlacedIn::body;
  Vec3 at{};
  Rotation rotation;
  bool touches_soil = true;  // no: drawn only
};

enum class StartKind { pose, towing_equilibrium };
struct Start {
  StartKind kind = StartKind::pose;
  double speed = 0;  // m/s along +x, towing equilibrium
};

struct Machine {
  std::vector<Body> bodies;
  std::vector<mbd::Marker> markers;
  std::vector<NamedJoint> joints;
  std::vector<NamedDriver> drivers;
  std::vector<NamedForce> forces;
  std::vector<NamedMeasure> measures;
  std::vector<Surface> surfaces;
  Start start;
  mbd::Redundancy redundant = mbd::Redundancy::minimum_norm;
  bool assemble = true;  // Newton on the rough pose; no: the pose must already satisfy the joints
};

// ---- time, output, limits ------------------------------------------------------------------------------------------

/// automatic: see integrator_of() in build/machine.hpp.
enum class IntegratorWord { automatic, adams_moulton, cvode, ida };
struct MachineTime {
  IntegratorWord integrator = IntegratorWord::automatic;
  long order = 4;
  std::optional<double> rtol, atol;  // cvode, ida
  mbd::IdaFormulation formulation = mbd::IdaFormulation::stabilised_index_2;
  bool locate_events = true;
  long soil_steps = 1;         // soil steps per machine step
  std::optional<double> step;  // without soil; with soil it is soil_steps * soil step
};

struct Time {
  double end = required;            // of dynamics and kinematics
  std::optional<double> soil_step;  // empty: auto
  double safety = 0.8;              // auto step / stable step (a bound on the safe side)
  double accuracy = 0.01;           // of the restitution, with the auto step
  MachineTime machine;
  long threads = 0;  // 0: all cores
};

enum class Column { position, velocity, spin, force, torque, contacts };
inline constexpr std::array<const char*, 6> column_names{"position", "velocity", "spin", "force", "torque", "contacts"};
enum class Precision { single, full };
enum class State { none, full };
/// What the columns of forces hold: means over the interval of a row, or values at its instant.
enum class ForceColumns { automatic, mean, instant };

/// A named column of the series made for the reader's eye.
struct Watch {
  enum class Kind { column, driver, force, joint, soil_force, soil_moment };
  std::string name;
  Kind kind = Kind::column;
  std::string of;       // column `shovel.angle`, or the driver, force, joint, body or boundary
  Vec3 along{1, 0, 0};  // joint, soil force: direction of the component; need not be a unit vector
};

struct Window {  // of the summary's means
  std::optional<double> from, until;
};

struct Output {
  std::optional<double> every;  // frames; end/200 unless given (unless `at` is)
  std::vector<double> at;       // further frame times
  double series_every = 1e-3;
  long book_every = 0;  // soil steps; 0: the bed's own choice
  ForceColumns forces = ForceColumns::automatic;
  std::vector<Column> columns{Column::position, Column::velocity, Column::spin,
                              Column::force,    Column::torque,   Column::contacts};
  Precision precision = Precision::single;
  long compression = 4;
  std::optional<Box> region;  // only spheres in it
  std::optional<double> state_every;
  State state = State::full;  // at the end
  std::vector<Watch> watch;
  Window window;
};

struct Limits {
  double overlap = 0.5;  // share of the radius
  double speed = 50;     // m/s
  double energy = 0.1;   // share of the machine's energy by which its balance may be off
};

/// What is done with the machine; all but dynamics are for machines without soil.
enum class Analysis { dynamics, kinematics, equilibrium, modes, assembly };
inline constexpr std::array<const char*, 5> analysis_names{"dynamics", "kinematics", "equilibrium", "modes",
                                                           "assembly"};

struct Scenario {
  long version = 1;
  std::string title;
  Analysis analysis = Analysis::dynamics;
  Vec3 gravity{0, -9.81, 0};
  std::vector<Material> materials;
  std::vector<Contact> contacts;
  std::optional<Soil> soil;
  std::vector<Boundary> boundaries;
  std::optional<Machine> machine;
  Time time;
  Output output;
  Limits limits;
  std::string simd = "auto";
  dem::Precision precision = dem::Precision::doubles;

  /// Without soil a row of the series holds everything at its instant, in full precision.
  bool has_bed() const { return soil.has_value() || !boundaries.empty(); }
  bool instant_forces() const {
    return output.forces == ForceColumns::instant || (output.forces == ForceColumns::automatic && !has_bed());
  }
  /// Analyses that follow the machine over time.
  bool runs_in_time() const { return analysis == Analysis::dynamics || analysis == Analysis::kinematics; }
};

}  // namespace subsoil::app
