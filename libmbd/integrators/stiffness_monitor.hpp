#pragma once

#include <algorithm>

namespace subsoil::mbd {

/// Which of two methods a variable-step integrator takes: an explicit one (Adams with functional iteration), whose step
/// the fastest decay limits far below what the error allows, or an implicit one (backward differences with Newton's
/// iteration), whose low order takes shorter steps for the same error. The spectrum of the Jacobian at the end of a
/// window of steps tells whether the step is at the limit of stability; a trial of the other method then measures which
/// of the two advances the motion farther per evaluation of the equations.
///
///   method     window       a trial of the other method where
///   explicit   2000 steps   mean step times fastest decay is above 0.02
///   implicit   2000 steps   mean step times spectral radius is below 0.5: the explicit method bears such steps
///   on trial   300 steps    none; the method stays where its last 150 steps advance twice as far per evaluation as the
///                           window before, otherwise the other one continues and its next windows are twice as long
///
/// Adams-Moulton methods are stable for real decays up to a product of 6 at order 3, 0.49 at order 8 and 0.06 at order
/// 12 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section III.9); functional iteration
/// contracts up to some 0.5. A window of steps of a motion that is not stiff covers some decays only, hence its length.
/// A decay is one within the sector of stability of backward differences of order 4: a damping ratio above 0.3. An
/// undamped oscillation has to be followed by either method. Counts alone decide, so that a run repeats its bits.
class StiffnessMonitor {
 public:
  /// Of the Jacobian (1/s): the fastest decay, the maximum absolute value of an eigenvalue.
  struct Spectrum {
    double decay = 0, radius = 0;
  };
  static constexpr double damping_ratio = 0.3;

  /// One step: by how much it has advanced the motion (s), evaluations that it has cost, of a system of n unknowns.
  void count(double advance, long evaluations, long unknowns);
  /// The window is at its end: see() is due.
  bool asks_for_spectrum() const { return !trial_ && steps_ >= window_; }
  void see(const Spectrum& spectrum);
  bool implicit() const { return implicit_; }
  /// The method is to begin again by what implicit() states; until begun().
  bool wants_change() const { return changed_; }
  void begun() { changed_ = false; }

 private:
  void change(bool trial);
  void end_trial();
  void open_window() { steps_ = evaluations_ = 0, advance_ = 0; }
  double progress() const { return advance_ / static_cast<double>(std::max(evaluations_, 1L)); }

  static constexpr long shortest_window = 2000, longest_window = 1'000'000, trial_steps = 300, trial_start = 150;
  static constexpr double explicit_limit = 0.02, implicit_limit = 0.5, times_better = 2;

  bool implicit_ = false, trial_ = false, changed_ = false;
  long factor_ = 1;  ///< of the length of a window, by trials in vain
  long window_ = shortest_window, steps_ = 0, evaluations_ = 0;
  double advance_ = 0, progress_ = 0;  ///< s; s per evaluation of the method before the trial
};

inline void StiffnessMonitor::count(double advance, long evaluations, long unknowns) {
  // Eigenvalues take some 25 n^3 operations, a step some 600 n: in a window of 2 n^2 steps they are 2 % of the work.
  window_ = std::min(std::max(shortest_window, 2 * unknowns * unknowns) * factor_, longest_window);
  ++steps_;
  if (!trial_ || steps_ > trial_start) advance_ += advance, evaluations_ += evaluations;
  if (trial_ && steps_ == trial_steps) end_trial();
}

inline void StiffnessMonitor::see(const Spectrum& spectrum) {
  const double step = advance_ / static_cast<double>(std::max(steps_, 1L));
  const bool other = implicit_ ? step * spectrum.radius < implicit_limit : step * spectrum.decay > explicit_limit;
  if (!other) return open_window();
  progress_ = progress();
  change(true);
}

inline void StiffnessMonitor::end_trial() {
  if (progress() > times_better * progress_) {
    factor_ = 1, trial_ = false;
    return open_window();
  }
  factor_ = std::min(2 * factor_, longest_window);
  change(false);
}

inline void StiffnessMonitor::change(bool trial) {
  implicit_ = !implicit_, trial_ = trial, changed_ = true;
  open_window();
}

}  // namespace subsoil::mbd
