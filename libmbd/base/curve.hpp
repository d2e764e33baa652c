#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "libmbd/base/body.hpp"
#include "libmbd/base/spline.hpp"

namespace subsoil::mbd {

/// A plane curve c(u), twice continuously differentiable, for cams and paths:
///   polar    c = rho(u) (cos u, sin u), rho a cubic spline over the angle u, counter-clockwise
///   through  x and y cubic splines over the length of the chords between given points
/// Closed curves use periodic splines. Open ones use natural splines and continue beyond the ends with rho, or x and y,
/// linear in u, which keeps the second derivative continuous.
///
/// The nearest point is found by a search over samples and Newton's method from the best, again at every call: the
/// result depends on the asked point alone. It is unique, and smooth, for points closer to the curve than its radius of
/// curvature and than half of the gap to another stretch of it.
class Curve {
 public:
  static Curve polar(const std::vector<double>& angles, const std::vector<double>& radii, bool closed);
  static Curve through(const std::vector<std::array<double, 2>>& points, bool closed);

  struct At {
    Vec2 point, first, second;  ///< c, c', c''
  };
  At at(double u) const;

  /// Of a point w: its signed distance d = n . (w - c), positive left of the curve, with grad d = n and
  /// Hess d = -kappa / (1 - kappa d) t t^T.
  struct Nearest {
    Vec2 point, tangent, normal;
    double distance = 0, curvature = 0;
    double bend() const { return -curvature / (1 - curvature * distance); }
  };
  Nearest nearest(Vec2 w) const;

  /// Support function of a closed convex curve, counter-clockwise: h(beta) = maximum c . (cos beta, sin beta), with two
  /// derivatives, and the point that touches. h + h'' is the radius of curvature there.
  struct Support {
    double value = 0, first = 0, second = 0;
    Vec2 point;
  };
  Support support(double beta) const;

  /// Distance of its farthest sample from the origin of its axes (m).
  double reach() const;
  /// Minimum and maximum curvature of the samples (1/m), positive to the left, and the parameters of them.
  struct Curvatures {
    double least, largest, least_at, largest_at;
  };
  Curvatures curvatures() const;
  /// Where the curve crosses itself, first place found.
  bool crosses_itself(Vec2& where) const;

 private:
  struct Sample {
    double u;
    Vec2 point;
  };
  Curve(PiecewiseCubic first, PiecewiseCubic second, bool polar, bool closed);
  double curvature(const At& c) const;
  template <class Slope>
  double root_near(std::size_t sample, Slope slope) const;

  PiecewiseCubic x_, y_;  // polar: x_ is rho, y_ is not used
  bool polar_, closed_;
  std::vector<Sample> samples_;  // of a closed curve the last one is not the first again
};

}  // namespace subsoil::mbd
