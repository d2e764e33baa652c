#pragma once

#include <algorithm>
#include <array>
#include <exception>

#include "libmbd/integrators/hidden_contacts.hpp"
#include "libmbd/integrators/inputs.hpp"
#include "libmbd/integrators/integrator.hpp"
#include "libmbd/integrators/profiles.hpp"
#include "libmbd/integrators/runge_kutta.hpp"

namespace subsoil::mbd {

/// What a step of a method with its own step control may err by, when `asked` is the error asked for: a hundredth,
/// since errors of some hundred steps gather and grow with the motion. Not below `floor`, where rounding would drive
/// the steps, unless that is what was asked for.
inline double local_tolerance(double asked, double floor) { return std::min(asked, std::max(0.01 * asked, floor)); }

/// Failures that a step may meet before it is given up, each shortening it fourfold. SUNDIALS' own 7 and 10 do not
/// bring a long step of a free flight down to what a stiff contact allows.
inline constexpr int most_failures_of_a_step = 40;

/// What the variable-step integrators have in common: they run on in steps of their own and outputs are read from
/// their dense output, put on Phi = 0 and Phi_q q' = -Phi_t to rounding by the partition. So a short output interval
/// costs no step. Where the future is not known, since external wrenches jump or forces remember (ruts), each advance()
/// is a stop time. No step is longer than what Inputs and Profiles let it be. Zeros of switching functions restart the
/// method: no smooth history crosses them. Beside a singular pose a Newton matrix loses its rank and an error control
/// sees rounding grow as the cube of the nearness. Such a pose is passed by Runge-Kutta in steps held to the same
/// tolerance, put on the constraints with least change of all coordinates, and the method begins anew behind it. The
/// pose itself is located from the distance before and after a step, and one step leads over it from about 0.03 rad
/// before to as far behind, whatever step and tolerance are: at a distance e rounding eps leaves eps/e^3 of the
/// accelerations, a step 2 e an error (2 e)^6, and both are small there. Its stages stay 0.4 e away. Outputs inside are
/// read from the quintic through q, q', q'' of its ends.
class Adaptive : public Integrator {
 public:
  /// Steps taken and right sides (residuals) evaluated since the start, over all restarts.
  virtual long steps() const = 0;
  virtual long evaluations() const = 0;
  /// The last step of the method's own (s), which its dense output is smooth over; 0 before the first.
  double last_step() const { return last_step_; }

 protected:
  explicit Adaptive(System& system);

  void on_start() override;
  void on_advance(double h) override;
  void on_restore(const double*&, const double*) override { on_start(); }
  bool finds_events() const override { return true; }

  struct Reached {
    double t = 0;
    bool root = false;  ///< a switching function is zero at t
  };
  /// A new solver for the present partition: after a start, or when the set of used equations has changed.
  virtual void build() = 0;
  /// Begins at now_ and flows_, without history.
  virtual void begin() = 0;
  /// One step of the method's choice; not beyond `stop` where it is finite. `end`: of the interval asked for.
  virtual Reached take_step(double end, double stop) = 0;
  /// Length of the step that the method takes next, at the most.
  virtual double planned_step(double end) const = 0;
  /// Dense output at t, which is not beyond what was reached: q, q' (of independent coordinates at least; the others
  /// are a guess) into now_, flows_ too.
  virtual void read(double t) = 0;
  /// -1, 0 or +1 for each switching function: where the last root was, and in which direction.
  virtual void root_directions(std::vector<int>& out) = 0;
  /// Whether the unknowns are those of the partition's choice, so that a new choice begins anew.
  virtual bool follows_partition() const = 0;
  /// What a step may err by in q and q' of size 1.
  virtual double step_tolerance() const = 0;
  /// The solution read last has left what was asked for by more than the tolerance: begin anew from the projection.
  virtual bool has_drifted() const { return false; }

  std::exception_ptr failure_;  ///< of the method's last trial step that threw, since it began

 private:
  void restart();
  void read_consistent(double t);
  void pass_event();
  void sample_gaps(GapSample& out);
  void stop_at_hidden_contact(double begin);
  void stop_at_hidden_event(double begin);
  [[noreturn]] void give_up(long taken, double end);
  bool try_step(double end, double stop, Reached& reached);
  void step_on(double end, double stop);
  bool creeps(double taken) const;
  double rate_of(const MotionState& m) const;
  void walk(double end);
  void begin_walk();
  bool try_walk(double h, double end);
  bool cross(double end);
  void leave_crossing();
  void read_crossing(double t);
  std::size_t stop_at_event(double h);

  StepClock clock_;
  Inputs inputs_;
  Profiles profiles_;
  std::vector<int> rows_;
  double front_ = 0;  // what has been reached: dense output ends here
  double last_step_ = 0;
  bool cut_ = false;  // the last step, much shorter than planned, where an input changes, or a failure: to begin anew
  bool has_past_ = false;  // steps since the method began
  bool root_ = false;
  bool coupled_ = false;
  bool remembers_ = false;  // forces that remember accepted states
  long wrench_changes_ = 0;
  std::vector<int> directions_;
  GapSample step_begin_, step_end_;
  std::optional<std::size_t> hidden_here_;  ///< what passes its zero at front_, of which the method knows no root

  RungeKutta walker_;
  bool beside_singular_ = false;  // at front_
  bool walking_ = false;          // the method has no part in what now_ is
  bool walk_controlled_ = false;
  bool landed_ = false;  // now_ is on a singular pose
  int walk_failures_ = 0;
  double walk_step_ = 0, landing_step_ = 0;
  double distance_ = 0, approach_ = 0;  // from the singular pose, and how fast it falls (1, 1/s); 0: not known
  bool may_cross_ = false;
  bool crossing_ = false;  // now_ is between before_ and after_
  MotionState before_crossing_, after_crossing_;
  Eigen::VectorXd flows_before_, flows_after_;
  MotionState next_;
  Eigen::VectorXd walk_flows_;
  std::vector<double> gaps_, gaps_before_;
  std::array<std::vector<double>, event_looks.size()> event_gaps_;
};

}  // namespace subsoil::mbd
