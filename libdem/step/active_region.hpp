#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/contacts/contact_store.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/particles/particle_store.hpp"
#include "libdem/step/energy_balance.hpp"

namespace subsoil::dem {

/// Which particle blocks move, and which of the others are evaluated in a step (docs/theory, section 8.1). Without a
/// rule all move.
///
/// Whole particle blocks sleep, not spheres: a block is skipped with one look, its contacts and their histories
/// stay where they are, and what it needs of its neighbours is known by block. Single sleeping spheres would have the
/// kernel ask for each lane.
///
/// | data                          | written by                                               | read by           |
/// |---|---|---|
/// | neighbours, boxes             | `begin_lists`: rebuilds                                  | `plan`            |
/// | states                        | `plan`, before each step, one thread                     | every worker      |
/// | outcomes                      | the worker of the particle block, during the sweep       | `plan` of the next step
/// | | time at rest, of each sphere (`calm`) | `keep`, before spheres are sorted again | `begin_lists`, saved
/// state |
///
/// All is decided between two steps, from what particle blocks and boundaries did: the same for any number of threads.
class ActiveRegion {
 public:
  void set_rule(const std::optional<ActiveRule>& rule);
  bool on() const { return rule_.has_value(); }

  // Rebuilds.
  /// Checks at rest of each sphere's block, into its record: blocks of the next lists are others.
  void keep(std::span<Sphere> spheres, std::span<const BlockSums> sums) const;
  /// @param cutoff by which the lists go beyond the surfaces of two spheres, m
  void begin_lists(const ContactStore& contacts, const ParticleStore& particles, double cutoff, int threads);
  void forget() { states_.clear(), count_ = 0; }  ///< spheres are others
  void check_all() { check_all_ = true; }         ///< something else than neighbours and surfaces changed the forces

  /// What the step at hand does with each particle block. @param gravity its magnitude, m/s2
  /// @param all_energies whether it sums those of every block
  void plan(long step, double dt, double gravity, bool new_lists, bool all_energies, bool snapshot,
            std::span<const Boundary> boundaries, const ParticleStore& particles, std::span<const BlockSums> sums,
            ContactStore& contacts);

  // What workers ask of a block in the sweep.
  bool evaluates(std::size_t block) const { return states_.empty() || states_[block].evaluated; }
  bool moves(std::size_t block) const { return states_.empty() || !states_[block].frozen; }
  bool freezes(std::size_t block) const { return !states_.empty() && states_[block].freezes; }
  bool checks(std::size_t block) const { return !states_.empty() && states_[block].checked; }
  bool is_observed(std::size_t block) const { return states_[block].observed; }
  bool any_observed() const { return observed_; }
  bool receives(std::size_t block) const { return states_[block].receives; }
  /// Whether no sphere would get too fast within the time of a sleep candidate. @param acceleration the maximum
  /// of a block's spheres, of the centre or by the torque of a point on the surface, m/s2
  bool is_balanced(double acceleration, bool freezes) const {
    return acceleration * calm_time_ < (freezes ? kFreezingShare : 1.0) * rule_->below;
  }
  /// Of a block that falls asleep or is checked.
  void found(std::size_t block, bool balanced) { outcomes_[block] = balanced ? Outcome::rests : Outcome::moves; }

  std::size_t frozen_spheres() const;

  static constexpr long kCheck = 16;         ///< steps between two checks
  static constexpr std::uint8_t kCalm = 16;  ///< checks in a row that find a block at rest before it sleeps
  /// Of gravity: the acceleration out of balance at which a sphere wakes, however short the step. A ball at rest
  /// on a slope of 2 degrees has more (5/7 sin 2 = 0.025); what a bed at rest creeps with is a hundredth of it.
  static constexpr double kUnbalanced = 0.02;
  static constexpr double kFreezingShare = 0.5;  ///< of what wakes a sphere: else rounding would wake what just froze

 private:
  struct State {
    bool frozen = false;    ///< its spheres stay where they are
    bool freezes = false;   ///< in this step, if its forces are balanced
    bool evaluated = true;  ///< its contacts, in this step
    bool observed = false;  ///< evaluated in this step for what is asked for alone (ObservedContacts)
    bool checked = false;   ///< asleep, and its forces are complete in this step
    bool receives = false;  ///< asleep, and gets some force from contacts of other blocks in this step
    bool outdated = true;   ///< what it stores was summed before it or a partner last moved
    bool near = false;      ///< a moving surface is
    std::uint8_t calm = 0;  ///< checks in a row that found all its spheres slow
    double speed2 = 0;      ///< maximum since the last check, m2/s2
  };
  enum class Outcome : std::uint8_t { none, rests, moves };

  void take_outcomes();
  void watch_speeds(std::span<const BlockSums> sums);
  void count_calm();
  void find_near(std::span<const Boundary> boundaries);
  void choose_freezing(const ParticleStore& particles);
  bool may_freeze(std::size_t block) const;
  void mark(bool check, bool all, bool all_energies, bool snapshot, ContactStore& contacts);
  void wake(std::size_t block);
  double limit2() const { return rule_->below * rule_->below; }

  /// Of a block: those that its spheres are first particles to, then those that they are second particles to.
  std::span<const std::uint32_t> later(std::size_t block) const {
    return std::span(partners_).subspan(begin_[block], middle_[block] - begin_[block]);
  }
  std::span<const std::uint32_t> earlier(std::size_t block) const {
    return std::span(partners_).subspan(middle_[block], begin_[block + 1] - middle_[block]);
  }
  std::span<const std::uint32_t> neighbours(std::size_t block) const {
    return std::span(partners_).subspan(begin_[block], begin_[block + 1] - begin_[block]);
  }
  void find_partners(const ContactStore& contacts, int threads);

  std::optional<ActiveRule> rule_;
  bool check_all_ = false, changed_ = true, plain_ = false, observed_ = false;
  double calm_time_ = 0;    ///< s, T of (26c)
  std::size_t count_ = 0;   ///< spheres in the lists
  std::size_t moving_ = 0;  ///< boundaries that moved before the last step
  std::vector<State> states_;
  std::vector<char> was_evaluated_;  ///< in the step before; kept for its storage
  std::vector<Outcome> outcomes_;
  std::vector<std::uint32_t> begin_, middle_, partners_;
  std::vector<Bounds> boxes_;  ///< that no sphere leaves while the lists hold
};

}  // namespace subsoil::dem
