#include "libmbd/integrators/dense_output.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace subsoil::mbd {

std::size_t DenseOutput::segment_at(double& t) const {
  const double first = empty() ? t : begin(), last = empty() ? t : end();
  const double rounding = std::max(1e-9 * (last - first), 1e-14 * std::max(1.0, std::abs(last)));
  if (!(first < last) || t < first - rounding || t > last + rounding)
    throw std::logic_error("dense output: t = " + std::to_string(t) + " s is not inside the last step that was kept");
  t = std::clamp(t, first, last);
  const auto found = std::find_if(segments.begin(), segments.end(), [&](const StepSegment& s) { return t <= s.end.t; });
  return static_cast<std::size_t>(found - segments.begin());
}

State DenseOutput::state(double t) const {
  const std::size_t segment = segment_at(t);
  return state(t, segment);
}

State DenseOutput::state(double t, std::size_t segment) const {
  State out;
  read(t, segment, out);
  return out;
}

void DenseOutput::read(double t, std::size_t segment, State& out) const {
  const StepSegment& s = segments[segment];
  out.before_jump = t > s.begin.t;
  out.open = s.open, out.grips = s.grips, out.choice = s.choice, out.nearest = s.nearest;
  out.memory = memory, out.external_work_begin = segments.front().flows_begin.external_work;
  out.motion = s.end, out.flows = s.flows_end;
  out.motion.t = t;
  if (!s.polynomial.empty()) {
    s.polynomial.read(t, s.end, out.motion, out.flows.of_elements);
  } else if (s.end.t - s.begin.t > 1e-9 * (end() - begin())) {  // else what is left behind an event at the step's end
    interpolate(s.begin, s.end, t, out.motion);
    interpolate_flows(s.begin, s.end, s.flows_begin.of_elements, s.flows_end.of_elements, t, out.flows.of_elements);
  }
}

}  // namespace subsoil::mbd
