#include "libdem/laws/friction.hpp"

#include <algorithm>
#include <stdexcept>

namespace subsoil::dem {

void Friction::take(Conventions program) {
  switch (program) {
    case Conventions::own:
      break;
    case Conventions::lammps:  // pair_style granular, fix wall/gran granular
      rule = rolling_rule = FrictionRule::spring_set_back;
      changing = Changing::keep_spring, damping = TangentialDamping::of_normal;
      limiting = LimitingForce::absolute;
      surface_moment_arm = SurfaceMomentArm::radius, slip_moment_arm = SlipMomentArm::radius;
      break;
    case Conventions::liggghts:  // tangential history, rolling_friction epsd
      rule = FrictionRule::spring_only_undamped, changing = Changing::keep_spring;
      limiting = LimitingForce::absolute, surface_moment_arm = SurfaceMomentArm::mid_overlap;
      break;
    case Conventions::mercury:  // Friction species
      rule = rolling_rule = FrictionRule::spring_set_back;
      changing = Changing::keep_spring, damping = TangentialDamping::none;
      limiting = LimitingForce::absolute_plus_attraction, surface_moment_arm = SurfaceMomentArm::mid_overlap;
      break;
    case Conventions::edem:  // Hertz-Mindlin (no slip), standard rolling friction
      changing = Changing::keep_spring, rolling = Rolling::constant_torque;
      break;
  }
}

void Friction::check() const {
  const int given = !std::isnan(c_t) + !std::isnan(e_t);
  if (given > 1) throw std::invalid_argument("c_t and e_t both say the tangential damping; keep one of them");
  if (given == 1 && damping_factor != 1)
    throw std::invalid_argument("`tangential damping factor` scales the law's dashpot; with c_t or e_t leave it out");
}

bool Friction::usual() const {
  return tangential == Tangential::spring && changing == Changing::lossy && rolling != Rolling::constant_torque &&
         rule == FrictionRule::spring_and_dashpot && damping == TangentialDamping::of_law && damping_factor == 1 &&
         std::isnan(c_t) && std::isnan(e_t) && limiting == LimitingForce::of_law && !(rolling_damping_at_limit > 0) &&
         std::isnan(k_r) && std::isnan(c_r) && rolling_rule == FrictionRule::spring_only &&
         slip_moment_arm == SlipMomentArm::as_force && !(mu_t > 0);
}

MomentArmShares Friction::shares(bool pair) const {
  double force = moment_arm == MomentArm::mid_overlap    ? (pair ? 0.5 : 1.0)
                 : moment_arm == MomentArm::full_overlap ? 1.0
                                                         : 0.0;
  if (!pair && surface_moment_arm != SurfaceMomentArm::by_moment_arm)
    force = surface_moment_arm == SurfaceMomentArm::mid_overlap    ? 0.5
            : surface_moment_arm == SurfaceMomentArm::full_overlap ? 1.0
                                                                   : 0.0;
  return {.force = force, .slip = slip_moment_arm == SlipMomentArm::radius ? 0.0 : force};
}

void Friction::bound(StiffnessBound& b, double m_eff, double r_eff, double i_roll) const {
  if (!std::isnan(c_t))
    b.c_t = c_t;
  else if (!std::isnan(e_t))
    b.c_t = 2 * damping_ratio(e_t) * std::sqrt(2.0 / 7.0 * m_eff * b.k_t);
  else
    b.c_t = damping == TangentialDamping::none
                ? 0
                : damping_factor * (damping == TangentialDamping::of_law ? b.c_t : b.c_n);
  if (tangential != Tangential::spring) b.k_t = 0;
  if (tangential == Tangential::constant_direction) b.c_t = 0;
  const double by_share = turning_share(mu_t) * b.k_n * r_eff * r_eff;
  const double own = std::isnan(k_r) ? turning_share(mu_r) * b.k_n * r_eff * r_eff : k_r;
  b.k_r = std::max(rolling == Rolling::elastic_plastic ? own : 0, by_share);
  b.c_r = 2 * rolling_damping * std::sqrt(i_roll * b.k_r);
  if (!std::isnan(c_r) && rolling == Rolling::elastic_plastic) b.c_r = std::max(c_r, mu_t > 0 ? b.c_r : 0);
}

}  // namespace subsoil::dem
