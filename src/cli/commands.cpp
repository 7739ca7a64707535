#include "cli/commands.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <ranges>
#include <system_error>

#include "input/described_scene.hpp"
#include "input/input_text.hpp"
#include "input/scene_keys.hpp"
#include "report/page.hpp"
#include "text/printable_text.hpp"
#include "viscobar/results/io_error.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar::cli {

void add_set(CLI::App& command, std::vector<std::string>& overrides, const std::string& what) {
  add_repeatable(command, "--set", "TABLE.KEY=VALUE", overrides, what + " (repeatable)");
}

void add_json(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print one JSON document on standard output, and nothing else there");
}

void add_quiet(CLI::App& command, bool& quiet) { command.add_flag("-q,--quiet", quiet, "Print nothing but errors"); }

void add_figures(CLI::App& command, bool& figures) {
  command.add_flag("--figures", figures, "Also write each picture as DIR/figures/NAME.svg, for papers");
}

void add_error(CLI::App& command, std::string& error, const std::string& what) {
  add(command, "--error", "ERROR", error, what + ", such as 1e-4 or \"0.01 %\"; the same as --set accuracy.error=...");
}

void add_threads(CLI::App& command, std::size_t& threads, const std::string& what) {
  constexpr std::size_t most = 4096;
  within(add(command, "--threads", "N", threads, what), std::size_t{1}, most);
}

SceneOptions::SceneOptions(CLI::App& command) {
  add(command, "scene", "SCENE", file, "The scene file (TOML), - for standard input")->required();
  add_set(command, overrides, "Replace a value of the scene, such as contact.epsilon=1e-5");
  add_json(command, json);
}

SceneFile SceneOptions::parse(const std::vector<Setting>& settings, const Adaptation& adapt) const {
  std::vector<Setting> all(overrides.begin(), overrides.end());
  all.insert(all.end(), settings.begin(), settings.end());
  return parse_scene_with(text(), file == "-" ? "standard input" : file, all, adapt);
}

std::string SceneOptions::text() const {
  if (file != "-") return input_text(std::filesystem::path(file));
  static const std::string text = input_text(std::cin, "standard input");  // can be read once
  return text;
}

SceneFile SceneOptions::read(const std::vector<Setting>& settings, const Adaptation& adapt) const {
  SceneFile scene = parse(settings, adapt);
  const Case& run = scene.run;
  if (scene.accuracy && !takes_accuracy)
    warn(
        "[accuracy] is for run, sweep and limit: this command takes mesh, method, epsilon and tolerance as the scene has them");
  detail(fmt::format("read {}: \"{}\", {} elements, {} to t = {}", file, run.scene.title, run.elements,
                     name(run.method), run.end));
  return scene;
}

OutputOptions::OutputOptions(CLI::App& command) {
  add(command, "-o,--output", "DIR", where,
      "Directory of the results; an earlier result there is replaced when the new one is complete (default: the "
      "scene's name with \".out\", in the working directory)");
  add_quiet(command, quiet);
}

std::filesystem::path OutputOptions::directory(const std::string& file) const {
  if (!where.empty()) return where;
  return std::filesystem::path(file == "-" ? "stdin" : file).stem() += ".out";
}

StudyOptions::StudyOptions(CLI::App& command) : scene(command), output(command) { add_figures(command, figures); }

Study::Study(const StudyOptions& options, const SceneFile& scene, ResultKind kind)
    : options_(options),
      scene_(scene),
      directory_(options.output.directory(options.scene.file), kind),
      name_(std::filesystem::path(files_of(kind).summary).stem()) {
  detail("results go to " + directory_.path().string());
  if (!options.output.quiet) warn_of_other_scenes(directory_.path(), scene, kind);
}

void Study::finish(StudyReport report) const {
  StudyFiles files{options_.figures, {}};
  if (!report.csv.empty()) files.tables[name_ + ".csv"] = std::move(report.csv);
  catch_interrupts();  // one that comes now waits: the files take their places together
  const std::string written = write_study(directory_.path(), name_, report.json, std::move(report.page), files);
  if (options_.scene.json)
    print(written);
  else if (!options_.output.quiet)
    print(fmt::format("{}\n\n{}", heading(scene_.run.scene.title, options_.scene.file), report.text) +
          row("pictures", (directory_.path() / (name_ + ".html")).string()));
}

void warn_of_other_scenes(const std::filesystem::path& directory, const SceneFile& scene, ResultKind own) {
  using Json = nlohmann::ordered_json;
  for (const ResultFiles& files : result_kinds()) {
    std::ifstream stream(directory / files.summary);
    if (&files == &files_of(own) || !stream) continue;
    const Json summary = Json::parse(stream, nullptr, false);
    if (!summary.is_object() || !summary.contains("scene") || !summary["scene"].is_object()) continue;
    if (!differing_tables(complete(scene), summary["scene"]).empty())
      warn(fmt::format("{} also holds {} of another scene, \"{}\"; it stays there, and `viscobar info` tells both",
                       directory.string(), files.summary, one_line(summary["scene"].value("title", ""))));
  }
}

std::vector<Setting> finest_mesh(const std::vector<std::size_t>& elements) {
  if (elements.empty()) return {};
  return {std::pair("mesh.elements", static_cast<std::int64_t>(*std::ranges::max_element(elements)))};
}

std::string positive_number(const std::string& text) {
  double value = 0.0;
  const bool positive = CLI::detail::lexical_cast(text, value) && value > 0.0 && std::isfinite(value);
  return positive ? "" : fmt::format("\"{}\" is not a positive number", text);
}

std::string number_of_elements(const std::string& text) {
  const KeyRange range = find_scene_key("mesh.elements")->range;
  const bool whole = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
  // Not by stod, which throws where the digits are more than a double reaches.
  const double value = whole ? std::strtod(text.c_str(), nullptr) : 0.0;
  const bool fits = whole && value >= range.low && value <= range.high;
  return fits ? "" : fmt::format("\"{}\" is not a whole number {}", text, range.words);
}

std::vector<MethodName> methods_named(const std::vector<std::string>& words) {
  const auto word_of = [](MethodName method) { return name(method); };
  std::vector<MethodName> methods;
  for (const std::string& word : words) {
    const auto* found = std::ranges::find(all_methods, word, word_of);
    if (found == std::end(all_methods))
      refuse("--methods: there is no method \"{}\"{}", word,
             instead_of(word, std::views::transform(all_methods, word_of)));
    methods.push_back(*found);
  }
  return methods;
}

double DecadeRange::number(const std::string& word) const {
  char* rest = nullptr;
  const double value = std::strtod(word.c_str(), &rest);
  if (word.empty() || *rest != '\0' || !(value >= low && value <= high))
    refuse("{}: \"{}\" is not {}; write {}", option, word, expected, example);
  return value;
}

std::vector<double> DecadeRange::operator()(const std::string& text, std::size_t per_decade) const {
  const std::size_t colon = text.find(':');
  const double a = number(text.substr(0, colon));
  const double b = colon == std::string::npos ? a : number(text.substr(colon + 1));
  constexpr double most = 1000.0;  // of runs, each with its own
  const double count = std::log10(std::max(a, b) / std::min(a, b)) * static_cast<double>(per_decade);
  if (!(count < most))
    refuse("{}: \"{}\" gives {:.0f} values, at most {:.0f} are taken", option, text, std::min(count, 1e9), most);
  if (a < b) warn(fmt::format("{}: {} is taken from its larger end down", option, text));
  return decades(std::max(a, b), std::min(a, b), per_decade);
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
