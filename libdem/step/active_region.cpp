#include "libdem/step/active_region.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libdem/geometry/world_box.hpp"
#include "libdem/step/clumps.hpp"

namespace subsoil::dem {
namespace {

/// In `Sphere::calm`: asleep; asleep, and its forces at rest are not known yet.
constexpr std::uint8_t kFrozen = 0xff, kFresh = 0xfe;

bool moves_now(const Boundary& b) {
  const Quaternion &was = b.pose_before.attitude, &is = b.pose.attitude;
  return b.active &&
         !(b.pose.position == b.pose_before.position && b.velocity == Vec3{} && b.angular_velocity == Vec3{} &&
           was.w == is.w && was.x == is.x && was.y == is.y && was.z == is.z);
}

/// Shortest distance of two boxes, 0 where they overlap.
double distance(const Bounds& a, const Bounds& b) {
  Vec3 apart;
  for (int d = 0; d < 3; ++d) apart[d] = std::max({0.0, b.low[d] - a.high[d], a.low[d] - b.high[d]});
  return norm(apart);
}

/// Distance of a box from the free side of a plane's surface; of other shapes, from their box.
double distance(const Bounds& box, const Boundary& b) {
  if (const auto* plane = std::get_if<Plane>(&b.shape)) {
    const Vec3 n = b.pose.attitude.rotate(plane->normal());
    Vec3 nearest;
    for (int d = 0; d < 3; ++d) nearest[d] = n[d] > 0 ? box.low[d] : box.high[d];
    return std::max(0.0, dot(n, nearest - b.pose.to_world(plane->point())));
  }
  return distance(box, world_box(bounds(b.shape), b.pose));
}

}  // namespace

void ActiveRegion::set_rule(const std::optional<ActiveRule>& rule) {
  rule_ = rule;
  forget();
  balance_.clear();
}

/// As the next step would begin, which decides on what the last one found; that step finds it all the same.
void ActiveRegion::keep(std::span<Sphere> spheres) {
  const auto states = states_;
  const auto clumps = clumps_;
  const auto outcomes = outcomes_;
  const bool changed = changed_;
  take_outcomes();
  const auto calm = [](const auto& s, bool asleep) -> std::uint8_t { return !asleep ? 0 : s.fresh ? kFresh : kFrozen; };
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const State& s = states_[k];
    const std::size_t begin = k * kParticleBlock, end = std::min<std::size_t>(begin + kParticleBlock, count_);
    for (std::size_t i = begin; i < end; ++i) spheres[i].calm = calm(s, s.frozen), balance_[i].slow = s.slow;
  }
  for (std::size_t c = 0; c < clumps_.size(); ++c)
    for (const std::uint32_t i : members(c)) spheres[i].calm = calm(clumps_[c], clumps_[c].asleep);
  states_ = states, clumps_ = clumps, outcomes_ = outcomes, changed_ = changed;
}

void ActiveRegion::sort(const std::vector<std::uint32_t>& new_index, std::size_t count) {
  if (!on()) return balance_.clear();
  std::vector<Balance> sorted(count);
  for (std::size_t i = 0; i < std::min(balance_.size(), new_index.size()); ++i)
    if (new_index[i] != kGone) sorted[new_index[i]] = balance_[i];
  balance_ = std::move(sorted);
}

void ActiveRegion::begin_lists(const ContactStore& contacts, const ParticleStore& particles, const Clumps& clumps,
                               double mean_radius, double cutoff, int threads) {
  if (!on()) return;
  const std::size_t blocks = contacts.particle_blocks.size();
  count_ = particles.size(), mean_radius_ = mean_radius;
  states_.assign(blocks, {}), outcomes_.assign(blocks, Outcome::none), boxes_.assign(blocks, {}),
      was_evaluated_.assign(blocks, 0);
  for (std::size_t k = 0; k < blocks; ++k) {
    const ParticleBlock& b = contacts.particle_blocks[k];
    State& state = states_[k];
    state.frozen = true, state.slow = 1e300;
    for (std::uint32_t i = b.begin; i < b.end; ++i) {
      const Sphere& s = particles[i];
      const double around = s.r + cutoff;
      boxes_[k].include(s.x - Vec3{around, around, around}), boxes_[k].include(s.x + Vec3{around, around, around});
      const bool asleep = s.calm >= kFresh;
      state.frozen = state.frozen && asleep;
      state.fresh = state.fresh || s.calm == kFresh;
      if (!asleep) state.slow = std::min(state.slow, balance_[i].slow);
      state.driven = state.driven || (is_fixed(s) && !(s.v == Vec3{} && s.w == Vec3{}));
    }
    state.frozen = state.frozen && !state.driven;
    if (state.frozen)
      state.slow = 0;
    else
      state.fresh = false;
  }
  find_partners(contacts, threads);
  find_clumps(clumps, particles);
  changed_ = true;
}

