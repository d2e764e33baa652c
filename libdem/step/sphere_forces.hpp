#pragma once
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/sphere_force.hpp"

namespace subsoil::dem {

/// Forces of users on spheres (libdem/sphere_force.hpp), and their work.
///
/// | data           | written by                                                         | read by                    |
/// |---|---|---|
/// | forces         | users, between steps; `begin_step`, restarts                       | the sweep, `Clumps`        |
/// | work of blocks | the worker of the particle block, in the sweep                     | energy balance, saved state|
/// | work on clumps | `Clumps`, after the sweep, one thread                              | likewise                   |
/// | fault          | whoever evaluates a force; that of the lowest sphere stays         | `throw_fault`              |
///
/// Work by the rule of leapfrog, (F_n + F_{n+1})/2 . v_{n+1/2} dt (docs/theory, section 6). Each force is added with
/// the half steps on either side of its instant, so that none has to be kept until the next step; the half behind t_n
/// is part of the balance from t_{n+1} on.
class SphereForces {
 public:
  struct Work {
    double until = 0;  ///< J, up to t_n
    double ahead = 0;  ///< J, of forces at t_n over the half step behind it
    void begin_step() { until += ahead, ahead = 0; }
    double all() const { return until + ahead; }
    void archive(Archive& a) { a("until", until)("ahead", ahead); }
  };
  struct Motion {
    Vec3 velocity, angular_velocity;
  };
  static constexpr int kMostSubstitutions = 64;  ///< of errors that halve each time, 2^-64 of the first is left

  bool any() const { return !forces_.empty(); }
  std::span<const NamedSphereForce> all() const { return forces_; }
  void add(std::string name, SphereForce force);  ///< throws std::invalid_argument
  SphereForce& at(std::string_view name);         ///< likewise
  void begin_lists(std::size_t blocks);

  // A step.
  void begin_step(double time);
  /// Of all forces. Throws BedFault where it is not finite.
  Wrench sum(const SphereAt& s) const;
  /// Of all forces on a free sphere; none after a fault.
  /// @param s with the velocities that contacts and gravity alone lead to at t_n
  /// @param push, turn half a step over mass, s/kg, and over moment of inertia, s/(kg m2)
  Wrench on_free(SphereAt s, double push, double turn);
  /// The motion that its own forces lead to: motion = after(motion), by substitution from what there is without them.
  /// @return the last correction over the one before; below 0: found
  template <class After>
  static double find_motion(Motion& motion, const After& after);
  [[noreturn]] static void refuse_step(const SphereAt& s, double ratio);
  void note_fault(std::uint32_t sphere) noexcept;  ///< the exception at hand
  void throw_fault();

  // Work.
  Work& of_block(std::size_t block) { return blocks_[block]; }
  Work& of_clumps() { return clumps_; }
  double work() const;  ///< J, up to t_n, since the start
  void reset_work();

  void archive(Archive& a);        ///< forces must be there
  void archive_lists(Archive& a);  ///< work since the lists were built

 private:
  std::vector<NamedSphereForce> forces_;
  std::vector<Work> blocks_;
  Work clumps_;
  double before_ = 0;  ///< J, in lists that are gone
  std::exception_ptr fault_;
  std::uint32_t faulty_ = 0;
};

template <class After>
double SphereForces::find_motion(Motion& motion, const After& after) {
  const Motion without = motion;
  // Rounding of the sum that gives `now`, twice.
  const auto is_same = [](const Vec3& now, const Vec3& last, const Vec3& base) {
    return norm(now - last) <= 8 * std::numeric_limits<double>::epsilon() * (norm(base) + norm(now));
  };
  double correction = 0, ratio = 0;
  for (int k = 0; k < kMostSubstitutions; ++k) {
    const Motion now = after(motion);
    if (is_same(now.velocity, motion.velocity, without.velocity) &&
        is_same(now.angular_velocity, motion.angular_velocity, without.angular_velocity))
      return -1;
    const double last = correction;
    correction = norm(now.velocity - motion.velocity) + norm(now.angular_velocity - motion.angular_velocity);
    ratio = last > 0 ? correction / last : 0;
    motion = now;
  }
  return ratio;
}

}  // namespace subsoil::dem
