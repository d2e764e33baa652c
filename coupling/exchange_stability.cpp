#include "coupling/exchange_stability.hpp"

#include "libmbd/base/dense.hpp"

namespace subsoil::coupling {

double explicit_growth(const ContactMode& mode, double soil_step, int soil_steps, Method method) {
  using Row = Eigen::Matrix<double, 1, 6>;
  const double n = soil_steps, window = n * soil_step, last = (n - 1) / n;
  const double a = mode.stiffness * window * window / mode.mass, c = mode.damping * window / mode.mass;
  // Rows act on (x, u, g, p, u_1, u_2).
  const Row x = Row::Unit(0), u = Row::Unit(1), g = Row::Unit(2), p = Row::Unit(3), u_1 = Row::Unit(4),
            u_2 = Row::Unit(5);
  const Row mean = x + (n - 1) / (2 * n) * u + (n - 1) * (2 * n - 1) / (12 * n * n) * g,
            end = x + last * u + 0.5 * last * last * g;
  const Row f = -a * mean - c * (end - p), v = u + f;
  const Row moved = method == Method::exact ? Row(u + 0.5 * f) : Row((9 * v + 19 * u - 5 * u_1 + u_2) / 24);
  Eigen::Matrix<double, 6, 6> window_of;
  window_of << x + moved, v, f, end, u, u_1;
  return mbd::spectral_radius(window_of);
}

double iterated_growth(const ContactMode& mode, double soil_step, int soil_steps) {
  const double n = soil_steps, window = n * soil_step, share = (n - 0.5) / n;
  const double a = mode.stiffness * window * window / mode.mass, c = mode.damping * window / mode.mass;
  // Rows act on (x, u, q); z holds f itself.
  const Eigen::RowVector3d f =
      (-a * Eigen::RowVector3d{1, 0.5, 0} - c * Eigen::RowVector3d{0, share, 0.5 / n}) / (1 + a / 4 + c * share / 2);
  const Eigen::RowVector3d z = Eigen::RowVector3d{1, 1, 0} + 0.5 * f;
  Eigen::Matrix3d window_of;
  window_of << z, Eigen::RowVector3d{0, 1, 0} + f, z - Eigen::RowVector3d{1, 0, 0};
  return mbd::spectral_radius(window_of);
}

}  // namespace subsoil::coupling
