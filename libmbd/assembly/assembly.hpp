#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A singular value or pivot below this share of the maximum counts as zero. Rounding leaves 1e-15; the closest call of
/// an honest machine (a nearly stretched toggle) stays above 1e-6.
inline constexpr double rank_share = 1e-9;

/// What assembly found out about a machine.
struct AssemblyReport {
  int equations = 0;
  int rank = 0;     ///< of Phi_q in the assembled pose
  int freedom = 0;  ///< coordinates - rank
  int iterations = 0;
  double residual = 0;                 ///< maximum |Phi|, angles times the machine's length (m)
  double moved = 0;                    ///< maximum displacement of a body by assembly, or length times angle (m)
  std::string moved_body;              ///< of this body
  std::vector<std::string> redundant;  ///< one sentence per dependency among constraints, naming joints and drivers
  std::vector<std::vector<PartName>> redundant_parts;  ///< what each of these names, in the order of their equations
};

/// Brings a rough guess of q onto the constraints with the minimum change of q (Newton, minimum norm), and q' onto
/// Phi_q q' = -Phi_t in the same way. Lengths and angles are made comparable by System::length_scale.
/// Coordinates of bodies whose pose is `exact` stay what they are. Of the velocities those that are exact, or given and
/// not 0, stay too, and the others follow; where the constraints allow that of none, all change by the minimum.
/// Redundant but consistent constraints are reported; throws std::invalid_argument naming joints and residuals when
/// constraints contradict each other or are out of reach.
AssemblyReport assemble(System& system, double t, Eigen::VectorXd& q, Eigen::VectorXd& velocity);

/// Refuses, by std::invalid_argument, an assembled start (q, velocity) that is not what the model gives: a body moved
/// by more than 1 % of its size (its longest moment arm), or a velocity other than 0 changed by more than 1e-3 of the
/// fastest one. Names each body with what was given, what was assembled and the difference. Poses and velocities that
/// are `about` may change.
void refuse_changed_start(const System& system, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity);

/// Refuses a pose whose joints are open by more than 1e-9 of the machine's length: std::invalid_argument naming them
/// with their residuals.
void refuse_open_joints(System& system, double t, const Eigen::VectorXd& q);

/// Drivers and joints that no velocities satisfy together at the state set last; none where they agree.
std::vector<PartName> contradicting_parts(const System& system);
/// "driver 'b' and driver 'a' depend on each other and ask for different motions from here on"
std::string different_motions(const std::vector<PartName>& parts);

/// Phi_q with angles scaled to lengths, rows and columns; and the column scale (1 or length) it used.
Eigen::MatrixXd scaled_jacobian(const System& system, const Constraints& c);
Eigen::VectorXd coordinate_scale(const System& system);
Eigen::VectorXd row_scale(const System& system);

}  // namespace subsoil::mbd
