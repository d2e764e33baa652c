#include <algorithm>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/partition.hpp"
#include "libmbd/base/dense.hpp"
#include "libmbd/base/slope.hpp"
#include "libmbd/equilibrium/equilibrium.hpp"

namespace subsoil::mbd {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The equations of motion in the independent coordinates v about a steady state, linear in dv, dv' and dx.
class Linearisation {
 public:
  Linearisation(System& system, double t, const Equilibrium& at)
      : system_(system), partition_(system), scale_(coordinate_scale(system)), length_(system.length_scale()) {
    at_.t = t, at_.q = at.q, at_.velocity = at.velocity;
    at_.acceleration = VectorXd::Zero(at.q.size());
    at_.lambda = VectorXd::Zero(system.equations());
    at_.rates = VectorXd::Zero(system.rate_count());
    const std::vector<double>& x = system.element_states();
    at_.states = at.states.size() > 0
                     ? at.states
                     : VectorXd(Eigen::Map<const VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
    partition_.choose(at_);
    s_ = at_.states.size();
    if (freedom() > 0) fill();
  }

  Eigen::Index freedom() const { return partition_.freedom(); }
  /// d(v, v', x)' = matrix d(v, v', x), states over their sizes, and an estimate of the error of every entry.
  const MatrixXd& matrix() const { return a_; }
  const MatrixXd& error() const { return error_; }
  /// dq/dv: how all coordinates follow.
  const MatrixXd& directions() const { return directions_; }
  /// The real largest entry that makes shapes comparable.
  Eigen::VectorXcd normal(Eigen::VectorXcd shape) const {
    Eigen::Index largest = 0;
    if (shape.cwiseProduct(scale_).cwiseAbs().maxCoeff(&largest) == 0) return shape;  // of a state alone
    return shape / shape[largest];
  }

 private:
  int independent(Eigen::Index j) const { return partition_.independent()[static_cast<std::size_t>(j)]; }
  double state_size(Eigen::Index j) const {
    return system_.state_scales()[static_cast<std::size_t>(j)] + std::abs(at_.states[j]);
  }
  /// v'' scaled to lengths, and x' over their sizes.
  VectorXd rates_at(MotionState s) {
    partition_.forget_factors();
    partition_.evaluate(s);
    VectorXd out(freedom() + s_);
    for (Eigen::Index i = 0; i < freedom(); ++i) out[i] = s.acceleration[independent(i)] * scale_[independent(i)];
    for (Eigen::Index i = 0; i < s_; ++i) out[freedom() + i] = s.rates[system_.flow_count() + i] / state_size(i);
    return out;
  }

  /// v and v' scaled to lengths, states over their sizes.
  void fill() {
    const auto f = freedom(), size = 2 * f + s_;
    a_ = error_ = MatrixXd::Zero(size, size);
    a_.block(0, f, f, f).setIdentity();
    directions_.resize(at_.q.size(), f);
    const auto take = [&](Eigen::Index column, double far, double argument, auto shift) {
      const auto shifted = [&](double by) {
        MotionState s = at_;
        shift(s, by);
        return rates_at(s);
      };
      const Slope slope = slope_at_zero(shifted, far, std::numeric_limits<double>::epsilon() * std::abs(argument));
      a_.col(column).tail(f + s_) = slope.value, error_.col(column).tail(f + s_) = slope.error;
    };
    for (Eigen::Index j = 0; j < f; ++j) {
      const int i = independent(j);
      take(j, 1e-4 * length_, at_.q[i] * scale_[i], [&](MotionState& s, double by) { s.q[i] += by / scale_[i]; });
    }
    // What swings fast has large velocities: beside the forces that hold a load, small steps are rounding. Friction is
    // regularised at small ones, so they grow a thousandfold at the most.
    const double fastest = std::clamp(std::sqrt(a_.block(f, 0, f, f).cwiseAbs().maxCoeff()), 1.0, 1e3);
    for (Eigen::Index j = 0; j < f; ++j) {
      const int i = independent(j);
      take(f + j, 1e-4 * length_ * fastest, at_.velocity[i] * scale_[i],
           [&](MotionState& s, double by) { s.velocity[i] += by / scale_[i]; });
      MotionState still = at_, moving = at_;
      moving.velocity[i] += 1 / scale_[i];
      partition_.evaluate(still), partition_.evaluate(moving);
      directions_.col(j) = moving.velocity - still.velocity;
    }
    for (Eigen::Index j = 0; j < s_; ++j)
      take(2 * f + j, 1e-4, at_.states[j] / state_size(j),
           [&](MotionState& s, double by) { s.states[j] += by * state_size(j); });
    partition_.evaluate(at_);
    drop_constants();
  }

  // A state that nothing changes, as an integral with a gain of 0, is a constant: it would take the zero of what it
  // pushes into a chain of its own.
  void drop_constants() {
    std::vector<Eigen::Index> kept(static_cast<std::size_t>(2 * freedom()));
    std::iota(kept.begin(), kept.end(), 0);
    for (Eigen::Index i = 2 * freedom(); i < a_.rows(); ++i)
      if (!a_.row(i).isZero(0) || !error_.row(i).isZero(0)) kept.push_back(i);
    a_ = MatrixXd(a_(kept, kept)), error_ = MatrixXd(error_(kept, kept));
  }

  System& system_;
  Partition partition_;
  MotionState at_;
  Eigen::Index s_ = 0;
  VectorXd scale_;
  double length_;
  MatrixXd directions_, a_, error_;
};

/// Diagonal D for which D^-1 A D has rows and columns of like norms (Parlett & Reinsch 1969), powers of 2: eigenvalues
/// keep the digits that oil in Pa beside metres would cost. What rounding leaves of a zero, below its share of the
/// row's largest entry, has no say: it would make a coordinate that nothing depends on a million times larger.
VectorXd balancing(MatrixXd a) {
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const double rounding = std::numeric_limits<double>::epsilon() * a.row(i).cwiseAbs().maxCoeff();
    a.row(i) = (a.row(i).array().abs() > rounding).select(a.row(i), 0);
  }
  VectorXd d = VectorXd::Ones(a.rows());
  for (int sweep = 0; sweep < 20; ++sweep) {
    bool changed = false;
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      double row = 0, column = 0;
      for (Eigen::Index j = 0; j < a.rows(); ++j) {
        if (j == i) continue;
        row += std::abs(a(i, j)) * d[j] / d[i], column += std::abs(a(j, i)) * d[i] / d[j];
      }
      if (!(row > 0 && column > 0)) continue;
      const double factor = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (factor > 1.5 || factor < 0.75) d[i] *= factor, changed = true;
    }
    if (!changed) break;
  }
  return d;
}