void ActiveRegion::find_clumps(const Clumps& clumps, const ParticleStore& particles) {
  const std::size_t count = clumps.all().size();
  clumps_.assign(count, {});
  members_begin_.assign(1, 0), members_.clear();
  std::vector<std::vector<std::uint32_t>> of(count > 0 ? states_.size() : 0);
  for (std::uint32_t c = 0; c < count; ++c) {
    for (const std::uint32_t i : clumps.members(c)) {
      members_.push_back(i);
      std::vector<std::uint32_t>& here = of[i / kParticleBlock];
      if (here.empty() || here.back() != c) here.push_back(c);
    }
    const std::uint8_t calm = particles[members_[members_begin_.back()]].calm;
    clumps_[c].asleep = calm >= kFresh, clumps_[c].fresh = calm == kFresh;
    members_begin_.push_back(static_cast<std::uint32_t>(members_.size()));
  }
  clumps_begin_.assign(1, 0), clumps_of_.clear();
  for (const auto& here : of) {
    clumps_of_.insert(clumps_of_.end(), here.begin(), here.end());
    clumps_begin_.push_back(static_cast<std::uint32_t>(clumps_of_.size()));
  }
}

/// Blocks that share a pair of the lists, from both sides.
void ActiveRegion::find_partners(const ContactStore& contacts, int threads) {
  const std::size_t blocks = contacts.particle_blocks.size();
  std::vector<std::vector<std::uint32_t>> of(blocks);
#pragma omp parallel num_threads(threads)
  {
    std::vector<std::uint32_t> seen(blocks, kGone);
#pragma omp for schedule(static)
    for (long n = 0; n < static_cast<long>(blocks); ++n) {
      const auto own = static_cast<std::uint32_t>(n);
      const ParticleBlock& block = contacts.particle_blocks[own];
      seen[own] = own;
      for (std::uint32_t r = block.runs_begin; r < block.runs_end; ++r)
        contacts.each_lane(contacts.runs[r], [&](std::uint32_t b, std::uint32_t lane) {
          const std::uint32_t second = contacts.blocks[contacts.runs[r].first + b].j[lane];
          const std::uint32_t partner = contacts.images.sphere(second) / kParticleBlock;
          if (std::exchange(seen[partner], own) != own) of[own].push_back(partner);
        });
      std::sort(of[own].begin(), of[own].end());
    }
  }
  std::vector<std::uint32_t> before(blocks, 0);  // partners that come before each block
  for (const auto& later_ones : of)
    for (const std::uint32_t k : later_ones) ++before[k];
  begin_.assign(blocks + 1, 0), middle_.assign(blocks, 0);
  for (std::size_t k = 0; k < blocks; ++k) {
    middle_[k] = begin_[k] + static_cast<std::uint32_t>(of[k].size());
    begin_[k + 1] = middle_[k] + before[k];
  }
  partners_.resize(begin_.back());
  std::vector<std::uint32_t> next = middle_;
  for (std::uint32_t k = 0; k < blocks; ++k) {
    std::copy(of[k].begin(), of[k].end(), partners_.begin() + begin_[k]);
    for (const std::uint32_t later_one : of[k]) partners_[next[later_one]++] = k;
  }
}

