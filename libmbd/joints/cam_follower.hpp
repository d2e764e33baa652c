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

/// Cam and follower: a point of body b, or a roller about it, stays on the profile of body a.
///   Phi = -d(w) - R = 0                                                         (m)
/// d: distance of w from the profile, positive inside (see Curve); w: follower point p_b seen from the profile's centre
/// p_a, in a's axes [m]; R roller radius [m] >= 0. The profile is a cubic spline of the radius rho over the angle, in
/// a's axes about p_a, periodic when closed: d, its gradient and its curvature are exact for that spline.
/// Validity: the roller fits into every hollow of the profile (checked), and stays closer to the profile than half the
/// gap to another stretch of it. Contact is kept: it pulls where a follower would lift off. Beyond the ends of an open
/// profile the radius continues linearly.
/// Reaction: a force along the profile's normal at the contact point, no moment.
struct CamFollower {
  static constexpr ConstraintMembers has{.check = true,
                                         .initialise_from_pose = true,
                                         .points = true,
                                         .reaction_point = true,
                                         .characteristic_length = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  std::vector<double> angles{}, radii{};
  bool closed = true;
  double roller = 0;
  std::shared_ptr<const Curve> curve{};  ///< of angles and radii; made at the start

  template <class V>
  void describe(V& v) {
    v.card("cam", "a point of the second body, or a roller about it, follows the profile of the first");
    v.bodies("cam", body_a, body_b, "the cam and the follower; the reaction is reported on the first, at the contact");
    v.end_points(body_a, p_a, body_b, p_b, "the centre of the profile and the follower's point, or roller's centre");
    v.table("profile", angles, radii, "rad", "m",
            "angle in the cam's own axes and radius, angles increasing; a cubic spline between");
    v.flag("closed", closed,
           "yes: the profile goes once around; no: beyond its first and last point the radius continues linearly");
    v.quantity("roller", roller, "m", "[0, inf)", "radius of the roller; 0: the point itself is on the profile");
  }
  void check() const {
    const Curve::Curvatures k = Curve::polar(angles, radii, closed).curvatures();
    if (roller < 0) throw std::invalid_argument("roller must not be below 0 m; for a point follower use 0");
    if (1 + k.least * roller <= 0)
      throw std::invalid_argument(
          "a roller of " + std::to_string(roller) + " m does not fit into the profile's hollow of radius " +
          std::to_string(-1 / k.least) + " m at " + std::to_string(k.least_at * 180 / std::numbers::pi) +
          " deg; take a smaller roller, or widen the hollow");
  }
  double characteristic_length() const { return radii.empty() ? 0 : *std::max_element(radii.begin(), radii.end()); }

  void initialise_from_pose(const BodyState& /*a*/, const BodyState& /*b*/, double /*t*/) {
    curve = std::make_shared<const Curve>(Curve::polar(angles, radii, closed));
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const RelativePoint p(a, p_a, b, p_b);
    const Curve::Nearest c = curve->nearest(p.w);
    const double slide = dot(c.tangent, p.rate);
    out[0] = p.row(-c.distance - roller, -1 * c.normal, -c.bend() * slide * slide);
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const {
    const Vec2 at = curve->nearest(RelativePoint(a, p_a, b, p_b).w).point;
    return a.point_in_world({p_a[0] + at.x, p_a[1] + at.y});
  }
};

}  // namespace subsoil::mbd
