#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "libmbd/assembly/choice.hpp"
#include "libmbd/base/sparse.hpp"
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A state with everything that follows from it.
struct MotionState {
  double t = 0;
  Eigen::VectorXd q, velocity, acceleration;
  Eigen::VectorXd lambda;  ///< one per equation; 0 for equations that the partition left out as redundant
  Eigen::VectorXd states;  ///< of elements: pressures, currents, integrals of controllers
  /// Powers, lost of each force, work of each force, work of each driver (W);
  /// then the rates of the states.
  Eigen::VectorXd rates;
};

/// Phi_q has lost rank at a pose: a singular configuration, where the constraints do not determine the motion.
struct SingularPose : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A motion that is none any more.
struct BlowUp : MotionFault {
  using MotionFault::MotionFault;
};

/// Throws BlowUp with time and body when a state is no motion of a machine any more: not a number, a
/// million lengths of the machine from its start at a speed that takes a tenth of the time t for it, or faster than 1e7
/// lengths in a second.
void refuse_blow_up(const System& system, const MotionState& m);

/// Generalised coordinate partitioning (Wehage & Haug 1982; model.md section 1): q -> (u dependent, v independent),
/// det Phi_u != 0, M diagonal because q holds centres of gravity. The integrator moves v and v' alone;
///   u from Phi(u, v, t) = 0 by Newton        Phi_u u' = -Phi_t - Phi_v v'
///   M^ v'' = F^,  M^ = M_vv + R^T M_uu R,  R = -Phi_u^-1 Phi_v         Phi_u u'' = gamma - Phi_v v''
///   Phi_u^T lambda = F_u - M_uu u''
/// R and M^ are dense: cheap for few freedoms, as of a closed linkage, and a cube of many. With more than six the same
/// v'' and lambda come from
///   S lambda = Phi_q M^-1 F - gamma,  S = Phi_q M^-1 Phi_q^T        M q'' = F - Phi_q^T lambda
/// where S has a nonzero only where two equations share a body, and Phi_u keeps the sparsity of Phi_q, so that a step
/// costs a time linear in the number of links of a chain. S also tells how near a singular pose is, and there alone
/// solves; so where a pivot of Phi_u has become small it is used whatever the freedom.
/// All factors have a fixed pattern from choose() on. Redundant equations stay outside them.
/// Friction in joints makes F depend on lambda: lambda = T(lambda) is iterated to 1e-13, starting from the lambda
/// given, and solved by Newton's method where that is slow. Where the spectral radius of T' is not below 1 the joint
/// locks itself, and accelerate() reports it. sensitivity(): how far the worst pivot of Phi_u has fallen since the
/// choice; |R| grows with it without bound as Phi_u becomes singular, and it costs nothing, so it is what asks for a
/// new choice.
class Partition {
 public:
  explicit Partition(System& system);
  Partition(const Partition&) = delete;
  Partition& operator=(const Partition&) = delete;

  /// Chooses u and v at an assembled state. Throws std::runtime_error at a singular pose.
  void choose(const MotionState& at);
  /// Takes the choice of another partition of the same system, without an elimination.
  void adopt(const std::shared_ptr<const Choice>& choice);
  /// The choice in use; the same object until it changes.
  const std::shared_ptr<const Choice>& choice();
  /// New choice when the last evaluation asks for it; true when the choice changed hands.
  bool choose_again_if_needed(const MotionState& at);
  /// The next evaluation factors its matrices at its own pose.
  void forget_factors() { factored_at_.setConstant(std::numeric_limits<double>::quiet_NaN()), reduced_ = false; }
  bool asks_for_choice() const;  ///< the last evaluation came near to where Phi_u is singular
  long choices() const { return choices_; }
  double sensitivity() const { return sensitivity_; }

  const std::vector<int>& independent() const { return choice_.independent; }
  const std::vector<int>& dependent() const { return u_; }     ///< ascending
  const std::vector<int>& used_rows() const { return rows_; }  ///< ascending
  Eigen::Index freedom() const { return static_cast<Eigen::Index>(choice_.independent.size()); }
  Eigen::Index rank() const { return static_cast<Eigen::Index>(choice_.rows.size()); }

  /// From t, q (v part exact, u part a guess) and v' (u' a guess) to everything: u, u', q'', lambda, rates.
  /// Throws SingularPose where lambda is not determined.
  void evaluate(MotionState& m);
  /// The same for the first evaluation of a pair of predictor and corrector: a guess of q and q' that misses Phi = 0 by
  /// less than 1e-7 of the machine's length stays as it is, and q'', lambda and the rates are those of
  ///   M q'' + Phi_q^T lambda = F,  Phi_q q'' = gamma
  /// there. They err by the order of the guess, as those of its projection would; the corrected state is put on the
  /// constraints by evaluate(). Coordinate projection after the step: Eich, SIAM J. Numer. Anal. 30 (1993) 1467.
  void evaluate_predicted(MotionState& m);
  /// As evaluate() from guesses of all of q and q', put on Phi = 0 and Phi_q q' = -Phi_t with the minimum change in the
  /// norm of M. For use beside a singular pose: at an angle e from it rounding eps leaves an error in the coordinates
  /// that the constraints hardly hold, eps/e of position, eps/e^2 of velocity, eps/e^3 of acceleration. u(v) hands it
  /// on to the independent coordinates, whichever they are; removed in the norm of M it does no work on the motion.
  void evaluate_nearest(MotionState& m);
  /// q'', lambda and the rates at q and q' as they are, off the constraints by however little:
  ///   M q'' + Phi_q^T lambda = F,  Phi_q q'' = gamma
  void accelerate_as_it_is(MotionState& m);
  /// Only q'', lambda, rates again at the state last evaluated: after a change of the external wrenches, or of what
  /// controllers and joint events hold.
  void accelerate(MotionState& m);
  /// The same after a change of external wrenches alone. Where no force depends on them, as without friction in joints,
  /// controllers and states, what they change is the right side by themselves.
  void accelerate_by_wrenches(MotionState& m);
  /// All multipliers; for redundant constraints the solution of minimum norm.
  Eigen::VectorXd reactions(const MotionState& m) const;
  /// Whether the pose last evaluated is nearer than some 0.1 rad to one where an equation is redundant.
  bool near_singular() const;
  /// Distance (rad) nearer than which reactions and accelerations of a pose between two steps are rounding, over its
  /// cube.
  static constexpr double known_reactions = 1.5e-3;
  /// The same for velocities, over its square, beside what a polynomial of the step gives for them.
  static constexpr double known_velocities = 0.03;
  /// About the angle (rad) between the pose last evaluated and a singular one, where that is small.
  double distance_from_singular() const;
  /// Sign of det Phi_u at the pose factored last, which a smooth motion changes where it passes a singular pose.
  int orientation() const { return orientation_; }
  /// Throws where near a singular pose the constraints were met by velocities that the guess did not know.
  void refuse_other_branch(const MotionState& m) const;
  /// The joint or driver of that equation.
  std::string singular_owner() const;
  const SparseConstraints& constraints() const { return c_; }
  /// Maximum |Phi| of all rows at the state last evaluated (angles times length).
  double residual() const;

