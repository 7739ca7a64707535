#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "viscobar/studies/fit/fit.hpp"

/// Random fits: does one that begins within a factor of ten of the truth find it, or say that it did not?
namespace viscobar::random_fits {

/// Fit number `index` of the campaign `seed`, the same on every machine: bars thrown at an obstacle, pulled at an end,
/// or under a load, of 12 elements, by `rigid`, a penalty, the scheme (2.8) or characteristics; one to three of
/// viscosity, modulus, gap and speed; one to four columns, without noise or with 1 %.
struct RandomFit {
  FitStudy study;
  std::vector<double> truth;
  double noise = 0.0;  ///< of the largest value of each column
  std::string words;   ///< description of the fit
};
/// Columns and their origin: any of the ends, by the model itself; or one that jumps, by eight times the elements of a
/// model of 12 to 60: forces are those of a joint between two bars. `few` are 12 to 60 samples of one that jumps, or
/// one to six contact times, by the model itself or four times its elements, of a bar that is thrown or bounces with a
/// mass. `bounces` are those of a lone mass or of a bar with one until it rests, by two or four times the elements, for
/// the restitution and at most one other value.
enum class Data { any, reactions, velocities, forces, few, bounces };
RandomFit random_fit(std::uint64_t seed, std::size_t index, Data data = Data::any);

struct Judged {
  bool found = false;      ///< S is no larger than the least of plain searches from other starts
  bool converged = false;  ///< it says that it is to be relied on
  double excess = 0.0;     ///< S over that, in variances of the noise or of 1 % of the deviations
  double off = 0.0;        ///< the largest distance of a parameter from the truth, in deviations told; see `floor`
  std::size_t runs = 0;
  std::string told;  ///< estimates with their deviations, and warnings
};

/// Compares fit() with MINPACK's Levenberg-Marquardt from the truth and from so many starts within a factor of ten of
/// it. A deviation counts as `floor` parts of the truth at least.
Judged judge(const RandomFit& fit, std::size_t starts = 20, double floor = 1e-3);
/// How far fit() is from the truth, where the data have another mesh; `found` is not asked.
Judged distance(const RandomFit& fit);

}  // namespace viscobar::random_fits
