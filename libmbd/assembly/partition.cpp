#include "libmbd/assembly/partition.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/partition_limits.hpp"

/// The choice of coordinates, its factors, and how near these are to none: where Phi_q loses rank.
namespace subsoil::mbd {

namespace {
// A pivot that has lost a factor of ten costs one digit only, and a new choice costs an elimination, so choosing is
// lazy.
constexpr double lazy_limit = 10;
// A predictor errs by a small share of the velocities; another branch turns or stops some of them.
constexpr double most_turn = 0.3;

std::string scientific(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2e", value);
  return text;
}

// Redundant constraints that no longer agree: of drivers, or of joints that do not fit.
std::string parted_constraints(const System& system, const Dependency& dependency) {
  std::vector<PartName> parts{system.part(dependency.row)};
  for (const int on : dependency.on)
    if (std::find(parts.begin(), parts.end(), system.part(on)) == parts.end()) parts.push_back(system.part(on));
  const bool driven =
      std::any_of(parts.begin(), parts.end(), [](const PartName& part) { return part.kind == PartName::Kind::driver; });
  return different_motions(parts) + "; " +
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

}  // namespace subsoil::mbd
