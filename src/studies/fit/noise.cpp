#include "studies/fit/noise.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <map>
#include <new>
#include <vector>

namespace viscobar::fitting {

namespace {

// Residuals, in deviations that were given, or assumed to be 1 %, so large that the model is not the data's: noise of a
// tenth of the largest value is said, and not assumed.
constexpr double large_residual = 3.0, large_where_assumed = 10.0;

// True if the residual is no noise. Either it follows a curve, so that successive values are alike: squared differences
// of noise are twice its squares, to 2 / m^(1/2). Or it stands out at few places: the median of noise is two thirds of
// its root mean square. True for numbers too few to tell.
bool is_systematic(const Eigen::VectorXd& residual, Eigen::Index parameters) {
  const Eigen::Index m = residual.size();
  if (m < parameters + 8) return true;
  const double sum = residual.squaredNorm(), size = static_cast<double>(m);
  std::vector<double> sizes(residual.begin(), residual.end());
  for (double& one : sizes) one = std::abs(one);
  std::ranges::nth_element(sizes, sizes.begin() + m / 2);
  return (residual.tail(m - 1) - residual.head(m - 1)).squaredNorm() <
             std::max(1.2, 2.0 - 6.0 / std::sqrt(size)) * sum ||
         sizes[static_cast<std::size_t>(m / 2)] < 0.3 * std::sqrt(sum / size);
}

// Without promotion to long double, whose constants are made before main and end the program under valgrind.
using InDouble = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

// The bound, in deviations, that noise exceeds with this probability.
double noise_beyond(double probability) {
  return std::sqrt(2.0) * boost::math::erfc_inv(std::min(probability, 1.0), InDouble());
}

// The bound, in deviations, that the largest of so many numbers of noise exceeds once in a thousand times.
double largest_of_noise(double count) { return noise_beyond(1e-3 / count); }

// True if the model stays on one side of a trace for a stretch as noise does once in a thousand fits: the mean of L
// samples of noise has the deviation L^(-1/2). Stretches of 2, 4, ... samples, half over each other, are two for each
// sample. Noise is no smaller than the deviation given; where nobody gave it, less than one is no matter.
bool has_stretch(const FitStudy& study, const Eigen::VectorXd& residual) {
  const double bound = std::pow(largest_of_noise(2.0 * static_cast<double>(residual.size())), 2);
  Eigen::Index begin = 0;
  for (const MeasuredTrace& trace : study.traces) {
    const Eigen::Index m = std::ranges::count_if(trace.values, [](double value) { return !std::isnan(value); });
    const auto part = residual.segment(begin, m);
    const double squares = part.squaredNorm();
    begin += m;
    for (Eigen::Index length = 2; 2 * length <= m; length *= 2)
      for (Eigen::Index at = 0; at + length <= m; at += length / 2) {
        const double sum = part.segment(at, length).sum(), size = static_cast<double>(length);
        const double rest = (squares - sum * sum / size) / static_cast<double>(m - 1);
        if (sum * sum / size > bound * std::max(rest, 1.0) && (!trace.assumed || std::abs(sum) > size)) return true;
      }
  }
  return false;
}

Case model_at(const FitStudy& study, const Minimum& at) {
  return study.model({at.at.data(), static_cast<std::size_t>(at.at.size())});
}

// A finer run at the same values; not sound where there is none.
Misfit finer_misfit(const FitStudy& study, const Minimum& at) {
  try {
    return measure(study, finer(model_at(study, at)), at.compared, false, 1000 + 200 * at.misfit.steps, at.errors);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace

double students_bound(double probability, std::size_t freedom) {
  if (freedom == 0) return noise_beyond(1.0 - probability);
  using StudentsT = boost::math::students_t_distribution<double, InDouble>;
  return boost::math::quantile(StudentsT(static_cast<double>(freedom)), 0.5 + 0.5 * probability);
}

double residual_of(const Misfit& misfit, Eigen::Index parameters) {
  return std::sqrt(misfit.sum() / static_cast<double>(std::max<Eigen::Index>(misfit.freedom(parameters), 1)));
}

bool is_large(const FitStudy& study, const Misfit& misfit) {
  const Eigen::Index n = std::ssize(study.parameters);
  const double residual = residual_of(misfit, n);
  if (misfit.residual.size() >= n + 8 && has_stretch(study, misfit.residual)) return true;
  if (residual <= curved_residual) return false;
  const bool assumed = std::ranges::all_of(study.traces, &MeasuredTrace::assumed) && study.changes.empty();
  if (residual > (assumed ? large_where_assumed : large_residual)) return true;
  return misfit.residual.size() >= n + 8 || residual > large_residual ? is_systematic(misfit.residual, n) : false;
}

bool is_explained(const FitStudy& study, const Misfit& misfit) {
  const Eigen::Index n = std::ssize(study.parameters);
  if (!misfit.sound) return false;
  return (residual_of(misfit, n) <= small_residual && misfit.is_tested(n)) ||
         (!is_systematic(misfit.residual, n) && !is_large(study, misfit));
}

bool is_met_exactly(const FitStudy& study, const Minimum& exact, double noise) {
  if (!exact.misfit.sound) return false;
  const Eigen::VectorXd size = exact.misfit.residual.cwiseAbs();
  // A residual that is never large is no matter.
  const double most = std::max(largest_of_noise(static_cast<double>(size.size())) * noise, curved_residual);
  if (size.maxCoeff() <= most || exact.errors.empty()) return size.maxCoeff() <= most;
  const Misfit fine = finer_misfit(study, exact);
  return fine.sound && (size - 2.0 * (fine.residual - exact.misfit.residual).cwiseAbs()).maxCoeff() <= most;
}

Case finer(Case run) {
  run.elements *= 2;
  run.tolerance.relative = std::max(0.1 * run.tolerance.relative, 1e-13);
  if (run.tolerance.absolute) *run.tolerance.absolute *= 0.1;
  if (run.step) *run.step *= 0.5;
  return run;
}

TimeErrors time_errors(const FitStudy& study, const Minimum& at) {
  TimeErrors errors;
  const Misfit fine = finer_misfit(study, at);
  if (!fine.sound) return errors;
  const Case run = model_at(study, at);
  const double step = is_scheme(run.method) ? resolve(run).step : 0.0;
  for (const Event& change : at.misfit.changes) errors[kind_of(change)].push_back(change.time);
  std::map<Kind, std::size_t> seen;
  for (const Event& change : fine.changes)
    if (std::vector<double>& all = errors[kind_of(change)]; seen[kind_of(change)] < all.size()) {
      double& time = all[seen[kind_of(change)]++];
      time = step + 2.0 * std::abs(time - change.time);
    }
  for (auto& [kind, all] : errors) all.resize(seen[kind]);
  return errors;
}

}  // namespace viscobar::fitting
