#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/bed.hpp"
#include "libdem/contacts/contact_store.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/particles/particle_store.hpp"
#include "libdem/step/energy_balance.hpp"

namespace subsoil::dem {

class Clumps;

/// Which particle blocks move, and which of the others are evaluated in a step (docs/theory, section 8.1). Without a
/// rule all move.
///
/// Whole particle blocks sleep, not spheres: a block is skipped with one look, its contacts and their histories
/// stay where they are, and what it needs of its neighbours is known by block. Single sleeping spheres would have the
/// kernel ask for each lane.
///
/// | data                    | written by                                               | read by                |
/// |---|---|---|
/// | neighbours, boxes       | `begin_lists`: rebuilds                                  | `plan`                 |
/// | states                  | `plan`, before each step, one thread                     | every worker           |
/// | outcomes, balance       | the worker of the block, in the sweep; `Clumps::move`    | `plan` of the next step |
/// | balance, `Sphere::calm` | `keep` and `sort`: rebuilds                              | saved state            |
///
/// A clump sleeps as a whole, whether or not its blocks do: a block whose spheres sleep has sleeping clumps only, but a
/// sleeping clump may have members in blocks that move, where they stay in place. So no chain of clumps that share
/// blocks has to fall asleep, or wake, together. Its record is that of its first member.
///
/// All is decided between two steps, from what particle blocks and boundaries did: the same for any number of threads.
class ActiveRegion {
 public:
  void set_rule(const std::optional<ActiveRule>& rule);
  bool on() const { return rule_.has_value(); }

  // Rebuilds.
  /// What is known of each sphere's block, into its record: blocks of the next lists are others.
  void keep(std::span<Sphere> spheres);
  /// Records as the spheres. @param new_index by index before, kGone of those that leave
  void sort(const std::vector<std::uint32_t>& new_index, std::size_t count);
  /// @param cutoff by which the lists go beyond the surfaces of two spheres, m
  void begin_lists(const ContactStore& contacts, const ParticleStore& particles, const Clumps& clumps,
                   double mean_radius, double cutoff, int threads);
  void forget() { states_.clear(), clumps_.clear(), count_ = 0; }  ///< spheres are others
  void check_all() { check_all_ = true; }  ///< something else than neighbours and surfaces changed the forces

  // Saved state: of spheres, in their order, and of blocks of the same lists.
  void archive(Archive& a, std::size_t count);
  void archive_lists(Archive& a, std::span<BlockSums> sums);

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
  bool is_asked_for_energy(std::size_t block) const { return states_[block].renews; }  ///< of one that is observed
  bool any_observed() const { return observed_; }
  bool receives(std::size_t block) const { return states_[block].receives; }
  /// Whether a sphere of a checked block stays asleep. @param acceleration by its forces, m/s2
  /// @param turn by its torque, of a point on the surface, m/s2
  bool rests(std::size_t block, std::size_t sphere, const Vec3& acceleration, const Vec3& turn);
  /// Of a block that is checked.
  void found(std::size_t block, bool balanced) { outcomes_[block] = balanced ? Outcome::rests : Outcome::moves; }

  // What `Clumps` asks of a clump after the sweep.
  bool clump_moves(std::size_t clump) const { return clumps_.empty() || !clumps_[clump].asleep; }
  /// Neither asleep nor falling asleep in this step.
  bool clump_drifts(std::size_t clump) const { return clump_moves(clump) && !clump_freezes(clump); }
  bool clump_freezes(std::size_t clump) const { return !clumps_.empty() && clumps_[clump].freezes; }
  bool checks_clump(std::size_t clump) const { return !clumps_.empty() && clumps_[clump].checked; }
  /// Of one that is checked. @param turn by its moment, of the point farthest from its centre, m/s2
  void check_clump(std::size_t clump, const Vec3& acceleration, const Vec3& turn);

  std::size_t frozen_spheres() const;

  static constexpr long kCheck = 16;  ///< steps between two checks
  static constexpr long kCalm = 16;   ///< checks that find a block slow before it sleeps, at least
  /// Of gravity: the mean acceleration above which a sphere does not fall asleep, and the lasting change of its forces
  /// that wakes it. A ball on a slope of 2 degrees has more (5/7 sin 2 = 0.025). Of the mean, because contacts of a bed
  /// at rest ring: 0.1 mm/s at 2,000 rad/s are 0.02 g for a moment and nothing on average.
  static constexpr double kUnbalanced = 0.02;
  /// Speed limit by default, in sqrt(g d) of the mean diameter: the inertial number of a layer that shears this fast
  /// under the weight of one sphere. Friction of soil depends on the rate from about 1e-3 to 1e-2 on.
  static constexpr double kInertialNumber = 0.002;

