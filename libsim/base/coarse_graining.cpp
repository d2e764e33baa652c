#include "libsim/base/coarse_graining.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace subsoil::sim {
namespace {

using std::numbers::pi;

/// Share of a Gaussian in three dimensions within 3 deviations.
const double within_three = std::erf(3 / std::sqrt(2.0)) - 3 * std::sqrt(2 / pi) * std::exp(-4.5);

/// Six points of Gauss and Legendre on [-1, 1]: on a stretch inside the reach the kernel is a smooth curve, and the
/// error some 1e-6 of the integral.
constexpr std::array<double, 3> nodes{0.2386191860831969, 0.6612093864662645, 0.9324695142031521};
constexpr std::array<double, 3> weights{0.4679139345726910, 0.3607615730481386, 0.1713244923791704};

}  // namespace

FieldKernel::FieldKernel(Kind kind, double width)
    : kind_(kind), width_(width), reach_(kind == Kind::lucy ? 2 * width : 3 * width) {
  factor_ = kind == Kind::lucy ? 105 / (16 * pi * reach_ * reach_ * reach_)
                               : 1 / (std::pow(std::sqrt(2 * pi) * width, 3) * within_three);
}

double FieldKernel::operator()(double distance2) const {
  if (!(distance2 < reach_ * reach_)) return 0;
  if (kind_ == Kind::gaussian) return factor_ * std::exp(-0.5 * distance2 / (width_ * width_));
  const double q = std::sqrt(distance2) / reach_, p = 1 - q;
  return factor_ * (1 + 3 * q) * p * p * p;
}

double FieldKernel::along(const Vec3& r, const Vec3& a, const Vec3& b) const {
  const Vec3 to = b - a, from = a - r;
  const double length2 = dem::dot(to, to);
  if (!(length2 > 0)) return (*this)(dem::dot(from, from));
  // |from + s to| < reach between the roots of a square.
  const double half = dem::dot(from, to) / length2, rest = (dem::dot(from, from) - reach_ * reach_) / length2;
  const double root2 = half * half - rest;
  if (!(root2 > 0)) return 0;
  const double root = std::sqrt(root2), begin = std::max(0.0, -half - root), end = std::min(1.0, -half + root);
  if (!(end > begin)) return 0;
  // Lucy's curve has a kink of third order where it comes nearest to r: each side is integrated alone.
  const double nearest = std::clamp(-half, begin, end);
  double sum = 0;
  for (const auto& [s0, s1] : {std::pair{begin, nearest}, {nearest, end}}) {
    const double middle = 0.5 * (s0 + s1), size = 0.5 * (s1 - s0);
    if (!(size > 0)) continue;
    for (std::size_t k = 0; k < nodes.size(); ++k)
      for (const double side : {-1.0, 1.0}) {
        const Vec3 at = from + (middle + side * size * nodes[k]) * to;
        sum += size * weights[k] * (*this)(dem::dot(at, at));
      }
  }
  return sum;
}

CoarseGraining::CoarseGraining(const FieldGrid& grid, const FieldKernel& kernel)
    : grid_(grid), kernel_(kernel), number_(grid.size(), 0.0) {
  for (std::vector<double>* field : {&sum_.density, &sum_.solid_fraction, &sum_.coordination})
    field->assign(grid.size(), 0.0);
  sum_.velocity.assign(grid.size(), {});
  sum_.kinetic_stress.assign(grid.size(), Tensor{});
  sum_.contact_stress.assign(grid.size(), Tensor{});
}

/// use(point, its number) for all within reach of a box.
template <class Use>
void CoarseGraining::near(const Vec3& low, const Vec3& high, const Use& use) const {
  std::array<std::size_t, 3> from{}, until{};
  for (int d = 0; d < 3; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const double first = std::ceil((low[d] - kernel_.reach() - grid_.low[d]) / grid_.spacing[d]),
                 last = std::floor((high[d] + kernel_.reach() - grid_.low[d]) / grid_.spacing[d]);
    if (!(last >= 0) || !(first <= static_cast<double>(grid_.n[at]) - 1)) return;
    from[at] = static_cast<std::size_t>(std::max(first, 0.0));
    until[at] = std::min(grid_.n[at], static_cast<std::size_t>(last) + 1);
  }
  for (std::size_t k = from[2]; k < until[2]; ++k)
    for (std::size_t j = from[1]; j < until[1]; ++j)
      for (std::size_t i = from[0]; i < until[0]; ++i) use(grid_.point(i, j, k), (k * grid_.n[1] + j) * grid_.n[0] + i);
}

void CoarseGraining::add(const FieldGrain& g) {
  near(g.position, g.position, [&](const Vec3& r, std::size_t at) {
    const Vec3 apart = r - g.position;
    const double phi = kernel_(dem::dot(apart, apart));
    if (phi == 0) return;
    sum_.density[at] += g.mass * phi, sum_.solid_fraction[at] += g.volume * phi;
    sum_.coordination[at] += g.contacts * phi, number_[at] += phi;
    sum_.velocity[at] += (g.mass * phi) * g.velocity;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        sum_.kinetic_stress[at][static_cast<std::size_t>(3 * a + b)] += g.mass * phi * g.velocity[a] * g.velocity[b];
  });
}

void CoarseGraining::add_contact(const Vec3& centre, const Vec3& end, const Vec3& force) {
  const Vec3 branch = centre - end;
  Vec3 low, high;
  for (int d = 0; d < 3; ++d) low[d] = std::min(centre[d], end[d]), high[d] = std::max(centre[d], end[d]);
  near(low, high, [&](const Vec3& r, std::size_t at) {
    const double phi = kernel_.along(r, centre, end);
    if (phi == 0) return;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        sum_.contact_stress[at][static_cast<std::size_t>(3 * a + b)] += phi * force[a] * branch[b];
  });
}

GrainFields CoarseGraining::finish() {
  GrainFields out = std::move(sum_);
  for (std::size_t at = 0; at < number_.size(); ++at) {
    if (!(number_[at] > 0)) continue;
    out.coordination[at] /= number_[at];
    out.velocity[at] *= 1 / out.density[at];
    // sum m (v - V)(v - V) phi = sum m v v phi - rho V V
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        out.kinetic_stress[at][static_cast<std::size_t>(3 * a + b)] -=
            out.density[at] * out.velocity[at][a] * out.velocity[at][b];
  }
  return out;
}

}  // namespace subsoil::sim
