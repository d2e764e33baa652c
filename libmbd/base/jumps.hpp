#pragma once

#include <optional>

#include "libmbd/base/function.hpp"

namespace subsoil::mbd {

/// Where a function of time or its rate jumps: values before and after.
struct Jump {
  double time = 0;  ///< s
  double before = 0, after = 0;
  bool of_rate = false;  ///< of f', f itself is continuous
};

/// What has to be continuous: of a position f and f', of a velocity f.
enum class Smooth { value, value_and_rate };

/// The first jump in [from, until], as a body sees it that follows f: it has at `from` the value there, and right after
/// it that of t > from. From sample to sample the trapezoidal rule foretells the change of f from f', that of f' from
/// f''. Where it is off by more than 1e-6 of the range of f (1e-4 where f is a velocity, and 1e-4 of the maximum |f'|)
/// the interval is halved down to 1e-9 s: what is still off there jumps, as far as a body can tell. So does a ramp that
/// is shorter.
/// Samples are 0.25 ms apart, as those of Inputs, up to 100 s, farther in longer runs. Jumps that cancel between two of
/// them stay unseen. A formula without a value has none here; it ends the run where it is asked for.
std::optional<Jump> first_jump(const Function& f, Smooth wanted, double from, double until);

}  // namespace subsoil::mbd
