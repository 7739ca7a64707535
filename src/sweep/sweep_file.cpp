#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "case/run_cost.hpp"
#include "input/described_scene.hpp"
#include "input/input_text.hpp"
#include "input/scene_entries.hpp"
#include "input/scene_values.hpp"
#include "studies/parallel.hpp"
#include "sweep/sweep_bars.hpp"
#include "sweep/varied_values.hpp"
#include "text/nearest_name.hpp"
#include "text/printable_text.hpp"
#include "viscobar/results/versions.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

namespace {

constexpr double most_cases = 1e7;

class SweepReader {
 public:
  SweepReader(const std::filesystem::path& file, std::span<const std::string> overrides)
      : file_(file), source_(file.string()), overrides_(overrides.begin(), overrides.end()) {}

  SweepFile read(const std::string& text) {
    TomlNode root;
    try {
      root = parse_toml(text);
    } catch (const TextError& error) {
      report("", error.at, error.what());
      throw SceneError(std::move(found_));
    }
    end_ = position_in(text, text.size());
    if (const TomlNode* bar = entry_of(root, "bar"); bar && !entry_of(root, "vary")) {
      report("", bar->key_at, "this is a scene; a sweep names one, scene = \"...\", and has a table [vary]");
      throw SceneError(std::move(found_));
    }
    const auto is_table = [](const TomlNode& entry) { return entry.kind == TomlNode::Kind::table; };
    for (const TomlNode& entry : root.inside)
      if (!is_table(entry)) top_level(entry);
    find_parameters(root);
    for (const TomlNode& entry : root.inside)
      if (is_table(entry)) top_level(entry);
    if (!has("scene")) report("scene", end_, "is missing: the scene file, relative to this one");
    if (!has("vary")) report("vary", end_, "is missing: a table [vary] with a list or a range for each varied key");
    check_command_line();
    check_sizes();
    if (!found_.empty()) {
      std::ranges::stable_sort(found_, {}, [](const Diagnostic& one) { return std::pair(one.line, one.column); });
      throw SceneError(std::move(found_));
    }
    sweep_.settings.insert(sweep_.settings.end(), overrides_.begin(), overrides_.end());
    heed_scene(sweep_);
    if (!sweep_.ensemble.outputs.empty()) {
      for (const auto& [key, message] : plan_bars(sweep_)) {
        const auto place = sweep_.places.find(key);
        report(key, place == sweep_.places.end() ? ensemble_ : TextPosition{place->second.line, place->second.column},
               message);
      }
      if (!found_.empty()) throw SceneError(std::move(found_));
    }
    return std::move(sweep_);
  }

 private:
  bool has(const std::string& key) const { return seen_.contains(key); }

  void report(const std::string& key, TextPosition at, const std::string& message) {
    found_.push_back({source_, at.line, at.column, one_line(key), one_line(message)});
  }

  void top_level(const TomlNode& entry) {
    static constexpr std::string_view known[] = {"title", "scene", "combine", "set", "vary", "ensemble"};
    std::string key = entry.key;
    if (std::ranges::find(known, key) == std::end(known)) {
      if (is_scene_table(key))
        return report(key, entry.key_at, "belongs to the scene; its keys are given in [set] or [vary]");
      report(key, entry.key_at, "unknown key; " + instead_of(key, known));
      const auto nearest = nearest_name(key, known);
      if (!nearest || has(std::string(*nearest))) return;
      key = *nearest;  // so that its value is checked, and does not count as missing
    }
    seen_.insert(key);
    if (key == "vary" || key == "set" || key == "ensemble") {
      if (entry.kind != TomlNode::Kind::table)
        return report(key, entry.value_at, fmt::format("must be a table, written [{}]", key));
      if (key == "ensemble") return ensemble(entry);
      for (const TomlNode& inside : entry.inside) scene_key(inside, "", key == "vary");
      if (key == "vary" && entry.inside.empty()) report(key, entry.value_at, "is empty: nothing varies");
      return;
    }
    const auto* text = std::get_if<std::string>(&entry.value);
    if (!text) return report(key, entry.value_at, fmt::format("must be a string, is {}", kind_of(entry.value)));
    if (key == "title") sweep_.title = *text;
    if (key == "combine") combine(*text, entry.value_at);
    if (key == "scene") scene(*text, entry.value_at);
  }

