#pragma once

#include <memory>

#include "libmbd/integrators/adaptive.hpp"

namespace subsoil::mbd {

/// SUNDIALS IDA (variable-order, variable-step backward differences) on the whole system, in one of two forms.
/// Stabilised index 2 (Gear, Gupta and Leimkuhler 1985), constraints on position and velocity level:
///   q' = w - Phi_q^T mu          M w' + Phi_q^T lambda = F
///   0  = Phi(q, t)               0 = Phi_q w + Phi_t
/// Index 1, constraints on the level of accelerations:
///   q' = w                       M w' + Phi_q^T lambda = F             0 = Phi_q w' - gamma
/// and in both e' = powers, the energy flows under the same error control.
/// Independent of partitioning, which only supplies consistent starts and puts outputs on Phi = 0 to rounding. The
/// index-1 form drifts off the constraints between; when the drift at an output exceeds the tolerance it restarts
/// from the projected state. After a jump of the external wrench q'' and lambda are made consistent and IDA begins
/// again.
class Ida : public Adaptive {
 public:
  Ida(System& system, const IdaOptions& options);
  ~Ida() override;

  long steps() const override;
  long evaluations() const override;

 protected:
  void build() override;
  void begin() override;
  Reached take_step(double stop, const Inputs::Inside& inside) override;
  double planned_step() const override;
  void read(double t) override;
  void dense(double t, StepSegment& out) override;
  const std::vector<double>& end_values() const override;
  void root_directions(std::vector<int>& out) override;
  double step_tolerance() const override { return rtol_ + atol_; }
  bool follows_partition() const override { return false; }
  bool has_drifted() const override { return drift_ > drift_limit_; }

 private:
  struct Solver;  // keeps SUNDIALS out of this header
  IdaOptions options_;
  double rtol_, atol_;  // of a step
  std::unique_ptr<Solver> solver_;
  double drift_ = 0, drift_limit_ = 0;  // maximum |Phi| read last, angles times length (m)
};

}  // namespace subsoil::mbd
