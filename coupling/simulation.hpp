#pragma once
#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "coupling/servo.hpp"
#include "libdem/bed.hpp"
#include "libmbd/machine.hpp"

/// Bed and machine together: which boundary moves with which body, the order of a step, the work at the interface.
namespace subsoil::coupling {

/// A boundary of the bed that is fixed to a body; the boundary's shape stands in the body's axes about its centre of
/// mass, in the machine's plane z = 0.
struct BodySurface {
  int body = 0;      ///< index in the machine, 1 ...
  int boundary = 0;  ///< index in the bed
};

/// A boundary on a given path, which a servo, if there is one, shifts along its line.
struct GivenMotion {
  int boundary = 0;
  std::function<dem::Pose(double time)> pose;
  std::optional<Servo> servo{};
};

/// What soil and machine did to each other through the machine's surfaces since the start, J.
struct InterfaceWork {
  double on_soil = 0;     ///< as the bed accumulates it: mean wrench of two instants times the displacement between
  double on_machine = 0;  ///< as the machine accumulates it: wrench constant over the step times displacement
  /// What the exchange created (> 0) or lost: both sides together. Explicit: of first order in the step. Iterated: zero
  /// to the tolerance.
  double error() const { return on_soil + on_machine; }
};

struct SimulationOptions {
  double soil_step = 0;     ///< s; with a bed
  int soil_steps = 1;       ///< per machine step
  double machine_step = 0;  ///< s; without a bed
  double tolerance = 0;     ///< m of the surfaces at a window's end: iterated exchange; 0: explicit
  int most_iterations = 20;
};

/// What the iterated exchange took, since the start.
struct ExchangeCount {
  long windows = 0, evaluations = 0;
  long open = 0;      ///< windows that did not come within the tolerance
  double widest = 0;  ///< m, of these
  template <class A>
  void archive(A& a) {
    a("windows", windows)("evaluations", evaluations)("open", open)("widest", widest);
  }
};

/// What a restart needs beside the states of bed and machine, as a value. Files name its fields by `archive`.
struct ExchangeState {
  int in_window = 0;     ///< soil steps since the window's start
  bool stepped = false;  ///< the bed's boundaries stand where the step before had them
  std::vector<dem::Wrench> window;
  std::vector<std::array<double, 3>> acceleration;
  std::vector<ServoState> servos;  ///< of the motions that have one
  /// Of the iterated exchange.
  struct Iterated {
    std::vector<std::array<double, 6>> starts;  ///< x, y, angle and their rates
    std::vector<std::array<double, 3>> ends;    ///< x, y, angle
    ExchangeCount count;
    template <class A>
    void archive(A& a) {
      a("starts", starts)("ends", ends)("count", count);
    }
  };
  std::optional<Iterated> iterated{};

  template <class A>
  void archive(A& a) {
    a("in window", in_window)("stepped", stepped)("window", window)("acceleration", acceleration);
    a("servos", servos)("iterated", iterated);
  }
};

/// One step in the source's order (Yuan & Yu 2020, section 3), explicit and staggered:
///   (1) the machine stands at t_n; (2) its surfaces take position and velocity; (3) contact forces; (4) spheres move
///   on to t_{n+1}; (5) each body's wrench about its centre of mass, averaged over the window of soil steps, moves the
///   machine over the window. Inside a window of several soil steps the surfaces run ahead with the machine's velocity
///   and acceleration at the window's start.
/// Velocities handed over are those of the middle of the step that ends at t_n (displacement over step), as the bed's
/// own leapfrog velocities are; that makes both energy balances exact for the motion that was made. A simulation may be
/// without bed (the machine runs alone) or without machine.
///
/// Iterated exchange: the wrench over a window of n soil steps is the trapezoidal mean of both its ends,
///   w = (w_0/2 + w_1 + ... + w_{n-1} + w_n/2)/n,
/// and w_1 ... w_n are those of surfaces that go evenly to the poses z to which w moves the machine. After the first
/// soil step, which is the same for every z, bed and machine repeat the rest of the window from checkpoints until z =
/// g(z) within the tolerance (QuasiNewton). On a spring this is Newmark's average acceleration, neutral for every
/// stiffness, and both sides do the same work to the tolerance. A path that bends with the start's velocity would be
/// nearer to the motion, but is unstable on stiff contacts (exchange_stability.hpp), and its works differ.
class Simulation {
 public:
  /// Bed and machine are the caller's and outlive the simulation; either may be null. Body surfaces are placed at once.
  Simulation(dem::Bed* bed, mbd::Machine* machine, std::vector<BodySurface> surfaces, std::vector<GivenMotion> motions,
             SimulationOptions options);

