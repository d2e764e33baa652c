#include "libmbd/equilibrium/equilibrium.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/partition.hpp"
#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/base/dense.hpp"
#include "libmbd/base/slope.hpp"
#include "libmbd/equilibrium/relaxation.hpp"
#include "libmbd/forces/beam_element.hpp"
#include "libmbd/integrators/events.hpp"

namespace subsoil::mbd {

namespace {

constexpr int most_turns = 400;
constexpr double longest_time = 1e6;  // of pseudo-time: rates that are slower count as none (s)
constexpr double touching = 1e-9;     // of the machine's length: contacts this near touch
constexpr double nearby = 1e-2;       // of the machine's length: poses that a contact's strain leads to

/// The machine's weight, in N; without gravity 1 N.
double weight_of(const System& system) {
  const double weight = system.model().weight();
  return weight > 0 ? weight : 1;
}

/// The balance of all coordinates, constraints and states at a steady state, scaled to forces, lengths and rates.
class Balance {
 public:
  Balance(System& system, double t, Equilibrium& at)
      : system_(system),
        t_(t),
        n_(system.coordinates()),
        m_(system.equations()),
        s_(static_cast<Eigen::Index>(system.state_count())),
        weight_(weight_of(system)),
        columns_(coordinate_scale(system)),
        rows_(row_scale(system)),
        load_(n_),
        still_(Eigen::VectorXd::Zero(n_)),
        spins_(static_cast<std::size_t>(n_), Spin::none) {
    find_spins(at);
  }

  /// (F - Phi_q^T lambda, -Phi, x').
  Eigen::VectorXd at(const Equilibrium& u) {
    set(u, u.velocity);
    system_.constraints(c_);
    Eigen::VectorXd out(n_ + m_ + s_);
    out.head(n_) = columns_.cwiseInverse().cwiseProduct(load_ - c_.jacobian.transpose() * u.lambda);
    for (Eigen::Index i = 0; i < n_; ++i)
      if (spin(i) == Spin::held) out[i] = 0;
    out.segment(n_, m_) = -rows_.cwiseProduct(c_.phi);
    if (s_ > 0) out.tail(s_) = rates(u);
    return out;
  }

  /// Between two poses, the maximum of any coordinate, angles times the machine's length (m).
  double distance(const Equilibrium& from, const Equilibrium& to) const {
    return (to.q - from.q).cwiseProduct(columns_).cwiseAbs().maxCoeff();
  }
  /// Of the forces evaluated last on any coordinate, scaled.
  double largest_load() const { return load_.cwiseQuotient(columns_).cwiseAbs().maxCoeff(); }

  /// What an implicit step of Euler's method from `from` to u leaves, of length `tau` for bodies and `dt` for states:
  ///   F - Phi_q^T lambda - M (q - q_0)/tau^2,  -Phi,  x' + what the way adds - (x - x_0)/dt
  /// The way from q_0 to q adds the mean of x'(v) - x'(0) along it, at the velocity v = (q - q_0)/dt, by Gauss's rule:
  /// oil that is locked in then has the pressure of its volume, whatever the steps were.
  Eigen::VectorXd after_step(const Equilibrium& from, const Equilibrium& u, const Eigen::VectorXd& inertia, double dt) {
    Eigen::VectorXd out = at(u), way = u.q - from.q;
    for (Eigen::Index j = 0; j < n_; ++j)
      if (spin(j) == Spin::none) out[j] -= inertia[j] * columns_[j] * way[j];
    if (s_ == 0) return out;
    constexpr std::array<double, 4> nodes{0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                          0.9305681557970263};
    constexpr std::array<double, 4> weights{0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                            0.17392742256872693};
    Equilibrium between = u;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      between.q = from.q + nodes[k] * way, between.states = from.states + nodes[k] * (u.states - from.states);
      set(between, u.velocity + way / dt);
      const Eigen::VectorXd moving = rates(between);
      set(between, u.velocity);
      out.tail(s_) += weights[k] * (moving - rates(between));
    }
    out.tail(s_) -= (u.states - from.states) / dt;
    set(u, u.velocity);
    return out;
  }

