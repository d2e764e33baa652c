#pragma once

// A verification case: a scenario file beside this one, a reference that shares nothing with the product, and how close
// they must be. Adding a case is a YAML file and one entry in a list.

#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "tests/verification/mechanisms/cases/minimal_coordinates.hpp"

namespace subsoil::cases {

using namespace test;
using std::numbers::pi;
using Coordinates = std::vector<Jet>;
using Poses = std::vector<Pose>;
inline constexpr double g = 9.81;  // m/s^2

/// Largest difference allowed, by the unit of the column: (m, rad), (m/s, rad/s), (m/s^2, rad/s^2), (N, N m), J.
/// Each is ten to a thousand times what order 6 leaves at the case's step, (w h)^6 w t for its fastest rate w,
/// magnified by the motion's sensitivity, and so that eight digits and more of every column are asserted; a derivative
/// costs a factor w.
struct Bounds {
  double position, velocity, acceleration, force, energy;
};

/// Columns that the reference knows at t; asked in rising order of t.
using Reference = std::function<test::Expected(double t)>;

struct Case {
  std::string name;    ///< of the file: <name>.yaml
  std::string source;  ///< of mechanism and reference
  Bounds bounds;
  std::function<Reference()> reference;
  bool passes_singular = false;  ///< through a pose where the constraints lose rank
};

inline Reference minimal(test::Mechanism mechanism) {
  return
      [oracle = std::make_shared<test::MinimalCoordinates>(std::move(mechanism))](double t) { return oracle->at(t); };
}

std::vector<Case> pendulums();
std::vector<Case> oscillators();
std::vector<Case> driven_linkages();
std::vector<Case> free_linkages();
std::vector<Case> elements();
std::vector<Case> published();

std::vector<Case> all_cases();

}  // namespace subsoil::cases
