#include "cli/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "cli/messages.hpp"
#include "input/input_text.hpp"
#include "input/scene_keys.hpp"
#include "report/page.hpp"
#include "results/result_directory.hpp"
#include "text/printable_text.hpp"
#include "viscobar/results/io_error.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar::cli {

SceneOptions::SceneOptions(CLI::App& command) {
  command.add_option("scene", file, "The scene file (TOML), - for standard input")->required()->type_name("SCENE");
  command.add_option("--set", overrides, "Replace a value of the scene, such as contact.epsilon=1e-5 (repeatable)")
      ->type_name("TABLE.KEY=VALUE")
      ->allow_extra_args(false);
  add_json(command, json);
}

SceneFile SceneOptions::read(const std::vector<std::string>& defaults, const std::vector<std::string>& settings,
                             const Adaptation& adapt) const {
  std::vector<std::string> all = defaults;
  all.insert(all.end(), overrides.begin(), overrides.end());
  all.insert(all.end(), settings.begin(), settings.end());
  SceneFile scene = from_standard_input()
                        ? parse_scene(input_text(std::cin, "standard input"), "standard input", all, adapt)
                        : read_scene(file, all, adapt);
  const Case& run = scene.run;
  if (scene.accuracy && !takes_accuracy)
    warn(
        "[accuracy] is for run, sweep and limit: this command takes mesh, method, epsilon and tolerance as the scene has them");
  detail(fmt::format("read {}: \"{}\", {} elements, {} to t = {}", file, run.scene.title, run.elements,
                     name(run.method), run.end));
  return scene;
}

OutputOptions::OutputOptions(CLI::App& command) {
  command
      .add_option(
          "-o,--output", where,
          "Directory of the results; an earlier result there is replaced when the new one is complete (default: the "
          "scene's name with \".out\", in the working directory)")
      ->type_name("DIR");
  add_quiet(command, quiet);
}

std::filesystem::path OutputOptions::directory(const SceneOptions& scene) const {
  const std::filesystem::path name = scene.from_standard_input() ? "stdin" : std::filesystem::path(scene.file).stem();
  const std::filesystem::path chosen =
      where.empty() ? std::filesystem::path(name) += ".out" : std::filesystem::path(where);
  detail("results go to " + chosen.string());
  return chosen;
}

void warn_of_other_scenes(const std::filesystem::path& directory, const SceneFile& scene, std::string_view own) {
  using Json = nlohmann::json;
  const Json ours = Json::parse(scene.complete());
  for (const char* name : json_summaries) {
    std::ifstream stream(directory / name);
    if (name == own || !stream) continue;
    const Json summary = Json::parse(stream, nullptr, false);
    if (!summary.is_object() || !summary.contains("scene") || !summary["scene"].is_object()) continue;
    const Json& theirs = summary["scene"];
    const auto differs = [&](const char* table) {
      return ours.value(table, Json::object()) != theirs.value(table, Json::object());
    };
    constexpr const char* problem[] = {"bar", "left", "right", "span", "initial", "load"};
    if (std::ranges::any_of(problem, differs))
      warn(fmt::format("{} also holds {} of another scene, \"{}\"; it stays there, and `viscobar info` tells both",
                       directory.string(), name, one_line(theirs.value("title", ""))));
  }
}

PictureOptions::PictureOptions(CLI::App& command) : OutputOptions(command) { add_figures(command, figures); }

void add_figures(CLI::App& command, bool& figures) {
  command.add_flag("--figures", figures, "Also write each picture as DIR/figures/NAME.svg, for papers");
}

void add_json(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print one JSON document on standard output, and nothing else there");
}

void add_quiet(CLI::App& command, bool& quiet) { command.add_flag("-q,--quiet", quiet, "Print nothing but errors"); }

std::string sensitivities_of(const std::vector<std::string>& keys) {
  return fmt::format("sensitivity.of=['{}']", fmt::join(keys, "', '"));
}

