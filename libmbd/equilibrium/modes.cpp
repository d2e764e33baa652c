#include <Eigen/Eigenvalues>
#include <algorithm>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/base/slope.hpp"
#include "libmbd/equilibrium/equilibrium.hpp"

namespace subsoil::mbd {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The equations of motion about a steady state, linear in
///   dq = U p,  dv = U p' + W p,  dx
/// U: directions that the constraints leave free, orthonormal in the mass matrix; W p: what the velocity constraints of
/// a machine that moves ask of a displacement. With G = F - Phi_q^T lambda,
///   M a + Phi_q^T dlambda - F_lambda dlambda = dG,   Phi_q a = dgamma,   p'' = U^T M a,   dx' = df
class Linearisation {
 public:
  Linearisation(System& system, double t, const Equilibrium& at)
      : system_(system),
        t_(t),
        at_(at),
        n_(system.coordinates()),
        m_(system.equations()),
        scale_(coordinate_scale(system)),
        length_(system.length_scale()) {
    if (at_.states.size() == 0) {
      const std::vector<double>& x = system.element_states();
      at_.states = Eigen::Map<const VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
    }
    s_ = at_.states.size();
    still_ = VectorXd::Zero(n_);
    take_directions();
    if (freedom() == 0) return;
    take_solver();
    fill();
  }

  Eigen::Index freedom() const { return directions_.cols(); }
  /// d(p, p', x)' = matrix d(p, p', x), and an estimate of the error of every entry.
  const MatrixXd& matrix() const { return a_; }
  const MatrixXd& error() const { return error_; }
  /// dq/dp: how all coordinates follow.
  const MatrixXd& directions() const { return directions_; }
  /// Sizes of states that count as much as a length of the machine.
  double state_size(Eigen::Index j) const {
    return system_.state_scales()[static_cast<std::size_t>(j)] + std::abs(at_.states[j]);
  }
  /// The real largest entry that makes shapes comparable.
  Eigen::VectorXcd normal(Eigen::VectorXcd shape) const {
    Eigen::Index largest = 0;
    if (shape.cwiseProduct(scale_).cwiseAbs().maxCoeff(&largest) == 0) return shape;  // of a state alone
    return shape / shape[largest];
  }

 private:
  struct Shift {
    VectorXd q, velocity, states, lambda;
  };

  /// Sets the system to the state moved by `by` times the shift.
  void set(const Shift& d, double by) {
    const auto moved = [by](const VectorXd& x, const VectorXd& dx) { return dx.size() ? VectorXd(x + by * dx) : x; };
    system_.set_state(t_, moved(at_.q, d.q), moved(at_.velocity, d.velocity));
    if (s_ > 0) system_.set_element_states(moved(at_.states, d.states));
    lambda_ = moved(at_.lambda, d.lambda);
    if (!system_.friction_rows().empty()) system_.set_multipliers(lambda_);
    system_.constraints(c_);
  }

  /// (G over the scale, gamma, x' over its size) at the state moved by `by` times the shift.
  VectorXd sides(const Shift& d, double by) {
    set(d, by);
    VectorXd load(n_), out(n_ + m_ + s_);
    system_.loads(load);
    out.head(n_) = (load - c_.jacobian.transpose() * at_.lambda).cwiseQuotient(scale_);
    out.segment(n_, m_) = c_.gamma;
    if (s_ > 0) {
      const std::vector<double>& rates = system_.take_state_rates(still_, lambda_);
      for (Eigen::Index i = 0; i < s_; ++i) out[n_ + m_ + i] = rates[static_cast<std::size_t>(i)] / state_size(i);
    }
    return out;
  }
  Slope slope(const Shift& d, double far) {
    return slope_at_zero([&](double by) { return sides(d, by); }, far);
  }

  void take_directions() {
    set({}, 0);
    MatrixXd free = MatrixXd::Identity(n_, n_);
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    if (m_ > 0) {
      solver.setThreshold(rank_share);
      solver.compute(scaled_jacobian(system_, c_));
      // A P = Q T Z: the last rows of Z are the right null space.
      free = solver.colsPermutation() * solver.matrixZ().transpose().rightCols(n_ - solver.rank());
    }
    free = scale_.cwiseInverse().asDiagonal() * free;
    if (free.cols() > 0) {
      const MatrixXd mass = free.transpose() * system_.mass().asDiagonal() * free;
      MatrixXd rows = free.transpose();
      mass.llt().matrixL().solveInPlace(rows);
      free = rows.transpose();
    }
    directions_ = free;
    drifts_ = MatrixXd::Zero(n_, freedom());
    if (m_ == 0 || at_.velocity.isZero(0)) return;
    for (Eigen::Index j = 0; j < freedom(); ++j) {
      const auto speeds = [&](double by) {
        set({directions_.col(j), {}, {}, {}}, by);
        return VectorXd(row_scale(system_).cwiseProduct(VectorXd(c_.jacobian * at_.velocity + c_.phi_t)));
      };
      const VectorXd w = -scale_.cwiseInverse().cwiseProduct(solver.solve(slope_at_zero(speeds, far(j)).value));
      drifts_.col(j) = w - directions_ * (directions_.transpose() * system_.mass().cwiseProduct(w));
    }
  }