  /// -d(balance)/d(q, lambda, x), all scaled, by differences: a law only has to be evaluated. States come with
  /// d(x - x_0)/dt - x' for what they do in the time `dt`, as the coordinates move from where they are.
  Eigen::MatrixXd matrix(const Equilibrium& u, double dt) {
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n_ + m_ + s_, n_ + m_ + s_);
    const Eigen::VectorXd r = at(u);
    const double step = 1e-7 * system_.length_scale();
    const auto shifted = [&](auto shift) {
      return [this, &u, shift](double by) {
        Equilibrium v = u;
        shift(v, by);
        return at(v);
      };
    };
    for (Eigen::Index j = 0; j < n_; ++j) {
      if (spin(j) == Spin::held) continue;
      const auto moves = [this, j](Eigen::VectorXd& x, double by) { x[j] += by / columns_[j]; };
      const auto of_place =
          shifted([&](Equilibrium& v, double by) { moves(spin(j) == Spin::none ? v.q : v.velocity, by); });
      take(k, j, -rough_slope(of_place, r, step));
      if (s_ == 0 || spin(j) != Spin::none) continue;
      const auto of_rate = shifted([&](Equilibrium& v, double by) { moves(v.velocity, by); });
      k.col(j).tail(s_) -= rough_slope(of_rate, r, step).tail(s_) / dt;
    }
    at(u);
    const Eigen::MatrixXd jacobian = scaled_jacobian(system_, c_);
    k.block(0, n_, n_, m_) = jacobian.transpose();
    k.block(n_, 0, m_, n_) = jacobian;
    for (Eigen::Index j = 0; j < n_; ++j) {
      if (spin(j) == Spin::held) k.row(j).setZero();
      if (spin(j) != Spin::none) k.col(j).segment(n_, m_).setZero();
    }
    if (!system_.friction_rows().empty() || controllers_read_reactions(system_))
      for (Eigen::Index j = 0; j < m_; ++j) {
        const auto pressed = shifted([&](Equilibrium& v, double by) { v.lambda[j] += by * rows_[j]; });
        const Eigen::VectorXd slope =
            rough_slope(pressed, r, 1e-6 * std::max(weight_, std::abs(u.lambda[j] / rows_[j])));
        k.col(n_ + j).head(n_) = -slope.head(n_), k.col(n_ + j).tail(s_) = -slope.tail(s_);
      }
    for (Eigen::Index j = 0; j < s_; ++j) {
      const double scale = state_size(u, j);
      const auto charged = shifted([&](Equilibrium& v, double by) { v.states[j] += by * scale; });
      const Eigen::VectorXd slope = rough_slope(charged, r, step);
      k.col(n_ + m_ + j).head(n_) = -slope.head(n_), k.col(n_ + m_ + j).tail(s_) = -slope.tail(s_);
      k(n_ + m_ + j, n_ + m_ + j) += scale / dt;
    }
    at(u);
    return k;
  }

  /// Angular velocities at which the moments on what spins vanish with all else as it is: a rate that friction
  /// saturates has no slope that Newton's method could follow.
  void settle_spins(Equilibrium& u) {
    for (Eigen::Index j = 0; j < n_; ++j)
      if (spin(j) == Spin::free) settle_spin(u, j);
  }

  /// Share of a change of a state that counts as much as the same share of the machine's length.
  double state_size(const Equilibrium& u, Eigen::Index j) const {
    return (system_.state_scales()[static_cast<std::size_t>(j)] + std::abs(u.states[j])) / system_.length_scale();
  }
  bool is_spin(Eigen::Index j) const { return spin(j) != Spin::none; }
  const Constraints& constraints() const { return c_; }
  const Eigen::VectorXd& columns() const { return columns_; }
  const Eigen::VectorXd& rows() const { return rows_; }
  Eigen::Index coordinates() const { return n_; }
  Eigen::Index equations() const { return m_; }
  Eigen::Index states() const { return s_; }

 private:
  /// Of an angle: none: it is unknown; free: its rate is unknown; held: both stay.
  enum class Spin : char { none, free, held };
  Spin spin(Eigen::Index j) const { return spins_[static_cast<std::size_t>(j)]; }