  /// Without a bed: the machine's last step is cut short so that it ends at `end` exactly.
  void end_at(double end) { end_ = end; }
  /// One soil step (or one machine step without a bed). After it, wrenches are those of t_n, poses those of t_{n+1}.
  void step(const dem::Bed::Request& request = {});
  /// A machine alone whose method ends anywhere: moves on to `time`, at most by its step.
  void step_to(double time);
  /// Whether the machine stands at this instant, and not at the start of a window of several soil steps.
  bool window_begins() const { return machine_ == nullptr || in_window_ == 0; }
  double window_length() const { return step_length() * (bed_ != nullptr ? options_.soil_steps : 1); }
  double time() const;  ///< t_{n+1}
  double step_length() const { return bed_ != nullptr ? options_.soil_step : options_.machine_step; }

  /// Wrench of the soil on a body about its centre of mass, world axes, at the last step; out-of-plane parts included:
  /// on a planar body they are what its guide takes.
  const dem::Wrench& soil_on_body(int body) const { return soil_on_body_[static_cast<std::size_t>(body)]; }
  /// Up to t_n, as the bed's energies are; the machine's inside a window up to its start, in its last step by a share.
  InterfaceWork interface_work() const;
  const ExchangeCount& exchange() const { return exchange_; }
  const std::vector<BodySurface>& surfaces() const { return surfaces_; }
  /// Where a boundary's surface stands now (t_{n+1}), for drawing.
  dem::Pose surface_pose(int boundary) const;
  /// Of a given motion, by its place in their list; what has no servo has stayed at zero.
  const ServoState& servo(std::size_t motion) const { return servos_[motion]; }
  /// A body of the machine at t_{n+1}: as the machine has it at a window's end, carried on with its velocity and
  /// acceleration of the window's start inside.
  mbd::BodyState body(int body) const;

  bool has_stepped() const { return stepped_; }

  ExchangeState save() const;
  /// Throws std::invalid_argument for the state of other bodies or servos, and for one inside a window of the other
  /// exchange.
  void restore(const ExchangeState& state);

 private:
  void place(dem::Boundary& boundary, const dem::Pose& pose, const dem::Vec3& velocity,
             const dem::Vec3& angular_velocity);
  void place_surfaces();
  dem::Pose pose_at(std::size_t motion, double time) const;
  void advance_servos();
  void gather();
  void take_accelerations();
  bool iterates() const { return options_.tolerance > 0 && machine_ != nullptr && !surfaces_.empty(); }
  void agree();
  void repeat_window();
  mbd::BodyState on_path(std::size_t body, double t) const;
  Eigen::VectorXd ends() const;
  void hand_over();
  void advance_machine();

  dem::Bed* bed_;
  mbd::Machine* machine_;
  std::vector<BodySurface> surfaces_;
  std::vector<GivenMotion> motions_;
  SimulationOptions options_;
  std::vector<ServoState> servos_;                   ///< by given motion
  std::vector<dem::Wrench> soil_on_body_, window_;   ///< per body; window: sum of shares, or the mean agreed upon
  std::vector<std::array<double, 3>> acceleration_;  ///< of bodies at the window's start
  int in_window_ = 0;
  // Iterated exchange.
  std::vector<int> coupled_;              ///< bodies with surfaces
  std::vector<double> arm_;               ///< m, of their surfaces: what an angle moves
  std::vector<mbd::BodyState> starts_;    ///< of all bodies at the window's start
  std::vector<std::array<double, 3>> z_;  ///< x, y, angle of all bodies at its end
  bool advanced_ = false;                 ///< the machine stands at the window's end
  dem::Bed::Checkpoint checkpoint_;
  ExchangeCount exchange_;
  double time_ = 0;
  double end_ = std::numeric_limits<double>::infinity();
  bool stepped_ = false;                   ///< the bed's boundaries stand where the step before had them
  std::optional<double> work_on_machine_;  ///< J, where the last step began; none: there was no step since restore()
};

/// Pose of a planar body in the world of the bed: plane z = 0, turned about z.
dem::Pose pose_of(const mbd::BodyState& body);

}  // namespace subsoil::coupling
