#pragma once
#include "libsim/keys/fields.hpp"
#include "libsim/scenario/sections/defaults.hpp"

/// Where something is and how it is turned.
namespace subsoil::sim {

struct Rotation {  // about a fixed axis through the placement
  Vec3 axis{0, 0, 1};
  double angle = 0;  // rad
};
void describe(Fields& v, Rotation& r);

struct Box {
  Vec3 size{required, required, required};
  Vec3 at{required, required, required};  // corner of minimum coordinates
};
void describe(Fields& v, Box& b);

}  // namespace subsoil::sim