  /// In a tow, angles that no constraint and no force depends on. Those that are free begin at the model's spin.
  void find_spins(Equilibrium& u) {
    if (u.velocity.isZero(0)) return;
    const Eigen::VectorXd r = at(u);
    const Eigen::MatrixXd jacobian = scaled_jacobian(system_, c_);
    const std::vector<char> held = system_.towed_spins();
    const double step = 1e-4 * system_.length_scale();
    for (Eigen::Index j = 2; j < n_; j += 3) {
      if (jacobian.rows() > 0 && jacobian.col(j).cwiseAbs().maxCoeff() > 1e-12) continue;
      Equilibrium turned = u;
      turned.q[j] += step / columns_[j];
      if ((at(turned) - r).cwiseAbs().maxCoeff() > 1e-9 * std::max(weight_, r.cwiseAbs().maxCoeff())) continue;
      const bool is_held = held[static_cast<std::size_t>(j / 3)] != 0;
      spins_[static_cast<std::size_t>(j)] = is_held ? Spin::held : Spin::free;
      if (!is_held) u.velocity[j] = system_.start_velocity()[j];
    }
  }

  void settle_spin(Equilibrium& u, Eigen::Index j) {
    constexpr int most_doublings = 60, most_halvings = 200;
    const auto moment = [&](double rate) {
      u.velocity[j] = rate;
      return at(u)[j];
    };
    const double begin = u.velocity[j], pull = moment(begin);
    double step = std::copysign(1e-3 * (1 + std::abs(begin)), pull), low = begin, high = begin;
    for (int i = 0; pull != 0 && i < most_doublings; ++i, step *= 2) {
      high = low + step;
      if (moment(high) * pull <= 0) break;
      low = high, high = begin;
    }
    if (high == begin) {  // nothing brakes it
      u.velocity[j] = begin;
      return;
    }
    for (int i = 0; i < most_halvings && std::abs(high - low) > 4e-16 * std::abs(low); ++i) {
      const double middle = 0.5 * (low + high);
      if (middle == low || middle == high) break;
      (moment(middle) * pull > 0 ? low : high) = middle;
    }
    u.velocity[j] = 0.5 * (low + high);
  }

  void set(const Equilibrium& u, const Eigen::VectorXd& velocity) {
    system_.set_state(t_, u.q, velocity);
    if (s_ > 0) system_.set_element_states(u.states);
    if (!system_.friction_rows().empty()) system_.set_multipliers(u.lambda);
    system_.loads(load_);
  }
  /// Rates of states, after loads().
  Eigen::VectorXd rates(const Equilibrium& u) {
    const std::vector<double>& x = system_.take_state_rates(still_, u.lambda);
    return Eigen::Map<const Eigen::VectorXd>(x.data(), s_);
  }

  void take(Eigen::MatrixXd& k, Eigen::Index j, const Eigen::VectorXd& slope) const {
    k.col(j).head(n_) = slope.head(n_), k.col(j).tail(s_) = slope.tail(s_);
  }

  System& system_;
  double t_;
  Eigen::Index n_, m_, s_;
  double weight_;
  Eigen::VectorXd columns_, rows_, load_, still_;
  std::vector<Spin> spins_;
  Constraints c_;
};

/// What decides whether a residual is small: the machine's weight, its moment arms, and of the rate of a state what
/// changes it by as much as a length of the machine.
struct Measure {
  explicit Measure(const System& system)
      : n(system.coordinates()),
        m(system.equations()),
        length(system.length_scale()),
        weight(weight_of(system)),
        sizes(static_cast<Eigen::Index>(system.state_count())) {
    for (Eigen::Index i = 0; i < sizes.size(); ++i)
      sizes[i] = system.state_scales()[static_cast<std::size_t>(i)] / length;
  }
  /// Sizes of the rates of states from the balance's matrix without the share of time: the largest change of the rate
  /// by any unknown.
  void take_sizes(const Eigen::MatrixXd& k, const Balance& balance, const Equilibrium& u, double dt) {
    for (Eigen::Index i = 0; i < sizes.size(); ++i) {
      Eigen::VectorXd row = k.row(n + m + i);
      row[n + m + i] -= balance.state_size(u, i) / dt;
      const double largest = row.cwiseAbs().maxCoeff();
      if (largest > 0) sizes[i] = largest;
    }
  }
  double operator()(const Eigen::VectorXd& r) const {
    double size = r.head(n).cwiseAbs().maxCoeff() / weight;
    if (m > 0) size += r.segment(n, m).cwiseAbs().maxCoeff() / length;
    return size + of_states(r);
  }
  double of_states(const Eigen::VectorXd& r) const {
    if (sizes.size() == 0) return 0;
    return r.tail(sizes.size()).cwiseQuotient(sizes).cwiseAbs().maxCoeff() / length;
  }
  Eigen::Index n, m;
  double length, weight;
  Eigen::VectorXd sizes;
};

