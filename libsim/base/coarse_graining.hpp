#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "libdem/base/vec3.hpp"

/// Continuum fields of a body of grains by coarse graining: I. Goldhirsch, Stress, stress asymmetry and couple stress:
/// from discrete particles to continuous fields, Granular Matter 12 (2010) 239; at boundaries after T. Weinhart et al.,
/// Granular Matter 14 (2012) 289. With the kernel phi of integral 1, sums over grains i and their contacts c:
///   rho(r)     = sum m_i phi(r - x_i)                               bulk density
///   nu(r)      = sum V_i phi(r - x_i)                               solid fraction, porosity 1 - nu
///   rho V(r)   = sum m_i v_i phi(r - x_i)                           velocity V
///   P_k(r)     = sum m_i (v_i - V)(v_i - V) phi(r - x_i)            kinetic stress
///   P_c(r)     = sum_c F_c b_c int_0^1 phi(r - x_i + s b_c) ds      contact stress
/// F_c is the force on i, b_c leads from the other end of the contact to x_i: from the centre of j, or from the point
/// on a surface. What a clump passes on inside itself is given as contacts too. Stresses are compressive positive,
/// first index the force. They obey the balance of momentum exactly, on every scale of phi: d(rho V)/dt = -div(P_k +
/// P_c + rho V V) + rho g + force of surfaces. P_c need not be symmetric.
namespace subsoil::sim {

using dem::Vec3;
using Tensor = std::array<double, 9>;  ///< xx xy xz yx ...

/// phi, by its width w: Lucy's quartic, zero from 2 w on, or a Gaussian of deviation w, cut off at 3 w.
class FieldKernel {
 public:
  enum class Kind { lucy, gaussian };
  FieldKernel(Kind kind, double width);
  double reach() const { return reach_; }
  /// By the square of the distance, 1/m^3; 0 from the reach on.
  double operator()(double distance2) const;
  /// int_0^1 phi(r - a - s (b - a)) ds over the stretch from a to b.
  double along(const Vec3& r, const Vec3& a, const Vec3& b) const;

 private:
  Kind kind_;
  double width_, reach_, factor_;
};

/// Points of a regular grid, x fastest.
struct FieldGrid {
  Vec3 low;
  Vec3 spacing{};  ///< along each axis
  std::array<std::size_t, 3> n{1, 1, 1};
  std::size_t size() const { return n[0] * n[1] * n[2]; }
  Vec3 point(std::size_t i, std::size_t j, std::size_t k) const {
    return low + Vec3{spacing.x * static_cast<double>(i), spacing.y * static_cast<double>(j),
                      spacing.z * static_cast<double>(k)};
  }
};

struct FieldGrain {
  Vec3 position{}, velocity{};
  double mass = 0, volume = 0, contacts = 0;
};

/// By point of the grid.
struct GrainFields {
  std::vector<double> density, solid_fraction, coordination;
  std::vector<Vec3> velocity;
  std::vector<Tensor> kinetic_stress, contact_stress;
};

class CoarseGraining {
 public:
  CoarseGraining(const FieldGrid& grid, const FieldKernel& kernel);
  void add(const FieldGrain& grain);
  /// @param end centre of the other sphere, or point on a surface @param force on the sphere at `centre`
  void add_contact(const Vec3& centre, const Vec3& end, const Vec3& force);
  GrainFields finish();

 private:
  template <class Use>
  void near(const Vec3& low, const Vec3& high, const Use& use) const;
  FieldGrid grid_;
  FieldKernel kernel_;
  GrainFields sum_;
  std::vector<double> number_;
};

}  // namespace subsoil::sim
