#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "libmbd/assembly/partition.hpp"
#include "libmbd/integrators/between.hpp"
#include "libmbd/integrators/events.hpp"

namespace subsoil::mbd {

/// The integrators; one word in a scenario. `kinematic` integrates nothing: it follows a machine that drivers hold in
/// every coordinate (analysis: kinematics).
enum class IntegratorKind { adams_moulton, cvode, ida, kinematic };

/// What to do with the past of a multistep method when the external wrench jumps between two machine steps.
///   shift    the jump in acceleration, exact at the present state, is added to every stored one, as if the new wrench
///            had acted all along. The step then transfers exactly h times the new wrench, no filter of old ones, and
///            costs one evaluation of forces. The past's velocities still bend where the wrench jumped, which leaves an
///            error of O(jump h^2) per step: for a wrench that follows a smooth soil force the jump is O(h) itself, so
///            the scheme keeps order 2, above the order 1 of the explicit staggered coupling that made the jump.
///   restart  forgets the past and starts again by Runge-Kutta: the full order inside each step, at six evaluations
///            in place of two. For checks, and for few, large jumps.
/// Keeping the past as it is would be worse than either: an order-4 step would weigh the wrenches of the last four
/// steps with 9, 19, -5 and 1 twenty-fourths, and the work at the interface would not be the soil's.
enum class WrenchJump { shift, restart };

struct AdamsMoultonOptions {
  int order = 4;
  WrenchJump wrench_jump = WrenchJump::shift;
  double longest_step = std::numeric_limits<double>::infinity();  ///< s; a step that is longer is made of equal parts
};

struct CvodeOptions {
  double rtol = 1e-8;
  double atol = 1e-10;
};

/// The equations that IDA solves; see ida.hpp.
enum class IdaFormulation { stabilised_index_2, index_1 };

struct IdaOptions {
  double rtol = 1e-8;
  double atol = 1e-10;
  IdaFormulation formulation = IdaFormulation::stabilised_index_2;
};

/// Energy that entered or left since the start (J): integrals of powers, never remainders.
struct EnergyFlows {
  /// Integrals of MotionState::rates: lost of forces, work of forces, work of drivers (J); then the states themselves.
  Eigen::VectorXd of_elements;
  double external_work = 0;  ///< of external wrenches: wrench times displacement, exact since it is constant per step
  double latched = 0;        ///< lost in impacts of joints that closed
};

/// Of the energies seen on the way (J): the most of kinetic + stored, the range of potential.
struct EnergyRange {
  double most = 0;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  void see(const System& system) {
    most = std::max(most, system.kinetic() + system.stored());
    const double potential = system.potential();
    lowest = std::min(lowest, potential), highest = std::max(highest, potential);
  }
};

/// What fixed steps are estimated to err by: the difference of predictor and corrector by Milne's device. Positions
/// over the machine's length, velocities over the maximum so far, angles times length.
struct StepError {
  double largest = 0;     ///< of a step, in position (1)
  double positions = 0;   ///< sum over the steps (1)
  double velocities = 0;  ///< sum over the steps, times `fastest` (m/s)
  double fastest = 0;     ///< m/s
  /// Of the whole run, where errors add up and the motion does not magnify them.
  double sum() const { return positions + (fastest > 0 ? velocities / fastest : 0); }
};

/// Moves a consistent state forward in time. One step interface for a coupling loop: set wrenches on the system,
/// advance.
class Integrator {
 public:
  explicit Integrator(System& system);
  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  /// Begins at a consistent state (see assemble()).
  void start(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity);
  /// Moves on by h > 0 with the external wrenches held, and accepts the step (ruts). Ends exactly at its end.
  void advance(double h);
  /// Whether zeros of switching functions are located and the method restarted there (default), or stepped over.
  /// Takes effect at the next start().
  void locate_events(bool locate) { locate_ = locate; }
  /// Events since the start, in time.
  const std::vector<Event>& events() const { return events_; }

  /// Whether advance() ends at any time at no cost, by a dense output of the method's own.
  virtual bool ends_anywhere() const { return true; }
  /// Keeps from now on what look_back() needs of the step before.
  void keep_steps() { keeps_ = true; }
  /// Shows state(), flows(), partition() and the system at a time inside the last step: the interpolant of that time,
  /// put on the constraints by a partition of its own, so that nothing that is read changes a bit of the motion. That
  /// stays at the step's end, to which look_ahead() returns. Throws std::logic_error for a time outside the step.
  void look_back(double t);
  /// A part of the last step in which nothing jumps: between events and samples, and of a method with steps of its own
  /// within one of these.
  struct Span {
    double begin, end;
    bool jumps;  ///< something may, at its begin
  };
  std::size_t pieces() const { return pieces_.size(); }
  Span piece(std::size_t i) const { return {pieces_[i].begin.t, pieces_[i].end.t, pieces_[i].jumps}; }
  /// The same in a piece: at its begin behind what jumps there, at its end before.
  void look_back(double t, std::size_t piece);
  void look_ahead();

  const MotionState& state() const { return viewer_ ? viewer_->state : shown_ ? shown_->state : now_; }
  const EnergyFlows& flows() const { return viewer_ ? viewer_->flows : shown_ ? shown_->flows : flows_; }
  /// Zero for methods that hold their errors to a tolerance.
  const StepError& step_error() const { return step_error_; }
  /// Energies in every step of the method's own since it was asked last.
  EnergyRange take_energy_range() { return std::exchange(energy_range_, {}); }
  Partition& partition() { return partition_; }
  const Partition& partition() const { return viewer_ ? viewer_->partition : shown_ ? shown_->partition : partition_; }
  System& system() { return system_; }

