#pragma once
#include <limits>
#include <string>

#include "libdem/laws/law_table.hpp"
#include "libdem/particles/clump.hpp"

/// Longest stable step of the explicit leapfrog with lagged damping.
///
/// One mode with stiffness k and damping c per unit mass, a = k/m (1/s2), b = c/m (1/s), damping taken from v_{n-1/2}:
///     v_{n+1/2} = v_{n-1/2} - dt (a x_n + b v_{n-1/2}),   x_{n+1} = x_n + dt v_{n+1/2}
/// is stable for a dt^2 + 2 b dt < 4 (Jury), so dt_crit = (sqrt(b^2 + 4 a) - b)/a: 2/omega undamped, 2/b without
/// spring.
///
/// The stiffest mode of a sphere among Z equal neighbours is the one in which every neighbour moves against it, so each
/// contact counts twice. Of Z contacts spread evenly, a third acts along and two thirds across any direction:
///     translation  a = 2 Z (k_n/3 + 2 k_t/3)/m                       (likewise b from c_n, c_t)
///     rotation     a = 2 Z ((2/3) k_t l^2 + k_r)/(0.4 m r^2)         l the moment arm of tangential forces
///     a pair       a = 2 k_n/m along, 2 k_t/m + 2 k_t l^2/(0.4 m r^2) across: one contact slides by both motions
///     a corner     of three surfaces: translation (k_n + 2 k_t)/m and rotation (2 k_t l^2 + 2 k_r)/(0.4 m r^2),
///     coupled
///                  by sqrt(3) k_t l
/// Not every bed can move like that (only bipartite ones can), so this is a bound on the safe side; measured limits
/// stand in docs/theory and tests/verification/particles/stable_step.cpp.
namespace subsoil::dem {

/// Stable step of one mode, s; a in 1/s2, b in 1/s, not both 0.
double stable_step_of_mode(double a, double b);

struct StableStep {
  double step = 0;    ///< s
  std::string cause;  ///< "damping of rotation between materials 0 and 0, 12 contacts", for the message
};

/// What the spheres of a bed may be up to.
struct StepQuestion {
  double smallest_radius, largest_radius;  ///< m
  double density;                          ///< of the smallest spheres, kg/m3
  double speed;                            ///< maximum approach speed to expect, m/s
  int neighbours;                          ///< Z, contacts of one sphere at most
  /// Of the body whose surface is touched, where it yields most, kg: at the point r from its centre of mass 1/M + r^2/I
  /// is its mobility. Infinite: it moves on a given path or not at all.
  double body_mass = std::numeric_limits<double>::infinity();
  int body_steps = 1;  ///< soil steps in a step of that body
  double overlap = 0;  ///< m, to which a contact of the smallest spheres is pressed, if deeper than by the speed
};

/// Limit from the law between two spheres. Throws std::invalid_argument when attraction would pull them into each
/// other.
StableStep stable_step(const Law& law, const StepQuestion& question);
/// Limit from the law between a sphere and a surface: each of up to three contacts counts once. Against a body that
/// yields a translation has the reduced mass of both.
StableStep stable_step_at_surface(const Law& law, const StepQuestion& question);

/// The same for a clump. Its modes are those of the six coordinates of a rigid body: with contacts at points r_c (from
/// the centre of mass) with normals n_c,
///     a = 2 lambda_max( M^-1/2 [ sum_c w_c B_c^T (k_n n n^T + k_t (1 - n n^T)) B_c ] M^-1/2 ),   B_c = (1, -[r_c]x)
/// and likewise b from c_n, c_t, of Z contacts spread evenly over what of each member lies in no other, Z ((r + r_s)/(2
/// r_s))^2 on a member of radius r among spheres of radius r_s, and of any one contact alone by the trace. For a clump
/// of one sphere these are the modes above. Spheres that are lighter have their own limit.
StableStep stable_step(const Law& law, const ClumpShape& shape, const StepQuestion& question);
/// Every member may touch three surfaces at right angles: the worst of 100 attitudes.
StableStep stable_step_at_surface(const Law& law, const ClumpShape& shape, const StepQuestion& question);
/// Minimum mass that a contact at the surface of a clump meets along its normal, kg: 1/(1/M + (r x n).J^-1 (r x n)).
double least_effective_mass(const ClumpShape& shape);

/// Contacts that one of N spheres can have at most: 12 for equal spheres, fewer in small sets.
int most_neighbours(std::size_t spheres);

}  // namespace subsoil::dem
