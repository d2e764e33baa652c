#include "libmbd/kinematic.hpp"

#include <stdexcept>

namespace subsoil::mbd {

namespace {
constexpr int parts = 4;
constexpr double boole[parts + 1] = {7. / 90, 32. / 90, 12. / 90, 32. / 90, 7. / 90};
}  // namespace

std::string coordinate_name(const System& system, int coordinate) {
  static constexpr const char* axes[] = {".x", ".y", ".angle"};
  return system.body_name(coordinate / 3 + 1) + axes[coordinate % 3];
}

void Kinematic::on_start() {
  clock_.restart();
  if (partition_.freedom() == 0) return;
  std::string free;
  for (const int i : partition_.independent()) free += (free.empty() ? "" : ", ") + coordinate_name(system_, i);
  throw std::invalid_argument("kinematic analysis: " + std::to_string(partition_.freedom()) +
                              " of the machine's freedoms are driven by nothing (" + free +
                              " for example): drive them, or let the forces move them by `analysis: dynamics`");
}

void Kinematic::on_advance(double h) {
  const double begin = now_.t, end = clock_.end_of_step(now_.t, h), dt = h / parts;
  flows_.of_elements += h * boole[0] * now_.rates;
  for (int k = 1; k <= parts; ++k) {
    now_.q += dt * now_.velocity + 0.5 * dt * dt * now_.acceleration;
    now_.t = k == parts ? end : begin + k * dt;
    partition_.evaluate(now_);
    flows_.of_elements += h * boole[k] * now_.rates;
  }
}

}  // namespace subsoil::mbd
