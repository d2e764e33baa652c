#pragma once

#include <array>
#include <stdexcept>
#include <string>

#include "libmbd/element/force.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd {

/// What a force does to the ground and two bodies in a given state.
struct Felt {
  std::array<std::array<double, 3>, 3> wrench{};
  ForceValues values{};
  ForcePower power;
};
template <class Force>
Felt feel(const Force& force, const BodyState& first, const BodyState& second = {}, double t = 0) {
  Felt felt;
  const std::array<BodyState, 3> bodies{BodyState{}, first, second};
  Loads loads(felt.wrench);
  felt.power = force.evaluate({bodies, t, {}}, loads, felt.values);
  return felt;
}

/// The text with which a force or characteristic refuses.
template <class Action>
std::string refusal(Action action) {
  return test::message_of<std::invalid_argument>(action);
}

}  // namespace subsoil::mbd
