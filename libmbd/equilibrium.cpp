#include "libmbd/equilibrium.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "libmbd/assembly.hpp"
#include "libmbd/partition.hpp"

namespace subsoil::mbd {

namespace {

constexpr int most_iterations = 400;

/// The balance of all coordinates and constraints at (q, lambda), scaled to forces and lengths.
class Balance {
 public:
  Balance(System& system, double t, Eigen::VectorXd velocity)
      : system_(system),
        t_(t),
        velocity_(std::move(velocity)),
        columns_(coordinate_scale(system)),
        rows_(row_scale(system)),
        load_(system.coordinates()) {}

  Eigen::VectorXd at(const Eigen::VectorXd& q, const Eigen::VectorXd& lambda) {
    system_.set_state(t_, q, velocity_);
    system_.constraints(c_);
    system_.loads(load_);
    Eigen::VectorXd out(q.size() + lambda.size());
    out.head(q.size()) = columns_.cwiseInverse().cwiseProduct(load_ - c_.jacobian.transpose() * lambda);
    out.tail(lambda.size()) = -rows_.cwiseProduct(c_.phi);
    return out;
  }

  /// -d(balance)/d(scaled q, scaled lambda), stiffness by central differences: a force law only has to be evaluated.
  Eigen::MatrixXd matrix(const Eigen::VectorXd& q, const Eigen::VectorXd& lambda) {
    const auto n = q.size(), m = lambda.size();
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n + m, n + m);
    const double step = 1e-7 * system_.length_scale();
    for (Eigen::Index j = 0; j < n; ++j) {
      Eigen::VectorXd plus = q, minus = q;
      plus[j] += step / columns_[j], minus[j] -= step / columns_[j];
      k.col(j).head(n) = (at(minus, lambda) - at(plus, lambda)).head(n) / (2 * step);
    }
    at(q, lambda);
    const Eigen::MatrixXd jacobian = scaled_jacobian(system_, c_);
    k.topRightCorner(n, m) = jacobian.transpose();
    k.bottomLeftCorner(m, n) = jacobian;
    return k;
  }

  const Constraints& constraints() const { return c_; }
  const Eigen::VectorXd& columns() const { return columns_; }
  const Eigen::VectorXd& rows() const { return rows_; }
  const Eigen::VectorXd& velocity() const { return velocity_; }

 private:
  System& system_;
  double t_;
  Eigen::VectorXd velocity_, columns_, rows_, load_;
  Constraints c_;
};

Eigen::VectorXd towing_velocity(const System& system, double speed) {
  Eigen::VectorXd velocity = Eigen::VectorXd::Zero(system.coordinates());
  for (int i = 0; i < system.coordinates(); i += 3) velocity[i] = speed;
  for (const auto& f : system.model().forces)
    std::visit(
        [&](const auto& force) {
          if constexpr (requires { force.towing_spin(speed); })
            velocity[3 * (force.body - 1) + 2] = force.towing_spin(speed);
        },
        f.element);
  return velocity;
}

}  // namespace

