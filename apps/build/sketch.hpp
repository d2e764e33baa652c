#pragma once
#include <string>
#include <vector>

#include "apps/scenario/scenario.hpp"

/// What pictures show of a machine: plane shapes fixed to its bodies, taken from the scenario alone.
namespace subsoil::app {

struct Sketch {
  /// A stretch of a body's outline, in its own axes. Closed ones can be filled.
  struct Outline {
    int body;
    std::vector<Vec2> points;
    bool closed = true;
  };
  /// A wheel, gear or roller about a point of a body.
  struct Disk {
    int body;
    Vec2 centre;
    double radius;
  };
  /// Two points of two bodies that belong together: p_a on a, p_b on b.
  struct Pair {
    int a, b;
    Vec2 p_a, p_b;
  };
  /// What moves along a line of body a, at angle_a in its axes: a block, or a pin in a slot.
  struct Slide : Pair {
    double angle_a;
    bool block;
  };
  struct Link : Pair {
    enum class Kind { rod, spring, damper } kind;
  };
  /// A straight side of a body without ends; the free side is on the left.
  struct Side {
    int body;
    Vec2 point;
    double angle;
  };

  std::vector<std::string> names;  // of bodies, ground first
  std::vector<Outline> outlines;
  std::vector<Disk> disks;
  std::vector<Pair> pins, welds;
  std::vector<Slide> slides;
  std::vector<Link> links;
  std::vector<Side> sides;
  std::vector<mbd::Marker> markers;
  double size = 1;  // m; the largest extent of the machine in its start pose

  /// Circles of this many sides are round enough in a picture.
  static constexpr int circle_sides = 36;
  static std::vector<Vec2> circle(Vec2 centre, double radius);
};

/// Bodies are drawn by their `outline`, else by their surfaces seen along z, else by their joints: a bar between two
/// points, the hull of more, a bar to the centre of mass from one. Reads mesh files.
Sketch sketch_of(const Scenario& scenario);

/// Where the bodies are in the scenario's start pose, ground first.
std::vector<mbd::BodyState> start_poses(const Scenario& scenario);

}  // namespace subsoil::app
