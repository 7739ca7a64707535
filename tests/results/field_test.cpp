#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstring>
#include <regex>
#include <tuple>

#include "results/field/field_file.hpp"
#include "results/field/field_reader.hpp"
#include "support/hdf5_attribute.hpp"
#include "support/scratch.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar::testing_field {
namespace {

namespace fs = std::filesystem;

struct Dataset {
  std::vector<hsize_t> extent;
  std::vector<double> values;
};

Dataset read(const fs::path& file, const char* name) {
  const Hdf5Handle<H5Fclose> h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  const Hdf5Handle<H5Dclose> dataset(H5Dopen2(h5.get(), name, H5P_DEFAULT));
  const Hdf5Handle<H5Sclose> space(H5Dget_space(dataset.get()));
  Dataset out;
  out.extent.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.get())));
  H5Sget_simple_extent_dims(space.get(), out.extent.data(), nullptr);
  out.values.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
  H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.values.data());
  return out;
}

double field_value(std::size_t row, std::size_t j) { return std::sin(0.1 * static_cast<double>(row * 1000 + j)); }

void append(FieldFile& file, std::size_t nodes, std::size_t first, std::size_t count) {
  std::vector<double> u(nodes), v(nodes);
  for (std::size_t row = first; row < first + count; ++row) {
    for (std::size_t j = 0; j < nodes; ++j) v[j] = -(u[j] = field_value(row, j));
    file.append({static_cast<double>(row), u, v, 0.0, 0.0});
  }
}

std::size_t times_in(const fs::path& xdmf) {
  const std::string text = read_text(xdmf);
  const std::regex time("<Time Value=");
  return static_cast<std::size_t>(std::distance(std::sregex_iterator(text.begin(), text.end(), time), {}));
}

// Every element that is opened is closed, in order.
bool well_formed(const std::string& xml) {
  std::vector<std::string> open;
  const std::regex tag(R"(<(/?)(\w+)[^<>]*?(/?)>)");
  for (std::sregex_iterator it(xml.begin(), xml.end(), tag), end; it != end; ++it) {
    if ((*it)[1].length()) {
      if (open.empty() || open.back() != (*it)[2]) return false;
      open.pop_back();
    } else if (!(*it)[3].length()) {
      open.push_back((*it)[2]);
    }
  }
  return open.empty();
}

class Blocks : public testing::TestWithParam<std::size_t> {};

