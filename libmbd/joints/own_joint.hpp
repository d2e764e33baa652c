#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

#include "libmbd/base/polymorphic.hpp"
#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// A joint of a user, compiled in the user's own source: model.add("name", OwnJoint(mine::Joint{...})). The struct is
/// one like those of the library (IsJoint in element/constraint.hpp; joints/distance.hpp is short to copy): `body_a`
/// and `body_b`, `rows` (1 to 3), `angular`, `has`, evaluate(). Of the members that `has` may name it can have check,
/// initialise_from_pose, points, reaction_point and characteristic_length. Its reaction is reported at its
/// reaction_point, else at p_b, else at the centre of gravity of body b. No scenario names it.
template <std::size_t n>
class OwnJoint {
 public:
  static constexpr ConstraintMembers has{.check = true,
                                         .initialise_from_pose = true,
                                         .points = true,
                                         .reaction_point = true,
                                         .characteristic_length = true};
  static constexpr std::size_t rows = n;
  std::array<bool, n> angular{};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};

  template <class J>
  requires(!std::is_same_v<J, OwnJoint> && IsJoint<J> && J::rows == n) explicit OwnJoint(J joint)
      : angular(J::angular),
        body_a(joint.body_a),
        body_b(joint.body_b),
        held_(std::make_unique<Held<J>>(std::move(joint))) {
    static_assert(!J::has.third_body, "OwnJoint takes joints of two bodies");
    held_->points(p_a, p_b);
  }

  void check() const { held_->check(); }
  void initialise_from_pose(const BodyState& a, const BodyState& b, double t) {
    held_->initialise_from_pose(a, b, t);
    held_->points(p_a, p_b);
  }
  void evaluate(const BodyState& a, const BodyState& b, double t, ConstraintRows<n>& out) const {
    held_->evaluate(a, b, t, out);
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const { return held_->reaction_point(a, b, p_b); }
  double characteristic_length() const { return held_->characteristic_length(); }

 private:
  struct Base {
    virtual ~Base() = default;
    virtual std::unique_ptr<Base> copy() const = 0;
    virtual void points(std::array<double, 2>& p_a, std::array<double, 2>& p_b) const = 0;
    virtual void check() const = 0;
    virtual void initialise_from_pose(const BodyState&, const BodyState&, double) = 0;
    virtual void evaluate(const BodyState&, const BodyState&, double, ConstraintRows<n>&) const = 0;
    virtual Vec2 reaction_point(const BodyState&, const BodyState&, const std::array<double, 2>& p_b) const = 0;
    virtual double characteristic_length() const = 0;
  };
  template <class J>
  struct Held final : Base {
    J joint;
    explicit Held(J j) : joint(std::move(j)) {}
    std::unique_ptr<Base> copy() const override { return std::make_unique<Held>(joint); }
    void points([[maybe_unused]] std::array<double, 2>& p_a,
                [[maybe_unused]] std::array<double, 2>& p_b) const override {
      if constexpr (J::has.points) p_a = joint.p_a, p_b = joint.p_b;
    }
    void check() const override {
      if constexpr (J::has.check) joint.check();
    }
    void initialise_from_pose(const BodyState& a, const BodyState& b, double t) override {
      if constexpr (J::has.initialise_from_pose) joint.initialise_from_pose(a, b, t);
    }
    void evaluate(const BodyState& a, const BodyState& b, double t, ConstraintRows<n>& out) const override {
      joint.evaluate(a, b, t, out);
    }
    Vec2 reaction_point(const BodyState& a, const BodyState& b, const std::array<double, 2>& p_b) const override {
      if constexpr (J::has.reaction_point) return joint.reaction_point(a, b);
      return b.point_in_world(p_b);
    }
    double characteristic_length() const override {
      if constexpr (J::has.characteristic_length) return joint.characteristic_length();
      return 0;
    }
  };

  Polymorphic<Base> held_;
};

template <class J>
OwnJoint(J) -> OwnJoint<J::rows>;

}  // namespace subsoil::mbd
