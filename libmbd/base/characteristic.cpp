#include "libmbd/base/characteristic.hpp"

#include <algorithm>
#include <stdexcept>

namespace subsoil::mbd {

void PolynomialCharacteristic::check() const {
  if (std::all_of(std::begin(law.c), std::end(law.c), [](double c) { return c == 0; }))
    throw std::invalid_argument("polynomial characteristic: all coefficients are 0; give one, or leave the curve out");
}

void TableCharacteristic::check() const {
  if (law.times.size() != law.values.size() || law.times.size() < 2)
    throw std::invalid_argument("table characteristic: needs at least two points, each with x and value");
  for (std::size_t i = 1; i < law.times.size(); ++i)
    if (!(law.times[i] > law.times[i - 1]))
      throw std::invalid_argument("table characteristic: x must increase; point " + std::to_string(i + 1) +
                                  " does not come after the one before");
}

double Characteristic::value(double x) const {
  if (const auto* p = get_if<PolynomialCharacteristic>()) return p->law.value(x);
  if (const auto* t = get_if<TableCharacteristic>()) return t->law.value(x);
  return 0;
}

std::span<const double> Characteristic::nodes() const {
  const auto* t = get_if<TableCharacteristic>();
  return t ? std::span<const double>(t->law.times) : std::span<const double>{};
}

double Characteristic::integral(double x) const {
  if (const auto* p = get_if<PolynomialCharacteristic>()) return p->law.integral(x);
  if (const auto* t = get_if<TableCharacteristic>()) return t->law.integral(x);
  return 0;
}

}  // namespace subsoil::mbd
