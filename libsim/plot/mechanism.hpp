#pragma once
#include <limits>
#include <string>
#include <vector>

#include "libsim/plot/canvas.hpp"
#include "libsim/setup/sketch.hpp"

namespace subsoil::sim {

/// A rectangle of the machine's plane, m.
struct Extent {
  double left = std::numeric_limits<double>::infinity(), right = -left, low = left, high = -left;
  void take(mbd::Vec2 p) {
    left = std::min(left, p.x), right = std::max(right, p.x);
    low = std::min(low, p.y), high = std::max(high, p.y);
  }
  double width() const { return right - left; }
  double height() const { return high - low; }
};

/// Where the machine's plane lies in a picture: `scale` pixels per metre, the extent's lower left corner at `corner`.
struct View {
  Extent seen;
  Spot corner;
  double scale = 1;
  Spot operator()(mbd::Vec2 p) const { return corner + scale * Spot{p.x - seen.left, p.y - seen.low}; }
};

/// Draws a machine with the symbols of textbooks: circles for pins, triangles and hatches where they hold on to the
/// ground, blocks on slides, zigzags for springs, boxes for dampers.
class MechanismDrawing {
 public:
  /// `all`: the poses of the whole run, from which slides know how far they go.
  MechanismDrawing(const Sketch& sketch, const std::vector<Poses>& all);

  /// What a pose covers is taken into `extent`.
  void take_extent(const Poses& poses, Extent& extent) const;
  void draw(Canvas& canvas, const View& view, const Poses& poses) const;
  /// The bodies alone, in grey: another pose behind the one that counts.
  void draw_shadow(Canvas& canvas, const View& view, const Poses& poses) const;

  /// Colour of a body's lines.
  static std::string colour_of(int body);

 private:
  struct Reach {
    double from = std::numeric_limits<double>::infinity(), to = -from;
  };
  const Sketch& sketch_;
  std::vector<Reach> reaches_;  // of the slides
};

}  // namespace subsoil::sim
