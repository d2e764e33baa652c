#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libmbd/base/angle_anchor.hpp"
#include "libmbd/base/fault.hpp"
#include "libmbd/controllers/controller.hpp"
#include "libmbd/controllers/pid.hpp"
#include "libmbd/element/constraint.hpp"
#include "libmbd/element/force.hpp"
#include "libmbd/system/joint_event.hpp"

namespace subsoil::mbd {

template <class Any>
struct Named {
  std::string name;
  Any element;
};

/// A machine as plain numbers, SI. Body i of `bodies` has the index i + 1 in joints and forces; 0 is the ground.
struct Model {
  std::array<double, 2> gravity{0, -9.81};  ///< m/s^2
  std::vector<Body> bodies{};
  std::vector<Named<AnyJoint>> joints{};
  std::vector<Named<AnyDriver>> drivers{};
  std::vector<Named<AnyForce>> forces{};
  std::vector<Named<AnyController>> controllers{};
  std::vector<Named<JointEvent>> events{};
  Redundancy redundancy = Redundancy::minimum_norm;
  double start_time = 0;

  double mass() const;    ///< of all bodies, kg
  double weight() const;  ///< of all bodies, N; 0 without gravity
  /// Adds and returns the index to use in joints and forces.
  int add(Body body);
  void add(std::string name, AnyJoint joint) { joints.push_back({std::move(name), std::move(joint)}); }
  void add(std::string name, AnyDriver driver) { drivers.push_back({std::move(name), std::move(driver)}); }
  void add(std::string name, AnyForce force) { forces.push_back({std::move(name), std::move(force)}); }
  void add(std::string name, AnyController c) { controllers.push_back({std::move(name), std::move(c)}); }
  void add(std::string name, JointEvent event) { events.push_back({std::move(name), std::move(event)}); }
};

/// A nonzero block of Phi_q: the row of an equation and a body, not the ground, that it touches.
struct Block {
  int row, body;
  std::array<bool, 3> has{true, true, true};  ///< false: of that coordinate nothing ever
};

/// All constraints at one state, rows in the order joints, then drivers: Phi, Phi_q, gamma, Phi_t. Phi_q by its nonzero
/// blocks only, one per System::blocks(): an equation touches two or three bodies of however many there are.
struct SparseConstraints {
  std::vector<double> phi, gamma, phi_t;
  std::vector<std::array<double, 3>> jacobian;
};

/// The same with Phi_q written out, for what is done once and not at every step.
struct Constraints {
  Eigen::VectorXd phi, gamma, phi_t;
  Eigen::MatrixXd jacobian;
  SparseConstraints sparse;
};

class System;
struct Motion;
/// What friction asks of a state as it begins to stick.
struct GripMotion {
  std::function<const Eigen::VectorXd&()> accelerate;  ///< solves the state again and returns its accelerations
  std::function<bool(double)> look_ahead;  ///< sets the system so much later (s); false where there is no such state
};
/// Fills phi, gamma, phi_t and jacobian from `sparse`.
void write_out(const System& system, Constraints& c);

/// A model checked and ready to be evaluated: who asks gives (t, q, q'), q = (x, y, angle) of body 1, 2, ...
/// Everything is stored once; evaluating allocates nothing. Knows no integrator.
class System {
 public:
  /// Checks the model; throws std::invalid_argument with name, value, rule and cure.
  explicit System(Model model);
  ~System();
  System& operator=(const System&) = delete;
  /// The same model with its memories at a state of its own: what is evaluated there leaves this one as it is.
  std::unique_ptr<System> copy() const;

