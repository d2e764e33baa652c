#include "libdem/particles/rigid_rotation.hpp"
#include "libdem/step/clumps.hpp"
#include "libdem/step/sphere_forces.hpp"

/// Forces of users on members of clumps. Beside the sweep, for the velocity of a member at t_n follows from all that
/// acts on its clump.
namespace subsoil::dem {

void Clumps::add_forces(SphereForces& forces, const ParticleStore& particles, const Vec3& gravity, double time,
                        double before, int threads) {
  own_.assign(loads_.size(), {});
  const double half = 0.5 * before;
  const auto count = static_cast<long>(clumps_.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long n = 0; n < count; ++n) {
    const auto k = static_cast<std::size_t>(n);
    const Clump& c = clumps_[k];
    const ClumpShape& shape = shapes_[c.shape];
    const Loaded contacts = gathered(k);
    const auto motion_of = [&](const Loaded& all) {
      return SphereForces::Motion{
          c.velocity + half * ((1 / shape.mass) * all.force + gravity),
          angular_velocity_of(c.attitude, shape.inertia, c.angular_momentum + half * all.moment)};
    };
    SphereAt at;
    const auto evaluate = [&](const SphereForces::Motion& motion) {
      Loaded all = contacts;
      for (std::uint32_t e = begin_[k]; e < begin_[k + 1]; ++e) {
        const Sphere s = particles.now(sphere_of_[e]);
        const Vec3 arm = c.attitude.rotate(shape.members[e - begin_[k]].at);
        at = {.time = time,
              .position = s.x,
              .velocity = motion.velocity + cross(motion.angular_velocity, arm),
              .angular_velocity = motion.angular_velocity,
              .mass = s.m,
              .radius = s.r,
              .id = s.id,
              .material = s.material};
        const Wrench w = forces.sum(at);
        own_[e] = {w.force, w.moment};
        all.force += w.force;
        all.moment += w.moment + cross(arm, w.force);
      }
      return motion_of(all);
    };
    try {
      SphereForces::Motion motion = motion_of(contacts);
      if (const double ratio = SphereForces::find_motion(motion, evaluate); !(ratio < 0))
        SphereForces::refuse_step(at, ratio);
    } catch (...) {
      forces.note_fault(at.id);
    }
  }
  for (std::size_t e = 0; e < own_.size(); ++e) loads_[e].force += own_[e].force, loads_[e].torque += own_[e].torque;
}

double Clumps::power_of_forces(const ParticleStore& particles) const {
  double sum = 0;
  for (std::size_t e = 0; e < own_.size(); ++e) {
    const Sphere s = particles.now(sphere_of_[e]);
    sum += dot(own_[e].force, s.v) + dot(own_[e].torque, s.w);
  }
  return sum;
}

}  // namespace subsoil::dem