/// How far a step goes, of coordinates and of states, before it is cut.
struct Way {
  double coordinates = 0, states = 0;
};

/// A step of Newton's method, coordinates scaled, that takes `r` out; `k` is used up. Steps are cut to `longest`.
Way newton_step(const Balance& balance, Eigen::MatrixXd& k, Eigen::VectorXd r, double longest, Equilibrium& found) {
  const auto n = balance.coordinates(), m = balance.equations(), s = balance.states();
  // Length-scaled multipliers are forces: bring rows and columns of all kinds to one size for the rank decision.
  const double stiffest = k.topLeftCorner(n, n).cwiseAbs().maxCoeff(), stiffness = stiffest > 0 ? stiffest : 1;
  k.middleCols(n, m) *= stiffness, k.block(n, 0, m, n) *= stiffness;
  r.segment(n, m) *= stiffness;
  Eigen::VectorXd charge = Eigen::VectorXd::Ones(s);
  for (Eigen::Index j = 0; j < s; ++j) {
    const double push = k.col(n + m + j).head(n).cwiseAbs().maxCoeff();
    if (push > 0) charge[j] = stiffness / push, k.col(n + m + j) *= charge[j];
  }
  for (Eigen::Index i = n + m; i < n + m + s; ++i) {
    const double factor = stiffness / k.row(i).cwiseAbs().maxCoeff();  // never 0: time has its share
    k.row(i) *= factor, r[i] *= factor;
  }
  const Eigen::VectorXd step = least_norm_solution(k, r, 1e-11);
  double far = 0;
  for (Eigen::Index j = 0; j < n; ++j)
    if (!balance.is_spin(j)) far = std::max(far, std::abs(step[j]));
  const double share = std::min(1.0, longest / std::max(1e-300, far));
  for (Eigen::Index j = 0; j < n; ++j)
    (balance.is_spin(j) ? found.velocity : found.q)[j] += share * step[j] / balance.columns()[j];
  found.lambda += share * stiffness * balance.rows().cwiseProduct(step.segment(n, m));
  Way way{far};
  for (Eigen::Index j = 0; j < s; ++j) {
    const double charged = charge[j] * step[n + m + j];
    way.states = std::max(way.states, std::abs(charged));
    found.states[j] += share * balance.state_size(found, j) * charged;
  }
  return way;
}