  // --- what there is ---
  int bodies() const { return static_cast<int>(model_.bodies.size()) + 1; }  ///< with the ground
  int coordinates() const { return 3 * (bodies() - 1); }
  int equations() const { return static_cast<int>(row_part_.size()); }
  const Model& model() const { return model_; }
  int body_index(const std::string& name) const;  ///< throws for an unknown name
  const std::string& body_name(int body) const;
  /// Joint or driver of an equation, and its name in messages: "joint 'H3'".
  const PartName& part(int row) const { return row_part_[static_cast<std::size_t>(row)]; }
  std::string owner(int row) const { return part(row).text(); }
  bool angular_row(int row) const { return row_angular_[static_cast<std::size_t>(row)]; }
  /// Nonzero blocks of Phi_q, by rows; those of `row` start at blocks()[first_block(row)].
  const std::vector<Block>& blocks() const { return blocks_; }
  std::size_t first_block(int row) const { return first_block_[static_cast<std::size_t>(row)]; }
  int first_row_of_joint(std::size_t joint) const { return joint_row_[joint]; }
  int row_of_driver(std::size_t driver) const { return driver_row_[driver]; }
  /// A length of the machine that makes angles and lengths comparable (m): the longest moment arm of a joint. Where
  /// that is below a hundredth of the machine's size, the size: the maximum of the radius of gyration of all masses and
  /// of the extents of what forces between points tie together.
  double length_scale() const { return length_scale_; }
  /// Longest moment arm of a joint's point on the body (m); the machine's length where it has none.
  double body_size(int body) const { return body_size_[static_cast<std::size_t>(body)]; }
  const Eigen::VectorXd& mass() const { return mass_; }  ///< diagonal of M
  Eigen::VectorXd start_position() const;
  Eigen::VectorXd start_velocity() const;

  // --- at a state ---
  /// Sets the state that everything below refers to.
  void set_state(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity);
  void set_position(double t, const Eigen::VectorXd& q);
  void set_velocity(const Eigen::VectorXd& velocity);
  const BodyState& body(int index) const { return states_[static_cast<std::size_t>(index)]; }
  double time() const { return t_; }
  /// Phi, Phi_q, gamma, Phi_t.
  void constraints(SparseConstraints& out) const;
  void constraints(Constraints& out) const;
  /// Phi, Phi_q, Phi_t, which need no velocities; then gamma at the same position, which does.
  void constraints_of_position(SparseConstraints& out) const;
  void constraints_of_velocity(SparseConstraints& out) const;
  /// F: gravity, forces, external wrenches; fills powers() and values() on the way.
  void loads(Eigen::VectorXd& out);
  /// Multipliers from which loads() takes the friction in joints.
  void set_multipliers(const Eigen::VectorXd& lambda) {
    std::copy(lambda.data(), lambda.data() + lambda.size(), multipliers_.begin());
  }
  /// First equations of the joints with friction; empty: loads() does not depend on the multipliers.
  const std::vector<int>& friction_rows() const { return friction_rows_; }
  const std::vector<ForcePower>& powers() const { return powers_; }
  const std::vector<ForceValues>& values() const { return values_; }
  /// What forces see of the state set last.
  Scene scene() const { return {states_, t_, ruts_, multipliers_, element_states_, signals_}; }
  double kinetic() const;
  double potential() const;  ///< of gravity, zero at the world's origin
  double stored() const;     ///< in forces

  // --- states of elements (pressures, currents, integrals of controllers),
  // integrated with the motion ---
  std::size_t state_count() const { return element_states_.size(); }
  /// Numbers that are integrated beside q and q': lost of each force, work of
  /// each force, work of each driver, then the states.
  Eigen::Index flow_count() const;
  Eigen::Index rate_count() const { return flow_count() + static_cast<Eigen::Index>(state_count()); }
  /// The size below which a state does not matter to 1.
  const std::vector<double>& state_scales() const { return state_scales_; }
  /// Start values at the state set last, which they are set to: those of set_start_states(), or of the elements.
  const std::vector<double>& begin_states();
  /// Start values from now until settle_forces(), as an equilibrium finds them; none: the elements' own.
  void set_start_states(const Eigen::VectorXd& x) { start_states_.assign(x.data(), x.data() + x.size()); }
  /// Force or controller that a state belongs to, for messages: "force 'lift'".
  std::string state_owner(std::size_t state) const;
  /// The same for controllers whose input is of the solution, once there is
  /// one; true where there are any.
  bool begin_states_of(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda);
  void set_element_states(const Eigen::VectorXd& x) {
    std::copy(x.data(), x.data() + x.size(), element_states_.begin());
  }
  const std::vector<double>& element_states() const { return element_states_; }
  /// Rates of all states after loads(), from the solution.
  const std::vector<double>& take_state_rates(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda);
  /// Outputs of the controllers, and what they miss.
  const std::vector<double>& signals() const { return signals_; }
  double controller_error(std::size_t controller) const;
  /// Sampled controllers: the next instant at which one acts (infinity: none),
  /// and its action there, give or take `close`.
  double next_instant() const;
  void act(const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda, double close);
  bool has_instants() const { return has_instants_; }
  /// Whether outputs at an instant at which they change are those before it, as dense output needs.
  void see_outputs_before(bool before) { outputs_before_ = before; }
  /// What outputs were before now is needed no more.
  void forget_outputs_before();

