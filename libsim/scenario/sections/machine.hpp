#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libmbd/base/marker.hpp"
#include "libmbd/controllers/controller.hpp"
#include "libmbd/element/constraint.hpp"
#include "libmbd/element/force.hpp"
#include "libmbd/integrators/integrator.hpp"
#include "libmbd/system/joint_event.hpp"
#include "libmbd/system/measure.hpp"
#include "libsim/scenario/sections/beams.hpp"
#include "libsim/scenario/sections/placement.hpp"
#include "libsim/scenario/sections/wear.hpp"
#include "libsim/scenario/shapes/shapes.hpp"

/// The planar multibody system. Lists end with what the beams stand for: see beams.hpp.
namespace subsoil::sim {

using Joint = mbd::AnyJoint;
using Driver = mbd::AnyDriver;
using Force = mbd::AnyForce;

struct BodySection {
  std::string name;
  double mass = required, inertia = required;  // about the centre of mass
  Vec2 at{required, required};                 // centre of mass in the start pose
  double angle = 0;
  Vec2 velocity{0, 0};
  double spin = 0;
  mbd::StartMark pose_is = mbd::StartMark::given, velocity_is = mbd::StartMark::given;
  std::vector<Vec2> outline;  // body axes, for pictures; empty: drawn from its surfaces or its joints
};
void describe(Fields& v, BodySection& b);

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

struct NamedController {
  std::string name;
  mbd::AnyController element;
};

/// A joint that opens or closes when something happens.
struct JointEventSection {
  std::string name;
  std::string opens, closes;  // the joint; one of them
  std::optional<double> at, reaction_above;
  std::string measure, above, below;  // the value with the measure's unit
  mbd::JointEvent::Starts starts = mbd::JointEvent::Starts::by_events;
};
void describe(Fields& v, JointEventSection& e);

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
  bool touches_soil = true;       // no: drawn only
  std::optional<double> cutting;  // rad, of the wedge: edges that cut fibres
  std::optional<WearSection> wear;
};
void describe(Fields& v, Surface& s);

enum class StartKind { pose, towing_equilibrium };
struct Start {
  StartKind kind = StartKind::pose;
  double speed = 0;  // m/s along +x, towing equilibrium
};

struct MachineSection {
  std::vector<BodySection> bodies;
  std::vector<BeamSection> beams;
  std::vector<mbd::Marker> markers;
  std::vector<NamedJoint> joints;
  std::vector<NamedDriver> drivers;
  std::vector<NamedForce> forces;
  std::vector<NamedMeasure> measures;
  std::vector<NamedController> controllers;
  std::vector<JointEventSection> events;
  std::vector<Surface> surfaces;
  Start start;
  mbd::Redundancy redundant = mbd::Redundancy::minimum_norm;
  bool assemble = true;  // Newton on the rough pose; no: the pose must already satisfy the joints
};
void describe(Fields& v, MachineSection& m);

/// The measure that a column belongs to (NAME or NAME.x) and its place among
/// that measure's columns; null: none.
const NamedMeasure* measure_of(const MachineSection& m, const std::string& column, std::size_t& place);

/// Columns of measures that a controller takes, in the order of its inputs.
std::vector<std::string> measured_by(const MachineSection& m, const mbd::AnyController& controller);

struct Checks;
struct Scenario;
/// Fills Surface::body_index.
void check_machine(Checks& checks, Scenario& s);

}  // namespace subsoil::sim