/// A change by half the rounding of the eigenvalue problem, the same in every run: an exact double zero has one
/// eigenvector only, and no left ones could be had.
MatrixXd split_zeros(const MatrixXd& a) {
  MatrixXd change(a.rows(), a.cols());
  std::uint64_t seed = 1;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    seed = seed * 6364136223846793005U + 1442695040888963407U;
    change.data()[i] = static_cast<double>(seed >> 11U) * 0x1p-52 - 1;  // in [-1, 1)
  }
  return 2 * std::numeric_limits<double>::epsilon() * a.norm() * change;
}

/// Each row over its largest entry, so that a stiff state, small beside a coordinate, counts as much as that. Rows
/// below 1e-6 are rounding: eigenvectors of a zero that rounding has split differ by the root of it.
MatrixXd rows_of_unit_size(MatrixXd z) {
  for (Eigen::Index i = 0; i < z.rows() && z.cols() > 0; ++i) {
    const double largest = z.row(i).cwiseAbs().maxCoeff();
    z.row(i) *= largest > 1e-6 ? 1 / largest : 0;
  }
  return z;
}

/// How many columns of `z` are independent, to 1e-4 for the same reason.
Eigen::Index rank_of(const MatrixXd& z) {
  if (z.cols() == 0 || z.rows() == 0) return 0;
  return (pivots(z).array() > 1e-4).count();
}

/// Entries whose error is a share of themselves, and of the largest: differences of a function that jumps at 0, or has
/// no finite slope there, grow as their steps shrink.
MatrixXd undetermined_part(const MatrixXd& a, const MatrixXd& error) {
  constexpr double share = 1e-3, of_largest = 1e-5;
  const double floor = of_largest * a.cwiseAbs().maxCoeff();
  return (error.array() > share * a.array().abs() && error.array() > floor).select(error, 0);
}

/// Coordinates that a constant force moves without bound: combinations y of the rows of v'' and x', v'' among them,
/// with y^T d(v'', x')/d(v, x) = 0. States that come to rest of themselves, as a current does, hold nothing; one that
/// follows the way alone, as the pressure of locked oil does, gives a y without v''. Rows and columns are scaled, so
/// that masses and units have no say.
Eigen::Index without_restoring_force(const Linearisation& linear) {
  constexpr double certain = 10, noise = 1e-9;
  const auto f = linear.freedom(), s = linear.matrix().rows() - 2 * f;
  const auto part = [&](Eigen::Index row, Eigen::Index rows, Eigen::Index column, Eigen::Index columns) {
    const MatrixXd a = linear.matrix().block(row, column, rows, columns),
                   error = linear.error().block(row, column, rows, columns);
    const double floor = a.size() > 0 ? noise * a.cwiseAbs().maxCoeff() : 0;
    return MatrixXd((a.array().abs() > (certain * error.array()).max(floor)).select(a, 0));
  };
  MatrixXd b(f + s, f + s);
  b << part(f, f, 0, f), part(f, f, 2 * f, s), part(2 * f, s, 0, f), part(2 * f, s, 2 * f, s);
  const auto scale = [](auto line) {
    const double largest = line.cwiseAbs().maxCoeff();
    if (largest > 0) line /= largest;
  };
  for (Eigen::Index i = 0; i < b.rows(); ++i) scale(b.row(i));
  for (Eigen::Index j = 0; j < b.cols(); ++j) scale(b.col(j));
  for (Eigen::Index i = 0; i < b.rows(); ++i) scale(b.row(i));
  return f + rank_of(b.bottomRows(s)) - rank_of(b);
}

}  // namespace

