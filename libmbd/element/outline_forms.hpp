#pragma once

#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "libmbd/base/outline.hpp"

namespace subsoil::mbd {

// What an outline is given by, in the axes of its body (of the ground: the world's).

struct DiskOutline {
  double radius = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 2> centre{0, 0};

  template <class V>
  void describe(V& v) {
    v.card("disk", "a disk: a roller, an eccentric cam");
    v.quantity("disk", radius, "m", "(0, inf)", "its radius");
    v.vector("centre", centre, "m", "its centre, in the body's own axes");
  }
  void check() const { make(); }
  Outline make() const {
    if (!(radius > 0)) throw std::invalid_argument("the disk's radius must be given and above 0");
    return Outline::disk(centre, radius);
  }
};

struct PolygonOutline {
  Outline::Points points{};
  double corner_radius = 0;

  template <class V>
  void describe(V& v) {
    v.card("polygon", "a solid polygon: a block, a hook, a pawl");
    v.outline("polygon", points,
              "corners `x y` once around, in the body's own axes, or a CSV file of them whose header names the unit");
    v.quantity("corner radius", corner_radius, "m", "[0, inf)",
               "its convex corners are rounded by it; 0: sharp, then corner against corner has no clear direction");
  }
  void check() const { make(); }
  Outline make() const {
    if (!(corner_radius >= 0)) throw std::invalid_argument("the corner radius must not be negative; 0 is sharp");
    return Outline::polygon(points, corner_radius);
  }
};

struct ProfileOutline {
  std::vector<double> angles{}, radii{};
  std::array<double, 2> centre{0, 0};

  template <class V>
  void describe(V& v) {
    v.card("profile", "the closed smooth profile of a cam, by its radius over the angle");
    v.table("profile", angles, radii, "rad", "m",
            "angle in the body's own axes and radius, angles increasing, once around; a cubic spline between");
    v.vector("centre", centre, "m", "where the radii begin, in the body's own axes");
  }
  std::shared_ptr<const Curve> curve() const {
    return std::make_shared<const Curve>(Curve::polar(angles, radii, true));
  }
  void check() const { make(); }
  Outline make() const { return Outline::curve(curve(), centre, {0, 0}, false, true); }
};

struct FlankOutline {
  Outline::Points points{};
  bool closed = false;

  template <class V>
  void describe(V& v) {
    v.card("flank", "a smooth curve through points, free on its left");
    v.outline("flank", points,
              "points `x y` of the curve in the body's own axes, or a CSV file of them whose header names the unit; a "
              "cubic spline through them, its free side on the left");
    v.flag("closed", closed,
           "yes: on from the last point to the first, clockwise around a body, counter-clockwise around a hole; no: "
           "straight on beyond its ends");
  }
  std::shared_ptr<const Curve> curve() const {
    const auto made = std::make_shared<const Curve>(Curve::through(points, closed));
    Vec2 where;
    if (made->crosses_itself(where))
      throw std::invalid_argument("the flank crosses itself near " + std::to_string(where.x) + " " +
                                  std::to_string(where.y) + " m; end it before, or part it in two contacts");
    return made;
  }
  void check() const { make(); }
  Outline make() const {
    if (!closed || !turns_clockwise()) return Outline::curve(curve(), {0, 0}, {0, 0}, true, closed);
    FlankOutline other{{points.rbegin(), points.rend()}, true};
    std::array<double, 2> mean{0, 0};
    for (const auto& p : points)
      for (std::size_t k = 0; k < 2; ++k) mean[k] += p[k] / static_cast<double>(points.size());
    return Outline::curve(other.curve(), {0, 0}, mean, false, true);
  }

 private:
  bool turns_clockwise() const {
    double twice_area = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto &p = points[i], &q = points[(i + 1) % points.size()];
      twice_area += p[0] * q[1] - p[1] * q[0];
    }
    return twice_area < 0;
  }
};

struct FlatOutline {
  std::array<double, 2> point{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  double angle = 0;

  template <class V>
  void describe(V& v) {
    v.card("flat", "a straight side without ends: a floor, a flat-faced follower");
    v.vector("flat", point, "m", "a point of it, in the body's own axes");
    v.quantity("direction", angle, "rad", "(-inf, inf)",
               "angle of the side in the body's own axes; its free side is on the left");
  }
  void check() const { make(); }
  Outline make() const { return Outline::flat(point, angle); }
};

using OutlineForm = std::variant<PolygonOutline, DiskOutline, ProfileOutline, FlankOutline, FlatOutline>;

}  // namespace subsoil::mbd
