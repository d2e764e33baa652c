#pragma once

#include "libmbd/integrators/inputs.hpp"
#include "libmbd/integrators/integrator.hpp"

namespace subsoil::mbd {

/// Kinematic analysis and inverse dynamics of a machine that joints and drivers hold in every coordinate (freedom 0):
///   Phi(q, t) = 0   by Newton from the pose before, carried on by q' dt + q'' dt^2/2
///   Phi_q q' = -Phi_t,   Phi_q q'' = gamma,   Phi_q^T lambda = F - M q''
/// so reactions and driving forces follow from the multipliers without any integration. Each step is parted
/// at the corners of ramps and tables, where driving forces jump, and Gauss's rule of three points, order 6, gives the
/// energy flows of each part: its points lie inside, on one side of the corners. A way between two points whose
/// solution lies further than a tenth of the machine's length from where it was expected is halved, so that Newton
/// stays on its branch; where halving does not help (lock-up, singular pose) the run ends with std::runtime_error.
/// start() throws std::invalid_argument naming the coordinates that nothing drives. Source: Haug 1989, Computer Aided
/// Kinematics and Dynamics of Mechanical Systems I, chapters 3 and 7.
class Kinematic : public Integrator {
 public:
  explicit Kinematic(System& system) : Integrator(system), inputs_(system.model()) {}

 protected:
  void on_start() override;
  void on_advance(double h) override;
  void on_restore(const Snapshot::Past&) override { on_start(); }
  /// Nothing is integrated, so no force's switch costs any order; events of joints are located.
  bool finds_events() const override { return !system_.has_joint_events(); }

 private:
  void follow(double to, int depth);
  void advance_smoothly(double until);

  StepClock clock_;
  Inputs inputs_;
};

/// How far a pose lies from another: maximum difference of a coordinate, angles times the machine's length (m).
double distance_of(const System& system, const Eigen::VectorXd& a, const Eigen::VectorXd& b);
/// Beyond this from where it was expected, a root of the constraints may lie on another branch.
inline double branch_limit(const System& system) { return 0.1 * system.length_scale(); }

/// "rod.angle": a coordinate as scenarios name it.
std::string coordinate_name(const System& system, int coordinate);

}  // namespace subsoil::mbd