 private:
  struct State {
    bool frozen = false;         ///< its spheres stay where they are
    bool freezes = false;        ///< in this step
    bool fresh = false;          ///< asleep; the next check takes its forces as those at rest
    bool evaluated = true;       ///< its contacts, in this step
    bool observed = false;       ///< evaluated in this step for what is asked for alone (ObservedContacts)
    bool checked = false;        ///< asleep, and its forces are complete in this step
    bool receives = false;       ///< asleep, and gets some force from contacts of other blocks in this step
    bool renews = false;         ///< observed for its energies, as without a frame
    bool outdated = true;        ///< what it stores was summed before it or a partner last moved
    bool near = false;           ///< a moving surface is
    bool driven = false;         ///< a fixed sphere of it moves, however slowly: neither it nor a neighbour sleeps
    bool beside_moving = false;  ///< asleep, and a neighbour is not
    double slow = 0;             ///< since when all its spheres are, s
    double speed2 = 0;           ///< maximum since the last check, m2/s2
  };
  /// Of a sphere.
  struct Balance {
    double slow = 0;           ///< State::slow of its block
    Vec3 acceleration, turn;   ///< when it fell asleep: what was out of balance then, as it was ringing
    Vec3 change, turn_change;  ///< since then, mean over the time of rest
    void archive(Archive& a) {
      a("slow", slow)("acceleration", acceleration)("turn", turn)("change", change)("turn change", turn_change);
    }
  };
  enum class Outcome : std::uint8_t { none, rests, moves };
  struct ClumpState {
    bool asleep = false;   ///< its members stay where they are
    bool freezes = false;  ///< in this step
    bool fresh = false;    ///< as State
    bool checked = false;  ///< asleep, and its forces are complete in this step
    Outcome outcome = Outcome::none;
  };

  void take_outcomes();
  void watch_speeds(std::span<const BlockSums> sums);
  void add_slow_time(double time);
  void find_near(std::span<const Boundary> boundaries);
  void choose_freezing(const ParticleStore& particles);
  bool may_freeze(std::size_t block) const;
  void mark(bool check, bool all, bool all_energies, bool snapshot, ContactStore& contacts);
  void wake(std::size_t block);
  void wake_what_sleeps(std::size_t block);
  void wake_clump(std::uint32_t clump);
  void fall_asleep();
  void find_clumps(const Clumps& clumps, const ParticleStore& particles);
  bool is_beside_moving(std::size_t clump) const;
  bool balanced(bool fresh, bool beside_moving, std::size_t sphere, const Vec3& acceleration, const Vec3& turn);
  double limit2() const { return speed_limit_ * speed_limit_; }

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

  std::span<const std::uint32_t> members(std::size_t clump) const {
    return std::span(members_).subspan(members_begin_[clump], members_begin_[clump + 1] - members_begin_[clump]);
  }
  std::span<const std::uint32_t> clumps_of(std::size_t block) const {
    if (clumps_.empty()) return {};
    return std::span(clumps_of_).subspan(clumps_begin_[block], clumps_begin_[block + 1] - clumps_begin_[block]);
  }
  State& state_of(std::uint32_t sphere) { return states_[sphere / kParticleBlock]; }
  const State& state_of(std::uint32_t sphere) const { return states_[sphere / kParticleBlock]; }

  std::optional<ActiveRule> rule_;
  bool check_all_ = false, changed_ = true, plain_ = false, observed_ = false;
  double speed_limit_ = 0;    ///< m/s
  double rest_time_ = 0;      ///< s, T of (26c)
  double change_limit_ = 0;   ///< m/s2
  double turning_limit_ = 0;  ///< m/s, of surfaces: what a fall by a radius gives
  double gain_ = 0;           ///< of a check in the running mean of changes
  double mean_radius_ = 0;    ///< m
  std::size_t count_ = 0;     ///< spheres in the lists
  std::size_t moving_ = 0;    ///< boundaries that moved before the last step
  std::vector<State> states_;
  std::vector<Balance> balance_;
  std::vector<char> was_evaluated_;  ///< in the step before; kept for its storage
  std::vector<Outcome> outcomes_;
  std::vector<std::uint32_t> begin_, middle_, partners_;
  std::vector<ClumpState> clumps_;                       ///< in the order of `Clumps`
  std::vector<std::uint32_t> members_begin_, members_;   ///< spheres of each, its first one first
  std::vector<std::uint32_t> clumps_begin_, clumps_of_;  ///< clumps of each block
  std::vector<Bounds> boxes_;                            ///< that no sphere leaves while the lists hold
};

}  // namespace subsoil::dem