  /// What p'' and x' are of (dG, dgamma, df). Without friction from reactions, and without controllers that measure
  /// the solution, p'' = U^T dG and x' = df.
  void take_solver() {
    to_acceleration_ = MatrixXd::Zero(freedom(), n_ + m_), to_states_ = MatrixXd::Zero(s_, n_ + m_ + s_);
    to_acceleration_.leftCols(n_) = directions_.transpose() * scale_.asDiagonal();
    to_states_.rightCols(s_).setIdentity();
    const bool friction = !system_.friction_rows().empty(), reads = controllers_read_reactions(system_);
    if (!friction && !reads) return;
    set({}, 0);
    // Unknown: accelerations times the scale, multipliers as shares of the heaviest body's force. All entries near 1.
    const VectorXd rows = row_scale(system_), inertia = system_.mass().cwiseQuotient(scale_.cwiseAbs2());
    const MatrixXd jacobian = scaled_jacobian(system_, c_);
    const double heavy = inertia.maxCoeff();
    MatrixXd kkt = MatrixXd::Zero(n_ + m_, n_ + m_), of_states = MatrixXd::Zero(s_, n_ + m_);
    kkt.topLeftCorner(n_, n_) = (inertia / heavy).asDiagonal();
    kkt.topRightCorner(n_, m_) = jacobian.transpose();
    kkt.bottomLeftCorner(m_, n_) = jacobian;
    for (Eigen::Index j = 0; j < m_; ++j) {
      Shift d;
      d.lambda = VectorXd::Zero(m_);
      d.lambda[j] = rows[j] * heavy;
      const VectorXd by = slope(d, 1e-4 * std::max(1.0, std::abs(at_.lambda[j] / d.lambda[j]))).value;
      kkt.col(n_ + j).head(n_) -= by.head(n_) / heavy;
      of_states.col(n_ + j) = by.tail(s_);
    }
    for (Eigen::Index j = 0; j < n_ && reads; ++j) of_states.col(j) = by_acceleration(j);
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    solver.setThreshold(1e-13);
    solver.compute(kkt);
    MatrixXd right = MatrixXd::Identity(n_ + m_, n_ + m_);
    right.topRows(n_) /= heavy;
    right.bottomRows(m_) = rows.asDiagonal() * right.bottomRows(m_);
    const MatrixXd solved = solver.solve(right);
    to_acceleration_ = directions_.transpose() * system_.mass().cwiseQuotient(scale_).asDiagonal() * solved.topRows(n_);
    to_states_.leftCols(n_ + m_) = of_states * solved;
  }

  /// d(x')/d(acceleration times the scale): of controllers that measure it.
  VectorXd by_acceleration(Eigen::Index j) {
    set({}, 0);
    VectorXd load(n_);
    system_.loads(load);
    const auto rates = [&](double by) {
      VectorXd a = still_, out(s_);
      a[j] = by / scale_[j];
      const std::vector<double>& x = system_.take_state_rates(a, at_.lambda);
      for (Eigen::Index i = 0; i < s_; ++i) out[i] = x[static_cast<std::size_t>(i)] / state_size(i);
      return out;
    };
    return slope_at_zero(rates, length_).value;
  }

  /// Largest coordinate that one unit of the direction moves.
  double far(Eigen::Index j) const {
    return 1e-4 * length_ / directions_.col(j).cwiseProduct(scale_).cwiseAbs().maxCoeff();
  }

