#pragma once

#include <algorithm>
#include <array>
#include <exception>
#include <limits>

#include "libmbd/integrators/hidden_contacts.hpp"
#include "libmbd/integrators/inputs.hpp"
#include "libmbd/integrators/integrator.hpp"
#include "libmbd/integrators/profiles.hpp"
#include "libmbd/integrators/singular_passage.hpp"

namespace subsoil::mbd {

/// What a step of a method with its own step control may err by, when `asked` is the error asked for: a hundredth,
/// since errors of some hundred steps gather and grow with the motion. Not below `floor`, where rounding would drive
/// the steps, unless that is what was asked for.
inline double local_tolerance(double asked, double floor) { return std::min(asked, std::max(0.01 * asked, floor)); }

/// Failures that a step may meet before it is given up, each shortening it fourfold. SUNDIALS' own 7 and 10 do not
/// bring a long step of a free flight down to what a stiff contact allows.
inline constexpr int most_failures_of_a_step = 40;

/// What the variable-step integrators have in common. They take steps of their own, whose ends depend on nothing that
/// is asked for: advance() takes steps until one reaches its end, and state() is then the dense output there, put on
/// Phi = 0 and Phi_q q' = -Phi_t to rounding by a partition of its own. Only where the future is not known, since
/// external wrenches may jump, is each end of advance() a stop time; instants of sampled controllers and timed events
/// are stop times always. No step is longer than what Inputs and Profiles let it be. Zeros of switching functions
/// restart the method: no smooth history crosses them. Steps beside and over singular configurations are those of
/// SingularPassage.
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
  void move(double h) override;
  void on_restore(const Snapshot::Past&) override { on_start(); }
  bool finds_events() const override { return true; }

  struct Reached {
    double t = 0;
    bool root = false;  ///< a switching function is zero at t
  };
  /// A new solver for the present partition: after a start, or when the set of used equations has changed.
  virtual void build() = 0;
  /// Begins at now_ and flows_, without history.
  virtual void begin() = 0;
  /// One step of the method's choice; not beyond `stop` where it is finite. Its inputs are seen from inside.
  virtual Reached take_step(double stop, const Inputs::Inside& inside) = 0;
  /// Length of the step that the method takes next, at the most.
  virtual double planned_step() const = 0;
  /// Dense output at t, which is not beyond what was reached: q, q' (of independent coordinates at least; the others
  /// are a guess) into now_, flows_ too.
  virtual void read(double t) = 0;
  /// Dense output of the last step as a polynomial, and the end of the segment at t.
  virtual void dense(double t, StepSegment& out) = 0;
  /// The switching functions at the end of the last step, where it ended at no root.
  virtual const std::vector<double>& end_values() const = 0;
  /// -1, 0 or +1 for each switching function: where the last root was, and in which direction.
  virtual void root_directions(std::vector<int>& out) = 0;
  /// Whether the unknowns are those of the partition's choice, so that a new choice restarts.
  virtual bool follows_partition() const = 0;
  /// What a step may err by in q and q' of size 1.
  virtual double step_tolerance() const = 0;
  /// The method asks to restart by other means, where a step of it has ended.
  virtual bool wants_restart() { return false; }
  /// The solution read last has left what was asked for by more than the tolerance: restart from the projection.
  virtual bool has_drifted() const { return false; }

  std::exception_ptr failure_;  ///< of the method's last trial step that threw, since it began

 private:
  /// What comes before the next step of the method.
  enum class First { nothing, event, restart };

  void restart();
  void meet_jump();
  bool act_at_instant(double end);
  void commit();
  void keep_segment(double begin, bool beside, const std::shared_ptr<const Choice>& choice);
  void read_consistent(double t);
  void need_state();
  void return_from_samples();
  void pass_event();
  void sample_gaps(GapSample& out);
  void stop_at_hidden_contact(double begin);
  void sample_step(double begin);
  void stop_at_dip(std::size_t which);
  void stop_at_hidden_event(double begin);
  void stop_at_hidden_slip(double begin, bool root);
  bool stop_at_slip_of_end(double begin);
  bool may_have_slipped(double begin, bool root);
  [[noreturn]] void give_up(long taken, double end);
  bool try_step(double stop, Reached& reached);
  double resolved_stop(double stop, double planned);
  void next_step(double stop);
  bool opens_contact();
  void method_step(double stop);
  void settle_step(double taken);
  bool creeps(double taken) const;
  bool meets_singular();
  void note_distance();
  void passage_step(double stop);
  void pass_event_of_passage();
  std::size_t stop_at_event(double h);

  StepClock clock_;
  Inputs inputs_;
  Profiles profiles_;
  std::vector<int> rows_;
  double front_ = 0;         // what has been reached: dense output ends here
  double output_ = 0;        // what has been asked for: the time of state()
  double last_step_ = 0;     // s, of the method's own
  double longest_step_ = 0;  // the longest of these since the start: beside it creeps() finds a collapse
  First first_ = First::nothing;
  bool has_past_ = false;                                         // steps since the method began
  double first_until_ = std::numeric_limits<double>::infinity();  // where the first step ends at the latest, s
  bool elsewhere_ = false;  // the system was evaluated last at another instant than that of now_
  bool coupled_ = false;    // external wrenches act, which are known to the end of each advance() only
  bool remembers_ = false, commits_ = false;  // forces that remember accepted states; front_ is not one yet
  bool jumps_ = true;                         // something may, at front_
  bool acted_ = false;                        // a sampled controller or timed event, at front_
  long wrench_changes_ = 0;
  std::vector<int> directions_;
  GapSample step_begin_, step_end_;
  std::optional<std::size_t> hidden_here_;  ///< what passes its zero at front_, of which the method knows no root

  SingularPassage passage_;
  std::optional<std::size_t> event_of_passage_;  ///< a switch that ended its last step, and has not acted yet
  struct Nearness {
    double distance = 1;  ///< from a singular configuration (rad)
    int orientation = 1;  ///< sign of det Phi_u
  };
  Nearness at_begin_, at_end_;  ///< of the last step of the method
  MotionState next_;
  Eigen::VectorXd next_flows_;
  std::vector<double> gaps_, gaps_before_;
  std::vector<TimedValue> samples_;  ///< of one switching function over a step
  std::vector<std::vector<double>> event_gaps_;

  /// Margins of friction where a step begins or ends, and how fast they change there.
  struct Margins {
    double t = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> at{}, rates{};
  };
  bool has_friction_ = false;      ///< a switching function is one of friction
  Margins slip_begin_, slip_end_;  ///< of the last step of the method
  Eigen::VectorXd q_sample_;
};

}  // namespace subsoil::mbd
