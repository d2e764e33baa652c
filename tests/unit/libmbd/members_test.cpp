// What an element says it has is what it has: a misspelt or unstated member keeps it out of the list of its family when
// it is compiled, so that the system never passes over a member in silence.

#include <gtest/gtest.h>

#include "libmbd/element/constraint.hpp"
#include "libmbd/element/force.hpp"
#include "libmbd/system/measure.hpp"

namespace subsoil::mbd::members_test {
namespace {

struct Pin {
  static constexpr ConstraintMembers has{.points = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{}, p_b{};
  void evaluate(const BodyState&, const BodyState&, double, ConstraintRows<1>&) const {}
};
struct MisspeltCheck : Pin {
  static constexpr ConstraintMembers has{.check = true, .points = true};
  void chek() const {}
};
struct UnstatedCheck : Pin {
  void check() const {}
};
struct MisspeltStart : Pin {
  static constexpr ConstraintMembers has{.initialise_from_pose = true, .points = true};
  void initialize_from_pose(const BodyState&, const BodyState&, double) {}
};
struct MissingThirdBody : Pin {
  static constexpr ConstraintMembers has{.points = true, .third_body = true};
};
struct SaysNothing {
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = -1, body_b = -1;
  void evaluate(const BodyState&, const BodyState&, double, ConstraintRows<1>&) const {}
};
static_assert(IsJoint<Pin>);
static_assert(!IsJoint<MisspeltCheck>);
static_assert(!IsJoint<UnstatedCheck>);
static_assert(!IsJoint<MisspeltStart>);
static_assert(!IsJoint<MissingThirdBody>);
static_assert(!IsJoint<SaysNothing>);
static_assert(!IsDriver<Pin> && !IsForce<Pin> && !IsMeasure<Pin>);

struct Push {
  static constexpr ForceMembers has{};
  static constexpr std::array<ForceColumn, 1> columns{{{"force", "N"}}};
  ForcePower evaluate(const Scene&, Loads&, ForceValues&) const { return {}; }
};
struct MisspeltGap : Push {
  static constexpr ForceMembers has{.gap = true};
  double gap_(const Scene&) const { return 1; }
  double gap_speed(const Scene&) const { return 1; }
};
struct UnstatedGap : Push {
  double gap(const Scene&) const { return 1; }
  double gap_speed(const Scene&) const { return 1; }
};
struct GapWithoutSpeed : Push {
  static constexpr ForceMembers has{.gap = true};
  double gap(const Scene&) const { return 1; }
};
struct HalfATrace : Push {
  static constexpr ForceMembers has{.trace = true};
  void begin_trace(const Scene&) {}
  std::array<double, 1> memory() const { return {}; }
};
static_assert(IsForce<Push>);
static_assert(!IsForce<MisspeltGap>);
static_assert(!IsForce<GapWithoutSpeed>);
static_assert(!IsForce<UnstatedGap>);
static_assert(!IsForce<HalfATrace>);

// The box gives back what it was given, and nothing of another type.
TEST(AnyElement, HoldsOneElement) {
  Pin pin;
  pin.p_a = {3, 4};
  const AnyJoint any = pin, copy = any;
  ASSERT_NE(copy.get_if<Pin>(), nullptr);
  EXPECT_NE(copy.get_if<Pin>(), any.get_if<Pin>()) << "a copy is its own";
  EXPECT_EQ(copy.get<Pin>().p_a, pin.p_a);
  EXPECT_EQ(any.get_if<MissingThirdBody>(), nullptr);
  EXPECT_EQ(AnyJoint().get_if<Pin>(), nullptr);
}

}  // namespace
}  // namespace subsoil::mbd::members_test
