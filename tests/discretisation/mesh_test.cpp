#include "viscobar/discretisation/mesh.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <ostream>
#include <tuple>
#include <utility>

namespace viscobar {

// GoogleTest would print the bytes, of which those between the members are nobody's.
static void PrintTo(const Grading& grading, std::ostream* out) {
  *out << grading.ratio << (grading.left ? " left" : "") << (grading.right ? " right" : "");
}

}  // namespace viscobar

namespace viscobar::testing_mesh {
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

constexpr double eps = std::numeric_limits<double>::epsilon();

class GradedMesh : public testing::TestWithParam<std::tuple<std::size_t, Grading>> {
 protected:
  Mesh mesh_{3.0, std::get<0>(GetParam()), std::get<1>(GetParam())};
};

TEST_P(GradedMesh, ElementsLieBetweenTheirNodesAndFillTheBar) {
  double sum = 0.0;
  for (std::size_t j = 0; j < mesh_.elements; ++j) {
    EXPECT_NEAR(mesh_.node(j + 1) - mesh_.node(j), mesh_.element(j), 4 * eps * mesh_.length) << j;
    EXPECT_GE(mesh_.element(j), mesh_.smallest() * (1 - 4 * eps)) << j;
    sum += mesh_.element(j);
  }
  EXPECT_EQ(mesh_.node(0), 0.0);
  EXPECT_EQ(mesh_.node(mesh_.elements), mesh_.length);
  EXPECT_NEAR(sum, mesh_.length, static_cast<double>(mesh_.elements) * eps * mesh_.length);
}

TEST_P(GradedMesh, GrowsByTheSameAmountFromElementToElement) {
  const bool both = mesh_.grading.left && mesh_.grading.right;
  const std::size_t graded = both ? mesh_.elements / 2 : mesh_.elements;
  const auto from_end = [&](std::size_t j) { return mesh_.element(mesh_.grading.left ? j : mesh_.elements - 1 - j); };
  for (std::size_t j = 0; j + 2 < graded; ++j)
    EXPECT_NEAR(from_end(j + 2) - from_end(j + 1), from_end(j + 1) - from_end(j), 4 * eps * mesh_.length) << j;
}

TEST_P(GradedMesh, IsTheMirrorImageOfTheOneTowardsTheOtherEnd) {
  Mesh mirrored = mesh_;
  std::swap(mirrored.grading.left, mirrored.grading.right);
  for (std::size_t j = 0; j < mesh_.elements; ++j)
    EXPECT_EQ(mirrored.element(mesh_.elements - 1 - j), mesh_.element(j)) << j;
}

TEST_P(GradedMesh, KeepsItsNodesWhenTheElementsAreDoubled) {
  Mesh doubled = mesh_;
  doubled.elements *= 2;
  for (std::size_t j = 0; j <= mesh_.elements; ++j)
    EXPECT_NEAR(doubled.node(2 * j), mesh_.node(j), 2 * eps * mesh_.length) << j;
}

INSTANTIATE_TEST_SUITE_P(Meshes, GradedMesh,
                         testing::Combine(testing::Values(1u, 2u, 3u, 8u, 9u, 1000u),
                                          testing::Values(Grading{4.0, true, false}, Grading{16.0, false, true},
                                                          Grading{64.0, true, true})));

// x'(s) is 2 / (1 + r) at a marked end and r times that at the other; the elements nearest to them lie half an element
// further in.
TEST(Mesh, GradedOnManyElementsHasItsRatioBetweenTheLastAndTheFirst) {
  for (const double ratio : {2.0, 16.0}) {
    const Mesh mesh{1.0, 100000, {ratio, true, false}};
    EXPECT_NEAR(mesh.element(mesh.elements - 1) / mesh.element(0), ratio, ratio * ratio / 1e5);
    EXPECT_NEAR(mesh.smallest(), 2 * mesh.spacing() / (1 + ratio), mesh.spacing() / 1e5);
  }
}

TEST(Mesh, WithoutRatioOrWithoutMarkedEndIsTheUniformOneToTheBit) {
  const Mesh uniform{0.7, 13};
  for (const Grading grading : {Grading{1.0, true, true}, Grading{8.0, false, false}}) {
    const Mesh mesh{0.7, 13, grading};
    EXPECT_TRUE(mesh.uniform());
    EXPECT_TRUE(same_nodes(mesh, uniform));
    for (std::size_t j = 0; j <= mesh.elements; ++j) EXPECT_EQ(mesh.node(j), uniform.node(j));
    for (std::size_t j = 0; j < mesh.elements; ++j) EXPECT_EQ(mesh.element(j), uniform.spacing());
  }
}

}  // namespace
}  // namespace viscobar::testing_mesh
