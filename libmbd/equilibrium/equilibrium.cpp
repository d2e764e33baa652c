#include "libmbd/equilibrium/equilibrium.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <complex>
#include <numbers>
#include <stdexcept>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/least_norm.hpp"
#include "libmbd/assembly/partition.hpp"
#include "libmbd/equilibrium/relaxation.hpp"
#include "libmbd/forces/beam_element.hpp"

namespace subsoil::mbd {

namespace {

constexpr int most_turns = 400;

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

/// What decides whether a residual is small: the machine's weight (or 1 N without gravity) and its moment arms.
struct Measure {
  explicit Measure(const System& system) : n(system.coordinates()), length(system.length_scale()) {
    const auto& g = system.model().gravity;
    double mass = 0;
    for (int i = 0; i < n; i += 3) mass += system.mass()[i];
    weight = std::max(1.0, mass * std::hypot(g[0], g[1]));
  }
  double operator()(const Eigen::VectorXd& r) const {
    const auto m = r.size() - n;
    return r.head(n).cwiseAbs().maxCoeff() / weight + (m ? r.tail(m).cwiseAbs().maxCoeff() / length : 0.0);
  }
  int n;
  double length, weight = 1;
};

/// A step of Newton's method, coordinates scaled, that takes `r` out; `k` is used up. Steps are cut to `longest`.
double newton_step(const Balance& balance, Eigen::MatrixXd& k, Eigen::VectorXd r, double longest, Equilibrium& found) {
  const auto n = found.q.size(), m = found.lambda.size();
  // Length-scaled multipliers are forces: bring rows and columns of both kinds to one size for the rank decision.
  const double stiffness = std::max(1.0, k.topLeftCorner(n, n).cwiseAbs().maxCoeff());
  k.topRightCorner(n, m) *= stiffness, k.bottomLeftCorner(m, n) *= stiffness;
  r.tail(m) *= stiffness;
  const Eigen::VectorXd step = least_norm_solution(k, r, 1e-11);
  const double far = step.head(n).cwiseAbs().maxCoeff();
  const double share = std::min(1.0, longest / std::max(1e-300, far));
  found.q += share * step.head(n).cwiseQuotient(balance.columns());
  found.lambda += share * stiffness * balance.rows().cwiseProduct(step.tail(m));
  return far;
}

/// Newton with pseudo-transient continuation from a guess; true when the balance closes.
bool solve_balance(System& system, Balance& balance, Equilibrium& found) {
  const auto n = system.coordinates(), m = system.equations();
  const Measure size(system);
  const auto& g = system.model().gravity;
  // Pseudo-time so that the first step under gravity is a hundredth of the machine's length.
  double inverse_tau2 = std::max(1.0, std::hypot(g[0], g[1])) / (0.01 * size.length);
  const Eigen::VectorXd inertia = system.mass().cwiseQuotient(balance.columns().cwiseAbs2());
  if (found.lambda.size() != m) found.lambda = Eigen::VectorXd::Zero(m);
  Eigen::VectorXd r = balance.at(found.q, found.lambda);
  double rounding = 0;  // of the stiffest force
  for (int turn = 0; turn < most_turns; ++turn, ++found.iterations) {
    const double before = size(r);
    if (before < 1e-13) break;
    Eigen::MatrixXd k = balance.matrix(found.q, found.lambda);
    rounding = 2e-16 * k.topLeftCorner(n, n).cwiseAbs().maxCoeff() * size.length / size.weight;
    if (inverse_tau2 > 1e-6) k.diagonal().head(n) += inverse_tau2 * inertia;
    newton_step(balance, k, r, 0.05 * size.length, found);
    r = balance.at(found.q, found.lambda);
    const double after = size(r);
    if (!std::isfinite(after)) break;
    if (before < std::max(1e-11, 100 * rounding) && after > 0.5 * before) break;
    inverse_tau2 *= std::clamp(after / before, 0.2, 2.0);
  }
  found.residual = r.head(n).cwiseAbs().maxCoeff();
  return size(r) < std::max(1e-9, 100 * rounding);
}

/// From a pose out of balance by r_0 along the poses that are out of it by (1 - s) r_0, s from 0 to 1: a load that
/// grows. For beams, whose axis is so much stiffer than their bending that Newton's method from afar goes astray.
bool follow_growing_load(System& system, Balance& balance, Equilibrium& found) {
  const Measure size(system);
  found.lambda = Eigen::VectorXd::Zero(system.equations());
  const Eigen::VectorXd r_0 = balance.at(found.q, found.lambda);
  const auto closes = [&](Equilibrium& at, double s) {
    constexpr int iterations = 12;
    for (int i = 0; i < iterations; ++i, ++found.iterations) {
      Eigen::MatrixXd k = balance.matrix(at.q, at.lambda);
      const double far = newton_step(balance, k, balance.at(at.q, at.lambda) - (1 - s) * r_0, size.length, at);
      if (!(far < 0.3 * size.length)) return false;
      if (far < 1e-6 * size.length) return true;
    }
    return false;
  };
  double s = 0, step = 0.125;
  while (s < 1) {
    const double next = std::min(1.0, s + step);
    Equilibrium trial = found;
    if (closes(trial, next)) {
      found.q = trial.q, found.lambda = trial.lambda;
      s = next, step *= 1.5;
    } else if ((step *= 0.25) < 1e-4) {
      return false;
    }
  }
  return true;
}

bool has_beams(const System& system) {
  const auto& forces = system.model().forces;
  return std::any_of(forces.begin(), forces.end(),
                     [](const auto& f) { return f.element.template get_if<BeamElement>(); });
}

void refuse_moving_drivers(const System& system, const Constraints& c, const Equilibrium& found, double speed) {
  const Eigen::VectorXd off = c.jacobian * found.velocity + c.phi_t;
  for (int row = 0; row < system.equations(); ++row) {
    if (std::abs(off[row]) <= 1e-9 * std::max(1.0, std::abs(speed))) continue;
    if (speed == 0)
      throw std::invalid_argument("static equilibrium: " + system.owner(row) + " moves (at " +
                                  std::to_string(std::abs(off[row])) + (system.angular_row(row) ? " rad/s" : " m/s") +
                                  "); hold it still, or ask for a towing equilibrium at its speed");
    throw std::invalid_argument("towing equilibrium at " + std::to_string(speed) + " m/s: " + system.owner(row) +
                                " asks for another velocity (off by " + std::to_string(off[row]) +
                                "); give the towing speed the driver's velocity");
  }
}

}  // namespace

Equilibrium towing_equilibrium(System& system, double t, const Eigen::VectorXd& guess, double speed) {
  Equilibrium found;
  found.q = guess;
  found.velocity = system.towing_velocity(speed);
  const auto hold_states = [&](const Eigen::VectorXd& q) {  // at what they start from
    if (system.state_count() == 0) return;
    system.set_state(t, q, found.velocity);
    system.begin_states();
  };
  hold_states(guess);
  Balance balance(system, t, found.velocity);
  bool closed = false;
  if (has_beams(system)) {
    closed = follow_growing_load(system, balance, found) && solve_balance(system, balance, found);
    if (!closed) found.q = guess, found.lambda.resize(0);
  }
  closed = closed || solve_balance(system, balance, found);
  if (!closed && speed == 0) {
    try {
      found.q = fall_to_rest(system, t, guess), found.lambda.resize(0);
      hold_states(found.q);
      closed = solve_balance(system, balance, found);
    } catch (const BlowUp&) {  // nothing holds it
      found.q = guess;
    }
  }
  if (!closed)
    throw std::runtime_error(std::string(speed == 0 ? "no static" : "no steady") +
                             " equilibrium found near the start pose: " + std::to_string(found.residual) +
                             " N stay unbalanced after " + std::to_string(found.iterations) +
                             " iterations; start nearer to it, or take the pose as given");
  refuse_moving_drivers(system, balance.constraints(), found, speed);
  return found;
}

namespace {

/// The equations of motion in the independent coordinates about a steady state.
class Linearisation {
 public:
  Linearisation(System& system, double t, const Equilibrium& at) : partition_(system) {
    at_.t = t, at_.q = at.q, at_.velocity = at.velocity;
    at_.acceleration = Eigen::VectorXd::Zero(at.q.size());
    at_.lambda = Eigen::VectorXd::Zero(system.equations());
    at_.rates = Eigen::VectorXd::Zero(system.rate_count());
    at_.states = Eigen::Map<const Eigen::VectorXd>(system.element_states().data(),
                                                   static_cast<Eigen::Index>(system.state_count()));
    partition_.choose(at_);
    scale_ = coordinate_scale(system), scales_ = system.state_scales();
    length_ = system.length_scale();
  }
  Eigen::Index freedom() const { return partition_.freedom(); }