  void ensemble(const TomlNode& table) {
    static constexpr std::string_view known[] = {"outputs", "error"};
    ensemble_ = table.key_at;
    for (const TomlNode& entry : table.inside) {
      const std::string key = "ensemble." + entry.key;
      if (entry.key == "outputs") {
        for (const TomlNode& one : entry.inside)
          if (const auto* text = std::get_if<std::string>(&one.value))
            sweep_.ensemble.outputs.push_back(*text);
          else
            report(key, one.value_at, fmt::format("holds texts, as \"impulse_left\"; this is {}", kind_of(one.value)));
        if (entry.kind != TomlNode::Kind::array || entry.inside.empty())
          report(key, entry.value_at, "must be a list of outputs, as [\"impulse_left\", \"u_left@0.5\"]");
      } else if (entry.key == "error") {
        const auto* number = std::get_if<double>(&entry.value);
        if (number && *number > 0.0 && *number < 1.0)
          sweep_.ensemble.error = *number;
        else
          report(key, entry.value_at, "must be a share between 0 and 1, as 1e-3");
      } else {
        report(key, entry.key_at, "unknown key; " + instead_of(entry.key, known));
      }
    }
    if (!entry_of(table, "outputs"))
      report("ensemble.outputs", table.key_at, "is missing: a list of what each bar tells, as [\"impulse_left\"]");
  }

  void combine(const std::string& word, TextPosition at) {
    static constexpr std::string_view known[] = {"grid", "zip"};
    if (word == "zip") sweep_.plan.combine = Combine::zip;
    if (std::ranges::find(known, word) == std::end(known))
      report("combine", at, fmt::format("cannot be \"{}\"; {}", word, instead_of(word, known)));
  }

  void scene(const std::string& name, TextPosition at) {
    const std::filesystem::path path = (file_.parent_path() / name).lexically_normal();
    sweep_.scene_source = path.string();
    try {
      sweep_.scene_text = input_text(path);
    } catch (const SceneError& error) {
      report("scene", at, fmt::format("\"{}\" {}", name, error.diagnostics.front().message));
    }
  }

  // Formulas in [set] and [vary] may use those of the scene, and those that are given there themselves.
  void find_parameters(const TomlNode& root) {
    const std::vector<Setting> settings(overrides_.begin(), overrides_.end());
    parameters_ = SceneEntries(sweep_.scene_text, sweep_.scene_source, settings).parameters();
    for (const char* table : {"set", "vary"})
      if (const TomlNode* node = entry_of(root, table))
        for (const TomlNode& inside : node->inside) {
          if (is_parameter(inside.key)) parameters_.emplace(parameter_name(inside.key), 1.0);
          if (inside.key == "parameters")
            for (const TomlNode& one : inside.inside) parameters_.emplace(one.key, 1.0);
        }
  }

  // "table.key" may be one quoted name, or two with a dot, or a table of its own.
  void scene_key(const TomlNode& node, const std::string& before, bool varied) {
    const std::string name = before.empty() ? node.key : before + "." + node.key;
    const std::string_view table = table_of(name);
    const SceneKey* key = find_scene_key(name);
    if (!key && node.kind == TomlNode::Kind::table &&
        (table.empty() || is_member_table(name) || is_inner_table(name))) {
      for (const TomlNode& inside : node.inside) scene_key(inside, name, varied);
      return;
    }
    if (!key)
      return report(name, node.key_at,
                    table.empty() ? unknown_key("", name) : unknown_key(table, name.substr(table.size() + 1)));
    SceneKey named = *key;
    named.name = name;  // of a parameter its own
    const Diagnostic place{source_, node.value_at.line, node.value_at.column, name, ""};
    if (!sweep_.places.try_emplace(name, place).second)
      return report(name, node.key_at, "is given twice: in [set], or in [vary]");
    if (!varied) return setting(named, node);
    const std::size_t before_count = found_.size();
    sweep_.plan.keys.push_back(varied_key(
        named, node, parameters_, [&](TextPosition at, const std::string& message) { report(name, at, message); }));
    if (found_.size() != before_count) faulty_ = true;
  }

