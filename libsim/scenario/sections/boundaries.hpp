#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libmbd/base/function.hpp"
#include "libsim/scenario/sections/placement.hpp"
#include "libsim/scenario/sections/servo.hpp"
#include "libsim/scenario/sections/wear.hpp"
#include "libsim/scenario/shapes/shapes.hpp"

/// Surfaces that are no machine's: fixed or on a given path.
namespace subsoil::sim {

using mbd::Function;

/// One stretch of a given motion; with p its profile, the sum V of all p velocity, and c the place, v_c = V + sum of
/// p `spin` x (c - about); each `about` that is given moves by V, one that is left out is c. Angular velocity is the
/// sum of all p `spin`.
struct Move {
  Vec3 velocity{};                     // m/s
  Vec3 spin{};                         // rad/s
  std::optional<Vec3> about;           // point of the rotation at the start
  Function profile{1.0};               // factor over time
  double from = 0, until = unlimited;  // s
};
void describe(Fields& v, Move& m);

struct BoundarySection {
  std::string name;
  std::string material;
  Shape shape;
  Vec3 at{};
  Rotation rotation;
  std::vector<Move> moves;
  std::optional<ServoSection> servo;
  std::optional<double> cutting;  // rad, of the wedge: edges that cut fibres
  std::optional<Vec3> reference;  // point of its wrench, carried along; `at` unless given
  std::optional<WearSection> wear;
  bool is_moved() const { return !moves.empty() || servo.has_value(); }
};
void describe(Fields& v, BoundarySection& b);

struct Checks;
struct Scenario;
void check_boundaries(Checks& checks, const Scenario& s);

}  // namespace subsoil::sim
