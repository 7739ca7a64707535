#include "report/judge/judge_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "input/scene_keys.hpp"
#include "report/measured.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

// A step behind the last =, unless a file has that name.
std::pair<std::string, std::optional<double>> file_and_step(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == text.npos || std::filesystem::exists(text)) return {text, std::nullopt};
  const auto step = number_in<double>(std::string_view(text).substr(equals + 1));
  if (!step || !(*step > 0.0 && std::isfinite(*step)))
    throw std::invalid_argument(fmt::format("--with: \"{}\" has no positive step behind =", text));
  return {text.substr(0, equals), step};
}

}  // namespace

std::vector<Setting> of_the_bar_itself() {
  std::vector<Setting> settings;
  for (const SceneKey& key : scene_keys())
    if (key.table() == "mesh" || key.table() == "method" || key.name == "contact.epsilon" || key.name == "accuracy.of")
      settings.emplace_back(fmt::format("{}=", key.name));
  settings.emplace_back("accuracy.error=0.1 %");
  return settings;
}

PreparedJudgement prepared_judgement(const std::vector<std::vector<std::string>>& schemes, SceneFile scene) {
  PreparedJudgement prepared{std::move(scene), {}, {}, {}};
  JudgeStudy& study = prepared.study;
  study.scene = prepared.scene.run;
  study.request = *prepared.scene.accuracy;
  std::vector<std::string> names = names_of_traces();
  names.insert(names.end(), {"where", "change"});
  for (std::size_t scheme = 0; scheme < schemes.size(); ++scheme)
    for (const std::string& text : schemes[scheme]) {
      const auto [file, step] = file_and_step(text);
      const TraceFile table = read_measured(prepared.scene, file, names, {"t"}, {"where", "change"});
      prepared.understood.push_back(table.understood);
      prepared.warnings.insert(prepared.warnings.end(), table.warnings.begin(), table.warnings.end());
      std::vector<TheirSolution>& all = study.solutions;
      const bool where = table.column("where"), change = table.column("change"), tells_changes = where || change;
      if (tells_changes && !(where && change && table.columns.size() == 3))
        throw std::invalid_argument(
            file + ": has some columns of events.csv: contact changes are t, where and change, in a file of their own");
      if (!tells_changes || all.empty() || all.back().scheme != scheme || all.back().changes)
        all.push_back({file, {}, {}, step, {}, scheme});
      else if (step)
        throw std::invalid_argument("--with: contact changes have the step of the file before them: " + text);
      TheirSolution& theirs = all.back();
      if (tells_changes) {
        theirs.changes = changes_in(table, file);
        continue;
      }
      theirs.times = table.column("t")->values;
      for (const TraceFile::Column& column : table.columns)
        if (column.name != "t") theirs.columns.push_back({column.name, column.values});
    }
  return prepared;
}

}  // namespace viscobar
