#pragma once

#include <string>

#include "viscobar/analysis/examination.hpp"
#include "viscobar/analysis/order_study.hpp"

namespace viscobar {

/// Tables for the terminal. A trial: each referee and how far the scheme is from it, its contacts beside theirs, and
/// what exceeds the bounds.
std::string trial_text(const TrialResult& result);

/// Errors level by level with the order between two of them, and the fitted orders with their standard errors.
std::string order_text(const OrderStudy& study);

}  // namespace viscobar
