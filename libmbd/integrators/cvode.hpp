#pragma once

#include <memory>

#include "libmbd/integrators/adaptive.hpp"

namespace subsoil::mbd {

/// SUNDIALS CVODE, Adams-Moulton methods of order 1 to 12 with variable step, functional iteration, on the partitioned
/// ordinary differential equations:
///   y = (v, v', e),   y' = (v', v'' of the partition, powers)
/// with the energy flows e under the same error control. A joint that cannot be closed at a trial state, or that closes
/// far from where the motion so far leads (another branch), asks for a shorter step; only when that does not help the
/// run ends with the joint's name. The choice for smooth motion that is not stiff: few evaluations per digit. For stiff
/// contacts and dampers: ida. Source: Hindmarsh et al. 2005, ACM TOMS 31, 363; Wehage & Haug 1982 for the equations.
class Cvode : public Adaptive {
 public:
  Cvode(System& system, const CvodeOptions& options);
  ~Cvode() override;

  long steps() const override;
  long evaluations() const override;

 protected:
  void build() override;
  void begin() override;
  Reached take_step(double stop) override;
  double planned_step() const override;
  void read(double t) override;
  void dense(double t, Piece& out) override;
  void root_directions(std::vector<int>& out) override;
  double step_tolerance() const override {
    return local_tolerance(options_.rtol, 1e-14) + local_tolerance(options_.atol, 1e-15);
  }
  bool follows_partition() const override { return true; }

 private:
  struct Solver;  // keeps SUNDIALS out of this header
  CvodeOptions options_;
  std::unique_ptr<Solver> solver_;
};

}  // namespace subsoil::mbd
