#pragma once

#include <string>
#include <vector>

#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/compare/compare.hpp"
#include "viscobar/studies/compare/examine.hpp"
#include "viscobar/studies/fit/fit.hpp"
#include "viscobar/studies/limit/coupling.hpp"
#include "viscobar/studies/limit/limit.hpp"
#include "viscobar/studies/orders/orders.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar {

/// A picture as a file of its own, for a paper: `name`.svg.
struct FigureFile {
  std::string name;  ///< without ending
  std::string svg;   ///< the whole file
};

/// A page that needs no other file, and each of its pictures.
struct PicturedPage {
  std::string html;                 ///< the whole file
  std::vector<FigureFile> figures;  ///< in the order of the page
};

/// All that a command prints and writes about a study.
struct StudyReport {
  std::string json;      ///< one document
  PicturedPage page;     ///< with pictures
  std::string text;      ///< for the terminal
  std::string csv = {};  ///< the rows; empty where there is no such file
};

/// Report of `viscobar compare`, of the methods that were chosen.
StudyReport compare_report(const SceneFile& scene, const MethodChoice& choice, const Comparison& check);
/// Report of `viscobar limit`, of the penalty and of the mesh with it.
StudyReport limit_report(const SceneFile& scene, const LimitStudy& study, const LimitResult& result,
                         const CouplingResult& coupling);
/// Report of `viscobar precision`.
StudyReport precision_report(const SceneFile& scene, const PrecisionStudy& study, const PrecisionResult& result);
/// Report of `viscobar fit`.
StudyReport fit_report(const SceneFile& scene, const FitStudy& study, const FitResult& result);

/// Options of the study whose limit.json this is: penalties, meshes, steps, tolerance, budget, derivatives.
/// Absent: it is another text. @throws std::invalid_argument where that is spoiled
std::optional<LimitStudy> limit_asked(const std::string& json);
/// A row of `viscobar limit` as it is made, in a sentence.
std::string limit_row_text(const LimitRow& row);

/// Tables for the terminal. A trial: each reference, the difference of the scheme to it, the contacts of both, and the
/// bounds that are exceeded.
std::string trial_text(const TrialResult& result);

/// Errors level by level with the order between two of them, and the fitted orders with their standard errors.
std::string order_text(const OrderStudy& study);

}  // namespace viscobar