  void setting(const SceneKey& key, const TomlNode& node) {
    if (const auto* series = std::get_if<SceneTable>(&node.value); series && takes(key.type, node.value)) {
      sweep_.settings.push_back(std::pair(std::string(key.name), SceneValue(*series)));
      return;
    }
    const bool is_list = key.type == KeyType::list || key.type == KeyType::numbers;
    const std::string problem = node.kind == TomlNode::Kind::plain || is_list
                                    ? problem_with(key, node.value, parameters_)
                                    : fmt::format("must be one value, is {}", kind_of(node.value));
    if (!problem.empty()) return report(std::string(key.name), node.value_at, problem);
    if (is_list)
      return sweep_.settings.push_back(std::pair(
          std::string(key.name), key.type == KeyType::list ? SceneValue(std::get<std::vector<std::string>>(node.value))
                                                           : SceneValue(*numbers_of(node.value))));
    TomlNode list;
    list.kind = TomlNode::Kind::array;
    list.inside = {node};
    const SweepPlan one{{varied_key(key, list, parameters_, [](TextPosition, const std::string&) {})}, Combine::grid};
    sweep_.settings.push_back(one.settings(0).front());
  }

  void report_at(const std::string& key, const std::string& message) {
    const Diagnostic& at = sweep_.places.at(key);
    report(key, {at.line, at.column}, message);
  }

  void check_command_line() {
    for (const std::string& text : overrides_) {
      std::string name = text.substr(0, text.find('='));
      std::erase(name, ' ');
      if (std::ranges::find(sweep_.plan.keys, name, &VariedKey::key) != sweep_.plan.keys.end())
        report_at(name, "varies, so --set cannot give it one value");
    }
  }

  void check_sizes() {
    const std::vector<VariedKey>& keys = sweep_.plan.keys;
    if (faulty_ || keys.empty()) return;
    if (sweep_.plan.combine == Combine::zip) {
      for (const VariedKey& key : keys)
        if (key.size() != keys.front().size())
          report_at(key.key, fmt::format("has {} values where {} has {}: zipped keys have the same number", key.size(),
                                         keys.front().key, keys.front().size()));
      return;
    }
    double cases = 1.0;
    for (const VariedKey& key : keys) cases *= static_cast<double>(key.size());
    if (cases > most_cases) report("vary", end_, fmt::format("the grid has {} cases, more than {}", cases, most_cases));
  }

  std::filesystem::path file_;
  std::string source_;
  std::vector<std::string> overrides_;
  SweepFile sweep_;
  Parameters parameters_;
  TextPosition end_, ensemble_;
  std::set<std::string> seen_;
  bool faulty_ = false;
  std::vector<Diagnostic> found_;
};

// A case is read on a coarse mesh: its initial data are then checked at a few nodes, by the worker at all, and a sweep
// of large bars is planned as fast as one of small ones. What the coarse mesh refuses, its own may take: a short bar of
// a chain, a section that varies fast. @throws SceneError
double cost_of(const std::string& scene_text, const std::string& source, const SweepCase& one) {
  constexpr std::size_t coarse = 32;
  std::size_t elements = 0;
  const auto coarsen = [&](Case& read) {
    elements = read.elements;
    read.elements = std::min(read.elements, coarse);
  };
  Case run;
  try {
    run = parse_scene_with(scene_text, source, one.settings, coarsen, Telling::nothing).run;
    run.elements = elements;
  } catch (const SceneError&) {
    if (elements <= coarse) throw;
    run = parse_scene_with(scene_text, source, one.settings, {}, Telling::nothing).run;
  }
  return estimated_seconds(resolve(std::move(run)));
}

}  // namespace

