#pragma once

#include <cstddef>
#include <vector>

#include "libmbd/integrators/step_clock.hpp"
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// What fixed steps are estimated to err by: the difference of predictor and corrector by Milne's device. Positions
/// over the machine's length, velocities over the maximum so far, angles times length.
struct StepError {
  double largest = 0;     ///< of a step, in position (1)
  double positions = 0;   ///< sum over the steps (1)
  double velocities = 0;  ///< sum over the steps, times `fastest` (m/s)
  double fastest = 0;     ///< m/s
  double drift = 0;       ///< way that `velocities` lead to, over the machine's length; not of external wrenches (1)
  double unseen = 0;      ///< of what an input does, the share that given steps miss or add: Inputs::Missed (1)
  /// Of the whole run, where errors add up and the motion does not magnify them.
  double sum() const { return positions + drift + (fastest > 0 ? velocities / fastest : 0); }
  bool operator==(const StepError&) const = default;
};

/// A machine between two steps, as a value: what a restart needs. Files name its fields by `archive`.
struct Snapshot {
  double time = 0;                                     ///< s
  std::vector<double> pose, velocity;                  ///< q, q'
  std::vector<double> flows;                           ///< EnergyFlows::of_elements
  double external_work = 0, latched = 0;               ///< J
  double energy_at_start = 0, most_energy = 0;         ///< J, of the balance
  double lowest_potential = 0, highest_potential = 0;  ///< J
  System::Restart elements;
  StepError error;
  std::vector<int> switches;  ///< sides
  struct SwitchEvent {
    double time = 0;
    int direction = 0;
    std::size_t of = 0;  ///< the switch
    bool operator==(const SwitchEvent&) const = default;
    template <class A>
    void archive(A& a) {
      a("time", time)("direction", direction)("switch", of);
    }
  };
  std::vector<SwitchEvent> events;
  /// Of a multistep method; empty for those that restart from the state alone.
  struct Past {
    double step = 0, origin = 0;  ///< s
    long steps = 0;
    long level = 0, sure = 0;                ///< of steps that are halved to their error
    std::vector<std::vector<double>> rates;  ///< the oldest first
    std::vector<double> missed, all;         ///< of inputs, by given steps
    StepClock clock;                         ///< of advance()
    bool operator==(const Past&) const = default;
  } past;

  bool operator==(const Snapshot&) const = default;
  template <class A>
  void archive(A& a) {
    a("time", time)("pose", pose)("velocity", velocity);
    a("flows", flows)("external work", external_work)("latched", latched);
    a("energy at start", energy_at_start)("most energy", most_energy);
    a("lowest potential", lowest_potential)("highest potential", highest_potential);
    a("elements", elements);
    a("largest error", error.largest)("error of positions", error.positions);
    a("error of velocities", error.velocities)("fastest", error.fastest)("drift", error.drift);
    a("switches", switches)("events", events);
    a.group("past", [&] {
      a("step", past.step)("origin", past.origin)("steps", past.steps)("level", past.level)("sure", past.sure);
      a("rates", past.rates)("missed", past.missed)("all", past.all);
      past.clock.archive(a);
    });
  }
};

}  // namespace subsoil::mbd