void finish_study(const std::string& name, const std::filesystem::path& directory, const SceneOptions& asked,
                  const PictureOptions& output, const SceneFile& scene, const std::string& json, PicturedPage page,
                  const std::string& text) {
  const std::string written = write_study(directory, name, json, std::move(page), output.figures);
  if (asked.json)
    print(written);
  else if (!output.quiet)
    print(fmt::format("{}\n\n{}", heading(scene.run.scene.title, asked.file), text) +
          row("pictures", (directory / (name + ".html")).string()));
}

const CLI::Validator& positive_number() {
  static const CLI::Validator validator(
      [](std::string& text) {
        double value = 0.0;
        const bool positive = CLI::detail::lexical_cast(text, value) && value > 0.0 && std::isfinite(value);
        return positive ? "" : fmt::format("\"{}\" is not a positive number", text);
      },
      "");
  return validator;
}

const CLI::Validator& number_of_elements() {
  static const CLI::Validator validator(
      [](std::string& text) {
        const Range range = find_scene_key("mesh.elements")->range;
        const bool whole = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
        // Not by stod, which throws where the digits are more than a double reaches.
        const double value = whole ? std::strtod(text.c_str(), nullptr) : 0.0;
        return whole && value >= range.low && value <= range.high
                   ? ""
                   : fmt::format("\"{}\" is not a whole number {}", text, range.words);
      },
      "");
  return validator;
}

std::vector<MethodName> methods_named(const std::vector<std::string>& words) {
  std::vector<std::string_view> known;
  for (const MethodName method : all_methods) known.push_back(name(method));
  std::vector<MethodName> methods;
  for (const std::string& word : words) {
    const auto found = std::ranges::find(known, word);
    if (found == known.end())
      throw std::invalid_argument(fmt::format("--methods: there is no method \"{}\"{}", word, instead_of(word, known)));
    methods.push_back(all_methods[found - known.begin()]);
  }
  return methods;
}

double DecadeRange::number(const std::string& word) const {
  std::size_t read = 0;
  double value = 0.0;
  try {
    value = std::stod(word, &read);
  } catch (const std::logic_error&) {
    read = 0;
  }
  if (read == 0 || read != word.size() || !(value >= low && value <= high))
    throw std::invalid_argument(fmt::format("{}: \"{}\" is not {}; write {}", option, word, expected, example));
  return value;
}

std::vector<double> DecadeRange::operator()(const std::string& text, std::size_t per_decade) const {
  const std::size_t colon = text.find(':');
  const double a = number(text.substr(0, colon));
  const double b = colon == std::string::npos ? a : number(text.substr(colon + 1));
  constexpr double most = 1000.0;  // of runs, each with its own
  const double count = std::log10(std::max(a, b) / std::min(a, b)) * static_cast<double>(per_decade);
  if (!(count < most))
    throw std::invalid_argument(fmt::format("{}: \"{}\" gives {:.0f} values, at most {:.0f} are taken", option, text,
                                            std::min(count, 1e9), most));
  return decades(std::max(a, b), std::min(a, b), per_decade);
}

void add_threads(CLI::App& command, std::size_t& threads, const std::string& what) {
  constexpr std::size_t most = 4096;
  command.add_option("--threads", threads, what + " (default: one a core)")
      ->type_name("N")
      ->check(CLI::Range(std::size_t{1}, most));
}

void print(std::string_view text) {
  const std::string shown = printable(text);
  if (std::fwrite(shown.data(), 1, shown.size(), stdout) == shown.size() && std::fflush(stdout) == 0) return;
  // A reader that has seen enough, such as head, ends the program as it would any other.
  if (errno == EPIPE) std::signal(SIGPIPE, SIG_DFL), std::raise(SIGPIPE);
  throw IoError("standard output", "cannot be written: " + std::generic_category().message(errno));
}

std::string row(std::string_view name, std::string_view value) {
  return fmt::format("  {:<20} {}\n", name, one_line(value));
}

std::string heading(const std::string& title, const std::string& otherwise) {
  return one_line(title.empty() ? otherwise : title);
}

}  // namespace viscobar::cli