TEST_P(Blocks, EveryRowIsReadBackWhateverTheBlockSize) {
  const Scratch scratch;
  const std::size_t nodes = 31, rows = 10;
  FieldFile file(scratch.path(), Mesh{3.0, nodes - 1}, GetParam());
  append(file, nodes, 0, rows);
  file.close();
  const Dataset u = read(scratch / "field.h5", "u"), v = read(scratch / "field.h5", "v");
  EXPECT_EQ(u.extent, (std::vector<hsize_t>{rows, nodes}));
  EXPECT_EQ(v.extent, u.extent);
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t j = 0; j < nodes; ++j) {
      ASSERT_EQ(u.values[row * nodes + j], field_value(row, j));
      ASSERT_EQ(v.values[row * nodes + j], -field_value(row, j));
    }
  EXPECT_EQ(read(scratch / "field.h5", "t").values, (std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  const Dataset x = read(scratch / "field.h5", "x");
  EXPECT_EQ(x.extent, (std::vector<hsize_t>{nodes}));
  EXPECT_EQ(x.values.back(), 3.0);
  EXPECT_EQ(times_in(scratch / "field.xdmf"), rows);
}

INSTANTIATE_TEST_SUITE_P(FieldFile, Blocks, testing::Values(1, 3, 10, 1000));

// Rows that wait for their block are written after a second all the same.
constexpr auto too_slow = "took a second, so the clock wrote, too";

TEST(FieldFile, GathersRowsToBlocksOfAMebibyte) {
  const Scratch scratch;
  const std::size_t nodes = 1 << 14;  // 128 KiB a row
  FlushClock clock;
  FieldFile file(scratch.path(), Mesh{1.0, nodes - 1}, 1'000'000);
  file.take_place();
  append(file, nodes, 0, 7);
  if (clock.due()) GTEST_SKIP() << too_slow;
  EXPECT_EQ(times_in(scratch / "field.xdmf"), 0u);
  append(file, nodes, 7, 1);
  EXPECT_EQ(times_in(scratch / "field.xdmf"), 8u);
}

TEST(FieldFile, AKilledRunLeavesAReadablePairOfFiles) {
  const Scratch scratch;
  const std::size_t nodes = 1 << 14;
  FlushClock clock;
  const pid_t child = fork();
  if (child == 0) {
    FieldFile file(scratch.path(), Mesh{1.0, nodes - 1}, 1'000'000);
    file.take_place();
    append(file, nodes, 0, 20);
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  if (clock.due()) GTEST_SKIP() << too_slow;
  const Dataset u = read(scratch / "field.h5", "u");
  EXPECT_EQ(u.extent, (std::vector<hsize_t>{16, nodes}));
  EXPECT_EQ(u.values.back(), field_value(15, nodes - 1));
  EXPECT_GE(times_in(scratch / "field.xdmf"), 8u);
  EXPECT_LE(times_in(scratch / "field.xdmf"), 16u);
  EXPECT_TRUE(well_formed(read_text(scratch / "field.xdmf")));
}

TEST(FieldFile, XdmfIsWellFormedAndNamesRowsThatExist) {
  const Scratch scratch;
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 3);
  file.take_place();
  EXPECT_TRUE(well_formed(read_text(scratch / "field.xdmf")));
  append(file, 5, 0, 7);
  file.close();
  const std::string text = read_text(scratch / "field.xdmf");
  EXPECT_TRUE(well_formed(text));
  EXPECT_NE(text.find("CollectionType=\"Temporal\""), std::string::npos);
  const std::regex slab("\\|(\\d+) 0:1 1:1 5:");
  std::vector<int> rows;
  for (std::sregex_iterator it(text.begin(), text.end(), slab), end; it != end; ++it)
    rows.push_back(std::stoi((*it)[1]));
  EXPECT_EQ(rows, (std::vector<int>{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6}));
}

// Every reference field.h5:/name of the description is a dataset, and the extents it gives are those of the dataset; of
// one that grows they end at the row that is meant.
TEST(FieldFile, XdmfNamesDatasetsThatExistWithTheirExtents) {
  const Scratch scratch;
  const std::size_t rows = 7;
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 3);
  append(file, 5, 0, rows);
  file.close();
  const std::string text = read_text(scratch / "field.xdmf");
  const std::regex reference(
      "<DataItem Dimensions=\"([\\d ]+)\" Format=\"HDF\"[^>]*>([^:<]+):/(\\w+)(?:\\|[^<]*:(\\d+) (\\d+))?</DataItem>");
  std::size_t found = 0, last_row = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), reference), end; it != end; ++it, ++found) {
    const std::smatch& match = *it;
    EXPECT_EQ(match[2], "field.h5");
    const std::string name = match[3];
    std::vector<hsize_t> given;
    std::istringstream extents(match[4].matched ? match.str(4) + " " + match.str(5) : match.str(1));
    for (hsize_t extent = 0; extents >> extent;) given.push_back(extent);
    ASSERT_EQ(given.size(), 2u);
    const Dataset dataset = read(scratch / "field.h5", name.c_str());
    if (name == "u" || name == "v" || name == "stress") {
      EXPECT_EQ(given[1], dataset.extent[1]);
      EXPECT_EQ(match[1], std::to_string(given[1]));
      EXPECT_LE(given[0], dataset.extent[0]);
      last_row = std::max<std::size_t>(last_row, given[0]);
    } else {
      EXPECT_EQ(given, dataset.extent) << name;
    }
  }
  EXPECT_EQ(found, 2 + 3 * rows);  // line and points once, u, v and stress of each time
  EXPECT_EQ(last_row, rows);
}

// The mesh and, of each time, what names it, two references to the mesh and the rows of two fields.
TEST(FieldFile, XdmfHoldsTheMeshOnce) {
  const Scratch scratch;
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 1000);
  append(file, 5, 0, 1000);
  file.close();
  const std::string text = read_text(scratch / "field.xdmf");
  for (const std::string once : {":/line<", ":/points<"}) {
    EXPECT_NE(text.find(once), text.npos);
    EXPECT_EQ(text.find(once), text.rfind(once));
  }
  EXPECT_LT(text.size(), 1000 * 700u);
}

