#include "libmbd/assembly/partition.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/base/dense.hpp"

namespace subsoil::mbd {

namespace {
// A pivot that has lost a factor of ten costs one digit only, and a new choice costs an elimination, so choosing is
// lazy.
constexpr double lazy_limit = 10;
// At an angle e from a singular pose a pivot of Phi_u falls as e and one of S, over its diagonal, as e^2. Either alone
// may be small for another reason: Phi_u by a choice that has had its time, S by bodies of very different mass. Nearer
// than 1e-6 rad rounding takes more than the third digit of the velocities.
struct Nearness {
  double pivot, share;
};
constexpr Nearness near_pose{0.05, 1e-2}, singular_pose{1e-5, 1e-12};
// Above it accelerations come from M^: S need not be asked how near a singular pose is (Adaptive stays beside one up to
// 0.15), and M^ has the square of R, so that rounding grows beside flat poses (two four-bar windows,
// IFToMM A02: 2e-8 J of kinetic energy with 0.2, 3e-11 J with 0.6). The rig stays above it.
constexpr double sure_pivot = 0.6;
// Freedoms up to which M^ is formed: a handful. A pendulum of six bars, which has nothing but freedoms, gains nothing.
constexpr Eigen::Index few_freedoms = 6;
// Factors of a pose this far away (lengths of the machine) still serve; they leave at most ten times the distance of a
// right side, and those of M^ no less than rounding does: where that is below the goal there is nothing to look at
// again.
constexpr double near_enough = 1e-7, left_by_distance = 10, left_by_rounding = 1e-12;
// Of a residual, over the size of its terms.
constexpr double rounding = 2e-16;
// A predictor errs by a small share of the velocities; another branch turns or stops some of them.
constexpr double most_turn = 0.3;
constexpr double rest_speed = 1e-8;  // lengths of the machine in a second
// Friction returns about mu times a ratio of moment arms of a change of the reaction: passes settle by that share each.
// Newton's method needs a pass per equation and step, two steps as a rule, and finds the share itself.
constexpr int most_friction_steps = 20, most_patient_passes = 600;
// Of the largest multiplier, for slopes by differences: T is piecewise linear in slides and smooth in pins.
constexpr double friction_difference = 1e-6;

template <std::size_t count>
using Count = std::integral_constant<std::size_t, count>;
template <std::size_t count>
using Few = Eigen::Vector<double, static_cast<int>(count)>;
template <std::size_t count>
using Square = Eigen::Matrix<double, static_cast<int>(count), static_cast<int>(count)>;
template <std::size_t count>
using ConstRow = Eigen::Map<const Few<count>>;

/// action(Count<freedom>), 1 to few_freedoms: vectors of a known length cost a third.
template <std::size_t count = 1, class Action>
void with_freedom(Eigen::Index freedom, Action action) {
  if (freedom == static_cast<Eigen::Index>(count)) return action(Count<count>{});
  if constexpr (count < few_freedoms) with_freedom<count + 1>(freedom, action);
}

std::string scientific(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2e", value);
  return text;
}

// Redundant constraints that no longer agree: of drivers, or of joints that do not fit.
std::string parted_constraints(const System& system, const Dependency& dependency) {
  std::vector<std::string> names{system.owner(dependency.row)};
  for (const int on : dependency.on)
    if (std::find(names.begin(), names.end(), system.owner(on)) == names.end()) names.push_back(system.owner(on));
  std::string all;
  for (std::size_t i = 0; i < names.size(); ++i)
    all += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  const auto is_driver = [&](int row) { return system.part(row).kind == PartName::Kind::driver; };
  const bool driven = is_driver(dependency.row) || std::any_of(dependency.on.begin(), dependency.on.end(), is_driver);
  return all + " depend on each other and ask for different motions from here on; " +
         (driven ? "drop a driver, or give them the same motion" : "free the constraint that is too many");
}

// Of a pose beside a singular configuration, where the equation `row` adds the least to the others.
/// Whose rows leave no other way, and which drivers ask for one.
std::string dead_centre(const System& system, const std::string& owner, const char* adds,
                        const std::vector<double>& phi_t) {
  std::string drivers;
  for (std::size_t d = 0; d < system.model().drivers.size(); ++d) {
    const int of = system.row_of_driver(d);
    if (phi_t[static_cast<std::size_t>(of)] != 0) drivers += (drivers.empty() ? "" : ", ") + system.owner(of);
  }
  return owner + " adds " + adds +
         " to the other constraints there: the machine is beside a singular configuration (a dead centre, or links in "
         "line)" +
         (drivers.empty() ? "" : ", beyond which " + drivers + " leads; end that motion before, or drive another body");
}

void refuse_undetermined_friction(const System& system, const Choice& choice) {
  for (const int friction : system.friction_rows())
    for (const Dependency& d : choice.dependencies)
      if (d.has(friction) || d.has(friction + 1))
        throw ModelFault(system.part(friction),
                         "friction in " + system.owner(friction) +
                             " needs its reaction, which is not determined: " + system.owner(d.row) +
                             " depends on other constraints; free the constraint that is too many");
}
}  // namespace

void refuse_blow_up(const System& system, const MotionState& m) {
  const double length = std::max(system.length_scale(), 1.0);
  for (Eigen::Index i = 0; i < m.q.size(); ++i) {
    // A shaft at a constant rate gets as far in time; what blows up has gone all its way within a tenth of the time.
    const double start = system.model().bodies[static_cast<std::size_t>(i / 3)].pose[static_cast<std::size_t>(i % 3)];
    const double moved = std::abs(m.q[i] - start), speed = std::abs(m.velocity[i]);
    const bool steady = moved <= 1e6 * length || speed * m.t <= 10 * moved;
    if (steady && speed <= 1e7 * length) continue;
    throw BlowUp(m.t,
                 "the motion blows up, body '" + system.body_name(static_cast<int>(i / 3) + 1) + "' is at " +
                     scientific(m.q[i]) + (i % 3 == 2 ? " rad with " : " m with ") + scientific(m.velocity[i]) +
                     (i % 3 == 2 ? " rad/s" : " m/s") +
                     ", beyond a million lengths of the machine from its start within a tenth of the time, or ten "
                     "million in a second; the step is too long for the stiffest spring, or a force feeds the motion "
                     "without bound",
                 MotionFault::Cause::blow_up);
  }
}

Partition::Partition(System& system)
    : system_(system),
      row_scale_(mbd::row_scale(system)),
      column_scale_(coordinate_scale(system)),
      inverse_mass_(system.mass().cwiseInverse()),
      load_(system.coordinates()),
      free_(system.coordinates()),
      lambda_before_(system.equations()) {
  factored_at_.setConstant(system.coordinates(), std::numeric_limits<double>::quiet_NaN());
}

void Partition::choose(const MotionState& at) {
  system_.set_state(at.t, at.q, at.velocity);
  system_.constraints(c_);
  Choice choice = choose_coordinates(system_, c_);
  // Rows of joints that have opened since are zero, and no loss.
  const auto stands = [&](int row) {
    return std::any_of(c_.jacobian.begin() + static_cast<std::ptrdiff_t>(system_.first_block(row)),
                       c_.jacobian.begin() + static_cast<std::ptrdiff_t>(system_.first_block(row + 1)),
                       [](const auto& block) { return block != std::array<double, 3>{}; });
  };
  const auto rank_before =
      system_.has_joint_events()
          ? static_cast<std::size_t>(std::count_if(choice_.rows.begin(), choice_.rows.end(), stands))
          : choice_.rows.size();
  if (choices_ > 0 && choice.rows.size() < rank_before)
    throw SingularPose("singular pose at t = " + std::to_string(at.t) + " s: the constraints lose " +
                       std::to_string(static_cast<long>(rank_before - choice.rows.size())) + " of their rank, at " +
                       system_.owner(choice.redundant.back()) +
                       " (a singular configuration); the motion is not determined from here");
  take(std::move(choice));
  refuse_undetermined_friction(system_, choice_);
  factor();
  reduced_ = false;
  if (rank() > 0) weigh(), factor_schur(at);
}

void Partition::take(Choice choice) {
  const bool same = choices_ > 0 && choice == choice_;
  ++choices_;
  if (!same) {
    choice_ = std::move(choice), shared_choice_ = nullptr;
    rows_ = choice_.rows, u_ = choice_.dependent;
    std::sort(rows_.begin(), rows_.end());
    std::sort(u_.begin(), u_.end());
    analyse(), list_products();
  }
  std::fill(best_pivot_.begin(), best_pivot_.end(), 0.0);
}

void Partition::adopt(const std::shared_ptr<const Choice>& choice) {
  if (choices_ > 0 && choice == shared_choice_) return;
  take(*choice);
  shared_choice_ = choice;
}

const std::shared_ptr<const Choice>& Partition::choice() {
  if (!shared_choice_) shared_choice_ = std::make_shared<const Choice>(choice_);
  return shared_choice_;
}

void Partition::analyse() {
  const auto r = rows_.size();
  const auto index = [](auto i) { return static_cast<Index>(i); };
  std::vector<int> index_of_column(static_cast<std::size_t>(system_.coordinates()), -1);
  std::vector<Index> place_in_choice(static_cast<std::size_t>(system_.equations()));
  for (std::size_t k = 0; k < r; ++k) {
    place_in_choice[static_cast<std::size_t>(choice_.rows[k])] = index(k);
    index_of_column[static_cast<std::size_t>(choice_.dependent[k])] = static_cast<int>(k);
  }
  used_.clear(), entries_.clear(), used_rows_.clear(), column_.clear(), pivot_scale_.clear();
  for (const Block& b : system_.blocks()) column_.push_back(index(3 * (b.body - 1)));
  for (std::size_t k = 0; k < r; ++k) {
    const int row = rows_[k];
    used_rows_.push_back({index(row), index(system_.first_block(row)), index(system_.first_block(row + 1)),
                          place_in_choice[static_cast<std::size_t>(row)]});
    for (Index b = used_rows_.back().first; b < used_rows_.back().last; ++b) used_.push_back({b, index(k), column_[b]});
    pivot_scale_.push_back(row_scale_[choice_.rows[k]] / column_scale_[choice_.dependent[k]]);
  }
  std::vector<std::vector<int>> pattern(r);
  const auto each_of_phi_u = [&](auto action) {
    for (const Used& u : used_)
      for (Index component = 0; component < 3; ++component) {
        const int j = index_of_column[u.column + component];
        if (j >= 0 && system_.blocks()[u.block].has[component]) action(u, component, used_rows_[u.index].chosen, j);
      }
  };
  each_of_phi_u([&](const Used&, Index, Index row, int j) { pattern[row].push_back(j); });
  phi_u_.analyse(pattern);
  each_of_phi_u([&](const Used& u, Index component, Index row, int j) {
    entries_.push_back({u.block, component, index(phi_u_.place(static_cast<int>(row), j))});
  });
  best_pivot_.assign(r, 0.0);
  work_.assign(r, 0.0), chosen_work_ = work_;
  list_free_entries();
}

void Partition::list_free_entries() {
  const auto f = choice_.independent.size();
  free_entries_.clear(), dependent_mass_.clear();
  if (freedom() > few_freedoms || freedom() == 0) return;
  for (const int i : choice_.dependent) dependent_mass_.push_back(system_.mass()[i]);
  for (const Used& u : used_)
    for (std::size_t j = 0; j < f; ++j) {
      const auto i = static_cast<Index>(choice_.independent[j]);
      if (i < u.column || i >= u.column + 3 || !system_.blocks()[u.block].has[i - u.column]) continue;
      free_entries_.push_back({u.block, i - u.column, static_cast<Index>(used_rows_[u.index].chosen * f + j)});
    }
  r_.assign(rows_.size() * f, 0.0), m_hat_.assign(f * f, 0.0);
}

void Partition::list_products() {
  std::vector<std::vector<Used>> on_body(static_cast<std::size_t>(system_.bodies()));
  for (const Used& u : used_) on_body[u.column / 3].push_back(u);
  std::vector<std::vector<int>> neighbours(rows_.size());
  for (const auto& list : on_body)
    for (const Used& a : list)
      for (const Used& b : list)
        if (a.index != b.index) neighbours[a.index].push_back(static_cast<int>(b.index));
  schur_.analyse(neighbours);
  products_.clear();
  for (const auto& list : on_body)
    for (std::size_t i = 0; i < list.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        products_.push_back(
            {list[i].block, list[j].block,
             static_cast<Index>(schur_.place(static_cast<int>(list[i].index), static_cast<int>(list[j].index)))});
  weighted_.resize(system_.blocks().size());
}

bool Partition::asks_for_choice() const { return sensitivity_ > lazy_limit; }

bool Partition::choose_again_if_needed(const MotionState& at) {
  if (!asks_for_choice()) return false;
  const auto before = choice_.independent;
  choose(at);
  return choice_.independent != before;
}

void Partition::factor() {
  auto& values = phi_u_.values();
  std::fill(values.begin(), values.end(), 0.0);
  for (const auto& e : entries_) values[e.place] = c_.jacobian[e.block][e.component];
  phi_u_.factor();
  sensitivity_ = 1, least_pivot_ = 1;
  bool negative = false;
  for (std::size_t k = 0; k < best_pivot_.size(); ++k) {
    const double pivot = std::abs(phi_u_.pivot(k)) * pivot_scale_[k];
    negative = negative != std::signbit(phi_u_.pivot(k));
    least_pivot_ = std::min(least_pivot_, pivot);
    best_pivot_[k] = std::max(best_pivot_[k], pivot);
    if (sensitivity_ * pivot < best_pivot_[k]) sensitivity_ = best_pivot_[k] / pivot;
  }
  orientation_ = negative ? -1 : 1;
}

// The corrector moves the pose by the local error of a step. Factors that are this near solve as well as fresh ones
// with one pass of refinement more, and cost a third of an evaluation less.
bool Partition::factors_serve(const MotionState& m) {
  double moved = 0;
  for (Eigen::Index i = 0; i < m.q.size(); ++i) {
    const double by = std::abs(m.q[i] - factored_at_[i]) * column_scale_[i];
    if (!(by <= moved)) moved = by;  // NaN counts as far
  }
  const double distance = moved / system_.length_scale();
  const bool serve = distance <= near_enough && !near_singular();
  trust_ = serve && reduced_ ? std::max(left_by_distance * distance, left_by_rounding) : left_by_distance * near_enough;
  return serve;
}

// After every change of Phi_q.
void Partition::weigh() {
  for (std::size_t b = 0; b < weighted_.size(); ++b) {
    const double* const inverse = inverse_mass_.data() + column_[b];
    for (std::size_t k = 0; k < 3; ++k) weighted_[b][k] = c_.jacobian[b][k] * inverse[k];
  }
}

void Partition::factor_schur(const MotionState& m) {
  auto& s = schur_.values();
  std::fill(s.begin(), s.end(), 0.0);
  for (const auto& p : products_) {
    const auto &a = c_.jacobian[p.i], &b = weighted_[p.j];
    s[p.place] += a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  reduced_ = false;
  if (schur_.factor() && (schur_.least_share() > singular_pose.share || least_pivot_ > singular_pose.pivot)) {
    factored_at_ = m.q;
    return;
  }
  refuse_singular(m);
}

void Partition::refuse_singular(const MotionState& m) const {
  if (m.q.allFinite()) refuse_blow_up(system_, m);  // else it may be the singular matrix that was solved with
  throw SingularPose("singular pose at t = " + std::to_string(m.t) +
                     " s: " + dead_centre(system_, singular_owner(), "nothing", c_.phi_t) +
                     "; the motion is not determined from here");
}

bool Partition::near_singular() const {
  return rank() > 0 && least_pivot_ < near_pose.pivot && schur_.least_share() < near_pose.share;
}

double Partition::distance_from_singular() const {
  return rank() > 0 ? std::max(least_pivot_, std::sqrt(std::max(schur_.least_share(), 0.0))) : 1;
}

void Partition::refuse_other_branch(const MotionState& m) const {
  if (velocity_turn_ > most_turn)
    throw std::runtime_error("singular pose at t = " + std::to_string(m.t) +
                             " s: beyond it the constraints are met on another branch, not on the continuation of the "
                             "motion, at " +
                             singular_owner() +
                             "; a step that does not end there may pass it, as the automatic one does");
}

std::string Partition::singular_owner() const {
  return system_.owner(rows_[static_cast<std::size_t>(schur_.least_row())]);
}

double Partition::residual() const {
  double most = 0;
  for (std::size_t i = 0; i < c_.phi.size(); ++i)
    most = std::max(most, std::abs(c_.phi[i]) * row_scale_[static_cast<Eigen::Index>(i)]);
  return most;
}

void Partition::refuse_open(const MotionState& m) const {
  if (m.q.allFinite()) refuse_blow_up(system_, m);  // else it may be the singular matrix that was solved with
  std::size_t worst = 0;
  for (std::size_t i = 0; i < c_.phi.size(); ++i) {
    const auto size = [&](std::size_t k) { return std::abs(c_.phi[k]) * row_scale_[static_cast<Eigen::Index>(k)]; };
    if (!(size(i) <= size(worst))) worst = i;
  }
  const int row = static_cast<int>(worst);
  std::string reason = "the machine has reached the end of its travel, or the step is too long";
  const auto parted = std::find_if(choice_.dependencies.begin(), choice_.dependencies.end(),
                                   [row](const Dependency& d) { return d.has(row); });
  if (parted != choice_.dependencies.end()) {
    reason = parted_constraints(system_, *parted);
  } else if (rank() > 0 && least_pivot_ < near_pose.pivot) {
    std::size_t least = 0;
    const auto pivot = [&](std::size_t k) { return std::abs(phi_u_.pivot(k)) * pivot_scale_[k]; };
    for (std::size_t k = 0; k < pivot_scale_.size(); ++k)
      if (pivot(k) < pivot(least)) least = k;
    reason = dead_centre(system_, system_.owner(choice_.rows[least]), "hardly anything", c_.phi_t);
  }
  throw std::runtime_error("the joints cannot be kept closed at t = " + std::to_string(m.t) +
                           " s: " + system_.owner(row) + " is open by " + scientific(std::abs(c_.phi[worst])) +
                           (system_.angular_row(row) ? " rad" : " m") + "; " + reason);
}

// Returns whether the factors of before serve the new pose.
bool Partition::solve_positions(MotionState& m) {
  // Newton with the matrix of the guess, which a predictor leaves nearly on Phi = 0: the first iteration then is the
  // last, and the same factors serve the velocities.
  double far = 0;
  for (Eigen::Index i = 0; i < m.q.size(); ++i)
    far = std::max(far,
                   std::abs(m.q[i]) * (i % 3 == 2 ? std::min(1.0, system_.body_size(static_cast<int>(i / 3 + 1))) : 1));
  const double scale = std::max(system_.length_scale(), far);
  // The second is the rounding of Phi itself. Beside a singular pose what is left returns over the distance from it.
  const double goal = nearest_ ? rounding * scale : 1e-14 * system_.length_scale() + 2e-15 * far;
  double before = 0, first = 0;
  bool serve = factors_serve(m);
  if (!serve) factored_at_[0] = std::numeric_limits<double>::quiet_NaN();
  for (int iteration = 0; iteration < 50; ++iteration) {
    system_.set_position(m.t, m.q);
    system_.constraints_of_position(c_);
    if (rank() == 0) return true;
    if (nearest_) weigh();
    if (iteration == 0 && !serve) factor_again(m);
    double now = 0;
    for (std::size_t k = 0; k < work_.size(); ++k) {
      work_[k] = c_.phi[used_rows_[k].row];
      now = std::max(now, std::abs(work_[k]));
    }
    if (now <= goal || (now <= 1e-13 * scale && iteration > 0 && now > 0.1 * before)) {
      if (!choice_.redundant.empty() && residual() > 1e-8 * scale) break;
      // What is left of a guess that met the goal follows the guess, from step to step. Where M^ is nearly singular
      // accelerations magnify it above what rounding makes of them. Near-singular Phi_u magnifies the rounding.
      if (now > rounding * scale && least_pivot_ >= sure_pivot) correct(m.q);
      return serve;
    }
    if (iteration == 0) first = now;
    if (!(now < 1e3 * scale)) break;
    if (iteration > 0 && now > 0.01 * before) factor_again(m), serve = false;
    before = now;
    correct(m.q);
  }
  if (first < 1e-8 * scale && least_pivot_ < singular_pose.pivot) refuse_singular(m);  // closed, and yet no way on
  refuse_open(m);
}

// Of what corrects, which beside a singular pose is S.
void Partition::factor_again(const MotionState& m) {
  factor();
  if (nearest_) factor_schur(m);
}

// Takes the residual in work_ out of positions or velocities: out of the dependent ones, or with least change of all.
void Partition::correct(Eigen::VectorXd& x) {
  if (nearest_) {
    schur_.solve(work_);
    subtract_reactions(work_, x);
    return;
  }
  for (std::size_t k = 0; k < work_.size(); ++k) chosen_work_[used_rows_[k].chosen] = work_[k];
  phi_u_.solve(chosen_work_);
  for (std::size_t k = 0; k < work_.size(); ++k) x[choice_.dependent[k]] -= chosen_work_[k];
}

// work_ = Phi_q x + sign * other; returns the largest of it.
template <int sign>
double Partition::apply_jacobian(const Eigen::VectorXd& x, const std::vector<double>& other) {
  const auto* const jacobian = c_.jacobian.data();
  double most = 0;
  for (std::size_t k = 0; k < work_.size(); ++k) {
    const UsedRow& r = used_rows_[k];
    double sum = sign * other[r.row];
    for (Index b = r.first; b < r.last; ++b) {
      const double* const p = x.data() + column_[b];
      const auto& j = jacobian[b];
      sum += j[0] * p[0] + j[1] * p[1] + j[2] * p[2];
    }
    work_[k] = sum;
    most = std::max(most, std::abs(sum));
  }
  return most;
}

void Partition::solve_velocities(MotionState& m) {
  // As a correction of the guess: the digits that the guess has are not lost to the condition of Phi_u.
  if (!m.velocity.allFinite())
    for (const int i : choice_.dependent) m.velocity[i] = 0;
  const double fastest = m.velocity.cwiseProduct(column_scale_).cwiseAbs().maxCoeff();
  const double goal = (nearest_ ? rounding : 2e-15) * fastest;  // of the sum of a row
  double before = std::numeric_limits<double>::infinity();
  Eigen::VectorXd& guess = free_;
  guess = m.velocity;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const double now = apply_jacobian<1>(m.velocity, c_.phi_t);
    if (now <= goal || !(now < 0.1 * before)) break;
    before = now;
    correct(m.velocity);
    if (trust_ * now <= goal && !near_singular()) break;
  }
  velocity_turn_ = 0;
  for (Eigen::Index i = 0; i < guess.size(); ++i)
    if (!(m.velocity[i] * guess[i] > 0.5 * guess[i] * guess[i]))
      velocity_turn_ = std::max(velocity_turn_, std::abs(m.velocity[i] - guess[i]) * column_scale_[i]);
  // A machine at rest has velocities of rounding, which turn as they like.
  if (velocity_turn_ > 0) velocity_turn_ /= std::max({fastest, velocity_turn_, rest_speed * system_.length_scale()});
}

void Partition::evaluate(MotionState& m) {
  nearest_ = false;
  put_on_constraints(m);
}

void Partition::evaluate_predicted(MotionState& m) {
  nearest_ = false;
  if (rank() == 0 || !may_reduce()) return evaluate(m);
  system_.set_state(m.t, m.q, m.velocity);
  system_.constraints(c_);
  double open = 0;
  for (const UsedRow& r : used_rows_)
    if (!(std::abs(c_.phi[r.row]) <= open)) open = std::abs(c_.phi[r.row]);
  if (!(open <= near_enough * system_.length_scale())) return evaluate(m);
  factor();
  if (!may_reduce()) return evaluate(m);
  velocity_turn_ = 0, of_this_pose_ = true;
  reduce(m);
  solve_motion(m);
}

void Partition::accelerate_as_it_is(MotionState& m) {
  system_.set_state(m.t, m.q, m.velocity);
  system_.constraints(c_);
  if (rank() > 0) {
    factor();
    weigh();
    factor_schur(m);
  }
  velocity_turn_ = 0;
  solve_motion(m);
}

void Partition::evaluate_nearest(MotionState& m) {
  nearest_ = true;
  factored_at_[0] = std::numeric_limits<double>::quiet_NaN();
  put_on_constraints(m);
}

void Partition::put_on_constraints(MotionState& m) {
  const bool serve = solve_positions(m);
  if (rank() > 0) {
    solve_velocities(m);
    of_this_pose_ = !serve;
    if (!nearest_) prepare_motion(m, serve);
  }
  system_.set_velocity(m.velocity);
  system_.constraints_of_velocity(c_);
  solve_motion(m);
}

// Factors for accelerations and multipliers, but where those of before serve. Phi_u has its own of the guess; R wants
// them of the pose itself, which cost less than a pass of refinement.
void Partition::prepare_motion(const MotionState& m, bool serve) {
  if (!serve && may_reduce()) {
    factor();
    return reduce(m);
  }
  if (serve && reduced_) return;
  weigh();
  if (!serve) factor_schur(m);
}

// The constraints are those of the evaluation before; one may have looked elsewhere since.
void Partition::accelerate(MotionState& m) {
  system_.set_state(m.t, m.q, m.velocity);
  if (!reduced_ || !system_.friction_rows().empty()) return solve_motion(m);
  system_.set_element_states(m.states);
  balance_ = load_;
  take_loads();
  balance_ = load_ - balance_;
  correct_reduced(m, false);
  take_rates(m);
}

void Partition::accelerate_by_wrenches(MotionState& m) {
  if (!reduced_ || !system_.friction_rows().empty() || system_.state_count() > 0) return accelerate(m);
  if (wrenches_ == system_.external_wrenches()) return accelerate(m);  // another force has jumped
  for (std::size_t i = 1; i < wrenches_.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double now = system_.external_wrench(static_cast<int>(i))[k];
      balance_[static_cast<Eigen::Index>(3 * (i - 1) + k)] = now - wrenches_[i][k];
    }
  load_ += balance_;
  wrenches_ = system_.external_wrenches();
  correct_reduced(m, false);
  take_driver_rates(m);
}

void Partition::take_loads() {
  system_.loads(load_);
  wrenches_ = system_.external_wrenches();
}

void Partition::solve_motion(MotionState& m) {
  system_.set_element_states(m.states);
  if (!m.lambda.allFinite()) m.lambda.setZero();  // what a failed evaluation left is no guess
  if (system_.friction_rows().empty()) {
    take_loads();
    solve_accelerations(m);
  } else {
    solve_with_friction(m);
  }
  take_rates(m);
}

void Partition::take_rates(MotionState& m) {
  const auto forces = static_cast<Eigen::Index>(system_.model().forces.size());
  for (Eigen::Index i = 0; i < forces; ++i) {
    m.rates[i] = system_.powers()[static_cast<std::size_t>(i)].lost;
    m.rates[forces + i] = system_.powers()[static_cast<std::size_t>(i)].work;
  }
  take_driver_rates(m);
  if (system_.state_count() == 0) return;
  const SharedReactions reactions(system_, rows_.size(), m.lambda, controllers_read_reactions(system_));
  const std::vector<double>& rates = system_.take_state_rates(m.acceleration, reactions.lambda());
  std::copy(rates.begin(), rates.end(), m.rates.data() + system_.flow_count());
}

// Constraint forces work at the rate -lambda^T Phi_q q' = lambda^T Phi_t: only drivers have a Phi_t.
void Partition::take_driver_rates(MotionState& m) {
  const auto first = static_cast<Eigen::Index>(2 * system_.model().forces.size());
  for (std::size_t d = 0; d < system_.model().drivers.size(); ++d) {
    const int row = system_.row_of_driver(d);
    m.rates[first + static_cast<Eigen::Index>(d)] = m.lambda[row] * c_.phi_t[static_cast<std::size_t>(row)];
  }
}

// acceleration -= M^-1 Phi_q^T lambda.
void Partition::subtract_reactions(const std::vector<double>& lambda, Eigen::VectorXd& acceleration) const {
  for (std::size_t k = 0; k < lambda.size(); ++k) {
    const double l = lambda[k];
    for (Index b = used_rows_[k].first; b < used_rows_[k].last; ++b) {
      double* const a = acceleration.data() + column_[b];
      const auto& w = weighted_[b];
      a[0] -= w[0] * l, a[1] -= w[1] * l, a[2] -= w[2] * l;
    }
  }
}

bool Partition::may_reduce() const { return freedom() > 0 && freedom() <= few_freedoms && least_pivot_ >= sure_pivot; }

// R and the factors of M^, from those of Phi_u at the same pose.
void Partition::reduce(const MotionState& m) {
  std::fill(r_.begin(), r_.end(), 0.0);
  for (const Entry& e : free_entries_) r_[e.place] = -c_.jacobian[e.block][e.component];
  with_freedom(freedom(), [&]<std::size_t f>(Count<f>) {
    phi_u_.solve_rows<f>(r_);
    Square<f> a = Square<f>::Zero();
    for (std::size_t k = 0; k < dependent_mass_.size(); ++k) {
      const Few<f> row = ConstRow<f>(r_.data() + k * f);
      a += (dependent_mass_[k] * row) * row.transpose();
    }
    for (std::size_t i = 0; i < f; ++i) {
      const auto d = static_cast<Eigen::Index>(i);
      a(d, d) += system_.mass()[choice_.independent[i]];
    }
    for (Eigen::Index j = 0; j < a.rows(); ++j)  // L L^T, with 1/L on the diagonal
      for (Eigen::Index i = j; i < a.rows(); ++i) {
        double sum = a(i, j);
        for (Eigen::Index k = 0; k < j; ++k) sum -= a(i, k) * a(j, k);
        a(i, j) = i == j ? 1 / std::sqrt(sum) : sum * a(j, j);
      }
    Eigen::Map<Square<f>>(m_hat_.data()) = a;
  });
  reduced_ = true;
  factored_at_ = m.q;
}

// balance_ = F - M q'' - Phi_q^T lambda; returns the largest acceleration that it makes of free bodies.
double Partition::balance(const MotionState& m) {
  balance_ = load_ - system_.mass().cwiseProduct(m.acceleration);
  for (const UsedRow& r : used_rows_) {
    const double lambda = m.lambda[r.row];
    for (Index b = r.first; b < r.last; ++b) {
      double* const rest = balance_.data() + column_[b];
      const auto& j = c_.jacobian[b];
      rest[0] -= j[0] * lambda, rest[1] -= j[1] * lambda, rest[2] -= j[2] * lambda;
    }
  }
  return balance_.cwiseProduct(inverse_mass_).cwiseAbs().maxCoeff();
}

// Takes balance_, and work_ = Phi_q q'' - gamma unless it is nothing, out of accelerations and multipliers.
void Partition::correct_reduced(MotionState& m, bool open) {
  const std::size_t r = dependent_mass_.size();
  double* const c = chosen_work_.data();
  for (std::size_t k = 0; k < r; ++k) c[used_rows_[k].chosen] = open ? -work_[k] : 0;
  if (open) phi_u_.solve(chosen_work_);
  with_freedom(freedom(), [&]<std::size_t f>(Count<f>) {
    const auto row = [&](std::size_t k) { return ConstRow<f>(r_.data() + k * f); };
    const Eigen::Map<const Square<f>> l(m_hat_.data());
    Few<f> y;
    for (std::size_t j = 0; j < f; ++j) y[static_cast<Eigen::Index>(j)] = balance_[choice_.independent[j]];
    for (std::size_t k = 0; k < r; ++k) y += row(k) * (balance_[choice_.dependent[k]] - dependent_mass_[k] * c[k]);
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      for (Eigen::Index k = 0; k < i; ++k) y[i] -= l(i, k) * y[k];
      y[i] *= l(i, i);
    }
    for (Eigen::Index i = y.size(); i-- > 0;) {
      for (Eigen::Index k = i + 1; k < y.size(); ++k) y[i] -= l(k, i) * y[k];
      y[i] *= l(i, i);
    }
    for (std::size_t j = 0; j < f; ++j) m.acceleration[choice_.independent[j]] += y[static_cast<Eigen::Index>(j)];
    for (std::size_t k = 0; k < r; ++k) {
      const double change = c[k] + row(k).dot(y);
      m.acceleration[choice_.dependent[k]] += change;
      c[k] = balance_[choice_.dependent[k]] - dependent_mass_[k] * change;
    }
  });
  phi_u_.solve_transposed(chosen_work_);
  for (std::size_t k = 0; k < r; ++k) m.lambda[choice_.rows[k]] += c[k];
}

void Partition::solve_reduced(MotionState& m) {
  if (of_this_pose_) {
    m.acceleration.setZero(), m.lambda.setZero();
    for (std::size_t k = 0; k < work_.size(); ++k) work_[k] = -c_.gamma[used_rows_[k].row];
    balance_ = load_;
    return correct_reduced(m, true);
  }
  // Factors of a pose near by serve for what is left of a guess.
  if (!m.acceleration.allFinite()) m.acceleration.setZero();
  for (const int row : choice_.redundant) m.lambda[row] = 0;
  double largest = load_.cwiseProduct(inverse_mass_).cwiseAbs().maxCoeff();
  for (const double g : c_.gamma) largest = std::max(largest, std::abs(g));
  const double goal = 1e-14 * largest;  // rounding of a sum of some ten terms
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < 6; ++pass) {
    const double now = std::max(balance(m), apply_jacobian<-1>(m.acceleration, c_.gamma));
    if (now <= goal || !(now < 0.1 * before)) return;
    before = now;
    correct_reduced(m, true);
    if (trust_ * now <= goal) return;
  }
}

