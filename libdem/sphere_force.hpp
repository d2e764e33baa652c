#pragma once
#include <concepts>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <utility>

#include "libdem/base/archive.hpp"
#include "libdem/base/vec3.hpp"
#include "libdem/geometry/boundary.hpp"

/// Forces of a user on the spheres of a bed: fields, drag in a fluid, charges. Any copyable object with
///
///     Wrench operator()(const SphereAt& s) const     force, N, and torque about the centre, N m, at t_n
///
/// is one: `bed.add_force("drag", Drag{...})`, or a lambda. Optional members:
///
///     void begin_step(double time)     once before each step, on one thread: what changes with time alone
///     void archive(Archive& a)         names the fields of its state, for both directions; without it there is none
///
/// The operator is called from several threads at once and several times in a step. It gives the same for the same
/// arguments until the next `begin_step`, and is continuous in the velocities.
///
/// It acts on free spheres and on members of clumps, at the member's centre; fixed spheres move as they do whatever
/// acts on them, so for them it is not called. With F the sum of the contacts, the velocity that it gets is that at
/// t_n, which its own force f helps to make,
///     v_n = v_{n-1/2} + (dt/2) (F_n + m g + f(x_n, v_n, w_n))/m
/// solved by substitution, likewise the angular velocity: second order in the step, no work by f = q v x B, and no
/// limit of stability by drag. Of the velocity v_{n-1/2} in its place a magnetic field makes energy in every step.
///
/// Substitution halves its error, or better, each time while (dt/2) |df/dv| < m/2; a step that is too long for this
/// throws BedFault. Its stiffness is not part of the stable step that libdem/step/stability.hpp gives: with k = |df/dx|
/// the step stays below 2 sqrt(m/k).
namespace subsoil::dem {

/// A sphere at t_n.
struct SphereAt {
  double time = 0;                  ///< s
  Vec3 position;                    ///< of the centre, m; in the periodic cell, where there is one
  Vec3 velocity, angular_velocity;  ///< m/s, rad/s; of a member those that its clump gives it
  double mass = 0;                  ///< kg; of a member its share in the clump, by volume
  double radius = 0;                ///< m
  std::uint32_t id = 0;             ///< the user's number
  int material = 0;
};

template <class F>
concept IsSphereForce = std::copy_constructible<F> && requires(const F& force, const SphereAt& s) {
  { force(s) } -> std::convertible_to<Wrench>;
};

/// Holds a force of any such type, as a value: a checkpoint has a copy.
class SphereForce {
 public:
  template <class F>
  requires(!std::same_as<F, SphereForce>) && IsSphereForce<F> SphereForce(F force)
      : held_(std::make_unique<HeldForce<F>>(std::move(force))) {}  // NOLINT: a force is one
  SphereForce(const SphereForce& other) : held_(other.held_->copy()) {}
  SphereForce(SphereForce&&) noexcept = default;
  SphereForce& operator=(SphereForce other) noexcept { return std::swap(held_, other.held_), *this; }

  Wrench operator()(const SphereAt& s) const { return held_->act(s); }
  void begin_step(double time) { held_->begin_step(time); }
  void archive(Archive& a) { held_->archive(a); }
  /// The object, to be read or changed between two steps, until the bed is restored. Throws std::invalid_argument where
  /// it is of another type.
  template <class F>
  F& as() {
    auto* const held = dynamic_cast<HeldForce<F>*>(held_.get());
    if (held == nullptr) throw std::invalid_argument(std::string("the force on spheres is no ") + typeid(F).name());
    return held->force;
  }

 private:
  struct Held {
    virtual ~Held() = default;
    virtual std::unique_ptr<Held> copy() const = 0;
    virtual Wrench act(const SphereAt& s) const = 0;
    virtual void begin_step(double time) = 0;
    virtual void archive(Archive& a) = 0;
  };
  template <class F>
  struct HeldForce final : Held {
    explicit HeldForce(F given) : force(std::move(given)) {}
    std::unique_ptr<Held> copy() const override { return std::make_unique<HeldForce>(force); }
    Wrench act(const SphereAt& s) const override { return force(s); }
    void begin_step([[maybe_unused]] double time) override {
      if constexpr (requires { force.begin_step(time); }) force.begin_step(time);
    }
    void archive([[maybe_unused]] Archive& a) override {
      if constexpr (requires { force.archive(a); }) force.archive(a);
    }
    F force;
  };
  std::unique_ptr<Held> held_;
};

struct NamedSphereForce {
  std::string name;
  SphereForce force;
};

}  // namespace subsoil::dem