TEST(FieldFile, ItsChecksumsTakenWhileItGrowsAreThoseOfTheFiles) {
  for (const auto& [elements, expected, rows] : {std::tuple{4u, 10u, 0u},
                                                 {4u, 10u, 1u},
                                                 {4u, 10u, 10u},
                                                 {30u, 5000u, 4095u},
                                                 {30u, 5000u, 9000u},
                                                 {999u, 400u, 131u},
                                                 {999u, 400u, 262u},
                                                 {200'000u, 4u, 3u}}) {
    const Scratch scratch;
    FieldFile file(scratch.path(), Mesh{1.0, elements}, expected);
    append(file, elements + 1, 0, rows / 3);
    file.flush();  // as the clock does, within a chunk
    append(file, elements + 1, rows / 3, rows - rows / 3);
    file.close();
    EXPECT_EQ(file.checksum(), checksum_of_file(scratch / "field.h5")) << elements << ' ' << rows;
    EXPECT_EQ(file.xdmf_checksum(), checksum_of_file(scratch / "field.xdmf")) << elements << ' ' << rows;
  }
}

// A killed run may have written more than its mark says, into a chunk that is not full.
TEST(FieldFile, GoesOnFromAMarkWhateverCameBehindIt) {
  const Scratch scratch;
  const Mesh mesh{1.0, 4};
  FieldMark mark;
  {
    FieldFile killed(scratch.path(), mesh, 100);
    append(killed, 5, 0, 40);
    mark = killed.mark();
    EXPECT_EQ(mark.checksum(), checksum_of_file(scratch / "field.h5"));
    append(killed, 5, 40, 30);
    killed.flush();
  }
  mark.check_values(scratch / "field.h5");
  FieldFile resumed(scratch.path(), mesh, 100, &mark);
  append(resumed, 5, 40, 10);
  resumed.close();
  EXPECT_EQ(resumed.checksum(), checksum_of_file(scratch / "field.h5"));
  EXPECT_EQ(read(scratch / "field.h5", "u").extent, (std::vector<hsize_t>{50, 5}));
}

TEST(FieldFile, AMarkNoticesEachValueThatIsChanged) {
  const Scratch scratch;
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 100);
  append(file, 5, 0, 40);
  const FieldMark mark = file.mark();
  file.close();
  for (const FieldMark::Region& region : mark.regions)
    for (const std::size_t at : {std::size_t{0}, static_cast<std::size_t>(region.values.bytes) - 1}) {
      std::fstream raw(scratch / "field.h5", std::ios::in | std::ios::out | std::ios::binary);
      const auto flip = [&] {
        raw.seekg(static_cast<std::streamoff>(region.begin + at));
        const int byte = raw.get();
        raw.seekp(static_cast<std::streamoff>(region.begin + at));
        raw.put(static_cast<char>(byte ^ 1)).flush();
      };
      flip();
      EXPECT_THROW(mark.check_values(scratch / "field.h5"), IoError) << region.begin;
      flip();
      EXPECT_NO_THROW(mark.check_values(scratch / "field.h5"));
    }
}

TEST(FieldFile, AFileThatMayNotGrowIsAnErrorThatNamesIt) {
  const Scratch scratch;
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1 << 16, 1 << 16};
    setrlimit(RLIMIT_FSIZE, &limit);
    int code = 1;
    try {
      FieldFile file(scratch.path(), Mesh{1.0, 999}, 1000);
      append(file, 1000, 0, 1000);
    } catch (const IoError& error) {
      const std::string text = error.what();
      code = error.file.filename() == "field.h5" && text.find("File too large") != std::string::npos ? 0 : 2;
    }
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(FieldFile, ThatHasBeenRemovedIsAnErrorThatSaysSo) {
  for (const char* name : {"field.h5", "field.xdmf"}) {
    const Scratch scratch;
    FieldFile file(scratch.path(), Mesh{1.0, 4}, 3);
    file.take_place();
    append(file, 5, 0, 3);
    std::filesystem::remove(scratch / name);
    try {
      file.close();
      FAIL() << name << ": a missing file was taken for a written one";
    } catch (const IoError& error) {
      EXPECT_NE(std::string(error.what()).find("was removed"), std::string::npos) << error.what();
    }
  }
}

TEST(FieldFile, FollowsNoLinks) {
  for (const char* name : {"field.h5", "field.h5.part", "field.xdmf", "field.xdmf.part"}) {
    const Scratch scratch;
    std::ofstream(scratch / "elsewhere") << "mine";
    std::filesystem::create_symlink(scratch / "elsewhere", scratch / name);
    FieldFile file(scratch.path(), Mesh{1.0, 4}, 3);
    append(file, 5, 0, 3);
    file.take_place();
    append(file, 5, 3, 3);
    file.close();
    EXPECT_EQ(read_text(scratch / "elsewhere"), "mine") << name;
  }
}

TEST(FieldFile, APlaceThatIsNotThereIsAnErrorAtOnce) {
  const Scratch scratch;
  EXPECT_THROW(FieldFile(scratch / "nowhere", Mesh{1.0, 4}, 3), IoError);
}

// By hand: (E (u_1 - u_0) + eta (v_1 - v_0)) / h on elements of length 1/4.
TEST(FieldFile, HasTheMeanStressOfEachElement) {
  const Scratch scratch;
  FieldOrigin of;
  of.bar.modulus = 2.0;
  of.bar.viscosity = 0.5;
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 10, nullptr, of);
  file.append({0.0, std::vector{0.0, 0.25, 0.25, 1.0, 0.0}, std::vector{1.0, 1.0, 2.0, 0.0, 0.0}, 0.0, 0.0});
  file.close();
  const FieldReader reader(scratch / "field.h5");
  ASSERT_TRUE(reader.has(FieldReader::Quantity::stress));
  std::vector<double> stress(4);
  reader.read(FieldReader::Quantity::stress, 0, stress);
  EXPECT_EQ(stress, (std::vector{2.0, 2.0, 2.0, -8.0}));
}

