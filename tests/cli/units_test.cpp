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
    "tolerance", "largest part", "order", "power of epsilon", "time errors are against", "left end", "right end",
    "parameter", "estimate", "half width, 95 %", "standard deviation", "solution", "quantity", "largest difference",
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
    EXPECT_FALSE(std::regex_search(text, found, std::regex(R"(.{0,40}\b[0-9.]+e[-+]?[0-9]+.{0,20})"))) << found.str();
  }
}

}  // namespace
}  // namespace viscobar
