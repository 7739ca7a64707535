#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

using MatrixXd = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;  // gcc 12 warns inside AVX-512's header

inline MatrixXd dense(const BandedMatrix& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.size());
  MatrixXd full(n, n);
  std::vector<double> unit(matrix.size()), column(matrix.size());
  for (Eigen::Index j = 0; j < n; ++j) {
    std::ranges::fill(unit, 0.0);
    unit[static_cast<std::size_t>(j)] = 1.0;
    matrix.multiply(unit, column);
    for (Eigen::Index i = 0; i < n; ++i) full(i, j) = column[static_cast<std::size_t>(i)];
  }
  return full;
}

}  // namespace viscobar
