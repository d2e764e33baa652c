#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "libmbd/assembly/partition.hpp"
#include "libmbd/integrators/dense_output.hpp"
#include "libmbd/integrators/evaluation.hpp"
#include "libmbd/integrators/events.hpp"
#include "libmbd/integrators/snapshot.hpp"
#include "libmbd/integrators/step_clock.hpp"

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
  /// What a step may err by, in a second of motion: position over the machine's length, velocity over the maximum so
  /// far. A step that errs by more is made of halves, of these again, and of whole ones as soon as these do. Infinite:
  /// all steps are as long as they are asked for.
  double error_per_second = std::numeric_limits<double>::infinity();
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
  /// The same to an instant > now: methods that end anywhere are there to the last bit, whatever led there.
  void advance_to(double end);
  /// Whether zeros of switching functions are located and the method restarted there (default), or stepped over.
  /// Takes effect at the next start().
  void locate_events(bool locate) { locate_ = locate; }
  /// Events since the start, in time.
  const std::vector<Event>& events() const { return events_; }

  /// Whether advance() ends at any time at no cost, by a dense output of the method's own.
  virtual bool ends_anywhere() const { return true; }
  /// Keeps from now on what a step leaves between its ends.
  void keep_dense_output() { keeps_ = true; }
  /// Of the last advance(); empty where it was not kept.
  const DenseOutput& dense_output() const { return dense_; }

  /// The machine at the end of the last advance().
  const MotionState& state() const { return shows_ ? shown_->instant().state : now_; }
  const EnergyFlows& flows() const { return shows_ ? shown_->instant().flows : flows_; }
  const Partition& partition() const { return shows_ ? shown_->instant().partition : partition_; }
  System& system() { return shows_ ? shown_->system() : system_; }
  const System& system() const { return shows_ ? shown_->instant().system : system_; }
  Instant now() const { return shows_ ? shown_->instant() : Instant{system_, partition_, now_, flows_}; }
  /// Zero for methods that hold their errors to a tolerance.
  const StepError& step_error() const { return step_error_; }
  /// Energies in every step of the method's own since it was asked last.
  EnergyRange take_energy_range() { return std::exchange(energy_range_, {}); }

  /// What a restart needs, but for the machine's balance of energy.
  Snapshot save() const;
  /// Throws std::invalid_argument for one of another machine.
  void restore(const Snapshot& from);

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
  /// Friction whose stiction or sense of sliding an impact or jump has ended, where no step has led there, and what is
  /// at its limit: at a state that the partition has evaluated.
  void release_friction();
  /// Contacts at their zero that the motion leads through, of which no root is found: several that close or open at one
  /// instant, and those that the start touches. At a state that the partition has evaluated.
  void pass_contacts_at_zero();
  /// Of a method that steps over events: sets contacts to the side that they are on.
  void update_contacts();
  /// Around what changes at an instant inside a step, or where a method's own step has ended: ends of its segments.
  void keep_begin(bool jumps = true);
  void keep_end();
  /// Inside on_advance(), between two steps of the method's own: what is read between its ends is that of these steps.
  void part_segment() { keep_end(), keep_begin(false); }
  /// Whether a step in parts is to end here: what a contact takes at its touch must not wait for the step's end.
  bool ends_at_event() { return to_event_ && crossed(); }
  bool keeps() const { return keeps_; }
  StepSegment begin_segment(bool jumps) const;
  /// What the elements remember at the end of the step, for its dense output.
  void keep_memory();
  /// now() is that of a time before the method's own end, by the dense output; hide() returns there.
  void show(double t);
  void hide() { shows_ = false; }
  bool shows() const { return shows_; }
  void act(double close);
  void fire(std::size_t event);
  virtual void on_save(Snapshot::Past&) const {}
  virtual void on_restore(const Snapshot::Past&) {}
  static std::vector<double> numbers(const Eigen::Ref<const Eigen::VectorXd>& v) {
    return {v.data(), v.data() + v.size()};
  }
  /// @param what for the refusal of another size
  static void take(const std::vector<double>& from, Eigen::VectorXd& to, const char* what);

  System& system_;
  Partition partition_;
  MotionState now_;
  EnergyFlows flows_;
  Switches switches_;
  StepError step_error_;
  EnergyRange energy_range_;
  DenseOutput dense_;  ///< of the last advance()
  Eigen::VectorXd q_before_;
  long changes_seen_ = 0;
  double asked_end_ = std::numeric_limits<double>::quiet_NaN();  ///< of advance_to()

 private:
  void step_by(double h);
  void begin_states();
  bool begin_controllers();
  void await_passage();
  bool switch_joints(std::vector<std::size_t> due, std::vector<char>& had);
  void arm(const std::vector<char>& open);
  void arm_returned();
  std::vector<std::size_t> reached(const std::vector<char>& had);
  void take_impulse();
  void begin_grips();
  double grip(std::size_t force, std::size_t place);
  double share_grips(std::size_t which);
  /// Of all that stick, after joints have changed.
  void damp_grips();
  void advance_part(double h);
  void advance_over_instants(double h);
  void advance_over_events(double h);
  void begin_part();
  bool crossed();
  bool comes_and_goes();
  void try_part(double h, bool to_event = false);
  void advance_to_event(double h, bool to_event);

  std::unique_ptr<Evaluation> shown_;
  bool shows_ = false, keeps_ = false;
  long starts_ = 0;

  bool locate_ = true;
  bool to_event_ = false;  // a step in parts may end at one
  std::vector<Event> events_;
  MotionState before_;
  EnergyFlows flows_before_;
  std::vector<double> stuck_since_;  ///< of each switch of friction, s; NaN: not since an event
  Eigen::VectorXd lost_at_once_;     ///< by the ground when it took the last step, J: of the next one, as its ruts are
  std::size_t segments_before_ = 0;
  std::vector<double> gaps_;
};

std::unique_ptr<Integrator> make_integrator(IntegratorKind kind, System& system, const AdamsMoultonOptions& adams = {},
                                            const IdaOptions& ida = {}, const CvodeOptions& cvode = {});

}  // namespace subsoil::mbd
