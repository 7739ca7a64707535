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

/// The output of `viscobar compare` as JSON.
std::string compare_json(const SceneFile& scene, const MethodChoice& choice, const Comparison& check);
/// The same for the terminal.
std::string compare_text(const MethodChoice& choice, const Comparison& check);
/// The methods as CSV, each with its difference to the reference.
std::string compare_csv(const Comparison& check);
/// The same as a page with pictures.
PicturedPage compare_page(const Scene& scene, const MethodChoice& choice, const Comparison& check);

/// The output of `viscobar limit` as JSON.
std::string limit_json(const SceneFile& scene, const LimitStudy& study, const LimitResult& result,
                       const CouplingResult& coupling);
/// Its rows as CSV.
std::string limit_csv(const LimitResult& result);
/// Options of the study whose limit.json this is: penalties, meshes, steps, tolerance, budget, derivatives.
/// Absent: it is another text. @throws std::invalid_argument where that is spoiled
std::optional<LimitStudy> limit_asked(const std::string& json);
/// A row as it is made, in a sentence.
std::string limit_row_text(const LimitRow& row);
/// The same for the terminal.
std::string limit_text(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling);
/// The same as a page with pictures.
PicturedPage limit_page(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling);

/// The output of `viscobar precision` as JSON.
std::string precision_json(const SceneFile& scene, const PrecisionStudy& study, const PrecisionResult& result);
/// The same for the terminal.
std::string precision_text(const PrecisionStudy& study, const PrecisionResult& result);
/// Its rows as CSV.
std::string precision_csv(const PrecisionResult& result);
/// The same as a page with pictures.
PicturedPage precision_page(const PrecisionStudy& study, const PrecisionResult& result);

/// The output of `viscobar fit` as JSON.
std::string fit_json(const SceneFile& scene, const FitStudy& study, const FitResult& result);
/// The same for the terminal.
std::string fit_text(const SceneFile& scene, const FitStudy& study, const FitResult& result);
/// The same as a page with pictures.
PicturedPage fit_page(const SceneFile& scene, const FitStudy& study, const FitResult& result);

/// Tables for the terminal. A trial: each reference, the difference of the scheme to it, the contacts of both, and the
/// bounds that are exceeded.
std::string trial_text(const TrialResult& result);

/// Errors level by level with the order between two of them, and the fitted orders with their standard errors.
std::string order_text(const OrderStudy& study);

}  // namespace viscobar
