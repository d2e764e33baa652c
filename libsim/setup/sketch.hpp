#pragma once
#include <string>
#include <vector>

#include "libsim/scenario/scenario.hpp"

/// What pictures show of a machine: plane shapes fixed to its bodies, taken from the scenario alone.
namespace subsoil::sim {

struct Sketch {
  /// A stretch of a body's outline, in its own axes. Closed ones can be filled.
  struct Outline {
    int body;
    std::vector<Vec2> points;
    bool closed = true;
    bool from_surface = false;
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
    std::string element{};  ///< path of the scenario that it stands for, such as `machine.joints.H8`
  };
  /// What moves along a line of body a, at angle_a in its axes: a block, or a pin in a slot.
  struct Slide : Pair {
    double angle_a;
    bool block, slot = false;
    double below = 0;  ///< m; how far the outline of b reaches across the line, to its right
  };
  struct Link : Pair {
    enum class Kind { rod, spring, damper } kind;
  };
  /// A straight side of a body without ends; the free side is on the left.
  struct Side {
    int body;
    Vec2 point;
    double angle;
    std::string element{};  ///< as of a pair; empty: the soil's surface
  };

  std::vector<std::string> names;  // of bodies, ground first
  std::vector<Outline> outlines;
  std::vector<Disk> disks;
  std::vector<Pair> pins, welds;
  std::vector<Slide> slides;
  std::vector<Link> links;
  std::vector<Side> sides;
  std::vector<mbd::Marker> markers;
  double size = 1;  // m; the maximum extent of the machine in its start pose

  /// Circles of this many sides are round enough in a picture.
  static constexpr int circle_sides = 36;
  static std::vector<Vec2> circle(Vec2 centre, double radius);
};

/// Joints that a body's own shape does not reach are joined to it by bars. Bodies are drawn by their `outline`, else by
/// their surfaces seen along z, else by their joints: a bar between two points, the hull of more, a bar to the centre
/// of mass from one. Reads mesh files.
Sketch sketch_of(const Scenario& scenario);

using Poses = std::vector<mbd::BodyState>;  ///< of all bodies, ground first

/// Where the bodies are in the scenario's start pose.
Poses start_poses(const Scenario& scenario);

/// Poses moved by `factor` times a mode's shape: x, y and angle of every body but the ground, one after another.
Poses displaced(const Poses& rest, const std::vector<double>& shape, double factor);
/// The factor, of one digit, with which a shape moves some point of the picture by about a tenth of the machine;
/// 0 for a shape that moves nothing.
double picture_factor(const Sketch& sketch, const Poses& rest, const std::vector<double>& shape);

}  // namespace subsoil::sim