  /// Everything a restart needs, as plain numbers, and back.
  void save(std::vector<double>& out) const;
  void restore(const double*& from, const double* end);

 protected:
  virtual void on_start() = 0;
  virtual void on_advance(double) {}
  /// All of advance(): steps of a fixed length that end where it does, in parts between instants and events.
  virtual void move(double h);
  /// A method with dense output finds events inside its own steps; fixed steps are repeated in parts by advance().
  virtual bool finds_events() const { return false; }
  bool watches_switches() const { return locate_ && switches_.count() > 0; }
  /// All switching functions at a state that the partition has evaluated.
  void look(const MotionState& m, std::vector<double>& gaps);
  /// Records the event and puts the switch on its other side, at the present state.
  void take_event(std::size_t which);
  /// Events of joints whose condition is met where no step has led there: at the start, after a jump of forces. At a
  /// state that the partition has evaluated; true where there were any.
  bool fire_due();
  /// Friction whose stiction or sense of sliding an impact or jump has ended, where no step has led there: at a
  /// state that the partition has evaluated.
  void release_friction();
  /// Around what changes at an instant inside a step, for look_back(); or where a method's own step has ended.
  void keep_begin(bool jumps = true);
  void keep_end();
  bool keeps() const { return keeps_; }

  /// What a step leaves to be read, in which nothing jumps: an immutable polynomial and what belongs to it.
  struct Piece {
    MotionState begin, end;
    EnergyFlows flows_begin, flows_end;
    std::vector<char> open{};  ///< joints that are open in it
    System::Grips grips{};     ///< of friction in it
    std::shared_ptr<const Choice> choice{};
    bool jumps = true;
    Polynomial polynomial{};  ///< empty: the quintic between both ends
    bool nearest = false;     ///< beside a singular configuration
  };
  /// Where one looks: a partition of its own, since the factors of the motion's must not depend on it.
  struct Viewer {
    explicit Viewer(System& system) : partition(system) {}
    Partition partition;
    MotionState state;
    EnergyFlows flows;
  };
  /// The state at t, for the viewer and the system.
  void view(double t, const Piece& piece, Viewer& out);
  /// state() is that of a time before the method's own end; look_ahead() returns there.
  void show(double t, const Piece& piece);
  /// state() is the motion's own again.
  void hide() {
    if (shown_) idle_shown_ = std::move(shown_);
  }
  bool shows() const { return shown_ != nullptr; }
  Piece begin_piece(bool jumps) const;
  void act(double close);
  void fire(std::size_t event);
  double external_work_since(const Eigen::VectorXd& q) const;
  virtual void on_save(std::vector<double>&) const {}
  virtual void on_restore(const double*&, const double*) {}
  static void put(std::vector<double>& out, const Eigen::VectorXd& v) {
    out.insert(out.end(), v.data(), v.data() + v.size());
  }
  static void take(const double*& from, const double* end, Eigen::VectorXd& v);
  static double take(const double*& from, const double* end);

  System& system_;
  Partition partition_;
  MotionState now_;
  EnergyFlows flows_;
  Switches switches_;
  StepError step_error_;
  EnergyRange energy_range_;
  std::vector<Piece> pieces_;  ///< of the last advance(), in time
  Eigen::VectorXd q_before_;
  long changes_seen_ = 0;

 private:
  void begin_states();
  bool begin_controllers();
  void await_passage();
  bool switch_joints(std::vector<std::size_t> due, std::vector<char>& had);
  void arm(const std::vector<char>& open);
  std::vector<std::size_t> reached(const std::vector<char>& had);
  void take_impulse();
  void begin_grips();
  double grip(std::size_t force);
  void advance_part(double h);
  void advance_over_instants(double h);
  void advance_over_events(double h);
  bool crossed();
  bool comes_and_goes();
  void try_part(double h);

  void set_seen(const MotionState& m);

  std::unique_ptr<Viewer> viewer_, idle_viewer_, shown_, idle_shown_;
  bool keeps_ = false, looks_back_ = false;
  std::vector<char> open_now_;  // during dense output
  System::Grips grips_now_;
  System::Seen seen_now_;

  bool locate_ = true;
  std::vector<Event> events_;
  MotionState before_;
  EnergyFlows flows_before_;
  std::vector<double> gaps_;
};

/// Ends of equal steps without gathered rounding: origin + count * h for as long as h stays what it is. Steps that
/// differ by rounding gather: origin and h are set again before that is seen.
class StepClock {
 public:
  void restart() { step_ = 0; }
  double end_of_step(double now, double h) {
    const double end = origin_ + static_cast<double>(count_ + 1) * step_;
    const bool goes_on = std::abs(h - step_) <= 1e-9 * step_ && std::abs(end - (now + h)) <= 1e-10 * h;
    if (!goes_on) step_ = h, origin_ = now, count_ = 0;
    return origin_ + static_cast<double>(++count_) * step_;
  }

 private:
  double step_ = 0, origin_ = 0;
  long count_ = 0;
};

std::unique_ptr<Integrator> make_integrator(IntegratorKind kind, System& system, const AdamsMoultonOptions& adams = {},
                                            const IdaOptions& ida = {}, const CvodeOptions& cvode = {});

}  // namespace subsoil::mbd