TEST(FieldFile, ElementsAreLineCellsOfTheXdmfFile) {
  const Scratch scratch;
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 3);
  append(file, 5, 0, 2);
  file.close();
  const std::string text = read_text(scratch / "field.xdmf");
  EXPECT_NE(text.find("TopologyType=\"Polyline\" NumberOfElements=\"4\" NodesPerElement=\"2\""), std::string::npos);
  EXPECT_NE(text.find("<Attribute Name=\"stress\" Center=\"Cell\"><DataItem Dimensions=\"4\""), std::string::npos);
  EXPECT_EQ(read(scratch / "field.h5", "line").values, (std::vector<double>{0, 1, 1, 2, 2, 3, 3, 4}));
}

TEST(FieldFile, SaysWhatItIsOfInAttributes) {
  const Scratch scratch;
  FieldOrigin of;
  of.title = "Überschrift";
  of.scene = "[bar]\nlength = 1.0\n";
  of.units.length = "m";
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 3, nullptr, of);
  append(file, 5, 0, 2);
  file.close();
  EXPECT_EQ(attribute(scratch / "field.h5", "/", "title"), of.title);
  EXPECT_EQ(attribute(scratch / "field.h5", "/", "scene"), of.scene);
  EXPECT_EQ(attribute(scratch / "field.h5", "/", "units"), "length: m");
  EXPECT_TRUE(attribute(scratch / "field.h5", "/", "version").starts_with("viscobar "));
  for (const char* dataset : {"x", "t", "u", "v", "stress", "points", "line"})
    EXPECT_NE(attribute(scratch / "field.h5", dataset, "long_name"), "none") << dataset;
  EXPECT_EQ(attribute(scratch / "field.h5", "u", "units"), "m");
  EXPECT_EQ(attribute(scratch / "field.h5", "v", "units"), "none") << "no unit of time is named";
}