  /// d(v, v', x)' = A d(v, v', x), x the states of elements. Steps of 1e-4 of a length at order 4: truncation and
  /// rounding both near 1e-12 of the stiffness. Velocities enter dampers linearly and friction steeply: short steps of
  /// order 2.
  Eigen::MatrixXd matrix() {
    const auto f = freedom(), states = at_.states.size();
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * f + states, 2 * f + states);
    a.block(0, f, f, f).setIdentity();
    for (Eigen::Index j = 0; j < f; ++j) {
      const double far = 1e-4 * unit(j), near = 1e-6 * unit(j);
      const auto slope = [&](bool rate, double step) {
        return Eigen::VectorXd((acceleration(j, rate, step) - acceleration(j, rate, -step)) / (2 * step));
      };
      a.col(j).tail(f + states) = (4 * slope(false, far) - slope(false, 2 * far)) / 3;
      a.col(f + j).tail(f + states) = slope(true, near);
    }
    for (Eigen::Index j = 0; j < states; ++j) {
      const double step = 1e-4 * (scales_[static_cast<std::size_t>(j)] + std::abs(at_.states[j]));
      MotionState plus = at_, minus = at_;
      plus.states[j] += step, minus.states[j] -= step;
      a.col(2 * f + j).tail(f + states) = (rates_at(plus) - rates_at(minus)) / (2 * step);
    }
    return a;
  }

