#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "libmbd/system.hpp"

namespace subsoil::mbd {

/// What assembly found out about a machine.
struct AssemblyReport {
  int equations = 0;
  int rank = 0;     ///< of Phi_q in the assembled pose
  int freedom = 0;  ///< coordinates - rank
  int iterations = 0;
  double residual = 0;                 ///< largest |Phi|, angles times the machine's length (m)
  double moved = 0;                    ///< largest change of a coordinate by assembly (m, angles times length)
  std::vector<std::string> redundant;  ///< one sentence per dependency among constraints, naming joints and drivers
};

/// Brings a rough guess of q onto the constraints with the least change of q (Newton, minimum norm), and q' onto
/// Phi_q q' = -Phi_t in the same way. Lengths and angles are made comparable by System::length_scale.
/// Redundant but consistent constraints are reported; throws std::invalid_argument naming joints and residuals when
/// constraints contradict each other or are out of reach.
AssemblyReport assemble(System& system, double t, Eigen::VectorXd& q, Eigen::VectorXd& velocity);

/// Refuses a pose whose joints are open by more than 1e-9 of the machine's length: std::invalid_argument naming them
/// with their residuals.
void refuse_open_joints(System& system, double t, const Eigen::VectorXd& q);

/// Phi_q with angles scaled to lengths, rows and columns; and the column scale (1 or length) it used.
Eigen::MatrixXd scaled_jacobian(const System& system, const Constraints& c);
Eigen::VectorXd coordinate_scale(const System& system);
Eigen::VectorXd row_scale(const System& system);

}  // namespace subsoil::mbd