Equilibrium towing_equilibrium(System& system, double t, const Eigen::VectorXd& guess, double speed) {
  Equilibrium found;
  found.q = guess;
  found.velocity = towing_velocity(system, speed);
  found.lambda = Eigen::VectorXd::Zero(system.equations());
  const auto n = system.coordinates(), m = system.equations();
  Balance balance(system, t, found.velocity);

  // Force and length that decide what is small: the machine's weight (or 1 N without gravity) and its levers.
  const double length = system.length_scale();
  const auto& g = system.model().gravity;
  double mass = 0;
  for (int i = 0; i < n; i += 3) mass += system.mass()[i];
  const double weight = std::max(1.0, mass * std::hypot(g[0], g[1]));
  const auto size = [&](const Eigen::VectorXd& r) {
    return r.head(n).cwiseAbs().maxCoeff() / weight + (m ? r.tail(m).cwiseAbs().maxCoeff() / length : 0.0);
  };

  // Pseudo-time so that the first step under gravity is a hundredth of the machine's length.
  double inverse_tau2 = std::max(1.0, std::hypot(g[0], g[1])) / (0.01 * length);
  const Eigen::VectorXd inertia = system.mass().cwiseQuotient(balance.columns().cwiseAbs2());
  Eigen::VectorXd r = balance.at(found.q, found.lambda);
  for (; found.iterations < most_iterations; ++found.iterations) {
    const double before = size(r);
    if (before < 1e-13) break;
    Eigen::MatrixXd k = balance.matrix(found.q, found.lambda);
    if (inverse_tau2 > 1e-6) k.diagonal().head(n) += inverse_tau2 * inertia;
    // Length-scaled multipliers are forces: bring rows and columns of both kinds to one size for the rank decision.
    const double stiffness = std::max(1.0, k.topLeftCorner(n, n).cwiseAbs().maxCoeff());
    k.topRightCorner(n, m) *= stiffness, k.bottomLeftCorner(m, n) *= stiffness;
    Eigen::VectorXd right = r;
    right.tail(m) *= stiffness;
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(1e-11);
    solver.compute(k);
    Eigen::VectorXd step = solver.solve(right);
    const double far = step.head(n).cwiseAbs().maxCoeff();
    const double share = std::min(1.0, 0.05 * length / std::max(1e-300, far));
    found.q += share * step.head(n).cwiseQuotient(balance.columns());
    found.lambda += share * stiffness * balance.rows().cwiseProduct(step.tail(m));
    r = balance.at(found.q, found.lambda);
    const double after = size(r);
    if (!std::isfinite(after)) break;
    if (before < 1e-11 && after > 0.5 * before) break;  // rounding
    inverse_tau2 *= std::clamp(after / before, 0.2, 2.0);
  }
  found.residual = r.head(n).cwiseAbs().maxCoeff();
  if (!(size(r) < 1e-9))
    throw std::runtime_error("no steady equilibrium found near the start pose: " + std::to_string(found.residual) +
                             " N stay unbalanced after " + std::to_string(found.iterations) +
                             " iterations; start nearer to it, or start from the given pose");

  const auto& c = balance.constraints();
  const Eigen::VectorXd off = c.jacobian * found.velocity + c.phi_t;
  for (int row = 0; row < m; ++row)
    if (std::abs(off[row]) > 1e-9 * std::max(1.0, std::abs(speed)))
      throw std::invalid_argument("towing equilibrium at " + std::to_string(speed) + " m/s: " + system.owner(row) +
                                  " asks for another velocity (off by " + std::to_string(off[row]) +
                                  "); give the towing speed the driver's velocity");
  return found;
}

std::vector<Mode> modes(System& system, double t, const Equilibrium& at) {
  Partition partition(system);
  MotionState m;
  m.t = t, m.q = at.q, m.velocity = at.velocity;
  m.acceleration = Eigen::VectorXd::Zero(at.q.size());
  m.lambda = Eigen::VectorXd::Zero(system.equations());
  m.rates = Eigen::VectorXd::Zero(
      static_cast<Eigen::Index>(2 * system.model().forces.size() + system.model().drivers.size()));
  partition.choose(m);
  const auto& v = partition.independent();
  const auto f = static_cast<Eigen::Index>(v.size());
  const Eigen::VectorXd scale = coordinate_scale(system);

  const auto acceleration = [&](Eigen::Index which, double shift) {
    MotionState s = m;
    const int k = v[static_cast<std::size_t>(which % f)];
    (which < f ? s.q : s.velocity)[k] += shift;
    partition.evaluate(s);
    Eigen::VectorXd out(f);
    for (Eigen::Index i = 0; i < f; ++i) out[i] = s.acceleration[v[static_cast<std::size_t>(i)]];
    return out;
  };
  // Differences of 1e-6 of a length (or per second): truncation 1e-12, rounding 1e-10 of the stiffness.
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * f, 2 * f);
  a.topRightCorner(f, f).setIdentity();
  for (Eigen::Index j = 0; j < 2 * f; ++j) {
    const double step = 1e-6 * system.length_scale() / scale[v[static_cast<std::size_t>(j % f)]];
    a.col(j).tail(f) = (acceleration(j, step) - acceleration(j, -step)) / (2 * step);
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(a, false);
  std::vector<Mode> found;
  // A coordinate that nothing holds (a free wheel) has two zero eigenvalues, which rounding splits: one zero mode.
  const double zero = 1e-6 * std::max(1.0, solver.eigenvalues().cwiseAbs().maxCoeff());
  int zeros = 0;
  for (Eigen::Index i = 0; i < 2 * f; ++i) {
    const auto s = solver.eigenvalues()[i];
    if (std::abs(s) < zero) {
      if (zeros++ % 2 == 0) found.push_back({});
    } else if (s.imag() >= 0) {
      found.push_back({s.imag() / (2 * std::numbers::pi), -s.real() / std::abs(s), s.real()});
    }
  }
  std::sort(found.begin(), found.end(), [](const Mode& x, const Mode& y) { return x.frequency < y.frequency; });
  return found;
}

}  // namespace subsoil::mbd
