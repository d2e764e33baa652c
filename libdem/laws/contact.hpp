#pragma once
#include "libdem/laws/number.hpp"

/// What passes between the sweep and a contact law. A law knows no particle, list or loop: numbers in, numbers out.
///
/// A law whose force depends on what happened before says `static constexpr int memory = M` and takes
/// `normal(const Approach<T>&, T (&memory)[M])`: numbers of the contact, 0 when it begins, kept from step to step, in
/// restarts and when lists are built anew. Scalars only, the same from either body's side. The pair may stay in the
/// lists while its surfaces are apart: the law sets its numbers back to 0 there.
namespace subsoil::dem {

/// One contact as a normal law sees it.
template <class T>
struct Approach {
  T overlap;  ///< delta, m; negative is a gap
  T rate;     ///< d delta/dt, m/s; positive while approaching, at the middle of the step that ends now
  T root_m;   ///< sqrt(m_eff), kg^1/2, m_eff = m1 m2/(m1 + m2), the sphere's mass at a boundary: damping needs the root
  T r_eff;    ///< r1 r2/(r1 + r2), m; the sphere's radius at a boundary
  T elapsed;  ///< time since the contact was last evaluated, s (0 at the first step of a run)
};

/// What a normal law answers. Forces along the contact normal, compression positive.
template <class T>
struct NormalForce {
  T force;          ///< N
  T damping;        ///< the part of `force` that dissipates, N
  T grip;           ///< what friction and rolling resistance are limited by, N >= 0: |F_t| <= mu grip
  T stored;         ///< energy stored in the normal direction, J; 0 when separated, negative under attraction
  T k_n;            ///< normal tangent stiffness now, N/m (rolling stiffness is derived from it)
  T k_t;            ///< tangential stiffness now, N/m
  T growth;         ///< stiffness at the previous evaluation over stiffness now; 1 where it is constant
  T soft_t;         ///< 1/k_t, m/N, 0 where k_t = 0
  T c_t;            ///< tangential damping coefficient, N s/m
  Mask<T> engaged;  ///< surfaces touch: tangential and rolling resistance act
  T lost = T(0.0);  ///< J lost in this step other than by `damping`: plastic work, and what tears; 0 for elastic laws
};

/// A law that remembers (`static constexpr int memory = M`) answers normal(approach, memory): M scalars of the contact,
/// the same seen from either body, 0 when it begins, brought up to date in place. The law itself sets them back to 0
/// when the surfaces have parted. What it stores and loses over a step adds up to the work of the force less damping.
template <class L>
concept Remembers = L::memory > 0;

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
  double speed;         ///< largest approach speed expected, m/s (nonlinear laws stiffen with it)
};

}  // namespace subsoil::dem