void Partition::solve_accelerations(MotionState& m) {
  if (reduced_) return solve_reduced(m);
  free_ = load_.cwiseProduct(inverse_mass_);
  m.acceleration = free_;
  if (rank() == 0) return;
  // From the lambda given on: it is near after a predictor, and then factors of a pose near by serve as well. Further
  // passes are iterative refinement: S has the square of the condition of Phi_q, and where that is large the
  // accelerations still satisfy their constraints to rounding.
  for (const int row : choice_.redundant) m.lambda[row] = 0;
  for (std::size_t k = 0; k < work_.size(); ++k) work_[k] = m.lambda[used_rows_[k].row];
  subtract_reactions(work_, m.acceleration);
  double largest = free_.cwiseAbs().maxCoeff();
  for (const double g : c_.gamma) largest = std::max(largest, std::abs(g));
  const double goal = 1e-15 * largest;
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < 6; ++pass) {
    const double now = apply_jacobian<-1>(m.acceleration, c_.gamma);
    if (now <= goal || !(now < 0.1 * before)) return;
    before = now;
    schur_.solve(work_);
    for (std::size_t k = 0; k < work_.size(); ++k) m.lambda[used_rows_[k].row] += work_[k];
    subtract_reactions(work_, m.acceleration);
    if (trust_ * now <= goal) return;
  }
}