std::vector<Mode> modes(System& system, double t, const Equilibrium& at) {
  const Linearisation linear(system, t, at);
  const auto f = linear.freedom();
  std::vector<Mode> found;
  if (f == 0) return found;
  const VectorXd d = balancing(linear.matrix());
  const auto balanced = [&](const MatrixXd& m) { return MatrixXd(d.cwiseInverse().asDiagonal() * m * d.asDiagonal()); };
  const MatrixXd a = balanced(linear.matrix());
  const MatrixXd error = balanced(linear.error());
  const MatrixXd undetermined = undetermined_part(a, error);
  // Rounding: of the differences, and of the eigenvalue problem a small multiple of eps |A|.
  const MatrixXd rounding = (error - undetermined).array() + 4 * std::numeric_limits<double>::epsilon() * a.norm();
  const auto [values, right] = eigenvectors(a + split_zeros(a));
  const Eigen::MatrixXcd left = inverse(right);
  constexpr double certain = 10;  // errors are estimates
  std::vector<Eigen::Index> zeros;
  double hidden = 0;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const auto s = values[i];
    // First order: |ds| <= |y|^T E |x| with y^T x = 1. Of a zero pair that rounding has split it is of its own size.
    const Eigen::RowVectorXd y_size = left.row(i).cwiseAbs();
    const VectorXd x_size = right.col(i).cwiseAbs();
    const double known = y_size * rounding * x_size, of_laws = y_size * undetermined * x_size, off = known + of_laws;
    const Eigen::VectorXcd p = d.head(f).asDiagonal() * right.col(i).head(f);
    const Eigen::VectorXcd shape = linear.directions().cast<std::complex<double>>() * p;
    const double scatter = std::sqrt(y_size.cwiseAbs2() * rounding.cwiseAbs2() * x_size.cwiseAbs2());
    // Without what is not determined it would be no zero, within the errors that are left.
    if (std::abs(s) <= certain * off && std::abs(s) > certain * known) {
      if (s.imag() < 0) continue;
      found.push_back({.error = off,
                       .error_of_laws = of_laws,
                       .rounding = scatter,
                       .shape = linear.normal(shape),
                       .undetermined = true});
    } else if (std::abs(s) <= certain * off || s == 0.0) {
      zeros.push_back(i);
      // Of a pair s, -s whose square is a stiffness over a mass: what the errors of that may hide.
      hidden = std::max(hidden, std::sqrt(2 * certain * std::abs(s) * known));
    } else if (s.imag() >= 0) {
      // A real part within its own error is that of an undamped oscillation.
      const double rate = std::abs(s.real()) <= off && s.imag() > 0 ? 0 : s.real();
      found.push_back({s.imag() / (2 * std::numbers::pi), 0.0 - rate / std::abs(s), rate, off, of_laws, scatter,
                       linear.normal(shape)});
    }
  }
  // What stays as it is, by left eigenvectors of zeros: a momentum, or a mixture of it with places and states, is of a
  // coordinate that nothing holds. One without momentum is of locked oil or a held integral. Of a zero pair that
  // rounding has split only the places differ.
  MatrixXd kept(a.rows() - f, 2 * static_cast<Eigen::Index>(zeros.size()));
  for (std::size_t k = 0; k < zeros.size(); ++k) {
    const Eigen::VectorXcd y = left.row(zeros[k]).tail(kept.rows()).transpose().normalized();
    kept.col(2 * static_cast<Eigen::Index>(k)) = y.real(), kept.col(2 * static_cast<Eigen::Index>(k) + 1) = y.imag();
  }
  kept = rows_of_unit_size(std::move(kept));
  const auto with_momentum = rank_of(kept.topRows(f));
  // Zeros of several states mix, and none may look like a small share: what has a restoring force is held.
  const auto free = with_momentum > 0 ? std::min(with_momentum, without_restoring_force(linear)) : 0;
  Mode zero;
  zero.error = hidden;
  found.insert(found.begin(), static_cast<std::size_t>(free), zero);
  // Those that do not swing the slowest first, and not as the eigenvalue problem has found them.
  std::stable_sort(found.begin(), found.end(), [](const Mode& x, const Mode& y) {
    return std::pair(x.frequency, std::abs(x.rate)) < std::pair(y.frequency, std::abs(y.rate));
  });
  return found;
}

StabilityReport stability(const std::vector<Mode>& modes) {
  StabilityReport report;
  for (const Mode& m : modes) {
    if (m.is_zero()) ++report.neutral;
    if (m.undetermined) ++report.undetermined;
    // An undamped oscillation has a real part of rounding, of either sign.
    if (m.damping < -1e-7 && m.rate > 2 * m.error) report.unstable += m.frequency > 0 ? 2 : 1;
  }
  report.kind = report.unstable       ? Stability::unstable
                : report.undetermined ? Stability::undetermined
                : report.neutral      ? Stability::neutral
                                      : Stability::stable;
  return report;
}

}  // namespace subsoil::mbd
