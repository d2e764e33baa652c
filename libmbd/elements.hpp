#pragma once

// The lists of what a machine can be built of. A new joint, driver or force is its own file and one entry here: the
// system, the scenario reader, the checker and the docs iterate over these tuples. Only sources that go through every
// type include this file; a model needs the headers of the elements that it names.
//
// describe(V&) uses the common vocabulary and these words besides:
//   v.bodies(key, a, b, meaning)                               the two bodies; the key is the element's word
//   v.joint_point(a, p_a, b, p_b, meaning)                     `at:` one world point of the start pose for both
//   v.end_points(a, p_a, b, p_b, meaning)                      `ends:` two points, one of either body
//   v.axis(key, a, angle, meaning)                             `along:` a world direction of the start pose
//   v.coordinate(key, body, coordinate, meaning)               `coordinate: trolley.x`: a body and x, y or angle of it
//   v.optional_characteristic(key, characteristic, x unit, unit, meaning)
//                                                              force over a measure; left out: is_set() stays false
//   v.exponent(key, number, range, meaning)                   that units beside it hold as n: N/m^(n+1)
//   v.joint(key, name, meaning)                                the name of a joint of the machine
//   v.optional_function(key, function, unit, meaning)          may be left out: function.is_set() stays false
//   v.optional_quantity(key, number, unit, range, meaning)     may be left out: the number stays NaN
//   v.point(key, body, point, meaning)                         a point in body axes; `at: x y m` is a world point of
//                                                              the start pose; left out: the centre of gravity
//   v.form(key, variant, meaning)                              one of several structs, chosen by the word that is there
//   v.optional_body(key, body, meaning)                        a body or the ground; left out: the ground

#include <tuple>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/drivers/distance_driver.hpp"
#include "libmbd/drivers/slide_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/beam_element.hpp"
#include "libmbd/forces/bushing.hpp"
#include "libmbd/forces/disk_contact.hpp"
#include "libmbd/forces/distance_stop.hpp"
#include "libmbd/forces/drag.hpp"
#include "libmbd/forces/electric_motor.hpp"
#include "libmbd/forces/ground_element.hpp"
#include "libmbd/forces/hydraulic_cylinder.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/outline_contact.hpp"
#include "libmbd/forces/own_force.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/forces/slide_stop.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/forces/torque_speed_motor.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/joints/cam_follower.hpp"
#include "libmbd/joints/coupler.hpp"
#include "libmbd/joints/disk_on_disk.hpp"
#include "libmbd/joints/disk_on_line.hpp"
#include "libmbd/joints/distance.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/flat_faced_cam.hpp"
#include "libmbd/joints/gear_pair.hpp"
#include "libmbd/joints/gear_ratio.hpp"
#include "libmbd/joints/own_joint.hpp"
#include "libmbd/joints/point_on_curve.hpp"
#include "libmbd/joints/point_on_line.hpp"
#include "libmbd/joints/rack_and_pinion.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/rolling_on_disk.hpp"
#include "libmbd/joints/rolling_on_line.hpp"
#include "libmbd/joints/translational.hpp"

namespace subsoil::mbd {

using Joints =
    std::tuple<Revolute, Translational, Fixed, PointOnLine, Distance, DiskOnLine, RollingOnLine, DiskOnDisk,
               RollingOnDisk, GearPair, GearRatio, RackAndPinion, Coupler, CamFollower, FlatFacedCam, PointOnCurve>;
using Drivers = std::tuple<CoordinateDriver, AngleDriver, SlideDriver, DistanceDriver>;
using Forces = std::tuple<SpringDamper, RotationalSpringDamper, Bushing, BeamElement, AppliedForce, Drag, LineContact,
                          DiskContact, OutlineContact, RotationalStop, SlideStop, DistanceStop, WheelOnSoil,
                          GroundElement, JointFriction, HydraulicCylinder, ElectricMotor, TorqueSpeedMotor>;

namespace detail {
template <class List, class... More>
using WithMore = decltype(std::tuple_cat(std::declval<List>(), std::declval<std::tuple<More...>>()));
}  // namespace detail

// Those above, which scenarios name, and those of a user's program.
using AllJoints = detail::WithMore<Joints, OwnJoint<1>, OwnJoint<2>, OwnJoint<3>>;
using AllForces = detail::WithMore<Forces, OwnForce>;

template <>
struct ListOf<JointFamily> {
  using type = AllJoints;
};
template <>
struct DeclaredOf<JointFamily> {
  using type = Joints;
};
template <>
struct DeclaredOf<ForceFamily> {
  using type = Forces;
};
template <>
struct ListOf<DriverFamily> {
  using type = Drivers;
};
template <>
struct ListOf<ForceFamily> {
  using type = AllForces;
};

}  // namespace subsoil::mbd