  void fill() {
    const auto f = freedom(), size = 2 * f + s_;
    a_ = error_ = MatrixXd::Zero(size, size);
    a_.block(0, f, f, f).setIdentity();
    const auto take = [&](Eigen::Index column, const Slope& s) {
      a_.col(column).segment(f, f) = to_acceleration_ * s.value.head(n_ + m_);
      error_.col(column).segment(f, f) = to_acceleration_.cwiseAbs() * s.error.head(n_ + m_);
      a_.col(column).tail(s_) = to_states_ * s.value;
      error_.col(column).tail(s_) = to_states_.cwiseAbs() * s.error;
    };
    for (Eigen::Index j = 0; j < f; ++j) {
      take(j, slope({directions_.col(j), drifts_.col(j), {}, {}}, far(j)));
      take(f + j, slope({{}, directions_.col(j), {}, {}}, far(j)));
    }
    for (Eigen::Index j = 0; j < s_; ++j) {
      Shift d;
      d.states = VectorXd::Zero(s_);
      d.states[j] = state_size(j);
      take(2 * f + j, slope(d, 1e-4));
    }
    set({}, 0);
    VectorXd load(n_);
    system_.loads(load);
  }

  System& system_;
  double t_;
  Equilibrium at_;
  Eigen::Index n_, m_, s_ = 0;
  VectorXd scale_, still_, lambda_;
  double length_;
  Constraints c_;
  MatrixXd directions_, drifts_, to_acceleration_, to_states_, a_, error_;
};

/// Diagonal D for which D^-1 A D has rows and columns of like norms (Parlett & Reinsch 1969), powers of 2: eigenvalues
/// keep the digits that oil in Pa beside metres would cost.
VectorXd balancing(const MatrixXd& a) {
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

/// How many columns of `z`, which are units or 0, are independent, to 1e-4: eigenvectors of a zero that rounding has
/// split differ by the root of it.
Eigen::Index rank_of(const MatrixXd& z) {
  if (z.cols() == 0 || z.rows() == 0) return 0;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(z);
  return (qr.matrixR().diagonal().array().abs() > 1e-4).count();
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
  MatrixXd error = balanced(linear.error());
  // Rounding of the eigenvalue problem: a small multiple of eps |A|.
  error.array() += 4 * std::numeric_limits<double>::epsilon() * a.norm();
  const Eigen::EigenSolver<MatrixXd> solver(MatrixXd(a + split_zeros(a)));
  const Eigen::MatrixXcd right = solver.eigenvectors(), left = right.partialPivLu().inverse();
  constexpr double certain = 10;  // errors are estimates
  std::vector<Eigen::Index> zeros;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const auto s = solver.eigenvalues()[i];
    // First order: |ds| <= |y|^T E |x| with y^T x = 1. Of a zero pair that rounding has split it is of its own size.
    const double off = left.row(i).cwiseAbs() * error * right.col(i).cwiseAbs();
    if (std::abs(s) <= certain * off || s == 0.0) {
      zeros.push_back(i);
    } else if (s.imag() >= 0) {
      const Eigen::VectorXcd p = d.head(f).asDiagonal() * right.col(i).head(f);
      const Eigen::VectorXcd shape = linear.directions().cast<std::complex<double>>() * p;
      found.push_back(
          {s.imag() / (2 * std::numbers::pi), 0.0 - s.real() / std::abs(s), s.real(), off, linear.normal(shape)});
    }
  }
  // What stays as it is, by left eigenvectors of zeros: a momentum, or a mixture of it with the place, is of a
  // coordinate that nothing holds. One with states in it is of locked oil or a held integral.
  MatrixXd kept(a.rows(), 2 * static_cast<Eigen::Index>(zeros.size()));
  for (std::size_t k = 0; k < zeros.size(); ++k) {
    const Eigen::VectorXcd y = left.row(zeros[k]).transpose().normalized();
    kept.col(2 * static_cast<Eigen::Index>(k)) = y.real(), kept.col(2 * static_cast<Eigen::Index>(k) + 1) = y.imag();
  }
  const auto free = rank_of(kept) - rank_of(kept.bottomRows(a.rows() - 2 * f));
  found.insert(found.begin(), static_cast<std::size_t>(std::max<Eigen::Index>(free, 0)), Mode{});
  std::stable_sort(found.begin(), found.end(), [](const Mode& x, const Mode& y) { return x.frequency < y.frequency; });
  return found;
}

StabilityReport stability(const std::vector<Mode>& modes) {
  StabilityReport report;
  for (const Mode& m : modes) {
    if (m.is_zero()) ++report.neutral;
    // An undamped oscillation has a real part of rounding, of either sign.
    if (m.damping < -1e-7 && m.rate > 2 * m.error) report.unstable += m.frequency > 0 ? 2 : 1;
  }
  report.kind = report.unstable ? Stability::unstable : report.neutral ? Stability::neutral : Stability::stable;
  return report;
}

}  // namespace subsoil::mbd
