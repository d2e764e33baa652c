#pragma once
#include "libdem/impact/impact.hpp"
#include "libmbd/base/plastic_stiffness.hpp"

namespace subsoil::sim {

/// Impact on the ground element: the source's own problem, for which libmbd's force of the same name has a machine.
///     The body m takes up the follower m_b = share m at rest (restitution 0): V0 = m V/(m + m_b), at once lost
///     (m m_b/(m + m_b)) V^2/2. Then (m + m_b) z'' = m g - K'(z, V, m) z until z' = 0; nothing comes back.
///     (m + m_b) V0^2/2 + m g z_max = int_0^z_max K' z dz;   force on the body F_s = m (K' z + m_b g)/(m + m_b)
/// With a share x of all loss in vibration and sound, share = x/(1 - x). The follower's weight is carried by the ground
/// before. The peak force leaves out the impulse of the first instant.
/// Source: Ye Min-zhen, Ground modeling in machinery-ground interaction system and parameter determination.
struct GroundImpact {
  mbd::PlasticStiffness stiffness;
  double share = 0.1;
  double gravity = 9.81;

  template <class V>
  void describe(V& v) {
    v.card("ground-element", "a body on a follower mass over a plastic spring");
    v.form("stiffness", stiffness, "K' of the plastic spring");
    v.quantity("follower", share, "1", "[0, 10]", "follower mass over the mass that strikes");
    v.quantity("gravity", gravity, "m/s^2", "[0, inf)", "acts on the body while it sinks; 0: left out");
  }
  double restitution_at(const dem::impact::Pair&, double) const { return 0; }
  dem::impact::Event strike(const dem::impact::Pair& pair, double speed, int samples) const;
};

}  // namespace subsoil::sim