  // --- joints that open and close ---
  bool has_joint_events() const { return !model_.events.empty(); }
  /// 1 for joints that are open: their rows are zero.
  const std::vector<char>& open_joints() const { return open_; }
  void set_open_joints(const std::vector<char>& open) { open_ = open; }
  int open_rows() const;
  /// Whether any event opens or closes the joint.
  bool may_open(std::size_t joint) const;
  /// Joints as the model has them at the start.
  void begin_joints();
  /// What an event waits for: above 0 until it comes; 1 where its joint is as it would be, or it comes by time.
  double event_gap(std::size_t event, const Eigen::VectorXd& acceleration, const Eigen::VectorXd& lambda) const;
  /// Opens or closes its joint at the state set last.
  void switch_joint(std::size_t event);
  /// An event that comes by time and is due at t, give or take `close`; the count of events: none.
  std::size_t due_event(double close) const;

  // --- what comes from outside or stays ---
  /// Wrench about the centre of gravity, world axes; stays until set again (the soil's, over a machine step).
  void set_external_wrench(int body, double fx, double fy, double mz);
  const std::array<double, 3>& external_wrench(int body) const { return external_[static_cast<std::size_t>(body)]; }
  const std::vector<std::array<double, 3>>& external_wrenches() const { return external_; }  ///< of all bodies
  /// Work of the external wrenches from one pose to another (J).
  double external_work(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;
  /// Counts changes of the external wrench and of sampled outputs, so that an integrator sees a jump.
  long wrench_changes() const { return wrench_changes_; }
  /// Fills what the model's forces leave to the start pose (free lengths) from the assembled one. Relative angles of
  /// joints and start values of drivers are taken from the model's own pose, before it is assembled.
  void settle_forces(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity);
  /// Restarts traces of wheels from the current state, for a state that was set and not travelled to.
  void restart_traces();
  /// q' of a tow: every body at `speed` along x, wheels on soil roll along.
  Eigen::VectorXd towing_velocity(double speed) const;
  /// 1 for bodies (from the first) whose angular velocity in a tow a force gives.
  std::vector<char> towed_spins() const;
  /// In statics: contacts whose gap is below `close` (m) touch, and stick from there on; others part. True where any
  /// has changed. @param from_here all begin at the state set last
  bool follow_touches(double close, bool from_here = false);
  /// Forces with friction that fades at rest, by name: it holds nothing there.
  std::vector<std::string> creeping() const;
  /// Tells a force that its friction at a place changes, at the state set last.
  Changeover pass_event(std::size_t force, std::size_t place);
  /// The same of a gap that has passed 0.
  Changeover touch(std::size_t force, std::size_t place, bool closes);
  /// The sense in which friction slides at a place, 0 where it sticks or is none.
  int sense(std::size_t force, std::size_t place) const;
  /// Lets friction that sticks begin with the force that holds its surfaces at the state set last. Surfaces that are
  /// led through rest, where no friction changes their motion, slide on. Returns the energy that stiction stores by it
  /// (J). An equilibrium's stiction (set_start_grips) keeps the force that it has.
  double grip(std::size_t force, std::size_t place, const GripMotion& motion);
  /// Places of one force that begin to stick at one instant share what they hold, by their limits: one after the other
  /// they would hold by their order. Not where that moves the surfaces, as of places that hold in different directions.
  /// Returns the energy that stiction stores more by it (J).
  double share_grips(std::size_t force, std::span<const std::size_t> places, const GripMotion& motion);
  /// Friction that sticks does so on, damped for the inertia that it meets now: a joint has opened or closed.
  void damp(std::size_t force, std::size_t place, const GripMotion& motion);
  /// What forces hold from one event to the next (stiction, impacts of a given restitution), to restore it before one.
  using Grips = std::vector<double>;
  Grips grips() const;
  void set_grips(const Grips& grips);
  /// What forces hold at a start from now until settle_forces(), as an equilibrium finds it.
  void set_start_grips(Grips grips) { start_grips_ = std::move(grips); }
  bool keeps_grips() const { return !start_grips_.empty(); }
  /// The state set last is accepted: the ground takes its ruts. Adds to `lost`, J by force, what is lost at that
  /// instant; whether there is any.
  bool commit(Eigen::VectorXd& lost);
  const std::vector<Rut>& ruts() const { return ruts_; }

  /// What evaluation at a state needs beside it and what the model has: external wrenches, and what elements remember
  /// of the motion so far.
  struct Memory {
    std::vector<std::array<double, 3>> external;
    std::vector<Sampler> samplers;
    std::vector<double> elements;  ///< of forces, then of joints that may open
    std::vector<Rut> ruts;
    bool operator==(const Memory&) const = default;
    template <class A>
    void archive(A& a) {
      a("external wrenches", external)("controllers", samplers)("memories", elements)("ruts", ruts);
    }
  };
  Memory memory() const;
  void set_memory(const Memory& memory);
  /// What a restart needs beside (t, q, q').
  struct Restart {
    struct DriverStart {
      double value = 0, rate = 0, time = 0;
      bool operator==(const DriverStart&) const = default;
      template <class A>
      void archive(A& a) {
        a("start", value)("rate", rate)("time", time);
      }
    };
    std::vector<DriverStart> drivers;
    Memory memory;
    std::vector<char> passed, open;  ///< events that came by time; joints
    bool operator==(const Restart&) const = default;
    template <class A>
    void archive(A& a) {
      a("drivers", drivers)("memory", memory)("passed", passed)("open", open);
    }
  };
  Restart save() const;
  /// Lets a driver move otherwise from now on. What its motion has begun with stays.
  void set_motion(std::size_t driver, const Motion& motion);
  /// Throws std::invalid_argument for one of another machine.
  void restore(const Restart& from);

 private:
  void check_bodies() const;
  void check_elements() const;
  void prepare_forces();
  void number_rows();
  void choose_length_scale(double joints);
  void place_elements();
  void attach_friction();
  void attach_controllers();
  void number_states();
  void attach_events();
  template <class Part>
  void constraints(Part part, SparseConstraints& out) const;
  void clear_open_rows(SparseConstraints& out) const;
  void take_signals();
  const PidController* sampled(std::size_t controller) const;
  void assign_ruts();
  void settle_constraints();

  System(const System&) = default;

  struct Elements;  ///< joints, drivers and forces by type; the only part that knows the lists of elements
  /// The lists point into the model: those of a copy are empty until place_elements().
  class ElementLists {
   public:
    ElementLists();
    ElementLists(const ElementLists&);
    ~ElementLists();
    Elements& operator*() const { return *lists_; }
    Elements* operator->() const { return lists_.get(); }

   private:
    std::unique_ptr<Elements> lists_;
  };

  Model model_;
  ElementLists elements_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> first_block_;
  std::vector<AnyForce> given_forces_;  // as the model has them, before the start pose fills them
  std::vector<PartName> row_part_;
  std::vector<bool> row_angular_;
  std::vector<int> joint_row_, driver_row_;
  int joints_end_ = 0;
  std::vector<int> friction_rows_;
  std::vector<double> multipliers_;
  double length_scale_ = 1;
  std::vector<double> body_size_;
  Eigen::VectorXd mass_;
  std::vector<Vec2> weights_;  // of the bodies (N)

  double t_ = 0;
  std::vector<BodyState> states_;
  std::vector<AngleAnchor> anchors_;  // of the bodies
  std::vector<std::array<double, 3>> wrenches_, external_;
  std::vector<ForcePower> powers_;
  std::vector<ForceValues> values_;
  std::vector<Rut> ruts_;
  long wrench_changes_ = 0;

  std::vector<double> element_states_, state_rates_, state_scales_, signals_, measured_, start_states_;
  Grips start_grips_;
  std::vector<std::size_t> first_measured_;  // of each controller, in measured_
  std::vector<Sampler> samplers_;            // of the controllers
  bool has_instants_ = false, outputs_before_ = false;
  std::vector<char> open_, open_at_start_;            // of joints
  std::vector<char> passed_;                          // of events that come by time
  std::vector<std::array<double, 3>> given_latched_;  // of joints
  Eigen::VectorXd no_acceleration_,
      no_lambda_;  // for inputs that do not look at them
};

}  // namespace subsoil::mbd
