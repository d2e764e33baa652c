#include "libmbd/base/plastic_stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace subsoil::mbd {

void PowerStiffness::check() const {
  if (!(K0 > 0 && alpha > -1 && alpha_1 > -1))
    throw std::invalid_argument(
        "K' must be given and above 0 and both depth exponents above -1, so that F grows with z");
}

double PowerStiffness::value(double z, double v, double m) const {
  const double shallow = std::pow(std::min(z, z1) / z0, alpha), deep = z > z1 ? std::pow(z / z1, alpha_1) : 1;
  return K0 * shallow * deep * std::pow(v / v0, beta) * std::pow(m / m0, gamma);
}

void BekkerStiffness::check() const {
  if (!(area > 0 && width > 0 && n > 0 && k_c >= 0 && k_phi >= 0 && k_c + k_phi > 0))
    throw std::invalid_argument("area and width must be above 0, n in (0, 3), k_c and k_phi not negative nor both 0");
}

double BekkerStiffness::value(double z, double v, double) const {
  return area * (k_c / width + k_phi) * std::pow(z, n - 1) * std::pow(v / v0, beta);
}

void TableStiffness::check() const {
  if (depths.size() != values.size() || depths.empty())
    throw std::invalid_argument("a table of K' needs at least one point, each with depth and value");
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!(values[i] > 0) || !(depths[i] >= 0))
      throw std::invalid_argument("a table of K' needs depths not below 0 and values above 0");
    if (i > 0 && !(depths[i] > depths[i - 1] && values[i] * depths[i] > values[i - 1] * depths[i - 1]))
      throw std::invalid_argument("a table of K' needs depths that increase, and K' z that increases with them");
  }
}

double TableStiffness::value(double z, double v, double) const {
  const auto next = std::upper_bound(depths.begin(), depths.end(), z);
  const auto i = static_cast<std::size_t>(next - depths.begin());
  double at = values[i == 0 ? 0 : i - 1];
  if (i > 0 && i < depths.size()) at += (z - depths[i - 1]) / (depths[i] - depths[i - 1]) * (values[i] - at);
  return at * std::pow(v / v0, beta);
}

void FormulaStiffness::check() const {
  if (!call) throw std::invalid_argument("a formula of K' must be read before it is used");
}

double plastic_force(const PlasticStiffness& stiffness, double z, double v, double m) {
  if (!(z > 0)) return 0;
  return z * std::visit([&](const auto& s) { return s.value(z, v, m); }, stiffness);
}

}  // namespace subsoil::mbd
