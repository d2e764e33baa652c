#pragma once
#include "libdem/laws/friction.hpp"

/// The keys of friction: which, with unit, range and meaning. Included by friction.hpp.
namespace subsoil::dem {

template <class V>
void Friction::describe(V& v) {
  const Conventions before = conventions;
  v.choice("conventions", conventions,
           {{"own", Conventions::own},
            {"lammps", Conventions::lammps},
            {"liggghts", Conventions::liggghts},
            {"mercury", Conventions::mercury},
            {"edem", Conventions::edem}},
           "whose conventions hold for what this entry leaves out: friction rule, limiting force, tangential damping, "
           "changing stiffness, moment arms, rolling (docs/reference/conventions.md)");
  if (conventions != before) take(conventions);  // while it is read; what stands beside it is read after it
  v.quantity("mu", mu, "1", "[0, inf)", "static friction coefficient, holds until slip");
  v.derived("mu_d", mu_d, "1", "[0, inf)", "friction coefficient while slipping; left out: mu");
  v.choice("tangential", tangential,
           {{"spring", Tangential::spring},
            {"dashpot", Tangential::dashpot},
            {"constant-direction", Tangential::constant_direction}},
           "friction below its limit: a spring that remembers and a dashpot, the dashpot alone, or nothing: the limit "
           "against the sliding");
  v.choice("changing stiffness", changing,
           {{"lossy", Changing::lossy},
            {"keep-spring", Changing::keep_spring},
            {"keep-force", Changing::keep_force},
            {"rescale", Changing::rescale}},
           "laws whose tangential stiffness changes with the overlap, what is kept then: rising the force and falling "
           "the spring; always the spring (EDEM, LIGGGHTS, LAMMPS mindlin); always the force; or rising the spring, "
           "which falling shrinks with the stiffness (LAMMPS mindlin_rescale)");
  v.choice("friction rule", rule,
           {{"spring-and-dashpot", FrictionRule::spring_and_dashpot},
            {"spring-set-back", FrictionRule::spring_set_back},
            {"spring-only", FrictionRule::spring_only},
            {"spring-only-undamped", FrictionRule::spring_only_undamped}},
           "what Coulomb's limit caps: the tangential spring and dashpot together; the same, the spring set back to "
           "the limit less the dashpot's part also where that winds it up and makes energy (LAMMPS, MercuryDPM); the "
           "spring alone with the dashpot beside it; or the spring alone and no dashpot at the limit (LIGGGHTS)");
  v.choice(
      "tangential damping", damping,
      {{"law", TangentialDamping::of_law}, {"normal", TangentialDamping::of_normal}, {"none", TangentialDamping::none}},
      "coefficient of the tangential dashpot: the law's own, the normal dashpot's (LAMMPS), or none");
  v.quantity("tangential damping factor", damping_factor, "1", "[0, inf)",
             "factor on that coefficient (LAMMPS x_gammat)");
  v.derived("c_t", c_t, "N s/m", "[0, inf)", "tangential damping coefficient, in place of tangential damping");
  v.derived(
      "e_t", e_t, "1", "(0, 1]",
      "tangential restitution of a contact that sticks, in place of tangential damping; the limit, which is 0 while "
      "the normal dashpot pulls, lets go before the end: 0.3 gives 0.40 unless `limiting force: absolute-force`");
  v.choice("limiting force", limiting,
           {{"law", LimitingForce::of_law},
            {"absolute-force", LimitingForce::absolute},
            {"positive-force", LimitingForce::positive},
            {"elastic-force", LimitingForce::elastic},
            {"force-plus-attraction", LimitingForce::plus_attraction},
            {"absolute-plus-attraction", LimitingForce::absolute_plus_attraction}},
           "normal force that limits friction and rolling: the law's (its own `friction limit`, where it has one), |F| "
           "(LAMMPS, LIGGGHTS), max(0, F), max(0, F without dashpot), max(0, F + A) or |F + A|, A the attraction");
  v.quantity("mu_r", mu_r, "1", "[0, inf)", "rolling friction coefficient");
  v.quantity("mu_t", mu_t, "1", "[0, inf)", "twisting friction coefficient: about the contact normal");
  v.choice("rolling", rolling,
           {{"elastic-plastic", Rolling::elastic_plastic},
            {"constant-torque", Rolling::constant_torque},
            {"none", Rolling::none}},
           "rolling resistance: elastic-plastic spring-dashpot (Ai type C), or a constant torque against rolling");
  v.choice("rolling rule", rolling_rule,
           {{"spring-only", FrictionRule::spring_only},
            {"spring-and-dashpot", FrictionRule::spring_and_dashpot},
            {"spring-set-back", FrictionRule::spring_set_back}},
           "what the limit of rolling caps, in the words of friction rule (LAMMPS sds: spring-set-back)");
  v.derived("k_r", k_r, "N m/rad", "(0, inf)", "rolling stiffness; left out: 2.25 k_n (mu_r r_eff)^2");
  v.derived("c_r", c_r, "N m s/rad", "[0, inf)", "rolling damping coefficient; left out: by rolling damping");
  v.quantity("rolling damping", rolling_damping, "1", "[0, 1]", "damping ratio of the rolling and twisting springs");
  v.quantity("rolling damping at limit", rolling_damping_at_limit, "1", "[0, 1]",
             "share of the rolling and twisting dashpots that stays when their springs are fully mobilised (f of Ai)");
  v.choice("moment arm", moment_arm,
           {{"mid-overlap", MomentArm::mid_overlap},
            {"radius", MomentArm::radius},
            {"full-overlap", MomentArm::full_overlap}},
           "arm of tangential forces about the centre of a sphere: r - delta/2, to the middle of the overlap (a "
           "boundary's surface), r, or r - delta");
  v.choice(
      "moment arm at surfaces", surface_moment_arm,
      {{"by-moment-arm", SurfaceMomentArm::by_moment_arm},
       {"mid-overlap", SurfaceMomentArm::mid_overlap},
       {"radius", SurfaceMomentArm::radius},
       {"full-overlap", SurfaceMomentArm::full_overlap}},
      "likewise at boundaries; by-moment-arm: r - delta, the boundary's surface, for mid-overlap, else as moment arm "
      "(LIGGGHTS: mid-overlap)");
  v.choice("slip moment arm", slip_moment_arm,
           {{"as-force", SlipMomentArm::as_force}, {"radius", SlipMomentArm::radius}},
           "moment arm of the angular velocities in the slip velocity: that of the force, or r (LAMMPS granular)");
}

}  // namespace subsoil::dem
