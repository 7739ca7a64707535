#include "viscobar/discretisation/mesh.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace viscobar {
namespace {

TEST(Mesh, HasOneNodeMoreThanElements) { EXPECT_EQ((Mesh{26.0, 702}).nodes(), 703u); }

TEST(Mesh, LastNodeIsExactlyTheLength) {
  for (std::size_t elements = 1; elements < 200; ++elements)
    EXPECT_EQ((Mesh{0.1, elements}).node(elements), 0.1) << elements;
}

TEST(Mesh, NodesAreASpacingApart) {
  const Mesh mesh{26.0, 702};
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * mesh.length;
  for (std::size_t j = 0; j < mesh.elements; ++j)
    EXPECT_NEAR(mesh.node(j + 1) - mesh.node(j), mesh.spacing(), rounding);
}

}  // namespace
}  // namespace viscobar