void ActiveRegion::plan(long step, double dt, double gravity, bool new_lists, bool all_energies, bool snapshot,
                        std::span<const Boundary> boundaries, const ParticleStore& particles,
                        std::span<const BlockSums> sums, ContactStore& contacts) {
  observed_ = false;
  if (states_.empty()) return;
  const bool check = step % kCheck == 0, all = new_lists || std::exchange(check_all_, false);
  speed_limit_ = rule_->below > 0 ? rule_->below : kInertialNumber * std::sqrt(2 * mean_radius_ * gravity);
  rest_time_ = static_cast<double>(kCheck * kCalm) * dt;
  if (gravity > 0) rest_time_ = std::max(rest_time_, 2 * speed_limit_ / (kUnbalanced * gravity));
  change_limit_ = gravity > 0 ? kUnbalanced * gravity : 2 * speed_limit_ / rest_time_;
  turning_limit_ = std::max(speed_limit_, std::sqrt(2 * mean_radius_ * gravity));
  // Of the change of the forces in a check; none where the check is not one of the series.
  gain_ = check ? std::min(1.0, static_cast<double>(kCheck) * dt / rest_time_) : 0;
  take_outcomes();
  watch_speeds(sums);
  const auto moving = static_cast<std::size_t>(std::count_if(boundaries.begin(), boundaries.end(), moves_now));
  if (check) add_slow_time(static_cast<double>(kCheck) * dt);
  if (check || all || moving != moving_) find_near(boundaries);
  moving_ = moving;
  if (check && !new_lists) choose_freezing(particles);
  mark(check, all, all_energies || snapshot, snapshot, contacts);
}

void ActiveRegion::take_outcomes() {
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const Outcome outcome = std::exchange(outcomes_[k], Outcome::none);
    State& s = states_[k];
    if (outcome == Outcome::moves) {
      wake(k);
    } else if (outcome == Outcome::rests && std::exchange(s.fresh, false)) {
      changed_ = true;
    }
  }
  for (std::uint32_t c = 0; c < clumps_.size(); ++c) {
    ClumpState& s = clumps_[c];
    const Outcome outcome = std::exchange(s.outcome, Outcome::none);
    if (outcome == Outcome::moves)
      wake_clump(c);
    else if (outcome == Outcome::rests && std::exchange(s.fresh, false))
      changed_ = true;
  }
  fall_asleep();
}

/// What the neighbours of those that fall asleep get from them is constant from now on.
void ActiveRegion::fall_asleep() {
  std::vector<std::size_t> rest;  // blocks where something does
  for (std::size_t c = 0; c < clumps_.size(); ++c) {
    if (!std::exchange(clumps_[c].freezes, false)) continue;
    clumps_[c].asleep = true;
    for (const std::uint32_t i : members(c)) rest.push_back(i / kParticleBlock);
  }
  for (std::size_t k = 0; k < states_.size(); ++k) {
    if (!std::exchange(states_[k].freezes, false)) continue;
    const auto of = clumps_of(k);  // one may have woken in this very step
    states_[k].frozen = std::all_of(of.begin(), of.end(), [&](std::uint32_t c) { return clumps_[c].asleep; });
    rest.push_back(k);
  }
  if (rest.empty()) return;
  changed_ = true;
  std::vector<char> renewed(states_.size(), 0);
  for (const std::size_t k : rest) {
    if (renewed[k] == 2) continue;
    renewed[k] = 2;
    for (const std::uint32_t n : neighbours(k)) renewed[n] = std::max<char>(renewed[n], 1);
  }
  for (std::size_t k = 0; k < states_.size(); ++k) {
    if (renewed[k] == 0) continue;
    states_[k].fresh = states_[k].frozen;
    for (const std::uint32_t c : clumps_of(k)) clumps_[c].fresh = clumps_[c].asleep;
  }
}

/// All that sleeps in a block that moves from now on. Blocks that wake with a clump have others that sleep on.
void ActiveRegion::wake(std::size_t block) {
  State& s = states_[block];
  s.frozen = s.fresh = false, s.slow = 0;
  changed_ = true;
  wake_what_sleeps(block);
}

void ActiveRegion::wake_what_sleeps(std::size_t block) {
  if (states_[block].frozen) return wake(block);
  for (const std::uint32_t c : clumps_of(block))
    if (clumps_[c].asleep) wake_clump(c);
}

void ActiveRegion::wake_clump(std::uint32_t clump) {
  clumps_[clump].asleep = clumps_[clump].fresh = false;
  changed_ = true;
  for (const std::uint32_t i : members(clump))
    if (State& s = state_of(i); s.frozen) s.frozen = s.fresh = false, s.slow = 0;
}

