#pragma once

#include <memory>

#include "libmbd/integrators/adaptive.hpp"
#include "libmbd/integrators/stiffness_monitor.hpp"

namespace subsoil::mbd {

/// SUNDIALS CVODE with variable step on the partitioned ordinary differential equations, by Adams-Moulton methods of
/// order 1 to 12 with functional iteration, or where the motion is stiff (StiffnessMonitor) by backward differences of
/// order 1 to 5 with Newton's iteration:
///   y = (v, v', e),   y' = (v', v'' of the partition, powers)
/// with the energy flows e under the same error control. A joint that cannot be closed at a trial state, or that closes
/// far from where the motion so far leads (another branch), asks for a shorter step; only when that does not help the
/// run ends with the joint's name. Adams' methods take few evaluations per digit of a smooth motion.
/// Source: Hindmarsh et al. 2005, ACM TOMS 31, 363; Wehage & Haug 1982 for the equations; Petzold 1983, SIAM J. Sci.
/// Stat. Comput. 4, 136 for the change of methods.
class Cvode : public Adaptive {
 public:
  Cvode(System& system, const CvodeOptions& options);
  ~Cvode() override;

  long steps() const override;
  long evaluations() const override;
  /// Whether it integrates by backward differences.
  bool implicit() const { return stiffness_.implicit(); }

 protected:
  void on_start() override;
  void build() override;
  void begin() override;
  Reached take_step(double stop, const Inputs::Inside& inside) override;
  double planned_step() const override;
  void read(double t) override;
  void dense(double t, StepSegment& out) override;
  const std::vector<double>& end_values() const override;
  void root_directions(std::vector<int>& out) override;
  double step_tolerance() const override {
    return local_tolerance(options_.rtol, 1e-14) + local_tolerance(options_.atol, 1e-15);
  }
  bool follows_partition() const override { return true; }
  bool wants_restart() override;

 private:
  struct Solver;  // keeps SUNDIALS out of this header
  CvodeOptions options_;
  StiffnessMonitor stiffness_;
  std::unique_ptr<Solver> solver_;
};

}  // namespace subsoil::mbd
