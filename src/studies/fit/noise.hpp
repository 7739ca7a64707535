#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "studies/fit/search.hpp"

namespace viscobar::fitting {

/// A residual, in deviations, so small that no other minimum is of interest: values that are right to a tolerance of
/// 1e-6 leave a tenth of it of a deviation of 1 %.
inline constexpr double small_residual = 0.001;

/// A residual, in deviations, so large where it follows a curve that the model is not the data's.
inline constexpr double curved_residual = 1.2;

/// Within so many standard deviations is a value with this probability: by Student's t, or the normal distribution
/// where the freedom is 0.
double students_bound(double probability, std::size_t freedom);

/// (S / (m - n))^(1/2), m numbers measured and n parameters; S^(1/2) where m is n or less.
double residual_of(const Misfit& misfit, Eigen::Index parameters);
/// True if the residual is so large that the model is not the data's.
bool is_large(const FitStudy& study, const Misfit& misfit);
/// True if the residual is noise, or too small to be of interest.
bool is_explained(const FitStudy& study, const Misfit& misfit);
/// True if none of the samples as they are stands out of this noise, but for what a finer run changes it by where the
/// minimum has errors of times.
bool is_met_exactly(const FitStudy& study, const Minimum& exact, double noise);

/// The same case with half of the errors of its mesh, its steps and its tolerances, or less.
Case finer(Case run);
/// Twice what a finer run changes the times of contact changes by, and a scheme's step. Empty where there is no such
/// run.
TimeErrors time_errors(const FitStudy& study, const Minimum& at);

}  // namespace viscobar::fitting