// One pass lambda -> T(lambda): the multipliers that belong to friction by those given. Returns the largest change.
double Partition::friction_pass(MotionState& m) {
  system_.set_multipliers(m.lambda);
  take_loads();
  lambda_before_ = m.lambda;
  solve_accelerations(m);
  return (m.lambda - lambda_before_).cwiseAbs().maxCoeff();
}

// Gives up once more than `affordable` passes are ahead at the share that the last two show.
bool Partition::iterate_friction(MotionState& m, double affordable) {
  constexpr double settled = 1e-13;
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < most_patient_passes; ++pass) {
    const double change = friction_pass(m), size = m.lambda.cwiseAbs().maxCoeff();
    if (change <= settled * size || (change <= 1e-11 * size && change > 0.5 * before)) return true;
    if (!(size < 1e100)) return false;
    if (pass >= 3 && std::isfinite(affordable) &&
        !(std::log(settled * size / change) > affordable * std::log(change / before)))
      return false;
    before = change;
  }
  return false;
}

void Partition::solve_with_friction(MotionState& m) {
  if (iterate_friction(m, 4 + 4.0 * static_cast<double>(system_.friction_rows().size()))) return;
  const LockedFriction found = solve_strong_friction(m);
  if (found.settled) return;
  // Between the branches of |N| and of the two ends of a guide Newton's method may turn in a circle.
  if (found.returned < 1 && iterate_friction(m, std::numeric_limits<double>::infinity())) return;
  char share[32];
  std::snprintf(share, sizeof share, "%.3g", found.returned);
  throw std::runtime_error("no unique acceleration at t = " + std::to_string(m.t) + " s: " + system_.owner(found.row) +
                           " locks itself; its friction returns " + share +
                           " times a change of the reaction that makes it, and must return less than 1. A smaller mu, "
                           "a longer guide or a load along the friction frees it");
}