  /// dq/dv: how all coordinates follow the independent ones.
  Eigen::MatrixXd tangent() {
    Eigen::MatrixXd out(at_.q.size(), freedom());
    for (Eigen::Index j = 0; j < freedom(); ++j) {
      MotionState still = at_, moving = at_;
      moving.velocity[independent(j)] += 1;
      partition_.evaluate(still);
      partition_.evaluate(moving);
      out.col(j) = moving.velocity - still.velocity;
    }
    return out;
  }

  /// The real largest entry that makes shapes comparable.
  Eigen::VectorXcd normal(Eigen::VectorXcd shape) const {
    Eigen::Index largest = 0;
    shape.cwiseProduct(scale_).cwiseAbs().maxCoeff(&largest);
    return shape / shape[largest];
  }

 private:
  int independent(Eigen::Index j) const { return partition_.independent()[static_cast<std::size_t>(j)]; }
  double unit(Eigen::Index j) const { return length_ / scale_[independent(j)]; }
  Eigen::VectorXd acceleration(Eigen::Index which, bool rate, double shift) {
    MotionState s = at_;
    (rate ? s.velocity : s.q)[independent(which)] += shift;
    return rates_at(s);
  }
  /// Of v' and x.
  Eigen::VectorXd rates_at(MotionState s) {
    partition_.evaluate(s);
    Eigen::VectorXd out(freedom() + s.states.size());
    for (Eigen::Index i = 0; i < freedom(); ++i) out[i] = s.acceleration[independent(i)];
    out.tail(s.states.size()) = s.rates.tail(s.states.size());
    return out;
  }

  Partition partition_;
  MotionState at_;
  Eigen::VectorXd scale_;
  std::vector<double> scales_;
  double length_ = 1;
};

}  // namespace

std::vector<Mode> modes(System& system, double t, const Equilibrium& at) {
  Linearisation linear(system, t, at);
  const auto f = linear.freedom();
  std::vector<Mode> found;
  if (f == 0) return found;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(linear.matrix());
  const Eigen::MatrixXd tangent = linear.tangent();
  // A coordinate that nothing holds (a free wheel) has two zero eigenvalues, which rounding splits: one zero mode.
  // Rounding of 1e-12 in the stiffness is 1e-6 in its root.
  const double zero = 1e-5 * std::max(1.0, solver.eigenvalues().cwiseAbs().maxCoeff());
  int zeros = 0;
  const bool states = system.state_count() > 0;
  for (Eigen::Index i = 0; i < solver.eigenvalues().size(); ++i) {
    const auto s = solver.eigenvalues()[i];
    if (std::abs(s) < zero) {  // of states they are what a lock-up of oil or a
                               // held integral leaves, not coordinates
      if (!states && zeros++ % 2 == 0) found.emplace_back();
    } else if (s.imag() >= 0) {
      const Eigen::VectorXcd shape = tangent.cast<std::complex<double>>() * solver.eigenvectors().col(i).head(f);
      found.push_back(
          {s.imag() / (2 * std::numbers::pi), 0.0 - s.real() / std::abs(s), s.real(), linear.normal(shape)});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Mode& x, const Mode& y) { return x.frequency < y.frequency; });
  return found;
}

StabilityReport stability(const std::vector<Mode>& modes) {
  StabilityReport report;
  for (const Mode& m : modes) {
    if (m.is_zero()) ++report.neutral;
    // An undamped oscillation has a real part of rounding, 1e-12 of its modulus, of either sign.
    if (m.damping < -1e-7) report.unstable += m.frequency > 0 ? 2 : 1;
  }
  report.kind = report.unstable ? Stability::unstable : report.neutral ? Stability::neutral : Stability::stable;
  return report;
}

}  // namespace subsoil::mbd