/// Newton with pseudo-transient continuation from a guess; true when the balance closes.
bool solve_balance(System& system, Balance& balance, Equilibrium& found) {
  const auto n = balance.coordinates(), m = balance.equations();
  Measure size(system);
  const Equilibrium start = found;
  const double g = std::hypot(system.model().gravity[0], system.model().gravity[1]);
  // Pseudo-time so that the first step under gravity is a hundredth of the machine's length.
  double inverse_tau2 = (g > 0 ? g : 1) / (0.01 * size.length);
  const Eigen::VectorXd inertia = system.mass().cwiseQuotient(balance.columns().cwiseAbs2());
  if (found.lambda.size() != m) found.lambda = Eigen::VectorXd::Zero(m);
  constexpr int most_shortened = 40;
  int shortened = 0;
  double rounding = 0;  // of the stiffest force and of the largest
  Eigen::VectorXd r;
  for (int turn = 0; turn < most_turns; ++turn, ++found.iterations) {
    balance.settle_spins(found);
    const double inverse_tau = std::sqrt(inverse_tau2), dt = 1 / std::max(inverse_tau, 1 / longest_time);
    Eigen::MatrixXd k = balance.matrix(found, dt);
    size.take_sizes(k, balance, found, dt);
    r = balance.at(found);
    const double before = size(r);
    if (before < 1e-13) break;
    const double farthest = std::max(size.length, found.q.cwiseAbs().maxCoeff());  // of places
    rounding =
        2e-16 * std::max(k.topLeftCorner(n, n).cwiseAbs().maxCoeff() * farthest, balance.largest_load()) / size.weight;
    Eigen::VectorXd added = Eigen::VectorXd::Zero(n);
    if (inverse_tau2 > 1e-6)
      for (Eigen::Index j = 0; j < n; ++j) added[j] = (balance.is_spin(j) ? inverse_tau : inverse_tau2) * inertia[j];
    // Without states the step need not be solved to the end. With them it is, or it is made shorter: what they conserve
    // must not be lost.
    const Equilibrium from = found;
    bool solved = balance.states() == 0;
    for (int i = 0; i < (solved ? 1 : 12); ++i) {
      if (i > 0) k = balance.matrix(found, dt), r = balance.after_step(from, found, added, dt);
      k.diagonal().head(n) += added;
      const Way way = newton_step(balance, k, r, 0.05 * (size.length + balance.distance(start, found)), found);
      if (balance.states() > 0 && std::max(way.coordinates, way.states) < 1e-10 * size.length) {
        solved = true;
        break;
      }
    }
    if (!solved && ++shortened < most_shortened) {
      found = from, r = balance.at(found);
      inverse_tau2 *= 16;
      continue;
    }
    r = balance.at(found);
    const bool touched = system.follow_touches(touching * size.length);
    if (touched) r = balance.at(found);
    const double after = size(r);
    // Forces balance and a slow state leads them along (an integral with a small gain): how slow it is has no say in
    // where it leads to, so its steps grow though the residual hardly falls.
    const bool led = solved && !touched && balance.states() > 0 && size.of_states(r) > 0.9 * after;
    if (!std::isfinite(after)) break;
    if (!touched && before < std::max(1e-11, 100 * rounding) && after > 0.5 * before) break;
    inverse_tau2 *= std::clamp(led ? 0 : after / before, 0.2, 2.0);
  }
  found.residual = r.head(n).cwiseAbs().maxCoeff();
  return size(r) < std::max(1e-9, 100 * rounding);
}

/// From a pose out of balance by r_0 along the poses that are out of it by (1 - s) r_0, s from 0 to 1: a load that
/// grows. For beams, whose axis is so much stiffer than their bending that Newton's method from afar goes astray.
bool follow_growing_load(System& system, Balance& balance, Equilibrium& found) {
  const Measure size(system);
  found.lambda = Eigen::VectorXd::Zero(system.equations());
  Eigen::VectorXd r_0 = balance.at(found);
  r_0.tail(balance.states()).setZero();
  const auto closes = [&](Equilibrium& at, double s) {
    constexpr int iterations = 12;
    for (int i = 0; i < iterations; ++i, ++found.iterations) {
      Eigen::MatrixXd k = balance.matrix(at, longest_time);
      const double far = newton_step(balance, k, balance.at(at) - (1 - s) * r_0, size.length, at).coordinates;
      if (!(far < 0.3 * size.length)) return false;
      if (far < 1e-6 * size.length) return true;
    }
    return false;
  };
  double s = 0, step = 0.125;
  while (s < 1) {
    const double next = std::min(1.0, s + step);
    Equilibrium further = found;
    if (closes(further, next)) {
      further.iterations = found.iterations;
      found = further;
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
      throw ModelFault(system.part(row), "static equilibrium: " + system.owner(row) + " moves (at " +
                                             std::to_string(std::abs(off[row])) +
                                             (system.angular_row(row) ? " rad/s" : " m/s") +
                                             "); hold it still, or ask for a towing equilibrium at its speed");
    throw ModelFault(system.part(row), "towing equilibrium at " + std::to_string(speed) + " m/s: " + system.owner(row) +
                                           " asks for another velocity (off by " + std::to_string(off[row]) +
                                           "); give the towing speed the driver's velocity");
  }
}

/// "; force 'lift' keeps changing by 3e4 of pressure a in a second": the state whose rate is the largest over its size.
std::string drifting_state(const System& system, const Eigen::VectorXd& r) {
  const auto first = system.coordinates() + system.equations();
  Eigen::Index worst = -1;
  double most = 1e-6;
  for (Eigen::Index i = 0; i < r.size() - first; ++i) {
    const double rate = std::abs(r[first + i]) / system.state_scales()[static_cast<std::size_t>(i)];
    if (rate > most) most = rate, worst = i;
  }
  if (worst < 0) return "";
  return ", and a state of " + system.state_owner(static_cast<std::size_t>(worst)) + " keeps changing by " +
         std::to_string(r[first + worst]) + " in a second";
}

/// Whether all that sticks at the state set last is within the limits of its friction, by more than its rounding.
bool friction_holds(const System& system) {
  Switches switches(system);
  std::vector<double> margins(switches.count());
  switches.gaps(margins);
  for (std::size_t i = 0; i < margins.size(); ++i)
    if (switches.of_friction(i) && margins[i] < 0) return false;
  return true;
}

/// ", give friction 'pad' a `stick stiffness`, without which it holds nothing at rest", where there is any.
std::string stiction_missing(const System& system, double speed) {
  const std::vector<std::string> names = system.creeping();
  if (speed != 0 || names.empty()) return "";
  std::string out = ", give the friction of ";
  for (std::size_t i = 0; i < names.size(); ++i) out += (i ? ", '" : "'") + names[i] + "'";
  return out + " a `stick stiffness` (without one it holds nothing at rest)";
}

}  // namespace

