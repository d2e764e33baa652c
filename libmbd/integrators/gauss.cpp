#include "libmbd/integrators/gauss.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "libmbd/assembly/assembly.hpp"

namespace subsoil::mbd {

namespace {

constexpr int most_collocations = 40;
// Below it an iteration changes rounding: of velocities; of accelerations, of a stage at a distance d, over d^3.
constexpr double collocation_rounding = 4e-16, rounding_of_stage = 1e-13;

using StageVector = Eigen::Vector<double, GaussCollocation::stages>;
using StageMatrix = Eigen::Matrix<double, GaussCollocation::stages, GaussCollocation::stages>;
constexpr int points = GaussCollocation::stages + 2;  // with both ends

/// Nodes, and what follows from them alone.
struct Tableau {
  StageVector c;
  StageMatrix a, a2;                             // q' and q of the stages: h a f, h^2 a2 f
  StageVector b, b2;                             // of the end
  StageVector at_end;                            // the cubic through the stages, there
  Eigen::Matrix<double, points, points> powers;  // of the quintic through begin, stages and end

  Tableau() {
    // Roots of the Legendre polynomial P4, on [0, 1].
    const double inner = std::sqrt(3. / 7 - 2. / 7 * std::sqrt(6. / 5)),
                 outer = std::sqrt(3. / 7 + 2. / 7 * std::sqrt(6. / 5));
    c = StageVector(0.5 - outer / 2, 0.5 - inner / 2, 0.5 + inner / 2, 0.5 + outer / 2);
    StageMatrix v, integral;
    StageVector whole;
    for (Eigen::Index i = 0; i < v.rows(); ++i)
      for (Eigen::Index k = 0; k < v.cols(); ++k) {
        v(i, k) = std::pow(c[i], k);
        integral(i, k) = std::pow(c[i], k + 1) / static_cast<double>(k + 1);
        whole[k] = 1 / static_cast<double>(k + 1);
      }
    const StageMatrix inverse = v.inverse();
    a = integral * inverse, a2 = a * a;
    b = inverse.transpose() * whole, b2 = a.transpose() * b;
    at_end = inverse.transpose() * StageVector::Ones();
    Eigen::Matrix<double, points, points> all;
    for (Eigen::Index i = 0; i < points; ++i) {
      const double s = i == 0 ? 0 : i == points - 1 ? 1 : c[i - 1];
      for (Eigen::Index k = 0; k < points; ++k) all(i, k) = k == 0 ? 1 : std::pow(s, k);
    }
    powers = all.inverse();
  }
};

const Tableau& tableau() {
  static const Tableau t;
  return t;
}

}  // namespace

GaussCollocation::GaussCollocation(const System& system, Partition& partition)
    : partition_(partition), scale_(coordinate_scale(system)) {
  accelerations_.setZero(system.coordinates(), points);
  rates_.setZero(system.rate_count(), points);
  stage_velocity_.setZero(system.coordinates(), stages);
}

bool GaussCollocation::step(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows) {
  const Tableau& t = tableau();
  const auto e = now.states.size();
  const auto size = [&](const auto& v) { return v.cwiseProduct(scale_).cwiseAbs().maxCoeff(); };
  t_ = now.t, h_ = h, q_ = now.q, velocity_ = now.velocity, flows_ = flows, landed_ = false;
  accelerations_.colwise() = now.acceleration;
  rates_.colwise() = now.rates;
  trial_.fill(now);
  std::array<double, stages> distances{};
  const auto f = accelerations_.middleCols<stages>(1), r = rates_.middleCols<stages>(1);
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0;; ++iteration) {
    const Eigen::MatrixXd moved = h * f * t.a.transpose(), way = h * h * f * t.a2.transpose();
    const Eigen::MatrixXd flowed = h * r * t.a.transpose();
    double change = 0, most = size(now.velocity), gained = 0;
    for (int i = 0; i < stages; ++i) {
      MotionState& m = trial_[static_cast<std::size_t>(i)];
      m.t = now.t + t.c[i] * h;
      m.q = now.q + t.c[i] * h * now.velocity + way.col(i);
      m.velocity = now.velocity + moved.col(i);
      m.states = now.states + flowed.col(i).tail(e);
      partition_.evaluate_nearest(m);
      distances[static_cast<std::size_t>(i)] = partition_.distance_from_singular();
      change = std::max(change, h * size(Eigen::VectorXd(m.acceleration - accelerations_.col(i + 1))));
      gained = std::max(gained, h * size(m.acceleration));
      if (e > 0) change = std::max(change, h * (m.rates - rates_.col(i + 1)).tail(e).cwiseAbs().maxCoeff());
    }
    for (int i = 0; i < stages; ++i) {
      accelerations_.col(i + 1) = trial_[static_cast<std::size_t>(i)].acceleration;
      rates_.col(i + 1) = trial_[static_cast<std::size_t>(i)].rates;
    }
    most = std::max(most, gained);
    const double nearest = *std::min_element(distances.begin(), distances.end());
    const double noise = std::min(rounding_of_stage / (nearest * nearest * nearest), 1e-2) * gained;
    const double settled = std::max(collocation_rounding * most, noise);
    if (change <= settled || (change <= 100 * settled && change > 0.5 * before)) break;
    if (iteration == most_collocations || !std::isfinite(change) || (iteration > 3 && change > 2 * before))
      return false;
    before = change;
  }
  next = trial_.back();
  next.t = now.t + h;
  next.q = now.q + h * now.velocity + h * h * f * t.b2;
  next.velocity = now.velocity + h * f * t.b;
  next.states = now.states + h * (r * t.b).tail(e);
  flows += h * r * t.b;
  const Eigen::VectorXd expected = f * t.at_end;
  const MotionState free = next;
  try {
    partition_.evaluate_nearest(next);
  } catch (const SingularPose&) {
    landed_ = true;
    next = free;
    next.acceleration = expected, next.rates = r * t.at_end;
  }
  accelerations_.rightCols<1>() = next.acceleration, rates_.rightCols<1>() = next.rates;
  distance_ = landed_ ? 0 : partition_.distance_from_singular();
  approach_ = landed_ ? 0 : (distances.back() - distance_) / ((1 - t.c[stages - 1]) * h);
  // For f = 1/(R - t) the cubic misses the end by (h/R)^4/70 and the step errs by h 8! 5.6e-10 (h/R)^8, both of the
  // size of f: the product of the nodes' distances from the end, and (4!)^4/(9 (8!)^3).
  const double largest = std::max(f.cwiseProduct(scale_.replicate<1, stages>()).cwiseAbs().maxCoeff(), 1e-300);
  const double missed = 70 * size(Eigen::VectorXd(next.acceleration - expected)) / largest;
  error_ = h * largest * 2.3e-5 * missed * missed;
  return true;
}

Polynomial GaussCollocation::polynomial() const {
  const Eigen::MatrixXd a = accelerations_ * tableau().powers.transpose(), r = rates_ * tableau().powers.transpose();
  const auto n = q_.size(), e = flows_.size();
  Polynomial out;
  out.centre = t_, out.scale = h_;
  out.set.resize(static_cast<std::size_t>(n));
  std::iota(out.set.begin(), out.set.end(), 0);
  out.powers.setZero(2 * n + e, points + 2);
  out.powers.col(0) << q_, velocity_, flows_;
  out.powers.col(1).head(n) = h_ * velocity_;
  for (Eigen::Index k = 0; k < points; ++k) {
    const auto once = static_cast<double>(k + 1), twice = once * static_cast<double>(k + 2);
    out.powers.col(k + 1).segment(n, n) = h_ / once * a.col(k);
    out.powers.col(k + 1).tail(e) = h_ / once * r.col(k);
    out.powers.col(k + 2).head(n) = h_ * h_ / twice * a.col(k);
  }
  return out;
}

}  // namespace subsoil::mbd