// It is the unit of the quotient; a pure number has the unit 1.
TEST(FieldFile, SaysTheUnitsOfDerivativesWhereThatOfTheKeyIsKnown) {
  const Scratch scratch;
  FieldOrigin of;
  of.units = {"m", "s", "", "", "Pa"};
  of.keys = {{"left.gap", UnitPowers{1, 0, 0, 0}}, {"bar.viscosity", UnitPowers{0, 1, 1, 0}}, {"parameters.speed"}};
  FieldFile(scratch.path(), Mesh{1.0, 4}, 3, nullptr, of).close();
  const auto unit = [&](const char* dataset) {
    return attribute(scratch / "field.h5", (std::string("sensitivity/") + dataset).c_str(), "units");
  };
  EXPECT_EQ(unit("left.gap/u"), "1");
  EXPECT_EQ(unit("left.gap/v"), "1/s");
  EXPECT_EQ(unit("left.gap/reaction_left"), "Pa/m");
  EXPECT_EQ(unit("bar.viscosity/u"), "m/(Pa s)");
  EXPECT_EQ(unit("bar.viscosity/reaction_right"), "1/s");
  EXPECT_EQ(unit("parameters.speed/u"), "none");
}

// In blocks of two rows, cut at an odd one.
TEST(FieldFile, HoldsTheDerivativesByEachKeyAndGoesOnWithThemBitForBit) {
  const Scratch scratch;
  constexpr std::size_t nodes = 5, rows = 7, cut = 3;
  FieldOrigin of;
  of.keys = {{"left.gap"}, {"parameters.speed"}};
  const auto append_rows = [&](FieldFile& file, std::size_t first, std::size_t count) {
    for (std::size_t row = first; row < first + count; ++row) {
      std::vector<double> u(nodes), v(nodes);
      for (std::size_t j = 0; j < nodes; ++j) v[j] = -(u[j] = field_value(row, j));
      const double now = static_cast<double>(row);
      const FieldSensitivity told[] = {{u, v, now, -now}, {v, u, 2.0 * now, std::nan("")}};
      Snapshot at{now, u, v, 0.0, 0.0};
      at.sensitivities = told;
      file.append(at);
    }
  };
  fs::create_directory(scratch / "whole");
  fs::create_directory(scratch / "cut");
  FieldFile whole(scratch / "whole", Mesh{1.0, nodes - 1}, 2, nullptr, of);
  append_rows(whole, 0, rows);
  whole.close();
  FieldFile begun(scratch / "cut", Mesh{1.0, nodes - 1}, 2, nullptr, of);
  append_rows(begun, 0, cut);
  const FieldMark mark = begun.mark();
  append_rows(begun, cut, 2);
  begun.close();
  mark.check_values(scratch / "cut/field.h5");
  FieldFile resumed(scratch / "cut", Mesh{1.0, nodes - 1}, 2, &mark, of);
  append_rows(resumed, cut, rows - cut);
  resumed.close();
  for (const auto& [key, unit] : of.keys)
    for (const char* name : {"u", "v", "reaction_left", "reaction_right"}) {
      const std::string dataset = "sensitivity/" + key + "/" + name;
      const Dataset one = read(scratch / "whole/field.h5", dataset.c_str());
      const Dataset other = read(scratch / "cut/field.h5", dataset.c_str());
      EXPECT_EQ(one.extent, other.extent) << dataset;
      ASSERT_EQ(one.values.size(), other.values.size()) << dataset;
      EXPECT_EQ(std::memcmp(one.values.data(), other.values.data(), one.values.size() * sizeof(double)), 0) << dataset;
      EXPECT_NE(attribute(scratch / "whole/field.h5", dataset.c_str(), "long_name").find(key), std::string::npos);
    }
  const Dataset u = read(scratch / "whole/field.h5", "sensitivity/parameters.speed/u");
  EXPECT_EQ(u.extent, (std::vector<hsize_t>{rows, nodes}));
  EXPECT_EQ(u.values[2 * nodes + 1], -field_value(2, 1));
  const Dataset reaction = read(scratch / "whole/field.h5", "sensitivity/left.gap/reaction_right");
  EXPECT_EQ(reaction.extent, (std::vector<hsize_t>{rows}));
  EXPECT_EQ(reaction.values[6], -6.0);
}

// The format holds 64 kB in an attribute.
TEST(FieldFile, TakesATitleOfAnyLength) {
  const Scratch scratch;
  FieldOrigin of;
  of.title = std::string(1 << 20, 'a');
  FieldFile file(scratch.path(), Mesh{1.0, 4}, 3, nullptr, of);
  append(file, 5, 0, 2);
  file.close();
  EXPECT_EQ(attribute(scratch / "field.h5", "/", "title"), "too long: see summary.json");
}

}  // namespace
}  // namespace viscobar::testing_field
