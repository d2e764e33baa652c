#pragma once

#include <array>
#include <span>
#include <vector>

#include "libmbd/body.hpp"
#include "libmbd/rut.hpp"

namespace subsoil::mbd {

/// What a force sees: the bodies (0 = ground), the time, the ground's ruts, and the multipliers of the equations for
/// the friction that they make.
struct Scene {
  std::span<const BodyState> bodies;
  double t = 0;
  std::span<const Rut> ruts;
  std::span<const double> lambda{};
};

/// Where a force puts what it does: (F_x, F_y, M_z) about each body's centre of gravity, world axes. Ground has a slot
/// that nobody reads, so that no force needs a branch for it.
class Loads {
 public:
  explicit Loads(std::span<std::array<double, 3>> wrenches) : wrenches_(wrenches) {}
  /// Force `f` on the material point at world lever `arm` from the centre of gravity.
  void add(int body, Vec2 arm, Vec2 f) { add_wrench(body, f.x, f.y, cross(arm, f)); }
  void add_wrench(int body, double fx, double fy, double mz) {
    auto& w = wrenches_[static_cast<std::size_t>(body)];
    w[0] += fx, w[1] += fy, w[2] += mz;
  }

 private:
  std::span<std::array<double, 3>> wrenches_;
};

/// The energy account of a force, of which the book of the whole system is made:
///   power on the bodies = work - lost - d(stored)/dt
struct ForcePower {
  double stored = 0;  ///< energy that it can give back (J)
  double lost = 0;    ///< rate of dissipation (W)
  double work = 0;    ///< rate of work that it brings in from outside (W)
};

/// What an event does to a force at that instant.
struct Changeover {
  double heat = 0;      ///< energy that it loses (J)
  bool slides = false;  ///< friction: whether it slides from now on
};

/// A reported value of a force: name and unit.
struct ForceColumn {
  const char* name;
  const char* unit;
};
inline constexpr std::size_t max_force_columns = 5;
using ForceValues = std::array<double, max_force_columns>;

}  // namespace subsoil::mbd
