#include "libmbd/equilibrium/relaxation.hpp"

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/integrators/cvode.hpp"
#include "libmbd/integrators/events.hpp"

namespace subsoil::mbd {

namespace {
constexpr int most_relaxation_steps = 20'000;
constexpr double near_rest = 1e-3;
// So many parts of a step of free motion, which lead 400 lengths of the machine away, without a turn: it falls for
// ever.
constexpr int most_without_turn = 300;
}  // namespace

Rest fall_to_rest(System& system, double t, const Eigen::VectorXd& from) {
  const System::Restart memory = system.save();
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(from.size()), scale = coordinate_scale(system);
  Cvode fall(system, {.rtol = 1e-4, .atol = 1e-6});
  // What sticks holds where it has touched: without it the fall would lead through the floor that carries the machine.
  fall.locate_events(needs_events(system.model()) && system.model().events.empty());
  fall.start(t, from, still);
  const auto pull = [&] { return scale.cwiseProduct(fall.state().acceleration).cwiseAbs().maxCoeff(); };
  const double first = pull();
  if (first > 0) {
    const double h = 0.1 * std::sqrt(system.length_scale() / first);
    double before = 0;
    int since_turn = 0;
    for (int i = 0; i < most_relaxation_steps && since_turn < most_without_turn; ++i) {
      fall.advance(h);
      const double now = system.kinetic();
      if (now >= before) {
        before = now, ++since_turn;
        continue;
      }
      since_turn = 0;
      const Eigen::VectorXd pose = fall.state().q;
      system.set_start_states(fall.state().states);
      fall.start(t, pose, still);
      before = 0;
      if (pull() < near_rest * first) break;
    }
  }
  const System::Grips grips = system.grips();
  system.set_start_states({});
  system.restore(memory);
  return {fall.state().q, fall.state().states, grips};
}

}  // namespace subsoil::mbd
