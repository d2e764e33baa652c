#pragma once

#include <algorithm>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/base/curve.hpp"
#include "libmbd/element/relative_point.hpp"

namespace subsoil::mbd {

/// Flat-faced follower: a straight face of body b stays tangent to the closed convex profile of body a.
///   Phi = m . w - h(beta) = 0,  m = (cos beta, sin beta)                        (m)
/// w: a point p_b of the face seen from the profile's centre p_a, in a's axes [m]; beta: direction of the face's normal
/// in a's axes, from the cam to the follower [rad]; h(beta): support function of the profile (see Curve), a cubic
/// spline of the radius over the angle, in a's axes about p_a.
/// The normal is k x face or its opposite, whichever points to the follower in the start pose (side = +1 or -1).
/// Validity: the profile is convex (checked). The face has no end; contact is kept.
/// Reaction: a force along m at the contact point, no moment. Source: Norton, Cam Design and Manufacturing Handbook, 7.
struct FlatFacedCam {
  static constexpr ConstraintMembers has{.check = true,
                                         .initialise_from_pose = true,
                                         .points = true,
                                         .reaction_point = true,
                                         .characteristic_length = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double angle_b = 0;  ///< direction of the face from body b's x axis
  std::vector<double> angles{}, radii{};
  double side = std::numeric_limits<double>::quiet_NaN();
  std::shared_ptr<const Curve> curve{};  ///< of angles and radii; made at the start

  template <class V>
  void describe(V& v) {
    v.card("flat-faced cam", "a straight face of the second body follows the closed convex profile of the first");
    v.bodies("flat-faced cam", body_a, body_b,
             "the cam and the follower; the reaction is reported on the first, at the contact");
    v.end_points(body_a, p_a, body_b, p_b, "the centre of the profile and a point of the face");
    v.axis("face", body_b, angle_b, "direction of the face in the start pose");
    v.table("profile", angles, radii, "rad", "m",
            "angle in the cam's own axes and radius, angles increasing, once around; a cubic spline between");
  }
  void check() const {
    const Curve::Curvatures k = Curve::polar(angles, radii, true).curvatures();
    if (k.least <= 0)
      throw std::invalid_argument(
          "the profile is not convex at " + std::to_string(k.least_at * 180 / std::numbers::pi) +
          " deg, and a flat face cannot reach into a hollow; fill the hollow, or use a cam with "
          "a point or roller");
  }
  double characteristic_length() const { return radii.empty() ? 0 : *std::max_element(radii.begin(), radii.end()); }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    curve = std::make_shared<const Curve>(Curve::polar(angles, radii, true));
    if (!std::isnan(side)) return;
    const double height = dot(normal(a, b, 1), RelativePoint(a, p_a, b, p_b).w);
    if (height == 0)
      throw std::invalid_argument(
          "the face goes through the profile's centre in the start pose, so its side is not known; start it on its "
          "side "
          "of the cam");
    side = height > 0 ? 1 : -1;
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const RelativePoint p(a, p_a, b, p_b);
    const Vec2 m = normal(a, b, side), across = turned(m);
    const Curve::Support h = curve->support(std::atan2(m.y, m.x));
    const double height = dot(m, p.w), phi_turn = dot(across, p.w) - h.first;
    const double second = p.turn_rate * (2 * dot(across, p.rate) - p.turn_rate * (height + h.second));
    out[0] = p.row(height - h.value, m, second, phi_turn);
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const {
    const Vec2 m = normal(a, b, side), at = curve->support(std::atan2(m.y, m.x)).point;
    return a.point_in_world({p_a[0] + at.x, p_a[1] + at.y});
  }

 private:
  Vec2 normal(const BodyState& a, const BodyState& b, double on_side) const {
    const double face = b.angle - a.angle + angle_b;
    return on_side * Vec2{-std::sin(face), std::cos(face)};
  }
};

}  // namespace subsoil::mbd
