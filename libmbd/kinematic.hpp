#pragma once

#include "libmbd/integrator.hpp"

namespace subsoil::mbd {

/// Kinematic analysis and inverse dynamics of a machine that joints and drivers hold in every coordinate (freedom 0):
///   Phi(q, t) = 0   by Newton from the pose before, carried on by q' dt + q'' dt^2/2
///   Phi_q q' = -Phi_t,   Phi_q q'' = gamma,   Phi_q^T lambda = F - M q''
/// so reactions and driving forces follow from the multipliers without any integration. Each step is made in four
/// parts, which keeps Newton on its branch and gives the energy flows by Boole's rule, order 6.
/// start() throws std::invalid_argument naming the coordinates that nothing drives.
/// Source: Haug 1989, Computer Aided Kinematics and Dynamics of Mechanical Systems I, chapters 3 and 7.
class Kinematic : public Integrator {
 public:
  explicit Kinematic(System& system) : Integrator(system) {}

 protected:
  void on_start() override;
  void on_advance(double h) override;
  void on_restore(const double*&, const double*) override { on_start(); }
  /// Nothing is integrated, so no force's switch costs any order.
  bool finds_events() const override { return true; }

 private:
  StepClock clock_;
};

/// "rod.angle": a coordinate as scenarios name it.
std::string coordinate_name(const System& system, int coordinate);

}  // namespace subsoil::mbd
