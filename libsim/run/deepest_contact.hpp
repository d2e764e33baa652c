#pragma once
#include <string>

#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// A sphere's deepest contact.
struct DeepestContact {
  int contacts = 0;           ///< of the sphere, with others and with surfaces
  double overlap = 0;         ///< m
  double approach = 0;        ///< m/s, of the two towards each other
  double smaller_radius = 0;  ///< m
  double r_eff = 0, m_eff = 0;
  int material = -1;  ///< of the other one
  bool at_surface = false;
  std::string other;
};

DeepestContact deepest_contact(const dem::Sphere& s, const World& world);

}  // namespace subsoil::sim
