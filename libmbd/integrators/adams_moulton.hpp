#pragma once

#include <span>
#include <utility>
#include <vector>

#include "libmbd/integrators/inputs.hpp"
#include "libmbd/integrators/integrator.hpp"
#include "libmbd/integrators/runge_kutta.hpp"

namespace subsoil::mbd {

/// Adams-Bashforth-Moulton, predict-evaluate-correct-evaluate, order k = 1 ... 6, fixed step, for
///   d(v, s)/dt = (s, M^^-1 F^)
///   predict  y* = y_n + h sum_{j<k} b_j f_{n-j}
///   correct  y  = y_n + h (c_0 f* + sum_{j<k-1} c_{j+1} f_{n-j})
/// The stored past holds q' and q'' of all coordinates, not of the independent ones only: after a new choice of the
/// independent set it serves as it is, and the dependent coordinates get a guess of the same order for free.
/// Past values come from Dormand-Prince steps of order 5 in substeps, so the start costs no order (k starting values of
/// local error h^6 each). A step of another length restarts. Energy flows ride along with the same corrector.
/// The difference of corrector and predictor, both before the joints are closed, tells the error of the step (Milne's
/// device): |y - y*| C_M / (C_B + C_M) with the error constants of both; step_error() sums it. A step that errs by a
/// tenth of the machine's length ends the run. Steps of the start, and of each restart at an event, count with the
/// error of the embedded order 4. Where an error per second is given, steps are halved to it: first steps of an impact
/// err by a low power of their length, since the force of a contact is no polynomial of time. Elements' states, as
/// currents and pressures, works and losses are held to the same share of their size. Steps that do not see what inputs
/// do in them are halved too; of given steps step_error() has the share that they miss. A step that ends on a singular
/// pose is bridged: q and q' by the predictor, closed with minimum change, q'' by extrapolation of the same order,
/// reactions of the step before. A step over one must continue smoothly: when the constraints answer with velocities
/// that the predictor does not know, the run stops instead of changing its branch.
class AdamsMoulton : public Integrator {
 public:
  AdamsMoulton(System& system, const AdamsMoultonOptions& options);
  bool ends_anywhere() const override { return false; }

 protected:
  void on_start() override;
  void on_advance(double h) override;
  void on_save(Snapshot::Past& out) const override;
  void on_restore(const Snapshot::Past& from) override;

 private:
  Eigen::Index slot(int age) const { return (newest_ + order_max - age) % order_max; }
  std::span<const double> weights() const;
  void watch_inputs(double h);
  bool no_wrench() const;           ///< from outside, as of soil
  bool follows_on(double h) const;  ///< a step of that length has the past of those before
  void whole_step(double h);
  void choose_again();
  bool controlled() const;  ///< by its error
  void controlled_step(double end);
  bool attempt(double h);
  void push_past();
  void take_jump();
  void multistep(double h);
  void predict(double h);
  void correct(double h);
  void bridge(double h);
  void check_branch();
  void keep_predicted();
  void estimate_error(double h);
  void begin_errors();
  void add_error(double h, double position, double velocity, const MotionState& at);
  void add_flow_error(double share, const Eigen::Ref<const Eigen::VectorXd>& difference, const MotionState& at);
  void one_step(double h);
  void sum_past(const double* weights, int count, double h);
  template <std::size_t... age>
  void sum_columns(const double* weights, double h, std::index_sequence<age...>);

  static constexpr int order_max = 6;
  AdamsMoultonOptions options_;
  // Columns (q', q'', rates) of the last steps, a ring: a predictor or corrector is then one sum over columns.
  Eigen::MatrixXd past_;
  Eigen::VectorXd sum_;
  double flow_error_ = 0;  // sum over the steps, of an energy to what is there, of an element's state to its size (1)
  Eigen::VectorXd predicted_q_, predicted_velocity_, predicted_flows_,
      scale_;  // of the step, before the joints are closed
  int newest_ = 0, stored_ = 0;
  double step_ = 0;
  double origin_ = 0;  // time of the first step of this length: t = origin + steps * h does not gather rounding
  double end_ = 0;     // of the step
  long steps_ = 0, wrench_changes_ = 0;
  StepClock clock_;  // of advance()
  MotionState trial_;
  RungeKutta starter_;
  Inputs inputs_;
  Inputs::Missed missed_;
  bool was_near_singular_ = false, bridged_ = false;
  double errors_from_ = std::numeric_limits<double>::infinity();  ///< begin of the last on_advance(), and then:
  StepError errors_before_;
  // Steps that are made of parts: of 2^level_, and how many have erred so little that fewer would do.
  int level_ = 0;
  long sure_ = 0;
};

}  // namespace subsoil::mbd