 private:
  using Index = std::uint32_t;
  struct Used {  // a block of a used row: where it is, its place among the used rows, the first coordinate of its body
    Index block, index, column;
  };
  struct UsedRow {  // its number, its blocks, its place in the choice
    Index row, first, last, chosen;
  };
  struct Entry {  // of Phi_u: component k of a block of Phi_q
    Index block, component, place;
  };
  struct Product {  // of S: two blocks on one body
    Index i, j, place;
  };
  void take(Choice choice);
  void analyse();
  void list_products();
  void put_on_constraints(MotionState& m);
  void solve_motion(MotionState& m);
  void weigh();
  bool solve_positions(MotionState& m);
  void factor();
  void factor_again(const MotionState& m);
  void correct(Eigen::VectorXd& x);
  bool factors_serve(const MotionState& m);
  void factor_schur(const MotionState& m);
  void solve_velocities(MotionState& m);
  void subtract_reactions(const std::vector<double>& lambda, Eigen::VectorXd& acceleration) const;
  void prepare_motion(const MotionState& m, bool serve);
  void take_loads();
  void take_driver_rates(MotionState& m);
  void list_free_entries();
  void take_rates(MotionState& m);
  bool may_reduce() const;
  void reduce(const MotionState& m);
  void solve_reduced(MotionState& m);
  void correct_reduced(MotionState& m, bool open);
  double balance(const MotionState& m);
  void solve_accelerations(MotionState& m);
  double friction_pass(MotionState& m);
  void solve_with_friction(MotionState& m);
  /// What Newton's method finds: whether it has settled, the share of a change of the reactions that friction returns,
  /// and the equation in which that is the maximum.
  struct LockedFriction {
    bool settled = false;
    double returned = 0;
    int row = 0;
  };
  bool iterate_friction(MotionState& m, double affordable);
  LockedFriction solve_strong_friction(MotionState& m);
  template <int sign>
  double apply_jacobian(const Eigen::VectorXd& x, const std::vector<double>& other);
  [[noreturn]] void refuse_singular(const MotionState& m) const;
  [[noreturn]] void refuse_open(const MotionState& m) const;

  System& system_;
  SparseConstraints c_;
  Choice choice_;
  std::shared_ptr<const Choice> shared_choice_;  // choice_, once asked for
  std::vector<int> rows_, u_;                    // of the choice, sorted
  Eigen::VectorXd row_scale_, column_scale_, inverse_mass_, load_, free_, lambda_before_;
  Eigen::VectorXd factored_at_;                  // q of the factors; NaN when there are none
  double trust_ = 1;                             // share of a right side that the factors leave at most
  std::vector<std::array<double, 3>> wrenches_;  // external ones in load_

  long choices_ = 0;
  bool nearest_ = false;
  int orientation_ = 1;
  double sensitivity_ = 1, least_pivot_ = 1;
  // The maximum change by which the last evaluation turned a guess of q' round or took half of it away, over the
  // maximum rate of the machine: what another branch does, and a guess that is merely rough does not.
  double velocity_turn_ = 0;

  std::vector<Used> used_;
  std::vector<UsedRow> used_rows_;  // ascending, as work_ and S are
  std::vector<Index> column_;       // of each block: the first coordinate of its body
  SparseLu phi_u_;                  // in the order of the choice
  std::vector<Entry> entries_;
  std::vector<double> pivot_scale_;
  std::vector<double> best_pivot_;  // maximum that each pivot of Phi_u has been since the choice
  SparseLdl schur_;
  std::vector<Product> products_;
  std::vector<std::array<double, 3>> weighted_;  // blocks of Phi_q M^-1
  std::vector<double> work_, chosen_work_;

  // Few freedoms: M^ itself, by R. In the order of the choice; reduced_: these were factored last, and not S.
  bool reduced_ = false, of_this_pose_ = false;
  std::vector<Entry> free_entries_;  // of Phi_v, into R
  // By rows of freedom() numbers; M^ as the factor L of L L^T, with 1/L on its diagonal.
  std::vector<double> r_, m_hat_;
  std::vector<double> dependent_mass_;
  Eigen::VectorXd balance_;
};

}  // namespace subsoil::mbd
