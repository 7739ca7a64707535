#include "scene/unit_names.hpp"

#include <gtest/gtest.h>

namespace viscobar {
namespace {

TEST(UnitNames, AreMadeOfWhatTheSceneNames) {
  const Units si{"m", "s", "kg", "", ""};
  EXPECT_EQ(unit_name(si, Dimension::length), "m");
  EXPECT_EQ(unit_name(si, Dimension::velocity), "m/s");
  EXPECT_EQ(unit_name(si, Dimension::stress), "kg/(m s^2)");
  EXPECT_EQ(unit_name(si, Dimension::impulse), "kg/(m s)");
  EXPECT_EQ(unit_name(si, Dimension::energy), "kg/s^2");
}

TEST(UnitNames, PreferTheNameOfTheStressThenThatOfTheForce) {
  EXPECT_EQ(unit_name({"m", "s", "kg", "N", "Pa"}, Dimension::stress), "Pa");
  EXPECT_EQ(unit_name({"m", "s", "kg", "N", "Pa"}, Dimension::energy), "Pa m");
  EXPECT_EQ(unit_name({"mm", "ms", "t", "N", ""}, Dimension::stress), "N/mm^2");
  EXPECT_EQ(unit_name({"mm", "ms", "t", "N", ""}, Dimension::energy), "N/mm");
  EXPECT_EQ(unit_name({"mm", "ms", "t", "N", ""}, Dimension::impulse), "N ms/mm^2");
}

TEST(UnitNames, AreEmptyWhereTheSceneNamesTooFew) {
  EXPECT_EQ(unit_name({}, Dimension::length), "");
  EXPECT_EQ(unit_name({"m", "", "", "", ""}, Dimension::velocity), "");
  EXPECT_EQ(unit_name({"m", "s", "", "", ""}, Dimension::stress), "");
  EXPECT_EQ(with_unit("time t", {}, Dimension::time), "time t");
  EXPECT_EQ(with_unit("stress s", {"m", "", "", "N", ""}, Dimension::stress), "stress s [N/m²]");
}

TEST(UnitNames, OfWordsAndQuotientsFollowFromTheirPowers) {
  const Units si{"m", "s", "kg", "", ""};
  const auto name = [&](const char* words) { return unit_name(si, unit_powers(words).value()); };
  EXPECT_EQ(name("density"), "kg/m^3");
  EXPECT_EQ(name("stress x time"), "kg/(m s)");
  EXPECT_EQ(name("stress x time / length"), "kg/(m^2 s)");
  EXPECT_EQ(name("length / stress"), "m^2 s^2/kg");
  EXPECT_EQ(name("1"), "");
  EXPECT_EQ(unit_name({"m", "s", "", "", "Pa"}, UnitPowers{3, -2, -1}), "m^3/(Pa s^2)") << "of u by the density";
  EXPECT_FALSE(unit_powers(""));
  EXPECT_FALSE(unit_powers("furlongs"));
}

}  // namespace
}  // namespace viscobar
