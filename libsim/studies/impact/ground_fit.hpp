#pragma once
#include <filesystem>

#include "libsim/studies/impact/fit.hpp"

namespace subsoil::sim {

/// K' of the ground element from measured forces F_s(z) at several speeds, columns `speed [m/s], depth [m], force [N]`
/// and, where masses differ, `mass [kg]`:
///     K' = (F_s (1 + share) - m_b g)/z,     ln K' = ln K0 + alpha ln(z/z0) + beta ln(v/v0) + gamma ln(m/m0)
/// by linear least squares on the logarithm, beyond z1 with a second power of the depth where the study has `deep
/// from`. F_s is the force between body and follower; both move as one. z0, v0, m0, z1 are the study's (stiffness:
/// {power:
/// ...}). Exponents that the data do not vary stay as they are. Throws ScenarioError with file:line.
ImpactFit fit_ground(const LoadedStudy& loaded, const std::filesystem::path& data);

}  // namespace subsoil::sim
