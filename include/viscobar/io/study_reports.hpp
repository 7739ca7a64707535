#pragma once

#include <string>

#include "viscobar/analysis/coupling.hpp"
#include "viscobar/analysis/cross_check.hpp"
#include "viscobar/analysis/penalty_limit.hpp"
#include "viscobar/analysis/work_precision.hpp"
#include "viscobar/io/pictured_page.hpp"
#include "viscobar/io/scene_file.hpp"

namespace viscobar {

/// What `viscobar compare` tells: as JSON, for the terminal, and as a page with pictures.
std::string cross_check_json(const SceneFile& scene, const MethodChoice& choice, const CrossCheck& check);
std::string cross_check_text(const MethodChoice& choice, const CrossCheck& check);
PicturedPage cross_check_page(const Scene& scene, const MethodChoice& choice, const CrossCheck& check);

/// Likewise of `viscobar limit`.
std::string limit_json(const SceneFile& scene, const LimitStudy& study, const LimitResult& result,
                       const CouplingResult& coupling);
std::string limit_text(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling);
PicturedPage limit_page(const LimitStudy& study, const LimitResult& result, const CouplingResult& coupling);

/// Likewise of `viscobar precision`.
std::string precision_json(const SceneFile& scene, const PrecisionStudy& study, const PrecisionResult& result);
std::string precision_text(const PrecisionStudy& study, const PrecisionResult& result);
PicturedPage precision_page(const PrecisionStudy& study, const PrecisionResult& result);

}  // namespace viscobar
