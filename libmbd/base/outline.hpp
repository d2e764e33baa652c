#pragma once

#include <array>
#include <memory>
#include <vector>

#include "libmbd/base/body.hpp"
#include "libmbd/base/curve.hpp"

namespace subsoil::mbd {

/// The side of a body that others may touch, in body axes: what distance a point has from it, and where it can touch
/// another outline itself.
///   disk      |w - c| - R
///   polygon   its solid side inside; corners may be rounded by a radius r: it is then the polygon whose sides lie r
///             further in, widened by r
///   curve     a smooth profile or flank (see Curve); free on its left, or on its right
///   flat      n . (w - q), a half plane
/// Signed distances are positive on the free side. Inside a convex polygon the nearest side counts, so the direction is
/// unique for depths that are small beside its sides. In a re-entrant corner of a polygon a disk lies on both sides at
/// once, and each pushes it: the nearest alone would flip its direction from side to side on the bisector, where such a
/// disk comes to rest.
class Outline {
 public:
  enum class Kind { disk, polygon, curve, flat };
  using Points = std::vector<std::array<double, 2>>;

  static Outline disk(std::array<double, 2> centre, double radius);
  /// Either sense of turning. Throws std::invalid_argument where sides cross or vanish within the corner radius.
  static Outline polygon(const Points& points, double corner_radius);
  /// `origin` is where the curve's own axes begin, `middle` a point inside of a closed one there; `free_left`: its
  /// solid side is on the right.
  static Outline curve(std::shared_ptr<const Curve> curve, std::array<double, 2> origin, std::array<double, 2> middle,
                       bool free_left, bool closed);
  static Outline flat(std::array<double, 2> point, double angle);

  Kind kind() const { return kind_; }

  struct Near {
    double distance = 0;
    Vec2 normal;  ///< unit, to the free side
  };
  /// Throws std::runtime_error at a disk's centre, where no direction is.
  Near near(Vec2 w) const;

  /// All places of the outline that a disk about w may touch at once, the nearest first; what is left of `out` stands
  /// at the distance `nowhere`. More than one only of a polygon with re-entrant corners: its sides, each to its own
  /// line, which continues into the solid beyond a re-entrant end, so that a place comes and goes at distance 0 of its
  /// disk and its force never jumps; and its convex corners.
  static constexpr std::size_t most_at_once = 3;
  static constexpr double nowhere = 1;  ///< m; finite, since integrators look for its zeros
  using Nears = std::array<Near, most_at_once>;
  void all_near(Vec2 w, Nears& out) const;
  std::size_t at_once() const { return re_entrant_ ? most_at_once : 1; }

  /// A point that can touch another outline with the radius about it: a disk's centre, a convex corner of a polygon
  /// with the outward normals of the sides before and after it, counter-clockwise.
  struct Corner {
    Vec2 centre;
    double radius;
    Vec2 before, after;
  };
  const std::vector<Corner>& corners() const { return corners_; }

  /// A straight side from `from` on along `along` (unit) over `length`, infinite of a flat, `radius` beneath its
  /// surface.
  struct Face {
    Vec2 from, along, normal;
    double length, radius;
  };
  const std::vector<Face>& faces() const { return faces_; }

  /// Whether it is a closed curve with its solid inside, which a face can touch.
  bool has_support() const { return kind_ == Kind::curve && closed_ && !free_left_; }
  /// Of such a curve: its farthest point along the unit vector m, and a point inside.
  Vec2 farthest(Vec2 m) const;
  Vec2 middle() const { return middle_; }
  /// Distance of its farthest point from the body's origin (m); infinity of a flat and of an open curve.
  double reach() const;
  /// Radius of the narrowest hollow of a curve (m); infinity without one.
  double narrowest_hollow() const;

 private:
  explicit Outline(Kind kind) : kind_(kind) {}
  struct OfPolygon {  // the nearest side, or the corner at its beginning
    std::size_t side;
    bool at_corner;
    double away;
  };
  OfPolygon nearest_of_polygon(Vec2 w) const;
  Near near_polygon(Vec2 w) const;
  void all_outside(Vec2 w, Nears& out) const;
  void all_inside(Vec2 w, const OfPolygon& nearest, Nears& out) const;
  bool faces_along(std::size_t side, Vec2 w) const;
  std::size_t before(std::size_t side) const { return (side + faces_.size() - 1) % faces_.size(); }
  std::size_t after(std::size_t side) const { return (side + 1) % faces_.size(); }

  Kind kind_;
  Vec2 centre_{}, middle_{};
  double radius_ = 0;
  std::vector<Corner> corners_;
  std::vector<Face> faces_;
  std::vector<char> convex_;  // of the corner at the beginning of each side
  std::shared_ptr<const Curve> curve_;
  bool free_left_ = false, closed_ = false, re_entrant_ = false;
};

}  // namespace subsoil::mbd
