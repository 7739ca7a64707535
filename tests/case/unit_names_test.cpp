#include "scene/unit_names.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

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

TEST(UnitNames, TakeTheMassWhereThatIsShorter) {
  const auto name = [](Units units, const char* words, bool of_section = false) {
    units.of_section = of_section;
    return unit_name(units, unit_powers(words).value());
  };
  const Units si{"m", "s", "kg", "N", "Pa"};
  EXPECT_EQ(name(si, "density"), "kg/m^3");
  EXPECT_EQ(name(si, "density x length x area"), "kg/m^2");
  EXPECT_EQ(name(si, "density x length x area", true), "kg");
  EXPECT_EQ(name(si, "stress x time"), "Pa s");
  EXPECT_EQ(name(si, "force x time", true), "N s");
  EXPECT_EQ(name({"mm", "ms", "t", "N", ""}, "density"), "t/mm^3");
  EXPECT_EQ(name({"m", "s", "", "", "Pa"}, "density"), "Pa s^2/m^2") << "without a mass";
}

TEST(UnitNames, OfForcesAreThoseOfTheWholeSectionWhereThereIsOne) {
  const auto names = [](Units units) {
    units.of_section = true;
    std::vector<std::string> all;
    for (const Dimension quantity : {Dimension::stress, Dimension::force, Dimension::impulse, Dimension::energy})
      all.push_back(unit_name(units, quantity));
    for (const char* words : {"force / length", "density x length x area", "area", "stress / length"})
      all.push_back(unit_name(units, unit_powers(words).value()));
    return all;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names({"m", "s", "", "N", "Pa"}), Names({"Pa", "N", "N s", "N m", "N/m", "N s^2/m", "m^2", "Pa/m"}));
  EXPECT_EQ(names({"mm", "ms", "", "", "MPa"}),
            Names({"MPa", "MPa mm^2", "MPa mm^2 ms", "MPa mm^3", "MPa mm", "MPa mm ms^2", "mm^2", "MPa/mm"}));
  EXPECT_EQ(names({"m", "s", "kg", "", ""}),
            Names({"kg/(m s^2)", "kg m/s^2", "kg m/s", "kg m^2/s^2", "kg/s^2", "kg", "m^2", "kg/(m^2 s^2)"}));
  EXPECT_EQ(unit_name({"m", "s", "", "N", "Pa"}, Dimension::force), "Pa") << "per area";
}

TEST(UnitNames, AreEmptyWhereTheSceneNamesTooFew) {
  EXPECT_EQ(unit_name({}, Dimension::length), "");
  EXPECT_EQ(unit_name({"m", "", "", "", ""}, Dimension::velocity), "");
  EXPECT_EQ(unit_name({"m", "s", "", "", ""}, Dimension::stress), "");
  EXPECT_EQ(with_unit("time t", unit_name({}, Dimension::time)), "time t");
  EXPECT_EQ(with_unit("stress s", squares(unit_name({"m", "", "", "N", ""}, Dimension::stress))), "stress s [N/m²]");
}

TEST(UnitNames, OfWordsAndQuotientsFollowFromTheirPowers) {
  const Units si{"m", "s", "kg", "", ""};
  const auto name = [&](const char* words) { return unit_name(si, unit_powers(words).value()); };
  EXPECT_EQ(name("density"), "kg/m^3");
  EXPECT_EQ(name("stress x time"), "kg/(m s)");
  EXPECT_EQ(name("stress x time / length"), "kg/(m^2 s)");
  EXPECT_EQ(name("length / stress"), "m^2 s^2/kg");
  EXPECT_EQ(name("1"), "");
  EXPECT_EQ(unit_name({"m", "s", "", "", "Pa"}, UnitPowers{3, -2, -1, 0}), "m^3/(Pa s^2)") << "of u by the density";
  EXPECT_FALSE(unit_powers(""));
  EXPECT_FALSE(unit_powers("furlongs"));
}

}  // namespace
}  // namespace viscobar