void ActiveRegion::watch_speeds(std::span<const BlockSums> sums) {
  for (std::size_t k = 0; k < states_.size(); ++k) {
    if (states_[k].frozen) continue;
    states_[k].speed2 = std::max(states_[k].speed2, sums[k].speed2);
    if (sums[k].speed2 < limit2() && !states_[k].driven) continue;
    wake_what_sleeps(k);
    for (const std::uint32_t n : neighbours(k)) wake_what_sleeps(n);
  }
}

void ActiveRegion::add_slow_time(double time) {
  for (State& s : states_) {
    if (s.frozen) continue;
    s.slow = s.speed2 < limit2() && !s.driven ? s.slow + time : 0;
    s.speed2 = 0;
  }
}

void ActiveRegion::find_near(std::span<const Boundary> boundaries) {
  for (State& s : states_) s.near = false;
  for (const Boundary& b : boundaries) {
    if (!moves_now(b)) continue;
    for (std::size_t k = 0; k < states_.size(); ++k)
      if (distance(boxes_[k], b) <= rule_->within) {
        states_[k].near = true;
        wake_what_sleeps(k);
      }
  }
}

bool ActiveRegion::may_freeze(std::size_t block) const {
  const auto rests = [&](std::uint32_t k) { return states_[k].frozen || states_[k].slow >= rest_time_; };
  const State& s = states_[block];
  const auto around = neighbours(block);
  return !s.frozen && !s.near && s.slow >= rest_time_ && std::all_of(around.begin(), around.end(), rests);
}

/// Speeds of centres have been watched; what is left are spheres that turn on the spot. About the normal of a contact
/// nothing brakes them unless the law resists torsion: one in a hundred turns for seconds in a bed at rest.
void ActiveRegion::choose_freezing(const ParticleStore& particles) {
  const auto turns = [&](std::uint32_t i) {
    const Sphere s = particles.now(i);
    return !(s.r * s.r * dot(s.w, s.w) < turning_limit_ * turning_limit_);
  };
  std::vector<char> may(states_.size());
  for (std::size_t k = 0; k < states_.size(); ++k) may[k] = may_freeze(k);
  for (std::size_t c = 0; c < clumps_.size(); ++c) {
    const auto of = members(c);
    clumps_[c].freezes = !clumps_[c].asleep && std::all_of(of.begin(), of.end(), [&](std::uint32_t i) {
      return may[i / kParticleBlock] != 0 && !turns(i);
    });
  }
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const auto of = clumps_of(k);
    if (may[k] == 0 ||
        !std::all_of(of.begin(), of.end(), [&](std::uint32_t c) { return clumps_[c].asleep || clumps_[c].freezes; }))
      continue;
    const std::size_t begin = k * kParticleBlock, end = std::min<std::size_t>(begin + kParticleBlock, count_);
    states_[k].freezes = true;
    for (std::size_t i = begin; i < end && states_[k].freezes; ++i)
      states_[k].freezes = !turns(static_cast<std::uint32_t>(i));
  }
}

void ActiveRegion::mark(bool check, bool all, bool all_energies, bool snapshot, ContactStore& contacts) {
  const bool plain = !check && !all && !all_energies;
  if (plain && plain_ && !changed_) return;
  changed_ = false, plain_ = plain;
  const auto moving = [&](std::uint32_t k) { return !states_[k].frozen; };
  const auto any = [](std::span<const std::uint32_t> blocks, const auto& holds) {
    return std::any_of(blocks.begin(), blocks.end(), holds);
  };
  for (std::size_t k = 0; k < states_.size(); ++k) {
    State& s = states_[k];
    const bool needed = !s.frozen || any(later(k), moving);
    was_evaluated_[k] = s.evaluated;
    s.evaluated = needed || all;
    s.renews = all_energies && s.outdated;
    s.observed = snapshot || s.renews;
    s.outdated = needed || (s.outdated && !all_energies);
    s.beside_moving = s.frozen && (needed || any(earlier(k), moving));
    s.checked = s.frozen && (s.fresh || all || (check && s.beside_moving));
  }
  for (std::size_t k = 0; k < states_.size(); ++k) {
    if (!states_[k].checked) continue;
    states_[k].evaluated = true;
    for (const std::uint32_t n : earlier(k)) states_[n].evaluated = true;
  }
  for (std::size_t c = 0; c < clumps_.size(); ++c) {
    ClumpState& s = clumps_[c];
    s.checked = s.asleep && (s.fresh || all || (check && is_beside_moving(c)));
  }
  for (State& s : states_) {
    s.observed = s.observed && !s.evaluated;
    s.evaluated = s.evaluated || s.observed;
    observed_ = observed_ || s.observed;
  }
  for (std::size_t k = 0; k < states_.size(); ++k) {
    State& s = states_[k];
    s.receives = s.frozen && (s.evaluated || any(earlier(k), [&](std::uint32_t n) { return states_[n].evaluated; }));
    if (was_evaluated_[k] == 0 || s.evaluated) continue;
    // What its contacts gave across interfaces is not given again.
    const ParticleBlock& block = contacts.particle_blocks[k];
    for (std::uint32_t r = block.runs_begin; r < block.runs_end; ++r)
      if (const PairRun& run = contacts.runs[r]; run.across_interface)
        std::fill_n(contacts.interface_given.begin() + run.rows, run.blocks, std::uint8_t{0});
  }
}