Equilibrium towing_equilibrium(System& system, double t, const Eigen::VectorXd& guess, double speed) {
  Equilibrium start;
  start.q = guess;
  start.velocity = system.towing_velocity(speed);
  start.lambda = Eigen::VectorXd::Zero(system.equations());
  system.set_start_states({});
  system.set_state(t, guess, start.velocity);
  const std::vector<double>& x = system.begin_states();
  start.states = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  const double close = touching * system.length_scale();
  system.follow_touches(close, true);
  Balance balance(system, t, start);
  Equilibrium found = start;
  const auto begin_again = [&](const Rest& from) {
    start.iterations = found.iterations, found = start;
    found.q = from.q, found.states = from.states;
    balance.at(found);
    system.follow_touches(close, true);
    if (!from.grips.empty()) system.set_grips(from.grips);
  };
  std::string falls;
  bool closed = false;
  if (has_beams(system)) {
    closed = follow_growing_load(system, balance, found) && solve_balance(system, balance, found);
    if (!closed) begin_again({start.q, start.states});
  }
  closed = closed || solve_balance(system, balance, found);
  const auto moved = [&] {
    return (found.q - guess).cwiseProduct(coordinate_scale(system)).cwiseAbs().maxCoeff() / system.length_scale();
  };
  const auto holds = [&] {
    balance.at(found);
    return friction_holds(system);
  };
  // Newton's steps may lead through contacts to a pose far away, though what sticks would hold the machine nearer.
  const bool may_be_nearer = closed && speed == 0 && needs_events(system.model()) && (moved() > nearby || !holds());
  if ((!closed && speed == 0) || may_be_nearer) {
    const Equilibrium first = found;
    const System::Grips first_grips = system.grips();
    const bool first_holds = closed && holds();
    const double first_moved = moved();
    closed = false;
    try {
      begin_again(fall_to_rest(system, t, guess));
      closed = solve_balance(system, balance, found);
    } catch (const BlowUp&) {  // nothing holds it
    } catch (const std::runtime_error&) {
      falls = ", and released there it falls into a pose from which it cannot move";
    }
    if (may_be_nearer && (!closed || !holds() || (first_holds && moved() > first_moved))) {
      closed = true, found = first;
      balance.at(found);
      system.set_grips(first_grips);
    }
  }
  char residual[32];
  std::snprintf(residual, sizeof residual, "%.4g", found.residual);
  if (!closed)
    throw std::runtime_error(std::string(speed == 0 ? "no static" : "no steady") +
                             " equilibrium found near the start pose: " + residual + " N stay unbalanced after " +
                             std::to_string(found.iterations) + " iterations" +
                             drifting_state(system, balance.at(found)) + falls + "; start nearer to it" +
                             stiction_missing(system, speed) + ", or take the pose as given");
  balance.at(found);
  found.grips = system.grips();
  refuse_moving_drivers(system, balance.constraints(), found, speed);
  return found;
}

}  // namespace subsoil::mbd
