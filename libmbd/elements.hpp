#pragma once

// The lists of what a machine can be built of. A new joint, driver or force is its own file and one entry here: the
// system, the scenario reader, the checker and the docs iterate over these tuples.
//
// describe(V&) uses the common vocabulary and these words besides:
//   v.coordinate(key, body, coordinate, meaning)               `coordinate: trolley.x`: a body and x, y or angle of it
//   v.joint(key, name, meaning)                                the name of a joint of the machine
//   v.optional_function(key, function, unit, meaning)          may be left out: function.is_set() stays false
//   v.optional_quantity(key, number, unit, range, meaning)     may be left out: the number stays NaN
//   v.point(key, body, point, meaning)                         a point in body axes; `at: x y m` is a world point of
//   the
//                                                              start pose; may be left out: the centre of gravity

#include <tuple>
#include <variant>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/drivers/slide_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"

namespace subsoil::mbd {

using Joints = std::tuple<Revolute, Translational, Fixed>;
using Drivers = std::tuple<CoordinateDriver, AngleDriver, SlideDriver>;
using Forces = std::tuple<SpringDamper, RotationalSpringDamper, AppliedForce, WheelOnSoil, JointFriction>;

namespace detail {
template <class Tuple>
struct AsVariant;
template <class... Types>
struct AsVariant<std::tuple<Types...>> {
  using type = std::variant<Types...>;
};
}  // namespace detail

using AnyJoint = detail::AsVariant<Joints>::type;
using AnyDriver = detail::AsVariant<Drivers>::type;
using AnyForce = detail::AsVariant<Forces>::type;

}  // namespace subsoil::mbd
