#pragma once

#include <string>
#include <vector>

#include "viscobar/report/reports.hpp"
#include "viscobar/studies/judge/judge.hpp"

namespace viscobar {

/// A scene as the bar itself has it, and the study of solutions of it.
struct PreparedJudgement {
  SceneFile scene;
  JudgeStudy study;
  std::vector<std::string> understood;  ///< how the files were read, a line each
  std::vector<std::string> warnings;    ///< values that were left out as codes, in sentences
};

/// Settings that leave to us what a scene says of its own solution: method, mesh, epsilon, step and tolerances.
std::vector<Setting> of_the_bar_itself();

/// Reads the files of each scheme, of the form of ends.csv and gauges.csv, each "FILE" or "FILE=STEP" with its step.
/// One of the form of events.csv has the contact changes of the file before it; at the beginning it is a solution
/// itself.
/// @throws SceneError, std::invalid_argument
PreparedJudgement prepared_judgement(const std::vector<std::vector<std::string>>& schemes, SceneFile scene);

StudyReport judge_report(const PreparedJudgement& asked, const JudgeResult& judgement);

}  // namespace viscobar
