#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace subsoil::dem {

/// What a step does for the energy balance on the contacts of a particle block.
struct Sample {
  bool record = false;      ///< keeps the dashpot forces that the losses of the next step need
  bool accumulate = false;  ///< adds up what is lost and stored; only with `record`
  double weight = 0;        ///< steps for which the losses stand
};

/// In which steps a particle block's losses are sampled: every block once in so many steps, each in its own, spread
/// evenly. A blow of a few steps is then seen by some of the blocks that it passes through, where it would be missed or
/// counted over by all of them if they were looked at together.
///
/// The losses of a step need the forces of dashpots in the step before, which only a recorded step keeps: two in a row
/// are recorded, of which the second is accumulated. Where lists are new there are other blocks: the samples that are
/// due come one step later.
class Sampling {
 public:
  /// Before each step.
  /// @param every steps per sample @param new_lists whether they were built for this step
  void begin(int every, long step, bool new_lists) {
    late_ = new_lists_ ? std::min(late_ + 1, every - 1) : 0;
    every_ = every, step_ = step, new_lists_ = new_lists;
  }
  /// What the next `begin` looks at, for a restart: steps by which samples are late, whether lists were new.
  int late() const { return late_; }
  bool lists_were_new() const { return new_lists_; }
  void go_on(int late, bool lists_were_new) { late_ = late, new_lists_ = lists_were_new; }
  Sample of(std::size_t block) const {
    if (every_ == 1) return {true, true, 1};
    const long due = overdue(block);
    if (due <= late_) return new_lists_ ? Sample{.record = true} : Sample{true, true, static_cast<double>(every_)};
    return {.record = due == every_ - 1};
  }

 private:
  /// Steps since the block's last sample was due. Neighbours in the order of blocks are far apart in time, and so are
  /// those a slab away: the golden section.
  long overdue(std::size_t block) const {
    constexpr double golden = 0.6180339887498949;
    const double turns = golden * static_cast<double>(block);
    const long offset = static_cast<long>((turns - std::floor(turns)) * every_);
    return (step_ + offset) % every_;
  }

  int every_ = 1, late_ = 0;
  long step_ = 0;
  bool new_lists_ = false;
};

}  // namespace subsoil::dem
