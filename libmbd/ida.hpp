#pragma once

#include <memory>

#include "libmbd/integrator.hpp"

namespace subsoil::mbd {

/// SUNDIALS IDA (variable-order, variable-step BDF) on the stabilised index-2 equations of Gear, Gupta and Leimkuhler:
///   q' = w - Phi_q^T mu          M w' + Phi_q^T lambda = F
///   0  = Phi(q, t)               0 = Phi_q w + Phi_t
///   e' = powers                  the energy flows, under the same error control
/// Independent of partitioning, which only supplies consistent starts and puts outputs on Phi = 0 to rounding.
/// advance() ends exactly at its end (stop time); after a jump of the external wrench q'' and lambda are made
/// consistent and IDA is re-initialised, since no smooth history crosses a jump.
class Ida : public Integrator {
 public:
  Ida(System& system, const IdaOptions& options);
  ~Ida() override;

  /// Steps taken since the start, over all re-initialisations.
  long steps() const;

 protected:
  void on_start() override;
  void on_advance(double h) override;
  void on_restore(const double*& from, const double* end) override;

 private:
  struct Solver;  // keeps SUNDIALS out of this header
  void reinitialise();
  IdaOptions options_;
  std::unique_ptr<Solver> solver_;
  long wrench_changes_ = 0;
  bool fresh_ = false;  // no step since the last re-initialisation
};

}  // namespace subsoil::mbd
