// `viscobar export` and the scripts of examples/ read the very numbers that a result holds.
#include <algorithm>
#include <charconv>

#include "cli/command.hpp"
#include "results/field/field_reader.hpp"

namespace viscobar {
namespace {

using testing_cli::fs::path;
using FieldQuantity = FieldReader::Quantity;

std::vector<double> numbers(const std::string& line) {
  std::vector<double> found;
  const char *at = line.data(), *end = at + line.size();
  while (at < end) {
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error == std::errc()) found.push_back(value);
    at = std::find(next, end, ',') + 1;
  }
  return found;
}

class Export : public testing_cli::Command {
 protected:
  Export() {
    viscobar("new scene.toml");
    // 301 rows of 1001 nodes: more than one block of 131 rows.
    viscobar("run scene.toml --quiet -o out --set mesh.elements=1000 --set time.end=0.3 --set output.every=1e-3");
  }

  std::vector<double> field(const FieldReader& reader, FieldQuantity quantity) const {
    std::vector<double> values(reader.rows() * reader.nodes());
    reader.read(quantity, 0, values);
    return values;
  }

  /// Runs a script of examples/ on the result, or says why not.
  std::string run_script(const std::string& interpreter, const std::string& script) const {
    const std::string line = "cd '" + directory_.string() + "' && " + interpreter +
                             " '" VISCOBAR_SOURCE_DIR "/examples/" + script + "' out >script.txt 2>script-error.txt";
    const int status = std::system(line.c_str());
    EXPECT_EQ(status, 0) << read_text(directory_ / "script-error.txt");
    return read_text(directory_ / "script.txt");
  }
};

TEST_F(Export, OfCsvHoldsTheFieldBitForBit) {
  ASSERT_EQ(viscobar("export out -o plain").code, 0);
  const FieldReader reader(directory_ / "out/field.h5");
  for (const auto& [name, quantity] :
       {std::pair{"plain/u.csv", FieldQuantity::displacement}, std::pair{"plain/v.csv", FieldQuantity::velocity}}) {
    std::ifstream stream(directory_ / name);
    std::string line;
    std::getline(stream, line);
    EXPECT_EQ(line.substr(0, 2), "t,");
    EXPECT_EQ(numbers(line.substr(2)), reader.x());
    const std::vector<double> values = field(reader, quantity);
    for (std::size_t row = 0; row < reader.rows(); ++row) {
      ASSERT_TRUE(std::getline(stream, line));
      const std::vector<double> found = numbers(line);
      ASSERT_EQ(found.size(), 1002u);
      ASSERT_EQ(found[0], reader.times()[row]);
      ASSERT_TRUE(std::equal(found.begin() + 1, found.end(), values.begin() + static_cast<long>(row * 1001)));
    }
    EXPECT_FALSE(std::getline(stream, line));
  }
  EXPECT_EQ(read_text(directory_ / "plain/ends.csv"), read_text(directory_ / "out/ends.csv"));
}

TEST_F(Export, OfARunThatStoppedHasTheRowsItReached) {
  EXPECT_EQ(viscobar("run scene.toml --quiet -o cut --set 'load.density=sqrt(0.205-t)'").code, 1);
  ASSERT_EQ(viscobar("export cut --quiet").code, 0);
  const std::string u = read_text(directory_ / "cut/csv/u.csv");
  const auto rows = std::ranges::count(u, '\n') - 1;
  EXPECT_GT(rows, 1);
  EXPECT_LE(rows, 22);  // 21 output times, and where it stopped
  EXPECT_EQ(std::ranges::count(u, ','), (rows + 1) * 28);
}

TEST_F(Export, OfWhatIsNoRunIsTheUsersError) {
  EXPECT_EQ(viscobar("export nowhere").code, 2);
  EXPECT_EQ(viscobar("export .").code, 2);
  const auto misspelt = viscobar("export out --format xmdf");
  EXPECT_EQ(misspelt.code, 2);
  EXPECT_NE(misspelt.error.find("did you mean xdmf?"), std::string::npos) << misspelt.error;
  std::ofstream(directory_ / "out/field.h5") << "no HDF5";
  EXPECT_EQ(viscobar("export out").code, 1);
}

// Both scripts print the counts, and the extremes to at least 12 digits.
void expect_extremes(const std::string& printed, const std::vector<double>& u, const std::vector<double>& v) {
  EXPECT_NE(printed.find("301 times and 1001 nodes"), std::string::npos) << printed;
  const auto largest = [](const std::vector<double>& values) {
    double most = 0.0;
    for (const double value : values) most = std::max(most, std::abs(value));
    return most;
  };
  const auto after = [&](const std::string& words) {
    return std::stod(printed.substr(printed.find(words) + words.size()));
  };
  EXPECT_NEAR(after("|u| ="), largest(u), 1e-12 * largest(u));
  EXPECT_NEAR(after("|v| ="), largest(v), 1e-12 * largest(v));
}

TEST_F(Export, IsNotNeededByAPythonScriptOfTenLines) {
  const std::string python = "/usr/bin/python3";  // Debian's, which has its packages
  if (std::system((python + " -c 'import h5py' 2>/dev/null").c_str()) != 0)
    GTEST_SKIP() << "python3-h5py is not installed";
  const FieldReader reader(directory_ / "out/field.h5");
  expect_extremes(run_script(python, "read_result.py"), field(reader, FieldQuantity::displacement),
                  field(reader, FieldQuantity::velocity));
}

TEST_F(Export, IsNotNeededByAnOctaveScriptOfTenLines) {
  if (std::system("octave-cli --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "octave is not installed";
  const FieldReader reader(directory_ / "out/field.h5");
  expect_extremes(run_script("octave-cli -q", "read_result.m"), field(reader, FieldQuantity::displacement),
                  field(reader, FieldQuantity::velocity));
}

TEST_F(Export, XdmfIsReadByMeshioWithACellForEachElement) {
  if (std::system("/usr/bin/python3 -c 'import meshio, h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-meshio is not installed";
  ASSERT_EQ(viscobar("export out --format xdmf").code, 0);
  std::ofstream(directory_ / "equal.py") << R"(
import h5py, meshio
field = h5py.File("out/field.h5")
with meshio.xdmf.TimeSeriesReader("out/xdmf/field.xdmf") as reader:
    points, cells = reader.read_points_cells()
    assert (points[:, 0] == field["x"][:]).all() and not points[:, 1:].any()
    (bar,) = cells
    elements = len(field["x"]) - 1
    assert bar.type == "line" and [list(cell) for cell in bar.data] == [[k, k + 1] for k in range(elements)]
    assert reader.num_steps == len(field["t"])
    for k in range(reader.num_steps):
        time, nodes, of_cells = reader.read_data(k)
        assert time == field["t"][k]
        assert (nodes["displacement"] == field["u"][k]).all() and (nodes["velocity"] == field["v"][k]).all()
        assert (of_cells["stress"][0] == field["stress"][k]).all()
)";
  EXPECT_EQ(std::system(("cd '" + directory_.string() + "' && /usr/bin/python3 equal.py").c_str()), 0);
}

TEST_F(Export, CutOffBetweenItsRenamesIsFinishedByTheNextReader) {
  ASSERT_EQ(viscobar("export out -q").code, 0);
  const testing_cli::fs::path csv = directory_ / "out/csv", waiting = csv / ".viscobar.export.whole";
  const std::string whole = read_text(csv / "u.csv");
  testing_cli::fs::create_directory(waiting);
  testing_cli::fs::rename(csv / "u.csv", waiting / "u.csv");
  std::ofstream(csv / "u.csv") << "t,0\n0,of an earlier export\n";
  EXPECT_EQ(viscobar("info out").code, 0);
  EXPECT_EQ(read_text(csv / "u.csv"), whole);
  EXPECT_FALSE(testing_cli::fs::exists(waiting));
}

}  // namespace
}  // namespace viscobar
