#include "libmbd/equilibrium/force_jumps.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "libmbd/elements.hpp"

namespace subsoil::mbd {
namespace {

/// Outputs of controllers, then of each force its largest column.
std::vector<double> outputs(System& system, Eigen::VectorXd& loads) {
  system.loads(loads);
  std::vector<double> out(system.signals());
  const auto& forces = system.model().forces;
  for (std::size_t i = 0; i < forces.size(); ++i)
    visit(
        [&](const auto& force) {
          double largest = 0;
          for (std::size_t k = 0; k < force.columns.size(); ++k)
            if (const double value = system.values()[i][k];
                !force.columns[k].whole && std::abs(value) > std::abs(largest))
              largest = value;
          out.push_back(largest);
        },
        forces[i].element);
  return out;
}

}  // namespace

std::vector<std::string> jumping(const System& given, double t, const MotionPoint& at,
                                 const Eigen::VectorXd& direction) {
  constexpr double far = 1e-5, shorter = 1e-2;  // of the machine's length, in a second too
  constexpr double most_change = 0.05;          // a finite slope leaves 0.01 over the shorter step, a root 0.1
  constexpr double smallest = 1e-9;             // of the output, else rounding
  const std::unique_ptr<System> system = given.copy();
  Eigen::VectorXd loads = Eigen::VectorXd::Zero(system->coordinates());
  const auto at_shifted = [&](double place, double rate) {
    system->set_state(t, at.q + place * direction, at.velocity + rate * direction);
    system->set_multipliers(at.lambda);
    return outputs(*system, loads);
  };
  const auto& model = system->model();
  std::vector<std::string> names;
  for (const bool moved : {true, false}) {
    const auto change = [&](double by) {
      std::vector<double> size = at_shifted(moved ? by : 0, moved ? 0 : by);
      const std::vector<double> behind = at_shifted(moved ? -by : 0, moved ? 0 : -by);
      for (std::size_t i = 0; i < size.size(); ++i)
        size[i] = std::abs(size[i] - behind[i]) > smallest * std::abs(size[i]) ? std::abs(size[i] - behind[i]) : 0;
      return size;
    };
    const double step = far * system->length_scale();
    const std::vector<double> wide = change(step), narrow = change(shorter * step);
    for (std::size_t i = 0; i < wide.size(); ++i) {
      if (i == model.controllers.size() && !names.empty()) break;  // forces follow them
      if (!(narrow[i] > most_change * wide[i])) continue;
      const std::size_t controllers = model.controllers.size();
      const std::string name = i < controllers ? "controller '" + model.controllers[i].name + "'"
                                               : "force '" + model.forces[i - controllers].name + "'";
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

}  // namespace subsoil::mbd
