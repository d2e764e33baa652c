#pragma once

#include <memory>
#include <vector>

#include "libmbd/partition.hpp"

namespace subsoil::mbd {

/// The integrators; one word in a scenario.
enum class IntegratorKind { adams_moulton, ida };

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

  template <class V>
  void describe(V& v) {
    v.card("adams-moulton",
           "Adams-Bashforth predictor, Adams-Moulton corrector, fixed step, on partitioned coordinates");
    v.count("order", order, "[1, 6]", "order of accuracy");
    v.choice("after a jump of the wrench", wrench_jump,
             {{"shift", WrenchJump::shift}, {"restart", WrenchJump::restart}},
             "what the multistep past becomes when the soil's wrench changes between steps");
  }
};

struct IdaOptions {
  double rtol = 1e-8;
  double atol = 1e-10;

  template <class V>
  void describe(V& v) {
    v.card("ida", "SUNDIALS IDA, variable order and step, on the stabilised index-2 equations");
    v.quantity("rtol", rtol, "1", "(0, 0.1]", "relative tolerance");
    v.quantity("atol", atol, "1", "(0, 0.1]", "absolute tolerance, in m, rad, m/s and rad/s");
  }
};

/// Energy that crossed the book since the start (J): integrals of powers, never remainders.
struct EnergyFlows {
  Eigen::VectorXd of_elements;  ///< as MotionState::rates: lost of forces, work of forces, work of drivers
  double external_work = 0;  ///< of external wrenches: wrench times displacement, exact since it is constant per step
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
  /// Moves on by h > 0 with the external wrenches held, and accepts the step (ruts).
  void advance(double h);

  const MotionState& state() const { return now_; }
  const EnergyFlows& flows() const { return flows_; }
  Partition& partition() { return partition_; }
  const Partition& partition() const { return partition_; }
  System& system() { return system_; }

  /// Everything a restart needs, as plain numbers, and back.
  void save(std::vector<double>& out) const;
  void restore(const double*& from, const double* end);

 protected:
  virtual void on_start() = 0;
  virtual void on_advance(double h) = 0;
  virtual void on_save(std::vector<double>&) const {}
  virtual void on_restore(const double*&, const double*) {}
  static void put(std::vector<double>& out, const Eigen::VectorXd& v) {
    out.insert(out.end(), v.data(), v.data() + v.size());
  }
  static void take(const double*& from, const double* end, Eigen::VectorXd& v);
  static double take(const double*& from, const double* end);

  System& system_;
  Partition partition_;
  MotionState now_;
  EnergyFlows flows_;

 private:
  Eigen::VectorXd q_before_;
};

std::unique_ptr<Integrator> make_integrator(IntegratorKind kind, System& system, const AdamsMoultonOptions& adams = {},
                                            const IdaOptions& ida = {});

}  // namespace subsoil::mbd
