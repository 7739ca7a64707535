// field.xdmf as those see it who read it: the XDMF library, which ParaView's reader is made of, and ParaView itself.
#ifdef VISCOBAR_XDMF
#include <XdmfAttribute.hpp>
#include <XdmfAttributeCenter.hpp>
#include <XdmfDomain.hpp>
#include <XdmfGeometry.hpp>
#include <XdmfGridCollection.hpp>
#include <XdmfReader.hpp>
#include <XdmfTime.hpp>
#include <XdmfTopology.hpp>
#include <XdmfUnstructuredGrid.hpp>
#endif

#include <cmath>

#include "results/field/field_file.hpp"
#include "support/scratch.hpp"

namespace viscobar::testing_xdmf {
namespace {

constexpr std::size_t nodes = 6, rows = 7;

double value(std::size_t row, std::size_t j) { return std::sin(static_cast<double>(10 * row + j)); }

/// Rows of u = value, v = -value at the times 0, 1/2, 1, ..., in blocks of three.
class Xdmf : public testing::Test {
 protected:
  Xdmf() {
    FieldFile file(scratch_.path(), Mesh{3.0, nodes - 1}, 3);
    std::vector<double> u(nodes), v(nodes);
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t j = 0; j < nodes; ++j) v[j] = -(u[j] = value(row, j));
      file.append({0.5 * static_cast<double>(row), u, v, 0.0, 0.0});
    }
    file.close();
  }
  const Scratch scratch_;
};

TEST_F(Xdmf, IsReadByItsOwnLibrary) {
#ifdef VISCOBAR_XDMF
  const auto item = XdmfReader::New()->read((scratch_ / "field.xdmf").string());
  const auto domain = shared_dynamic_cast<XdmfDomain>(item);
  ASSERT_EQ(domain->getNumberGridCollections(), 1u);
  const auto times = domain->getGridCollection(0);
  ASSERT_EQ(times->getNumberUnstructuredGrids(), rows);
  for (const unsigned row : {0u, 3u, 6u}) {
    const auto grid = times->getUnstructuredGrid(row);
    EXPECT_EQ(grid->getTime()->getValue(), 0.5 * row);
    const auto points = grid->getGeometry();
    points->read();
    ASSERT_EQ(points->getSize(), 3 * nodes);
    EXPECT_EQ(points->getValue<double>(3 * nodes - 3), 3.0);
    EXPECT_EQ(grid->getTopology()->getNumberElements(), nodes - 1);
    const auto stress = grid->getAttribute("stress");
    stress->read();
    EXPECT_EQ(stress->getCenter(), XdmfAttributeCenter::Cell());
    EXPECT_EQ(stress->getSize(), nodes - 1);
    for (const auto& [name, sign] : {std::pair{"displacement", 1.0}, std::pair{"velocity", -1.0}}) {
      const auto field = grid->getAttribute(name);
      field->read();
      ASSERT_EQ(field->getSize(), nodes) << name;
      for (unsigned j = 0; j < nodes; ++j) EXPECT_EQ(field->getValue<double>(j), sign * value(row, j)) << name;
    }
  }
#else
  GTEST_SKIP() << "libxdmf-dev or libxml2-dev is not installed";
#endif
}

TEST_F(Xdmf, IsReadByParaView) {
  if (std::system("/usr/bin/python3 -c 'import paraview' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-paraview is not installed";
  std::ofstream(scratch_ / "read.py") << R"(
import sys
from paraview.simple import OpenDataFile, servermanager
reader = OpenDataFile(sys.argv[1])  # by the reader that ParaView itself chooses
print(*reader.TimestepValues)
for time in reader.TimestepValues:
    reader.UpdatePipeline(time=time)
    points = servermanager.Fetch(reader)
    print(points.GetNumberOfCells(), points.GetCellData().GetArray("stress").GetNumberOfTuples())
    for name in ("displacement", "velocity"):
        values = points.GetPointData().GetArray(name)
        print(*(repr(values.GetValue(j)) for j in range(values.GetNumberOfTuples())))
)";
  // The whole path, as from its dialog: ParaView 5.11 does not find field.h5 beside a bare file name.
  const std::string command =
      "cd '" + scratch_.path().string() + "' && /usr/bin/python3 read.py \"$PWD/field.xdmf\" >read.txt";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream printed(scratch_ / "read.txt");
  double found = 0.0;
  for (std::size_t row = 0; row < rows; ++row) {
    printed >> found;
    EXPECT_EQ(found, 0.5 * static_cast<double>(row));
  }
  for (std::size_t row = 0; row < rows; ++row) {
    std::size_t cells = 0, stresses = 0;
    ASSERT_TRUE(printed >> cells >> stresses);
    EXPECT_EQ(cells, nodes - 1);
    EXPECT_EQ(stresses, nodes - 1);
    for (const double sign : {1.0, -1.0})
      for (std::size_t j = 0; j < nodes; ++j) {
        ASSERT_TRUE(printed >> found);
        EXPECT_EQ(found, sign * value(row, j));
      }
  }
}

}  // namespace
}  // namespace viscobar::testing_xdmf
