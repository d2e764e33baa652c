#pragma once

#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

/// Angle of a marker's axes against those of another, counter-clockwise:   angle_P - angle_Q                   (rad)
/// It counts turns, as the angles of bodies do.
struct AngleMeasure {
  static constexpr MeasureMembers has{};
  Marker of{}, from{.name = "ground"};

  template <class V>
  void describe(V& v) {
    v.card("angle", "the angle of a marker's axes, counter-clockwise; whole turns count");
    v.marker("angle", of, "the marker or body whose axes are looked at");
    v.optional_marker("from", from, "against whose axes");
  }
  std::vector<MeasureColumn> columns() const { return {{"", "rad"}}; }
  void evaluate(const Observation& o, std::span<double> out) const { out[0] = o.at(of).angle - o.at(from).angle; }
};

/// Angular velocity of a marker against another:   spin_P - spin_Q                                           (rad/s)
struct AngularVelocityMeasure {
  static constexpr MeasureMembers has{};
  Marker of{}, from{.name = "ground"};

  template <class V>
  void describe(V& v) {
    v.card("angular velocity", "how fast a marker's body turns, counter-clockwise");
    v.marker("angular velocity", of, "the marker or body that is looked at");
    v.optional_marker("from", from, "against which");
  }
  std::vector<MeasureColumn> columns() const { return {{"", "rad/s"}}; }
  void evaluate(const Observation& o, std::span<double> out) const { out[0] = o.at(of).omega - o.at(from).omega; }
};

/// Angular acceleration of a marker against another:   alpha_P - alpha_Q                                   (rad/s^2)
struct AngularAccelerationMeasure {
  static constexpr MeasureMembers has{.of_solution = true};
  Marker of{}, from{.name = "ground"};

  template <class V>
  void describe(V& v) {
    v.card("angular acceleration", "how a marker's body gains angular velocity");
    v.marker("angular acceleration", of, "the marker or body that is looked at");
    v.optional_marker("from", from, "against which");
  }
  std::vector<MeasureColumn> columns() const { return {{"", "rad/s^2"}}; }
  void evaluate(const Observation& o, std::span<double> out) const { out[0] = o.at(of).alpha - o.at(from).alpha; }
};

/// Angle at the middle one of three markers, from the line to the first to the line to the last:              (rad)
///   atan2(e x f, e . f),  e = r_1 - r_2,  f = r_3 - r_2;   counter-clockwise, in (-pi, pi]
/// The transmission angle of a four-bar, with the two pins of its coupler's end and the far pin of the follower.
struct CornerMeasure {
  static constexpr MeasureMembers has{};
  std::array<Marker, 3> at{};

  template <class V>
  void describe(V& v) {
    v.card("corner", "the angle at the second of three markers, between the lines to the first and to the third");
    v.markers("corner", at, "the three markers or bodies; counter-clockwise from the first line, -180 to 180 deg");
  }
  std::vector<MeasureColumn> columns() const { return {{"", "rad"}}; }
  void evaluate(const Observation& o, std::span<double> out) const {
    const Vec2 corner = o.at(at[1]).r, e = o.at(at[0]).r - corner, f = o.at(at[2]).r - corner;
    out[0] = std::atan2(cross(e, f), dot(e, f));
  }
};

}  // namespace subsoil::mbd