// Newton's method for T(y) = y, y the multipliers that friction reads. Of two solutions it may find either, so the
// spectral radius of T' there decides: from 1 on the accelerations are not unique, or there are none (Painleve).
Partition::LockedFriction Partition::solve_strong_friction(MotionState& m) {
  std::vector<Eigen::Index> rows;
  for (const int row : system_.friction_rows()) rows.push_back(row), rows.push_back(row + 1);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  const auto n = static_cast<Eigen::Index>(rows.size());
  const auto next = [&](const Eigen::VectorXd& y) {
    m.lambda(rows) = y;
    friction_pass(m);
    return Eigen::VectorXd(m.lambda(rows));
  };
  LockedFriction found{.row = static_cast<int>(rows.front())};
  Eigen::VectorXd y = m.lambda(rows);
  Eigen::MatrixXd slope(n, n);
  double before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < most_friction_steps; ++step) {
    const Eigen::VectorXd t = next(y);
    const double size = m.lambda.cwiseAbs().maxCoeff(), change = (t - y).cwiseAbs().maxCoeff();
    if (!(size < 1e100)) break;
    if (change <= 1e-13 * size || (change <= 1e-11 * size && change > 0.5 * before)) {
      found.settled = found.returned < 1;
      break;
    }
    before = change;
    const Eigen::VectorXd solution = m.lambda;
    for (Eigen::Index k = 0; k < n; ++k) {
      Eigen::VectorXd beside = y;
      beside[k] += friction_difference * size;
      slope.col(k) = (next(beside) - t) / (friction_difference * size);
    }
    m.lambda = solution;
    const auto [values, vectors] = eigenvectors(slope);
    Eigen::Index fastest = 0, largest = 0;
    found.returned = values.cwiseAbs().maxCoeff(&fastest);
    vectors.col(fastest).cwiseAbs().maxCoeff(&largest);
    found.row = static_cast<int>(rows[static_cast<std::size_t>(largest)]);
    y += solve(Eigen::MatrixXd::Identity(n, n) - slope, t - y);
  }
  return found;
}

Eigen::VectorXd Partition::reactions(const MotionState& m) const {
  if (choice_.redundant.empty()) return m.lambda;
  Constraints dense;
  dense.sparse = c_;
  write_out(system_, dense);
  return least_norm_reactions(system_, dense, m.lambda);
}

}  // namespace subsoil::mbd
