#pragma once

// Reference motions of mechanisms in minimal coordinates, with reactions from free-body diagrams. Nothing here is the
// product's: loops are closed by closed formulas of the position, not by constraints; there are no multipliers; the
// integrator is boost::odeint's Runge-Kutta-Fehlberg 7(8).

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/verification/mechanisms/cases/jet.hpp"

namespace subsoil::test {

using OdeState = std::vector<double>;

using Triple = std::array<double, 3>;  ///< x, y, angle; or force and moment
using Triples = std::vector<Triple>;

/// All bodies at one time: (x, y, angle) and derivatives.
struct Motion {
  Triples pose, velocity, acceleration;
};

/// Columns and what they should be.
using Expected = std::vector<std::pair<std::string, double>>;

/// A point in the world in the start pose.
struct Place {
  double x = 0, y = 0;
};

/// Ground in place of a body's index.
inline constexpr int world = -1;

/// An unknown reaction between two bodies; columns as the program names them, force on `a`, at `at` as `b` carries it.
///   pin    force                  slide  force across the direction `angle` of body a, and moment
///   weld   force and moment       motor  torque on b        ram  force on b along `angle` of body a
struct Joint {
  enum Kind { pin, slide, weld, motor, ram } kind = pin;
  std::string name;
  int a = world, b = world;
  Place at{};
  double angle = 0;
};

/// Spring and damper in line between two points; compression positive.
struct Spring {
  std::string name;
  int a = world, b = world;
  Place on_a{}, on_b{};
  double stiffness = 0, free_length = 0, damping = 0;
};

/// A mechanism as this reference needs it: where its bodies are, given as many coordinates as it has freedoms.
struct Mechanism {
  std::vector<std::string> names{};                                      ///< of the bodies, as in the scenario
  Triples mass{};                                                        ///< (m, m, I) of each
  std::function<std::vector<Pose>(const std::vector<Jet>&, Jet)> poses;  ///< from coordinates and time
  OdeState start{};                                                      ///< coordinates, then their rates
  std::vector<Joint> joints{};
  std::vector<Spring> springs{};
  std::function<void(double, const Motion&, Triples&)> loads{};  ///< adds forces and moments about the centres
  double gravity = 9.81;
};

inline Triple uniform_bar(double m, double length) { return {m, m, m * length * length / 12}; }

/// Moves a mechanism through time; times asked must not fall.
class MinimalCoordinates {
 public:
  explicit MinimalCoordinates(Mechanism mechanism);

  /// Bodies, joints, springs and energies at t; angles count from the start pose.
  Expected at(double t);

 private:
  /// A spring as it stands: direction from a to b, levers of its ends.
  struct Line {
    double x, y, length, rate;
    Place on_a, on_b;
  };
  /// Where a place of the start pose has gone with its body, its velocity, its lever.
  struct Carried {
    double x, y, vx, vy;
    Place lever;
  };

  Carried carried(int body, Place place, const Motion& now) const;
  Line line(const Spring& spring, const Motion& now) const;
  Triples given(double t, const Motion& now) const;
  Motion accelerate(const OdeState& y, OdeState& rates, double t) const;
  void report_bodies(const Motion& now, Expected& out) const;
  void report_energies(const Motion& now, Expected& out) const;
  void report_joints(double t, const Motion& now, Expected& out) const;
  Triples units_of(const Joint& joint, const Motion& now) const;

  Mechanism m_;
  OdeState y_;
  std::size_t n_;
  double t_ = 0;
  Triples start_;
};

}  // namespace subsoil::test
