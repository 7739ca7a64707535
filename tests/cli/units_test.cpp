// Pages of a scene that names its units: heads of tables and axes have them, and numbers have one notation.
#include <regex>
#include <set>
#include <string>

#include "cli/command.hpp"
#include "support/scene_text.hpp"

namespace viscobar {
namespace {

using UnitsOfPages = testing_cli::Command;

/// Heads and axes of words, of numbers without unit, of seconds of the processor, and of cells with units of their own.
const std::set<std::string> without = {
    "", "case", "closings", "where", "change", "method", "mass", "settings", "setting", "steps", "seconds", "changes",
    "bounces", "changes matched", "elements", "contact changes", "regime", "theory", "scheme's power of dt",
    "tolerance", "largest part", "order", "power of ε", "time errors are against", "left end", "right end", "parameter",
    "estimate", "half width, 95 %", "standard deviation", "solution", "quantity", "largest difference",
    "of the largest value", "our own error", "mean", "our own",
    // powers of epsilon
    "penetration", "to its own limit", "to the scheme"};

TEST_F(UnitsOfPages, AreAtEachHeadAndAxisAndNumbersHaveOneNotation) {
  std::ofstream(directory_ / "scene.toml") << falling_bar_with({{"units.length", "\"m\""},
                                                                {"units.time", "\"s\""},
                                                                {"units.mass", "\"kg\""},
                                                                {"output.every", "0.05"},
                                                                {"contact.restitution", "0.5"}});
  std::ofstream(directory_ / "sweep.toml")
      << "scene = \"scene.toml\"\n[vary]\nbar.viscosity = [0.1, 0.2]\nleft.gap = [0.1, 0.2]\n";
  struct {
    const char *command, *page;
    std::size_t heads, axes;  // at least
    const char* unit;         // one of the page
  } const pages[] = {
      {"run scene.toml -o run", "run/report.html", 8, 10, "reaction R [kg/(m s²)]"},
      {"run scene.toml -o other --set method.name=ida", "other/report.html", 8, 10, "time t [s]"},
      {"run scene.toml -o slopes --sensitivity left.gap,bar.viscosity", "slopes/report.html", 8, 12,
       "du / d bar.viscosity [m² s/kg]"},
      {"run scene.toml -o section --set bar.section=1+0.3*x", "section/report.html", 8, 10, "A = 1 to 1.3\u00a0m²"},
      {"run scene.toml -o span --set span.gap=0.2 --set method.name=ida", "span/report.html", 8, 10,
       "m² s²/kg at an end, m³ s²/kg along the span"},
      {"compare scene.toml --methods cvode,ida -o methods", "methods/compare.html", 20, 5, "u, L2 [m^1.5]"},
      {"compare run other -o results", "results/compare.html", 20, 5, "v, L2 [m^1.5/s]"},
      {"compare scene.toml --with run/ends.csv -o with", "with/judge.html", 9, 10, "at t [s]"},
      {"limit scene.toml --epsilon 1e-2:1e-4 --budget 0 -o limit", "limit/limit.html", 15, 6, "penalty ε [m² s²/kg]"},
      {"precision scene.toml --methods cvode,fully_discrete --tolerance 1e-3:1e-4 --repeat 3 -o precision",
       "precision/precision.html", 10, 4, "error: largest |u − u*| [m]"},
      {"fit scene.toml --data run/ends.csv --parameters left.gap --set left.gap=0.11 -o fit", "fit/fit.html", 3, 10,
       "v_left [m/s]"},
      {"sweep sweep.toml -o sweep", "sweep/sweep.html", 4, 0, "bar.viscosity [kg/(m s)]"}};
  const std::regex head(R"(<th[^>]*>([^<]*)</th>)"), axis(R"(<text class="axis"[^>]*>([^<]*)</text>)");
  for (const auto& [command, page, heads, axes, unit] : pages) {
    SCOPED_TRACE(command);
    const testing_cli::Ended ended = viscobar(command + std::string(" --quiet"));
    ASSERT_LE(ended.code, 1) << ended.error;
    const std::string html = read_text(directory_ / page);
    const auto told = [&](const std::regex& of) {
      std::size_t count = 0;
      for (std::sregex_iterator at(html.begin(), html.end(), of), end; at != end; ++at, ++count) {
        const std::string words = (*at)[1];
        EXPECT_TRUE(words.ends_with("]") || words.find("] / 10") != words.npos || without.contains(words)) << words;
      }
      return count;
    };
    EXPECT_GE(told(head), heads);
    EXPECT_GE(told(axis), axes);
    EXPECT_NE(html.find(unit), std::string::npos);
    std::string text = html.substr(0, html.find("<script"));
    for (const char* tag : {"<style[^<]*</style>", "<[^>]*>"}) text = std::regex_replace(text, std::regex(tag), " ");
    std::smatch found;
    EXPECT_EQ(text.find("m^2"), std::string::npos);
    EXPECT_FALSE(std::regex_search(text, found, std::regex(R"(.{0,40}\b[0-9.]+e[-+]?[0-9]+.{0,20})"))) << found.str();
  }
}

class UnitsOfTerminal : public testing_cli::Command {
 protected:
  UnitsOfTerminal() {
    std::ofstream(directory_ / "bars.toml")
        << "[units]\nlength = \"m\"\ntime = \"s\"\nstress = \"Pa\"\nmass = \"kg\"\n"
           "[[bar]]\nlength = 1.0\ndensity = 7850.0\nmodulus = 210e9\nvelocity = 1.0\nviscosity = 2e5\n"
           "[[bar]]\nlength = 1.0\ndensity = 7850.0\nmodulus = 210e9\nvelocity = 0.0\nviscosity = 2e5\n"
           "[[joint]]\nkind = \"contact\"\ngap = 1e-4\n[time]\nend = 8e-4\n[mesh]\nelements = 40\n";
  }
  static void has(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
};

TEST_F(UnitsOfTerminal, StandBehindTheNumbersOfARunAndACheckAndJointsAreToldAsEnds) {
  const std::string run = viscobar("run bars.toml -o out").out, check = viscobar("check bars.toml").out;
  has(run, "  energy               3925 Pa m to ");
  has(run, "  joint 1              1 closing, in contact for 0.0003");
  has(run, " m in displacements up to 0.000");
  has(check,
      "bar of L = 1 m, rho = 7850 kg/m^3, E = 2.1e+11 Pa, eta = 200000 Pa s, then contact over a gap of 0.0001 m");
  has(check, " at t = 0.0001 s, speed 1 m/s");
}

TEST_F(UnitsOfTerminal, AFitHasHalfWidthsAndAsManyDigitsAsTheyLeave) {
  ASSERT_EQ(viscobar("run bars.toml -o out --quiet").code, 0);
  const auto fitted = viscobar(
      "fit bars.toml --data out/joints.csv --parameters bar.2.modulus --set bar.2.modulus=2e11 "
      "--deviation u_right:1=1e-5 -o fit");
  ASSERT_EQ(fitted.code, 0) << fitted.error;
  has(fitted.out, "half width, 95 %");
  const std::regex row(R"(bar\.2\.modulus +([0-9.]+)e\+11 Pa +([0-9.]+)e\+([0-9]+) Pa )");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(fitted.out, found, row)) << fitted.out;
  const auto digits = [](std::string number) {
    return static_cast<int>(std::erase(number, '.') == 0 ? 1 : number.size());
  };
  EXPECT_LE(digits(found[1]), 11 - std::stoi(found[3]) + 2) << "an estimate tells no more than its error leaves";
}

TEST_F(UnitsOfTerminal, StrainsThatAreNotSmallAreWarnedOf) {
  EXPECT_EQ(viscobar("check bars.toml").error, "");
  const std::string fast = "bars.toml --set bar.1.velocity=5000 ";
  has(viscobar("check " + fast).error, "warning: strains: the data make strains of about 0.");
  has(viscobar("run " + fast + "-o fast").error, "warning: strains: the data make strains of about 0.");
  EXPECT_EQ(viscobar("check " + fast + "--set units.length=").error.find("strains:"), std::string::npos);
}

}  // namespace
}  // namespace viscobar
