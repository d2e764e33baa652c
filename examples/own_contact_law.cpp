// A contact law of one's own: F = k delta^(5/4), without damping. The kernels are compiled here, by the last line.
#include <cmath>
#include <cstdio>
#include <span>

#include "libdem/bed.hpp"
#include "libdem/own_law.hpp"

namespace mine {
using namespace subsoil::dem;

/// F = k delta^(5/4) = k delta sqrt(sqrt(delta)), stored = (4/9) k delta^(9/4); k N/m^1.25, delta overlap m.
struct Soft {
  static constexpr bool constant_stiffness = false;
  static constexpr LawMembers has{.needs_radius = false};
  double k = 0;
  Friction friction{};

  template <class V>
  void describe(V& v) {
    v.card("soft", "power law with exponent 5/4");
    v.quantity("k", k, "N/m^1.25", "(0, inf)", "stiffness");
    friction.describe(v);
  }
  Soft resolved() const { return *this; }
  double cutoff() const { return 0; }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a) const {
    using subsoil::dem::sqrt;  // of numbers and of SIMD vectors
    const T zero(0.0);
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    const T overlap = max(a.overlap, zero), slope = T(k) * sqrt(sqrt(overlap));
    n.force = slope * overlap;
    n.damping = zero;
    n.stored = T(4.0 / 9) * n.force * overlap;
    n.limiting_force = n.force;
    n.k_n = T(1.25) * slope;
    n.k_t = n.k_n;
    n.stiffness_ratio = T(1.0);
    n.tangential_compliance = select(n.in_contact, T(1.0) / max(n.k_t, tiny<T>()), zero);
    n.c_n = n.c_t = zero;
    return n;
  }
  StiffnessBound bound(const WorstContact& w) const {
    const double deepest = std::pow(9.0 / 8 * w.m_eff * w.speed * w.speed / k, 4.0 / 9);
    const double k_n = 1.25 * k * std::pow(deepest, 0.25);
    return {.k_n = k_n, .c_n = 0, .k_t = k_n, .c_t = 0};
  }
};
}  // namespace mine

SUBSOIL_CONTACT_LAW(mine::Soft)

int main() {
  mine::Soft law;
  law.k = 1e5;
  using namespace subsoil::dem;
  Bed bed({.materials = 1, .index = {0}, .laws = {Law(law)}}, {.gravity = {0, 0, 0}, .threads = 1});
  const double radius = 0.01, v = 0.5, density = 2500, m = density * 4 / 3 * M_PI * radius * radius * radius;
  const SphereSpec ball{
      .position = {0, radius, 0}, .velocity = {0, -v, 0}, .angular_velocity = {}, .radius = radius, .density = density};
  bed.add(std::span(&ball, 1));
  Boundary floor;
  floor.shape = Plane({0, 0, 0}, {0, 1, 0});
  bed.add(std::move(floor));

  double deepest = 0;
  for (int i = 0; i < 25000; ++i) {
    bed.step(2e-7);
    deepest = std::max(deepest, radius - bed.spheres()[0].x.y);
  }
  const double exact = std::pow(9.0 / 8 * m * v * v / law.k, 4.0 / 9);  // m v^2/2 = (4/9) k delta^(9/4)
  std::printf("depth %.6f mm (exact %.6f), speed after %.6f m/s (%.6f)\n", 1e3 * deepest, 1e3 * exact,
              bed.spheres()[0].v.y, v);
  return std::abs(deepest / exact - 1) < 1e-4 && std::abs(bed.spheres()[0].v.y / v - 1) < 1e-4 ? 0 : 1;
}