bool ActiveRegion::balanced(bool fresh, bool beside_moving, std::size_t sphere, const Vec3& acceleration,
                            const Vec3& turn) {
  Balance& b = balance_[sphere];
  if (fresh) {
    b = {.slow = 0, .acceleration = acceleration, .turn = turn, .change = {}, .turn_change = {}};
    return true;
  }
  const auto take = [&](const Vec3& now, const Vec3& at_rest, Vec3& change) {
    if (!beside_moving)
      change = now - at_rest;
    else
      change += gain_ * (now - at_rest - change);
    return norm(change) < change_limit_;
  };
  const bool moves = take(acceleration, b.acceleration, b.change), turns = take(turn, b.turn, b.turn_change);
  return moves && turns;
}

bool ActiveRegion::rests(std::size_t block, std::size_t sphere, const Vec3& acceleration, const Vec3& turn) {
  return balanced(states_[block].fresh, states_[block].beside_moving, sphere, acceleration, turn);
}

bool ActiveRegion::is_beside_moving(std::size_t clump) const {
  const auto of = members(clump);
  return std::any_of(of.begin(), of.end(),
                     [&](std::uint32_t i) { return !state_of(i).frozen || state_of(i).beside_moving; });
}

void ActiveRegion::check_clump(std::size_t clump, const Vec3& acceleration, const Vec3& turn) {
  ClumpState& s = clumps_[clump];
  const bool rests = balanced(s.fresh, is_beside_moving(clump), members(clump).front(), acceleration, turn);
  s.outcome = rests ? Outcome::rests : Outcome::moves;
}

void ActiveRegion::archive(Archive& a, std::size_t count) {
  if (a.reads()) forget(), balance_.clear(), check_all_ = false;
  bool kept = on();
  a("kept", kept);
  if (!kept) return;
  std::vector<Balance> balance = balance_;
  balance.resize(count);  // those that were added since the last lists
  a("balance", balance);
  if (balance.size() != count) Archive::refuse("balance");
  if (a.reads()) balance_ = std::move(balance);
}

void ActiveRegion::archive_lists(Archive& a, std::span<BlockSums> sums) {
  std::size_t blocks = states_.size();
  a("blocks", blocks)("moving", moving_)("check all", check_all_);
  if (blocks > sums.size()) Archive::refuse("blocks");
  for (std::size_t k = 0; k < blocks; ++k) {
    double speed2 = k < states_.size() ? states_[k].speed2 : 0;  // none where the run continues without sleep
    a("speed2 of check", speed2)("speed2", sums[k].speed2)("frozen", sums[k].frozen);
    if (k < states_.size()) states_[k].speed2 = speed2;
  }
}

std::size_t ActiveRegion::frozen_spheres() const {
  std::size_t frozen = 0;
  for (std::size_t k = 0; k < states_.size(); ++k)
    if (states_[k].frozen) frozen += std::min<std::size_t>(kParticleBlock, count_ - k * kParticleBlock);
  for (std::size_t c = 0; c < clumps_.size(); ++c)
    for (const std::uint32_t i : members(c)) frozen += clumps_[c].asleep && !state_of(i).frozen ? 1 : 0;
  return frozen;
}

}  // namespace subsoil::dem
