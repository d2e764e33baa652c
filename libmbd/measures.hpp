#pragma once

// What can be measured of a machine. A new measure is its own file and one entry in the list: the machine, the scenario
// reader and the docs iterate over it.
//
// describe(V&) uses the words of libmbd/elements.hpp and these:
//   v.marker(key, marker, meaning)            a marker, a body (its centre of gravity, its axes) or the ground
//   v.optional_marker(key, marker, meaning)   may be left out: the marker stays what it is
//   v.markers(key, array, meaning)            as many markers as the array holds
//   v.force(key, name, meaning)               the name of a force of the machine

#include <tuple>

#include "libmbd/measures/acceleration.hpp"
#include "libmbd/measures/angle.hpp"
#include "libmbd/measures/beam.hpp"
#include "libmbd/measures/distance.hpp"
#include "libmbd/measures/energy.hpp"
#include "libmbd/measures/force.hpp"
#include "libmbd/measures/position.hpp"
#include "libmbd/measures/reaction.hpp"
#include "libmbd/measures/velocity.hpp"

namespace subsoil::mbd {

using Measures = std::tuple<PositionMeasure, VelocityMeasure, AccelerationMeasure, DistanceMeasure, DistanceRateMeasure,
                            AngleMeasure, AngularVelocityMeasure, AngularAccelerationMeasure, CornerMeasure,
                            ReactionMeasure, ForceMeasure, EnergyMeasure, BeamMeasure>;

template <>
struct ListOf<MeasureFamily> {
  using type = Measures;
};

}  // namespace subsoil::mbd
