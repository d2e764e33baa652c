#pragma once
#include <vector>

#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// A body of the machine whose surfaces of one material spheres may hit, and the mass that an impact meets where the
/// body yields most, 1/max(n . W n) with the mobility W of the point in the plane.
struct YieldingBody {
  int body = 0;
  int material = 0;
  double free_mass = 0;    ///< kg, as if no joint held it: W = 1/M + r^2/I across r; joints make it larger only
  double start_mass = 0;   ///< kg, with joints and drivers as they stand at the start
  double middle_mass = 0;  ///< kg, likewise, at the middle of its surface: what contacts all over it move
};

/// Bodies that would yield to a sphere of mass m, kg: lighter than `yielding_ratio` times it, and not held by drivers
/// or joints altogether. Nodes of beams are none: the beam on both sides of a node holds it in much less than a
/// contact's time.
std::vector<YieldingBody> yielding_bodies(const World& world, const Scenario& scenario, double sphere_mass);

/// Beyond this ratio of body to sphere a body is a wall to the spheres: the reduced mass differs from the sphere's by
/// 1 %, the contact's length by half of that, and the exchange errs by exp((pi/4) w dt/101) - 1, in a contact of 40
/// steps 6e-4.
inline constexpr double yielding_ratio = 100;

}  // namespace subsoil::sim
