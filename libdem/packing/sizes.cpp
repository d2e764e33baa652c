#include "libdem/packing/sizes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace subsoil::dem {

double RandomNumbers::normal() {
  const double u = 1 - uniform();  // (0, 1]: log is finite
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * uniform());
}

Vec3 RandomNumbers::in_unit_ball() {
  for (;;) {
    const double x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
    const Vec3 p{x, y, z};
    if (dot(p, p) <= 1) return p;
  }
}

namespace {

template <class... F>
struct Overload : F... {
  using F::operator()...;
};

[[noreturn]] void refuse_radius(const std::string& what) { throw std::invalid_argument("radius of the bed: " + what); }

void require_range(double least, double largest) {
  if (!(least > 0)) refuse_radius("the least radius is " + std::to_string(least) + " m; it must be positive");
  if (!(largest >= least) || !std::isfinite(largest))
    refuse_radius("the largest radius must be finite and not below the least");
}

void check(const RadiusDistribution& sizes) {
  std::visit(
      Overload{[](const EqualRadius& d) { require_range(d.radius, d.radius); },
               [](const UniformRadius& d) { require_range(d.least, d.largest); },
               [](const NormalRadius& d) {
                 require_range(d.least, d.largest);
                 if (!(d.deviation >= 0)) refuse_radius("the deviation must not be negative");
                 // Drawing again ends only when the range holds a fair share of the distribution.
                 if (!(d.mean + 3 * d.deviation >= d.least && d.mean - 3 * d.deviation <= d.largest) ||
                     (d.deviation == 0 && !(d.mean >= d.least && d.mean <= d.largest)) ||
                     d.largest - d.least < 1e-3 * d.deviation)
                   refuse_radius("the range from least to largest must hold part of the normal distribution; widen it");
               },
               [](const TableRadius& d) {
                 if (d.radius.empty() || d.radius.size() != d.share.size())
                   refuse_radius("a table needs as many shares as radii, and at least one");
                 double sum = 0;
                 for (std::size_t i = 0; i < d.radius.size(); ++i) {
                   require_range(d.radius[i], d.radius[i]);
                   if (!(d.share[i] >= 0)) refuse_radius("shares must not be negative");
                   sum += d.share[i];
                 }
                 if (!(sum > 0) || !std::isfinite(sum)) refuse_radius("the shares of a table must have a positive sum");
               }},
      sizes);
}

}  // namespace

double least_radius(const RadiusDistribution& sizes) {
  return std::visit(Overload{[](const EqualRadius& d) { return d.radius; },
                             [](const TableRadius& d) { return *std::min_element(d.radius.begin(), d.radius.end()); },
                             [](const auto& d) { return d.least; }},
                    sizes);
}

double largest_radius(const RadiusDistribution& sizes) {
  return std::visit(Overload{[](const EqualRadius& d) { return d.radius; },
                             [](const TableRadius& d) { return *std::max_element(d.radius.begin(), d.radius.end()); },
                             [](const auto& d) { return d.largest; }},
                    sizes);
}

RadiusSampler::RadiusSampler(RadiusDistribution sizes, ShareOf shares) : sizes_(std::move(sizes)), shares_(shares) {
  check(sizes_);
  if (const auto* table = std::get_if<TableRadius>(&sizes_)) {
    double sum = 0;
    for (std::size_t i = 0; i < table->radius.size(); ++i) {
      const double r = table->radius[i];
      sum += shares_ == ShareOf::mass ? table->share[i] / (r * r * r) : table->share[i];
      cumulative_.push_back(sum);
    }
    for (double& c : cumulative_) c /= sum;
  }
}

double RadiusSampler::draw(RandomNumbers& random) const {
  return std::visit([&](const auto& d) { return draw_from(d, random); }, sizes_);
}

double RadiusSampler::draw_from(const EqualRadius& d, RandomNumbers&) const { return d.radius; }

double RadiusSampler::draw_from(const NormalRadius& d, RandomNumbers& random) const {
  for (;;) {
    const double r = d.mean + d.deviation * random.normal();
    if (r >= d.least && r <= d.largest && keep(r, d.least, random)) return r;
  }
}

double RadiusSampler::draw_from(const UniformRadius& d, RandomNumbers& random) const {
  for (;;) {
    const double r = random.uniform(d.least, d.largest);
    if (keep(r, d.least, random)) return r;
  }
}

double RadiusSampler::draw_from(const TableRadius& d, RandomNumbers& random) const {
  const auto at = std::upper_bound(cumulative_.begin(), cumulative_.end(), random.uniform());
  return d.radius[std::min(static_cast<std::size_t>(at - cumulative_.begin()), d.radius.size() - 1)];
}

/// Thins a continuous distribution of mass to one of number: accepts in proportion to 1/r^3.
bool RadiusSampler::keep(double radius, double least, RandomNumbers& random) const {
  if (shares_ == ShareOf::number) return true;
  const double q = least / radius;
  return random.uniform() < q * q * q;
}

namespace {

/// Means of r, r^2 and r^3 by number.
struct RadiusMoments {
  double first = 0, second = 0, third = 0;
};

RadiusMoments moments_of(const RadiusDistribution& sizes, ShareOf shares) {
  constexpr int drawn = 20000;
  const RadiusSampler sampler(sizes, shares);
  RandomNumbers random(1);
  RadiusMoments m;
  for (int k = 0; k < drawn; ++k) {
    const double r = sampler.draw(random);
    m.first += r, m.second += r * r, m.third += r * r * r;
  }
  return {m.first / drawn, m.second / drawn, m.third / drawn};
}

}  // namespace

double radius_of_mean_volume(const RadiusDistribution& sizes, ShareOf shares) {
  if (const auto* equal = std::get_if<EqualRadius>(&sizes)) return equal->radius;
  return std::cbrt(moments_of(sizes, shares).third);
}

double denser_than_equal(const RadiusDistribution& sizes, ShareOf shares) {
  if (std::holds_alternative<EqualRadius>(sizes)) return 1;
  const RadiusMoments m = moments_of(sizes, shares);
  const double variance = m.second - m.first * m.first;
  if (!(variance > 1e-12 * m.second)) return 1;
  const double delta = std::sqrt(variance) / m.first;
  const double skewed = (m.third - 3 * m.first * m.second + 2 * std::pow(m.first, 3)) / std::pow(variance, 1.5);
  return 1 + (0.0658 * delta + 0.0857 * skewed * delta * delta) / 0.634;
}

}  // namespace subsoil::dem
