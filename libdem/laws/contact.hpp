#pragma once
#include <algorithm>
#include <limits>

#include "libdem/laws/law.hpp"
#include "libdem/simd/number.hpp"

/// What passes between the sweep and a contact law. A law knows no particle, list or loop: numbers in, numbers out.
///
/// A law whose force depends on what happened before states `has.memory = M` (LawMembers) and takes
/// `normal(const Approach<T>&, T (&memory)[M])`: numbers of the contact, 0 when it begins, kept from step to step, in
/// restarts and when lists are rebuilt. Scalars only, the same from either body's side. The pair may stay in the
/// lists while its surfaces are apart: the law sets its numbers back to 0 there.
///
/// What else a law may have, beside `describe`, `resolved()`, `cutoff()`, `rest_overlap()`, `normal`, `bound`,
/// `example()` and a member `friction`, states LawMembers.
namespace subsoil::dem {

/// What a law has beside the members that all have, as its `static constexpr LawMembers has{...}`. The engine asks for
/// what stands here and nothing else. IsLaw compares it with the members that there are, so that a misspelt one is no
/// silent loss: the law's interface does not compile.
struct LawMembers {
  int memory = 0;                 ///< numbers that a contact keeps, at most kOwnMemory: normal() gets them
  bool plastic = false;           ///< part of the force loses energy along its path
  bool needs_radius = true;       ///< Approach::r_eff is read
  bool needs_sum = false;         ///< Approach::per_sum is read
  bool cutoff_by_radius = false;  ///< cutoff(r_eff) in place of cutoff()
  bool weaken = false;            ///< weaken(share): leaves a share of the attraction
  bool may_gain = false;          ///< may_gain(): whether a contact that parts may free what it never stored
  bool refuse_collapse = false;   ///< refuse_collapse(r_eff): throws where attraction wins over the contact
};

/// One contact as a normal law sees it.
template <class T>
struct Approach {
  T overlap;  ///< delta, m; negative is a gap
  T rate;     ///< d delta/dt, m/s; positive while approaching, at the middle of the step that ends now
  T root_m;   ///< sqrt(m_eff), kg^1/2, m_eff = m1 m2/(m1 + m2), the sphere's mass at a boundary: damping needs the root
  T r_eff;    ///< r1 r2/(r1 + r2), m; the sphere's radius at a boundary
  T elapsed;  ///< time since the contact was last evaluated, s (0 at the first step of a run)
  T per_sum = T(0.0);  ///< 1/(r1 + r2), 1/m; 0 at a boundary; filled where has.needs_sum only
};

/// What a normal law answers. Forces along the contact normal, compression positive.
template <class T>
struct NormalForce {
  T force;                  ///< N
  T damping;                ///< the part of `force` that dissipates, N
  T limiting_force;         ///< what friction and rolling resistance are limited by, N >= 0: |F_t| <= mu limiting_force
  T stored;                 ///< energy stored in the normal direction, J; 0 when separated, negative under attraction
  T k_n;                    ///< normal tangent stiffness now, N/m (rolling stiffness is derived from it)
  T k_t;                    ///< tangential stiffness now, N/m
  T stiffness_ratio;        ///< stiffness at the previous evaluation over stiffness now; 1 where it is constant
  T tangential_compliance;  ///< 1/k_t, m/N, 0 where k_t = 0
  T c_t;                    ///< tangential damping coefficient, N s/m
  Mask<T> in_contact;       ///< surfaces touch: tangential and rolling resistance act
  T c_n = T(0.0);           ///< normal damping coefficient, N s/m; where it acts
  T attraction = T(0.0);    ///< the part of `force` that pulls, N >= 0
  T lost = T(0.0);  ///< J lost in this step other than by `damping`: plastic work, and what tears; 0 for elastic laws
};

/// What `clip attraction` leaves of a normal force at least.
template <class T>
inline T least_force(bool clip) {
  return T(clip ? 0.0 : -std::numeric_limits<double>::infinity());
}

/// The law's normal force; `own` holds the contact's numbers, in and out (one that is not used where there are none).
template <class L, class T, int Numbers>
[[gnu::always_inline]] inline NormalForce<T> normal_force(const L& law, const Approach<T>& a, T (&own)[Numbers]) {
  constexpr int memory = L::has.memory;
  static_assert(Numbers >= memory && memory <= kOwnMemory);
  if constexpr (memory == 0) {
    return law.normal(a);
  } else if constexpr (memory == Numbers) {
    return law.normal(a, own);
  } else {
    T mine[memory];
    std::copy_n(own, memory, mine);
    const NormalForce<T> out = law.normal(a, mine);
    std::copy_n(mine, memory, own);
    return out;
  }
}

/// Upper bounds of what a law can do to a sphere, for the stable step (stability.hpp).
struct StiffnessBound {
  double k_n = 0, c_n = 0;  ///< N/m, N s/m
  double k_t = 0, c_t = 0;
  double k_r = 0, c_r = 0;  ///< rolling, N m/rad, N m s/rad
};

/// What the bound may assume about the worst contact.
struct WorstContact {
  double m_eff, r_eff;  ///< kg, m
  double r_min;         ///< radius of the smaller sphere, m
  double speed;         ///< maximum approach speed expected, m/s (nonlinear laws stiffen with it)
  double overlap = 0;   ///< m, to which it is pressed, where that is deeper than an impact at that speed
};

}  // namespace subsoil::dem
