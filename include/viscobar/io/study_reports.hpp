#pragma once

#include <string>

#include "viscobar/analysis/coupling.hpp"
#include "viscobar/analysis/cross_check.hpp"
#include "viscobar/analysis/penalty_limit.hpp"
#include "viscobar/analysis/work_precision.hpp"
#include "viscobar/io/pictured_page.hpp"
#include "viscobar/io/scene_file.hpp"

namespace viscobar {

/// What `viscobar compare` tells, as JSON.
std::string cross_check_json(const SceneFile& scene, const MethodChoice& choice, const CrossCheck& check);
/// The same for the terminal.
std::string cross_check_text(const MethodChoice& choice, const CrossCheck& check);
/// The same as a page with pictures.
PicturedPage cross_check_page(const Scene& scene, const MethodChoice& choice, const CrossCheck& check);

/// What `viscobar limit` tells, as JSON.
std::string limit_json(const SceneFile& scene, const LimitStudy& study, const LimitResult& result,
                       const CouplingResult& coupling);
/// The same for the terminal.
std::string limit_text(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling);
/// The same as a page with pictures.
PicturedPage limit_page(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling);

/// What `viscobar precision` tells, as JSON.
std::string precision_json(const SceneFile& scene, const PrecisionStudy& study, const PrecisionResult& result);
/// The same for the terminal.
std::string precision_text(const PrecisionStudy& study, const PrecisionResult& result);
/// The same as a page with pictures.
PicturedPage precision_page(const PrecisionStudy& study, const PrecisionResult& result);

}  // namespace viscobar
