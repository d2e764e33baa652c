#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "libsim/document/quantity.hpp"

// Oracles are the definitions of the units (SI brochure; international yard and pound), typed in by hand.
namespace subsoil::sim::scenario_units_test {
namespace {

std::string refusal(const std::string& text, const std::string& expected, std::optional<double> n = {}) {
  try {
    const double value = parse_quantity(text, expected, n);
    return "accepted as " + std::to_string(value);
  } catch (const UnitError& e) {
    return e.what();
  }
}

TEST(ScenarioUnits, DecimalFractionsAreExact) {
  EXPECT_EQ(parse_quantity("16 kN/m", "N/m"), 16000.0);
  EXPECT_EQ(parse_quantity("20 mm", "m"), 0.020);
  EXPECT_EQ(parse_quantity("18 mm", "m"), 0.018);  // 18 * 0.001 would be off by the last bit
  EXPECT_EQ(parse_quantity("15 us", "s"), 15e-6);
  EXPECT_EQ(parse_quantity("15 µs", "s"), 15e-6);
  EXPECT_EQ(parse_quantity("9.81 m/s^2", "m/s^2"), 9.81);
  EXPECT_EQ(parse_quantity("1 mm3", "m^3"), 1e-9);
  EXPECT_EQ(parse_quantity("1.8 g/cm^3", "kg/m^3"), 1800.0);
}

TEST(ScenarioUnits, ANumberBelowTheSmallestDoubleIsZero) {
  EXPECT_EQ(parse_quantity("1e-400 m", "m"), 0);
  EXPECT_EQ(parse_quantity("-1e-400 m", "m"), 0);
  EXPECT_EQ(parse_quantity("1e-43 m", "m"), 1e-43);
  EXPECT_NE(refusal("1e400 m", "m").find("too large"), std::string::npos);
}

TEST(ScenarioUnits, NamesOfUdunits) {
  EXPECT_DOUBLE_EQ(parse_quantity("1 lbf", "N"), 4.4482216152605);
  EXPECT_DOUBLE_EQ(parse_quantity("36 km/h", "m/s"), 10);
  EXPECT_DOUBLE_EQ(parse_quantity("2 in", "m"), 0.0508);
  EXPECT_DOUBLE_EQ(parse_quantity("1 h", "s"), 3600);
  EXPECT_DOUBLE_EQ(parse_quantity("3 GPa", "Pa"), 3e9);
}

TEST(ScenarioUnits, ProductsQuotientsAndWholePowers) {
  for (const char* text : {"611 N s/m", "611 N*s/m", "611 N.s/m", "611 N·s/m", "611 N s m-1", "611 N s m^-1",
                           "611 (N s)/m", "611 kg/s", "611 kg s**-1", "611kg/s"}) {
    EXPECT_DOUBLE_EQ(parse_quantity(text, "N s/m"), 611) << text;
  }
  EXPECT_DOUBLE_EQ(parse_quantity("2 m/(s s)", "m/s^2"), 2);
  EXPECT_DOUBLE_EQ(parse_quantity("2 m²", "m^2"), 2);
  EXPECT_DOUBLE_EQ(parse_quantity("1.8 g cm⁻³", "kg/m^3"), 1800);
  EXPECT_DOUBLE_EQ(parse_quantity("5 s⁻¹", "1/s"), 5);
  EXPECT_DOUBLE_EQ(parse_quantity("2 m⁺²", "m^2"), 2);
  EXPECT_NE(refusal("2 m⁻", "1/m").find("has a power that is no number"), std::string::npos);
  EXPECT_DOUBLE_EQ(parse_quantity("5 1/s", "1/s"), 5);
  EXPECT_DOUBLE_EQ(parse_quantity("5 /s", "1/s"), 5);
}

TEST(ScenarioUnits, DecimalPowersThatUdunitsMisreads) {
  EXPECT_DOUBLE_EQ(parse_quantity("1.7e10 N/m^1.5", "N/m^1.5"), 1.7e10);
  EXPECT_DOUBLE_EQ(parse_quantity("1.7 kN/mm^1.5", "N/m^1.5"), 1.7e3 * std::pow(1000, 1.5));
  EXPECT_DOUBLE_EQ(parse_quantity("2 N/m^(3/2)", "N/m^1.5"), 2);
  EXPECT_EQ(refusal("2 N/m^1.5", "N/m"),
            "`N/m^1.5` is kg m^-0.5 s^-2, but needed is a stiffness (kg s^-2), such as N/m");
  EXPECT_EQ(refusal("2 N/m1.5", "N/m^1.5"),
            "the unit `N/m1.5` has a decimal power without `^`; write m^1.5, or m^2 s for a product");
}

TEST(ScenarioUnits, SymbolicPowersTakeTheLawsN) {
  EXPECT_DOUBLE_EQ(parse_quantity("1434.81 kN/m^(n+1)", "N/m^(n+1)", 1.3126), 1434810);
  EXPECT_DOUBLE_EQ(parse_quantity("2 kN/mm^(n+2)", "N/m^(n+2)", 0.5), 2000 * std::pow(1000, 2.5));
  EXPECT_DOUBLE_EQ(parse_quantity("3 N/m^2.3126", "N/m^(n+1)", 1.3126), 3);
  EXPECT_DOUBLE_EQ(parse_quantity("3 Pa", "N/m^(n+1)", 1.0), 3);  // at n = 1 it is a pressure
  EXPECT_NE(refusal("3 Pa", "N/m^(n+1)", 1.3126).find("needed is"), std::string::npos);
  EXPECT_EQ(refusal("3 N/m^(n+1)", "N/m^2"),
            "the unit `N/m^(n+1)` has the power n, but nothing here has a parameter n");
  EXPECT_NE(refusal("3 N/m^(n+2)", "N/m^(n+1)", 1.3126).find("needed is"), std::string::npos);
}

TEST(ScenarioUnits, NumbersComeFirstThenOneUnit) {
  EXPECT_EQ(parse_quantities("1 2 3 mm", "m", 3), (std::vector<double>{0.001, 0.002, 0.003}));
  EXPECT_EQ(parse_quantities("0 -9.81 0 m/s^2", "m/s^2", 3), (std::vector<double>{0, -9.81, 0}));
  EXPECT_EQ(parse_quantities("1 0", "1", 2), (std::vector<double>{1, 0}));
  EXPECT_EQ(refusal("1 2 3 mm", "m"), "holds 3 numbers; needed is one");
  EXPECT_THROW(parse_quantities("1 2 mm", "m", 3), UnitError);
  EXPECT_EQ(refusal("mm", "m"), "a number must come first, then its unit");
  const std::string cure = "numbers come first, then one unit, and arithmetic stands in brackets: (1/4) m";
  EXPECT_EQ(refusal("1/2 m", "m"), "the unit `/2 m` holds a number; " + cure);
  EXPECT_EQ(refusal("1 mm 2 mm", "m"), "the unit `mm 2 mm` holds a number; " + cure);
}

TEST(ScenarioUnits, MissingUnit) {
  EXPECT_EQ(refusal("16", "N/m"), "has no unit; needed is a stiffness (kg s^-2), such as N/m");
  EXPECT_EQ(refusal("0", "m"), "has no unit; needed is a length (m), such as m");
}

TEST(ScenarioUnits, WrongDimensionNamesBoth) {
  EXPECT_EQ(refusal("16 kN", "N/m"), "`kN` is a force (kg m s^-2), but needed is a stiffness (kg s^-2), such as N/m");
  EXPECT_EQ(refusal("2 parsnip", "m"), "unknown unit `parsnip`");
}

TEST(ScenarioUnits, DimensionlessValues) {
  EXPECT_EQ(parse_quantity("0.3", "1"), 0.3);
  EXPECT_DOUBLE_EQ(parse_quantity("30 percent", "1"), 0.3);
  EXPECT_DOUBLE_EQ(parse_quantity("30 %", "1"), 0.3);
  EXPECT_DOUBLE_EQ(parse_quantity("3 mm/m", "1"), 0.003);
  EXPECT_EQ(refusal("0.3 m", "1"), "`m` is a length (m), but this value is a plain number; leave the unit away");
  EXPECT_EQ(refusal("8 deg", "1"), "`deg` is an angle (rad), but this value is a plain number; leave the unit away");
}

TEST(ScenarioUnits, Angles) {
  EXPECT_DOUBLE_EQ(parse_quantity("180 deg", "rad"), std::numbers::pi);
  EXPECT_DOUBLE_EQ(parse_quantity("0.1 rad", "rad"), 0.1);
  EXPECT_DOUBLE_EQ(parse_quantity("60 rpm", "rad/s"), 2 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(parse_quantity("90 deg/s", "rad/s"), std::numbers::pi / 2);
  EXPECT_EQ(refusal("8", "rad"), "has no unit; needed is an angle, such as deg or rad");
  EXPECT_EQ(refusal("8 percent", "rad"), "`percent` is a plain number (1), but needed is an angle, such as deg or rad");
  // Hz could mean turns or radians per second: refused rather than guessed.
  EXPECT_NE(refusal("5 Hz", "rad/s").find("needed is an angular speed"), std::string::npos);
  EXPECT_NE(refusal("5 rad/s", "Hz").find("needed is a rate"), std::string::npos);
  EXPECT_DOUBLE_EQ(parse_quantity("2 N m/deg", "N m/rad"), 360 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(parse_quantity("2 N m", "N m/rad"), 2);  // usual for torsion springs
}

TEST(ScenarioUnits, NumbersThatAreRefused) {
  for (const char* text : {"nan m", "NaN m", "inf m", "-inf m", "Infinity m", "+.inf m"}) {
    EXPECT_EQ(refusal(text, "m"), "must be a finite number") << text;
  }
  EXPECT_EQ(refusal("0x10 m", "m"), "hexadecimal numbers are not read; write a decimal number");
  EXPECT_EQ(refusal("1e999 m", "m"), "a number is too large for double precision");
  EXPECT_EQ(refusal("1,5 m", "m"), "a comma stands in a number; write 1.5, and blanks between numbers");
  for (const char* text : {"1.2.3 m", "3-2 m", "1e2-3 m", "5.10.20 m"})
    EXPECT_EQ(refusal(text, "m"), "two numbers stand without a blank between them") << text;
  EXPECT_EQ(refusal("1e308 km", "m"), "a number is too large for double precision in SI units");
}

// ' is the sign of arc minutes, and 000 would be their power.
TEST(ScenarioUnits, ThousandsSeparatorsAreNoUnits) {
  EXPECT_EQ(
      refusal("1'000 kg", "kg"),
      "the unit `'000 kg` has the power 0 behind ', the sign of arc minutes; numbers have no thousands separators: "
      "1000 kg");
  EXPECT_THROW(parse_quantity("10'000'000 kg", "kg"), UnitError);
  EXPECT_NE(refusal("1'500 kg", "kg"), "");
  EXPECT_EQ(refusal("5 m0 kg", "kg"),
            "the unit `m0 kg` has the power 0, by which a unit vanishes; leave that unit out");
  EXPECT_DOUBLE_EQ(parse_quantity("3 N/m^(n-1)", "N/m^(n-1)", 1.0), 3);
}

TEST(ScenarioUnits, UnitsWithoutSize) {
  EXPECT_EQ(refusal("20 degC", "K"), "the unit `degC` has an offset; give a difference in K");
  EXPECT_NE(refusal("3 m)", "m").find("too many"), std::string::npos);
  EXPECT_NE(refusal("3 (m", "m").find("lacks"), std::string::npos);
  EXPECT_NE(refusal("3 m/", "m").find("ends where"), std::string::npos);
}

TEST(ScenarioUnits, WrittenValuesReadBackExactly) {
  for (const double value : {0.1, 1.0 / 3, 1434810.0, 6.02e23, 1e-300, 0.326396, 0.020000000000000004}) {
    for (const char* unit : {"m", "mm", "kN/m", "rad", "deg", "kN/m^(n+1)", "1"}) {
      const std::string text = format_quantity(value, unit, 1.3126);
      EXPECT_EQ(parse_quantity(text, unit, 1.3126), value) << text;
    }
  }
}

}  // namespace
}  // namespace subsoil::sim::scenario_units_test
