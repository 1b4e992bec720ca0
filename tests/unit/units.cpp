#include "common/units/units.h"

#include <gtest/gtest.h>
#include <stdexcept>

using namespace heartbus::config;

namespace {
std::string complaint(const std::string &text, const std::string &unit) {
  try {
    parse_quantity(text, unit);
  } catch (const std::invalid_argument &error) {
    return error.what();
  }
  return "";
}
} // namespace

TEST(Units, QuantitiesOfAHeartConvertToSi) {
  EXPECT_EQ(parse_quantity("0.2 ms", "s"), 0.0002);
  EXPECT_EQ(parse_quantity("5000 kg/(m^2 s)", "kg/(m^2 s)"), 5000);
  EXPECT_EQ(parse_quantity("1.3e7 kg/(s m^4)", "kg/(m^4 s)"), 1.3e7);
  EXPECT_DOUBLE_EQ(parse_quantity("10 mmHg", "Pa"), 1333.22387415);
  EXPECT_DOUBLE_EQ(parse_quantity("60 deg", "rad"), 1.0471975511965976);
  EXPECT_EQ(parse_quantity("7.7e-5 m^2/s", "m^2/s"), 7.7e-5);
  EXPECT_EQ(parse_quantity("0.88 kPa", "Pa"), 880);
  EXPECT_EQ(parse_quantity("20 kPa s/m", "Pa s/m"), 20000);
  EXPECT_EQ(parse_quantity("1.06 g/cm^3", "kg/m^3"), 1060);
  EXPECT_DOUBLE_EQ(parse_quantity("120 mL", "m^3"), 1.2e-4);
  EXPECT_EQ(parse_quantity("3.5 mPa s", "Pa s"), 0.0035);
  EXPECT_EQ(parse_quantity("1 Pa", "kg/(m s^2)"), 1);
  EXPECT_EQ(parse_quantity("-11mm", "m"), -0.011);
  EXPECT_EQ(parse_quantity("0.5", "1"), 0.5);
  EXPECT_EQ(with_unit(0.5, "1"), "0.5");
  EXPECT_EQ(with_unit(0.5, "mV"), "0.5 mV");
}

TEST(Units, TheCodeMayComputeInUnitsOtherThanSi) {
  EXPECT_EQ(parse_quantity("0.0357 V/ms", "mV/ms"), 35.7);
  EXPECT_EQ(parse_quantity("1.2 uM", "uM"), 1.2);
  EXPECT_EQ(parse_quantity("0.0012 mM", "uM"), 1.2);
  EXPECT_EQ(parse_quantity("1.2 \xC2\xB5M", "uM"), 1.2);
  EXPECT_EQ(parse_quantity("-85.23 mV", "mV"), -85.23);
  EXPECT_EQ(parse_quantity("52 pA/pF", "V/s"), 52);
}

TEST(Units, AWrongDimensionIsNamed) {
  EXPECT_EQ(complaint("0.2 ms", "Pa"), "expected a pressure-like unit, e.g. Pa; got ms");
  EXPECT_EQ(complaint("5 Pa", "kg/(m^2 s)"), "expected a unit, e.g. kg/(m^2 s); got Pa");
  EXPECT_NE(complaint("5 V", "kg m^2/(s^3 A)"), "");
}

TEST(Units, AMissingUnitIsAsked) {
  EXPECT_EQ(complaint("5000", "kg/(m^2 s)"), "'5000' has no unit; write e.g. '5000 kg/(m^2 s)'");
}

TEST(Units, AnUnknownUnitGetsTheNearest) {
  EXPECT_EQ(complaint("10 mmhg", "Pa"), "unit 'mmhg' is unknown; did you mean 'mmHg'?");
  EXPECT_NE(complaint("10 kg/(m s", "Pa").find("lacks a ')'"), std::string::npos);
  EXPECT_NE(complaint("ten Pa", "Pa").find("not a number"), std::string::npos);
  EXPECT_NE(complaint("nan Pa", "Pa").find("not a number"), std::string::npos);
}

TEST(Units, ShortestTextReadsBackToTheSameBits) {
  for (const double value : {0.1, 2e-4, 1.0 / 3, 1e300, -7.7e-5, 0.0})
    EXPECT_EQ(parse_number(shortest(value)), value);
}
