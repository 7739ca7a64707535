#include "report/judge/judge_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "input/scene_keys.hpp"
#include "report/measured.hpp"
#include "scene/unit_names.hpp"
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

PreparedJudgement prepared_judgement(const std::vector<std::string>& files, SceneFile scene) {
  PreparedJudgement prepared{std::move(scene), {}, {}, {}};
  JudgeStudy& study = prepared.study;
  study.scene = prepared.scene.run;
  study.request = *prepared.scene.accuracy;
  for (const std::string& text : files) {
    const auto [file, step] = file_and_step(text);
    TraceFile table = read_measured(prepared.scene, file, names_of_traces(), {"t"});
    TheirSolution& theirs = study.solutions.emplace_back();
    theirs.label = file;
    theirs.step = step;
    theirs.times = table.column("t")->values;
    for (TraceFile::Column& column : table.columns) {
      if (column.name == "t") continue;
      if (const auto known = trace_column(column.name))
        convert(table, column, unit_of(known->first, prepared.scene.run.scene.units), file);
      theirs.columns.push_back({column.name, column.values});
    }
    prepared.understood.push_back(table.understood);
    prepared.doubts.insert(prepared.doubts.end(), table.doubts.begin(), table.doubts.end());
  }
  return prepared;
}

}  // namespace viscobar
