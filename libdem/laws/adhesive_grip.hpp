#pragma once
#include "libdem/laws/contact.hpp"

/// What limits friction and rolling of a contact whose adhesion grows with its past: three conventions in use.
///     force-plus-adhesion  max(0, F + A)   A the adhesive branch at this overlap: nothing where the contact tears
///                                          (Luding 2008; EEPA of Morrissey 2013; LIGGGHTS)
///     absolute-force       |F|             MercuryDPM
///     repulsion-only       max(0, F)
namespace subsoil::dem {

enum class AdhesiveGrip { force_plus_adhesion, absolute_force, repulsion_only };

template <class V>
void describe(V& v, AdhesiveGrip& grip) {
  v.choice("friction limit", grip,
           {{"force-plus-adhesion", AdhesiveGrip::force_plus_adhesion},
            {"absolute-force", AdhesiveGrip::absolute_force},
            {"repulsion-only", AdhesiveGrip::repulsion_only}},
           "what friction and rolling are limited by under attraction");
}

/// @param force with damping, N; @param adhesion pull of the adhesive branch at this overlap, N >= 0
template <class T>
[[gnu::always_inline]] inline T grip_of(AdhesiveGrip rule, T force, T adhesion) {
  const T zero(0.0);
  if (rule == AdhesiveGrip::absolute_force) return max(force, -force);
  return max(zero, rule == AdhesiveGrip::force_plus_adhesion ? force + adhesion : force);
}

}  // namespace subsoil::dem
