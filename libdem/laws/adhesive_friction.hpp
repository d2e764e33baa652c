#pragma once
#include "libdem/laws/contact.hpp"

/// What limits friction and rolling of a contact whose adhesion grows with its past: three conventions in use.
///     force-plus-adhesion  max(0, F + A)   A the adhesive branch at this overlap: nothing where the contact tears
///                                          (Luding 2008; EEPA of Morrissey 2013; LIGGGHTS)
///     absolute-force       |F|             MercuryDPM
///     repulsion-only       max(0, F)
namespace subsoil::dem {

enum class AdhesiveLimit { force_plus_adhesion, absolute_force, repulsion_only };

template <class V>
void describe(V& v, AdhesiveLimit& limiting_force) {
  v.choice("friction limit", limiting_force,
           {{"force-plus-adhesion", AdhesiveLimit::force_plus_adhesion},
            {"absolute-force", AdhesiveLimit::absolute_force},
            {"repulsion-only", AdhesiveLimit::repulsion_only}},
           "what friction and rolling are limited by under attraction");
}

/// @param force with damping, N; @param adhesion pull of the adhesive branch at this overlap, N >= 0
template <class T>
[[gnu::always_inline]] inline T limiting_force_of(AdhesiveLimit rule, T force, T adhesion) {
  const T zero(0.0);
  if (rule == AdhesiveLimit::absolute_force) return max(force, -force);
  return max(zero, rule == AdhesiveLimit::force_plus_adhesion ? force + adhesion : force);
}

}  // namespace subsoil::dem
