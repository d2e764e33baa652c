#pragma once

#include <algorithm>
#include <iterator>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "libmbd/base/polymorphic.hpp"
#include "libmbd/element/force.hpp"

namespace subsoil::mbd {

/// A force of a user, compiled in the user's own source: model.add("name", OwnForce(mine::Spring{...})). The struct is
/// one like those of the library (IsForce in element/force.hpp; forces/drag.hpp is short to copy): its bodies as `body`
/// or `body_a` and `body_b`, `has`, `columns`, evaluate(). Of the members that `has` may name it can have check,
/// initialise_from_pose, gap or gaps, and states, which scene.states then holds alone. No scenario names it.
/// Forces of the library are inlined; one of these costs a call through a pointer.
class OwnForce {
 public:
  // All that a force of a user may have; what its type lacks is empty.
  static constexpr ForceMembers has{.check = true, .initialise_from_pose = true, .gaps = true, .states = true};
  std::span<const ForceColumn> columns{};
  int body_a = ground, body_b = ground;
  std::size_t first_state = 0;

  template <class F>
  requires(!std::is_same_v<F, OwnForce> && IsForce<F>) explicit OwnForce(F force)
      : columns(F::columns), held_(std::make_unique<Held<F>>(std::move(force))) {
    static_assert(!F::has.prepare && !F::has.stick && !F::has.touch && !F::has.trace && !F::has.rut &&
                      !F::has.towing_spin && !F::has.joint && !F::has.profiles && !F::has.controlled,
                  "OwnForce takes check, initialise_from_pose, gap, gaps and states");
    static_assert(std::size(F::columns) <= max_force_columns, "a force has as many columns as ForceValues at most");
    const F& own = static_cast<const Held<F>&>(*held_).force;
    if constexpr (requires { own.body; }) {
      body_b = own.body;
    } else {
      body_a = own.body_a, body_b = own.body_b;
    }
  }

  void check() const { held_->check(); }
  void initialise_from_pose(const Scene& scene) { held_->initialise_from_pose(seen(scene)); }
  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    return held_->evaluate(seen(scene), loads, values);
  }
  std::size_t gap_count() const { return held_->gap_count(); }
  void gaps(const Scene& scene, std::span<double> out) const { held_->gaps(seen(scene), out); }
  double gap_speed(const Scene& scene) const { return held_->gap_speed(seen(scene)); }
  std::size_t state_count() const { return held_->state_scales().size(); }
  std::vector<double> start_states(const Scene& scene) const { return held_->start_states(seen(scene)); }
  std::vector<double> state_rates(const Scene& scene) const { return held_->state_rates(seen(scene)); }
  std::vector<double> state_scales() const { return held_->state_scales(); }

 private:
  struct Base {
    virtual ~Base() = default;
    virtual std::unique_ptr<Base> copy() const = 0;
    virtual void check() const = 0;
    virtual void initialise_from_pose(const Scene&) = 0;
    virtual ForcePower evaluate(const Scene&, Loads&, ForceValues&) const = 0;
    virtual std::size_t gap_count() const = 0;
    virtual void gaps(const Scene&, std::span<double>) const = 0;
    virtual double gap_speed(const Scene&) const = 0;
    virtual std::vector<double> start_states(const Scene&) const = 0;
    virtual std::vector<double> state_rates(const Scene&) const = 0;
    virtual std::vector<double> state_scales() const = 0;
  };
  template <class F>
  struct Held final : Base {
    F force;
    explicit Held(F f) : force(std::move(f)) {}
    std::unique_ptr<Base> copy() const override { return std::make_unique<Held>(force); }
    void check() const override {
      if constexpr (F::has.check) force.check();
    }
    void initialise_from_pose(const Scene& scene) override {
      if constexpr (F::has.initialise_from_pose) force.initialise_from_pose(scene);
    }
    ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const override {
      return force.evaluate(scene, loads, values);
    }
    std::size_t gap_count() const override {
      if constexpr (F::has.gaps) return force.gap_count();
      return F::has.gap ? 1 : 0;
    }
    void gaps(const Scene& scene, std::span<double> out) const override {
      if constexpr (F::has.gap) out[0] = force.gap(scene);
      if constexpr (F::has.gaps) force.gaps(scene, out);
    }
    double gap_speed(const Scene& scene) const override {
      if constexpr (F::has.gap || F::has.gaps) return force.gap_speed(scene);
      return 0;
    }
    std::vector<double> start_states(const Scene& scene) const override {
      if constexpr (F::has.states) return list(force.start_states(scene));
      return {};
    }
    std::vector<double> state_rates(const Scene& scene) const override {
      if constexpr (F::has.states) return list(force.state_rates(scene));
      return {};
    }
    std::vector<double> state_scales() const override {
      if constexpr (F::has.states) return list(force.state_scales());
      return {};
    }
    template <class List>
    static std::vector<double> list(const List& values) {
      return std::vector<double>(values.begin(), values.end());
    }
  };

  /// Of all states those of the force alone, which begin at its own first_state, 0.
  Scene seen(const Scene& scene) const {
    Scene own = scene;
    const std::size_t first = std::min(first_state, scene.states.size());
    own.states = scene.states.subspan(first);
    return own;
  }

  Polymorphic<Base> held_;
};

}  // namespace subsoil::mbd
