#include "tests/tools/every_law.hpp"

#include <type_traits>

#include "libdem/law_list.hpp"
#include "tests/tools/laws.hpp"

namespace subsoil::dem::test {
namespace {

/// The examples of one law.
template <class L>
void add_examples(std::vector<NamedLaw>& laws) {
  const L example = L::example();
  const Law alone(example);
  const std::string name = alone->name();
  laws.push_back({name, alone});
  if constexpr (requires { example.cohesion; }) laws.push_back({name + ", cohesion", with(example, dmt(5))});
  if constexpr (requires { example.bond; }) laws.push_back({name + ", bonded", with(example, cement())});
}

template <class... L>
std::vector<NamedLaw> examples(std::type_identity<std::variant<L...>>) {
  std::vector<NamedLaw> laws;
  (add_examples<L>(laws), ...);
  return laws;
}

std::vector<NamedLaw> other_settings() {
  Wet all_bands = soil();
  all_bands.damping = Wet::Damping::all_bands;
  all_bands.limit = Wet::FrictionLimit::elastic_force;
  Wet gap = soil();  // largest attraction across a gap: friction acts through the film
  gap.D = -0.5e-3;
  HertzMindlin hertz = elastic(1e7, 0.3, 0.7, 0.4, 0.05);
  Linear constant = grains();
  constant.friction.rolling = Rolling::constant_torque;
  constant.friction.mu_d = 0.3;
  HuntCrossley spheres = viscoelastic(1.5, NAN, 0.3, 0.4, 0.05);
  spheres.E_eff = 5e6;
  Jkr at_pull_off = tacky(10);
  at_pull_off.separation = Jkr::Separation::pull_off;
  Cohesion by_area = cohesion_by_area(2e5, Cohesion::Area::sjkr2);
  by_area.limit = Cohesion::FrictionLimit::net_force;
  HertzMindlin twisting = hertz;
  twisting.friction.mu_t = 0.1, twisting.friction.mu_r = 0, twisting.friction.rolling_damping_at_limit = 0.5;
  Linear beside = with(grains(), by_area);
  beside.friction.rule = FrictionRule::spring_only, beside.friction.rolling_damping_at_limit = 1;
  Hysteretic undamped = with(compactable(), cohesion_by_area(1e5));
  undamped.friction.rule = FrictionRule::spring_only_undamped, undamped.damping_factor = 0.1;
  Cohesion from_afar = water(5e-9, 0.8);
  from_afar.forms = Cohesion::Forms::at_rupture_distance, from_afar.limit = Cohesion::FrictionLimit::thornton;
  Linear smooth = grains();
  smooth.friction.tangential = Tangential::dashpot, smooth.friction.mu_t = 0.02;
  Linear opposing = grains();
  opposing.friction.tangential = Tangential::constant_direction;
  // What other programs do (friction.hpp), as far as it makes no energy.
  Linear dashpots = grains();
  dashpots.restitution = NAN, dashpots.damping = 3, dashpots.clip = true;
  dashpots.friction.c_t = 1, dashpots.friction.limiting = LimitingForce::absolute;
  dashpots.friction.moment_arm = MomentArm::full_overlap,
  dashpots.friction.surface_moment_arm = SurfaceMomentArm::mid_overlap;
  dashpots.friction.mu_r = 0.05, dashpots.friction.k_r = 0.5, dashpots.friction.c_r = 1e-4;
  HertzMindlin elastic_limit = hertz;
  elastic_limit.friction.e_t = 0.6, elastic_limit.friction.limiting = LimitingForce::elastic;
  elastic_limit.friction.rolling_rule = FrictionRule::spring_and_dashpot;
  Linear reaching = with(grains(), adhesion(0.2, 1e3));
  reaching.friction.limiting = LimitingForce::plus_attraction, reaching.friction.damping = TangentialDamping::none;
  HertzMindlin reversible = with(hertz, adhesion(0.2, 1e3, Cohesion::Forms::at_rupture_distance));
  reversible.friction.damping = TangentialDamping::of_normal, reversible.friction.damping_factor = 0.5;
  reversible.friction.limiting = LimitingForce::absolute_plus_attraction;
  Hysteretic kept = compactable();
  kept.yield = NAN, kept.K1 = 1e4, kept.residual = Hysteretic::Residual::kept, kept.damping_factor = 0.1;
  Luding steady = sticky();
  steady.unloading = Luding::Unloading::constant, steady.damping = NAN, steady.restitution = 0.8;
  Eepa hertzian = powder(1.5, 3e5, 0.6, 20);
  hertzian.f0 = 0.01, hertzian.chi = 3.5;
  Bond frictional = cement(1e7, 1.5e5);
  frictional.ratio = 2, frictional.radius = 0.8, frictional.friction_angle = 0.5, frictional.moment_share = 0.5;
  frictional.damping = 0.1;
  return {{"hertz-mindlin, bonded, twist", with(twisting, frictional)},
          {"hysteretic, kept", kept},
          {"linear, dashpots of their own", dashpots},
          {"hertz-mindlin, elastic limit", elastic_limit},
          {"linear, adhesion across a gap", reaching},
          {"hertz-mindlin, reversible adhesion", reversible},
          {"luding, constant", steady},
          {"eepa, n = 1.5", hertzian},
          {"eepa, n = 1", powder(1, 1e4, 0.7, 50)},
          {"variable restitution, linear", yielding(VariableRestitution::Normal::linear)},
          {"hysteretic, cohesion by area", undamped},
          {"hunt-crossley, n = 1", viscoelastic(1, 2e4, 0.5, 0.4, 0.05)},
          {"hunt-crossley, n = 1.7", viscoelastic(1.7, 2e6, 0.2, 0.4)},
          {"wet, all bands", all_bands},
          {"wet, D < 0", gap},
          {"linear, constant torque", constant},
          {"linear, constant direction", opposing},
          {"jkr, pull-off", at_pull_off},
          {"linear, cohesion by area", beside},
          {"hertz-mindlin, dmt, twist", with(twisting, dmt(5))},
          {"hunt-crossley, liquid bridge", with(spheres, water())},
          {"linear, liquid bridge from afar", with(smooth, from_afar)}};
}

}  // namespace

std::vector<NamedLaw> every_law() {
  std::vector<NamedLaw> laws = examples(std::type_identity<GivenLaw>{});
  for (NamedLaw& other : other_settings()) laws.push_back(std::move(other));
  return laws;
}

}  // namespace subsoil::dem::test
