#include "libmbd/element/rut.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace subsoil::mbd {

namespace {
constexpr long block = 1000;         // grid points per growth
constexpr double most_points = 1e8;  // 0.8 GB of depths

void require_near(double x0, double x1, double spacing) {
  const double farthest = most_points * spacing;
  for (const double x : {x0, x1}) {
    if (std::abs(x) <= farthest) continue;
    char text[200];
    std::snprintf(text, sizeof text,
                  "a wheel or ground element presses the ground at x = %.6g m; ruts on its grid of %.3g mm are kept up "
                  "to %.3g km from the origin: is its velocity right?",
                  x, 1e3 * spacing, 1e-3 * farthest);
    throw std::runtime_error(text);
  }
}
}  // namespace

double Rut::stored(long i) const {
  const long k = i - first_;
  return k >= 0 && k < static_cast<long>(depths_.size()) ? depths_[static_cast<std::size_t>(k)] : 0.0;
}

Rut::Depth Rut::at(double x) const {
  const double u = x / spacing_, base = std::floor(u);
  const long i = static_cast<long>(base);
  const double left = stored(i), right = stored(i + 1);
  return {left + (u - base) * (right - left), (right - left) / spacing_};
}

void Rut::deepen(long i, double z) {
  if (depths_.empty()) first_ = i - block / 2;
  if (i < first_) {
    const long more = ((first_ - i) / block + 1) * block;
    depths_.insert(depths_.begin(), static_cast<std::size_t>(more), 0.0);
    first_ -= more;
  }
  const auto k = static_cast<std::size_t>(i - first_);
  if (k >= depths_.size()) depths_.resize((k / block + 1) * block, 0.0);
  depths_[k] = std::max(depths_[k], z);
}

void Rut::press(double x0, double z0, double x1, double z1) {
  if (z0 <= 0 && z1 <= 0) return;
  require_near(x0, x1, spacing_);
  if (x0 > x1) std::swap(x0, x1), std::swap(z0, z1);
  // Grid points inside the passed stretch; a step shorter than the grid often holds none, which is right: the point
  // is pressed by the step that crosses it.
  const long from = static_cast<long>(std::ceil(x0 / spacing_)), to = static_cast<long>(std::floor(x1 / spacing_));
  for (long i = from; i <= to; ++i) {
    const double x = static_cast<double>(i) * spacing_;
    const double share = x1 > x0 ? std::clamp((x - x0) / (x1 - x0), 0.0, 1.0) : 0.0;
    const double z = z0 + share * (z1 - z0);
    if (z > 0) deepen(i, z);
  }
}

void Rut::press_flat(double x0, double x1, double z) {
  require_near(x0, x1, spacing_);
  const long from = static_cast<long>(std::floor(x0 / spacing_)), to = static_cast<long>(std::ceil(x1 / spacing_));
  for (long i = from; i <= to; ++i) deepen(i, z);
}

void Rut::press_disk(double x, double z, double radius) {
  const double reach = std::sqrt(2 * radius * z);
  require_near(x - reach, x + reach, spacing_);
  const long from = static_cast<long>(std::ceil((x - reach) / spacing_)),
             to = static_cast<long>(std::floor((x + reach) / spacing_));
  for (long i = from; i <= to; ++i) {
    const double off = static_cast<double>(i) * spacing_ - x;
    deepen(i, z - off * off / (2 * radius));
  }
}

}  // namespace subsoil::mbd