std::string SweepFile::identity() const {
  std::string text = fmt::format("viscobar {}\n", versions().viscobar);
  for (const Setting& setting : settings) text += fmt::format("{}\n", text_of(setting));
  for (const std::string& output : ensemble.outputs) text += fmt::format("output {}\n", output);
  if (ensemble.error) text += fmt::format("error {}\n", *ensemble.error);
  text += plan.combine == Combine::zip ? "zip\n" : "grid\n";
  for (const VariedKey& key : plan.keys) {
    text += key.key + ":";
    for (std::size_t k = 0; k < key.size(); ++k)
      std::visit([&](const auto& list) { text += fmt::format(" {},", list[k]); }, key.values);
    text += "\n";
  }
  return text + scene_text;
}

SweepFile read_sweep(const std::filesystem::path& file, std::span<const std::string> overrides) {
  return parse_sweep(input_text(file), file, overrides);
}

SweepFile parse_sweep(const std::string& text, const std::filesystem::path& file,
                      std::span<const std::string> overrides) {
  return SweepReader(file, overrides).read(text);
}

void heed_scene(SweepFile& sweep) {
  const SceneEntries entries(sweep.scene_text, sweep.scene_source, sweep.settings);
  sweep.plan.sensitivities = entries.list("sensitivity.of");
  sweep.plan.joints = std::max<std::size_t>(entries.members("bar"), 1) - 1;
  sweep.units = entries.units();
  // Workers do not know where the scene lies, and read its measured series as they are now.
  for (const std::string& key : entries.series_keys()) sweep.settings.push_back(std::pair(key, entries.described(key)));
  sweep.plan.accuracy = entries.present("accuracy.error") ||
                        std::ranges::find(sweep.plan.keys, "accuracy.error", &VariedKey::key) != sweep.plan.keys.end();
}

SweepCase case_of(const SweepFile& sweep, std::size_t index) {
  SweepCase one{index, sweep.settings};
  std::ranges::move(sweep.plan.settings(index), std::back_inserter(one.settings));
  return one;
}

std::vector<double> plan_cases(const SweepFile& sweep, std::size_t threads, const SweepPart& part) {
  std::vector<double> costs(sweep.plan.size(), 0.0);
  const std::vector<bool> own = part.own(costs.size());
  std::vector<std::size_t> cases;
  // Bars side by side cost alike; one that cannot be run costs nothing.
  if (!sweep.ensemble.outputs.empty()) return std::vector<double>(costs.size(), 1.0);
  for (std::size_t i = 0; i < costs.size(); ++i)
    if (own[i]) cases.push_back(i);
  std::vector<std::vector<Diagnostic>> refused(cases.size());
  parallel_for(
      cases.size(),
      [&](std::size_t k) {
        const std::size_t i = cases[k];
        try {
          costs[i] = cost_of(sweep.scene_text, sweep.scene_source, case_of(sweep, i));
        } catch (const SceneError& error) {
          refused[k] = error.diagnostics;
        }
      },
      threads);
  const bool whole = part.of == 1;
  if (!whole || std::ranges::any_of(refused, [](const auto& list) { return list.empty(); })) return costs;

  // No case can run: the input is wrong as a whole. What an override brought in stands in the sweep file.
  std::vector<Diagnostic> all;
  std::set<std::string> texts;
  for (const auto& list : refused)
    for (Diagnostic found : list) {
      if (const auto place = sweep.places.find(found.key); found.source == "--set" && place != sweep.places.end()) {
        const std::string message = std::exchange(found, place->second).message;
        found.message = message;
      }
      if (texts.insert(found.text()).second) all.push_back(found);
    }
  throw SceneError(std::move(all));
}

}  // namespace viscobar
