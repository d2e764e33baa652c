#pragma once
#include <memory>

#include "coupling/simulation.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/reference_ode.hpp"

/// The smooth problem on which the coupling is measured: a body whose lower face lies on one sphere, the sphere on a
/// floor, both contacts always closed. In the linear law that is a chain of two masses and two springs, a linear ODE.
namespace subsoil::coupling::test {

struct Stack {
  double body_mass = 0.2, sphere_mass = 0.05, stiffness = 2e4, restitution = 1;  ///< kg, kg, N/m
  double gravity = 9.81, radius = 0.01, face = 0.03;  ///< m/s2, m, m from the body's centre down to its face
  double share = 1.4;                                 ///< overlaps at the start over those at rest
  double end = 0.02;                                  ///< s; two thirds of the slow mode's period

  double floor_overlap() const { return share * (body_mass + sphere_mass) * gravity / stiffness; }
  double face_overlap() const { return share * body_mass * gravity / stiffness; }
  double sphere_start() const { return radius - floor_overlap(); }
  double body_start() const { return sphere_start() + radius - face_overlap() + face; }
  /// Of both contacts: the law takes the sphere's mass at a surface.
  double damping() const { return 2 * dem::damping_ratio(restitution) * std::sqrt(sphere_mass * stiffness); }
};

/// Force of the sphere on the body, N; y = (body height, velocity, sphere height, velocity).
inline double face_force(const Stack& s, const subsoil::test::OdeState& y) {
  return s.stiffness * (y[2] + s.radius - y[0] + s.face) + s.damping() * (y[3] - y[1]);
}

/// y at the end, and the integral of -F'/2 v, to which interface error over step converges (restitution 1 only).
inline subsoil::test::OdeState exact(const Stack& s) {
  const auto right = [&](const auto& y, auto& d, double) {
    const double above = face_force(s, y), below = s.stiffness * (s.radius - y[2]) - s.damping() * y[3];
    d[0] = y[1], d[1] = above / s.body_mass - s.gravity;
    d[2] = y[3], d[3] = (below - above) / s.sphere_mass - s.gravity;
    d[4] = -0.5 * s.stiffness * (y[3] - y[1]) * y[1];
  };
  return subsoil::test::solve_ode(right, {s.body_start(), 0, s.sphere_start(), 0, 0}, 0, s.end);
}

struct StackRun {
  double height, velocity;  ///< of the body at the end
  double least_force;       ///< smallest force on the face, N: above 0 the contact never opened
  double impulse;           ///< N s, of the face's forces
  InterfaceWork work;
  double to_the_end;  ///< J, of both sides, the machine's to the end of the last step
  double closure;     ///< bed closure + machine balance + interface error, J
};

/// @param tolerance of the iterated exchange, m; 0: explicit
inline StackRun run(const Stack& s, double soil_step, int soil_steps = 1,
                    mbd::IntegratorKind kind = mbd::IntegratorKind::adams_moulton, double tolerance = 0) {
  dem::Linear law = dem::test::grains(s.stiffness, s.restitution, 0, 0);
  dem::Bed bed(dem::test::table(law), dem::test::quiet({0, -s.gravity, 0}));
  const double volume = 4.0 / 3.0 * M_PI * std::pow(s.radius, 3);
  const dem::SphereSpec ball{{0, s.sphere_start(), 0}, {}, {}, s.radius, s.sphere_mass / volume, 0};
  bed.add(std::span(&ball, 1));
  dem::test::add_plane(bed, {}, {0, 1, 0});
  const int face = dem::test::add_plane(bed, {0, -s.face, 0}, {0, -1, 0});
  mbd::Model model;
  model.gravity = {0, -s.gravity};
  const int body = model.add({.name = "weight", .mass = s.body_mass, .inertia = 1e-3, .pose = {0, s.body_start(), 0}});
  mbd::Machine machine(model, {.integrator = kind, .ida = {.rtol = 1e-12, .atol = 1e-14}});
  machine.start_from_pose();
  Simulation simulation(&bed, &machine, {{body, face}}, {},
                        {.soil_step = soil_step, .soil_steps = soil_steps, .tolerance = tolerance});
  const long steps = std::lround(s.end / soil_step);
  StackRun out{
      .height = 0, .velocity = 0, .least_force = 1e300, .impulse = 0, .work = {}, .to_the_end = 0, .closure = 0};
  double start = 0;
  for (long n = 0; n < steps; ++n) {
    simulation.step({.energy = n == 0 || n + 1 == steps, .snapshot = nullptr});
    if (n == 0) start = bed.energy().total() - bed.energy().boundary_work;
    const double force = simulation.soil_on_body(body).force.y;
    out.least_force = std::min(out.least_force, force);
    out.impulse += force * soil_step;
  }
  out.height = machine.body(body).r.y, out.velocity = machine.body(body).v.y;
  out.work = simulation.interface_work();
  out.to_the_end = out.work.on_soil + machine.energy().external_work;
  out.closure =
      bed.energy().total() - bed.energy().boundary_work - start + machine.energy().balance() + out.work.error();
  return out;
}

}  // namespace subsoil::coupling::test
