// Ranges, and what a visitor of declarations sees.

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "libsim/keys/range.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/scenario/shapes/shapes.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::sim::scenario_fields_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Read when the program is compiled; a literal that is no range does not compile.
static_assert(Range("(0, inf)").low() == 0 && Range("(0, inf)").high() == infinity);
static_assert(Range("(0, inf)").open_low() && !Range("[0, 0.999]").open_high());
static_assert(Range("[0, 0.999]").high() == 0.999 && Range("(-1, 0.5]").low() == -1);
static_assert(Range("(-inf, inf)").contains(-1e300) && !Range("(-inf, inf)").contains(infinity));
static_assert(!Range("(0, 1]").contains(0) && Range("(0, 1]").contains(1) && !Range("[0, 1)").contains(1));

TEST(Range, NotANumberIsInNone) {
  EXPECT_FALSE(Range("(-inf, inf)").contains(std::numeric_limits<double>::quiet_NaN()));
}

// A member that is misspelt or of another type is missed when the list is compiled, not ignored when it runs.
struct NoName {
  static constexpr bool bounded = true;
  void describe(Fields&);
  ShapeFault fault() const;
  dem::TriangleMesh meshh() const;
};
struct WrongType {
  static constexpr bool bounded = true;
  void describe(Fields&);
  bool fault() const;
  dem::TriangleMesh mesh() const;
};
static_assert(Triangulated<BoxShape> && !Analytic<BoxShape> && Analytic<PlaneShape> && !Triangulated<PlaneShape>);
static_assert(!Triangulated<NoName> && !Analytic<NoName> && !Triangulated<WrongType>);

struct TakesHalf {
  bool needs_yield() const;
  void take_yeld(double, double);
};
static_assert(MentionsYield<TakesHalf> && !TakesYield<TakesHalf>);
struct TakesDensityByHalf {
  bool needs_density() const;
  void take_densty(double);
};
static_assert(MentionsDensity<TakesDensityByHalf> && !TakesDensity<TakesDensityByHalf>);

TEST(Cure, FollowsTheRuleAndTheMeaning) {
  const std::string text =
      "subsoil: 1\ntime: {end: 1 s}\nmaterials: {a: {density: 1 kg/m^3}}\nboundaries:\n"
      "  - {name: p, material: a, shape: {plane: {}}}\n"
      "contacts:\n  - {between: [a, a], law: linear, k_n: 1 N/m, restitution: 1.5}\n";
  const std::string refused = test::message_of<ScenarioError>([&] { load_scenario_text(text, "a.yaml"); });
  EXPECT_NE(refused.find("restitution = 1.5: must be in (0, 1]; for no damping use 1"), std::string::npos) << refused;
  EXPECT_NE(explain("contacts.hertz-mindlin.restitution").find("coefficient of restitution; for no damping use 1"),
            std::string::npos);
  EXPECT_NE(
      explain("contacts.linear.restitution").find("coefficient of restitution; or give damping; for no damping use 1"),
      std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::scenario_fields_test
