#include "libmbd/system/deep_start.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "libmbd/elements.hpp"

namespace subsoil::mbd {

namespace {

/// The smallest gap of a force; above 0 where it has none.
template <class Force>
double smallest_gap(const Force& force, const Scene& scene) {
  if constexpr (Force::has.gap) {
    return force.gap(scene);
  } else if constexpr (Force::has.gaps) {
    std::vector<double> gaps(force.gap_count());
    force.gaps(scene, gaps);
    return gaps.empty() ? 1 : *std::min_element(gaps.begin(), gaps.end());
  } else {
    return 1;
  }
}

template <class Force>
bool is_angular(const Force& force) {
  return std::any_of(force.columns.begin(), force.columns.end(), [](const ForceColumn& c) {
    return std::strcmp(c.name, "gap") == 0 && std::strcmp(c.unit, "rad") == 0;
  });
}

}  // namespace

std::vector<DeepStart> deep_starts(const System& system, const Eigen::VectorXd& acceleration) {
  constexpr double weights = 4;
  const double weight = system.model().weight();
  double unbalanced = 0;
  for (Eigen::Index i = 0; i < acceleration.size(); ++i)
    unbalanced =
        std::max(unbalanced, std::abs(system.mass()[i] * acceleration[i]) / (i % 3 == 2 ? system.length_scale() : 1));
  std::vector<DeepStart> found;
  for (std::size_t i = 0; i < system.model().forces.size(); ++i)
    visit(
        [&]<class Force>(const Force& force) {
          if constexpr (!Force::has.gap && !Force::has.gaps) {
            return;
          } else {
            const double gap = smallest_gap(force, system.scene()), energy = system.powers()[i].stored;
            if (!(gap < 0) || !(energy > 0)) return;
            const bool angular = is_angular(force);
            const double arm = angular ? system.length_scale() : 1, push = 2 * energy / -gap;
            if (push <= weights * weight * arm || unbalanced < 0.5 * push / arm) return;
            found.push_back({system.model().forces[i].name, -gap, angular, energy, push, weight * arm});
          }
        },
        system.model().forces[i].element);
  return found;
}

}  // namespace subsoil::mbd
