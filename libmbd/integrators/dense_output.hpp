#pragma once

#include "libmbd/integrators/between.hpp"
#include "libmbd/integrators/state.hpp"

namespace subsoil::mbd {

/// A part of a step in which nothing jumps: between events and samples, and of a method with steps of its own within
/// one of these.
struct StepSegment {
  MotionState begin, end;
  EnergyFlows flows_begin, flows_end;
  std::vector<char> open{};  ///< joints that are open in it
  System::Grips grips{};     ///< what forces hold in it
  std::shared_ptr<const Choice> choice{};
  bool jumps = true;        ///< something may, at its begin
  Polynomial polynomial{};  ///< empty: the quintic between both ends
  bool nearest = false;     ///< beside a singular configuration
};

/// What a step leaves between its ends: the states of all its times, as values. A copy outlives the step.
class DenseOutput {
 public:
  struct Span {
    double begin, end;
    bool jumps;  ///< something may, at its begin
  };
  bool empty() const { return segments.empty(); }
  double begin() const { return segments.front().begin.t; }
  double end() const { return segments.back().end.t; }
  std::size_t count() const { return segments.size(); }
  Span span(std::size_t i) const { return {segments[i].begin.t, segments[i].end.t, segments[i].jumps}; }

  /// At a time in the step; where something jumps, before it. Throws std::logic_error for a time outside.
  State state(double t) const;
  /// At a time in a segment: at its begin behind what jumps there, at its end before.
  State state(double t, std::size_t segment) const;
  /// The same without memory of its own.
  void read(double t, std::size_t segment, State& out) const;
  /// The first segment that `t` lies in, `t` put into the step where rounding has it outside.
  std::size_t segment_at(double& t) const;

  std::vector<StepSegment> segments;  ///< in time; written by integrators
  std::shared_ptr<const StepMemory> memory;
};

}  // namespace subsoil::mbd
