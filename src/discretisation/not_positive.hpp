#pragma once

#include <stdexcept>

namespace viscobar {

/// A pivot of a matrix is not positive: it is not positive definite, or not all numbers.
struct NotPositive : std::domain_error {
  /// @param of_numbers see BandedMatrix::finite()
  explicit NotPositive(bool of_numbers)
      : std::domain_error("tridiagonal matrix is not positive definite"), finite(of_numbers) {}
  bool finite;  ///< all entries are numbers, an infinite one of the diagonal among them
};

}  // namespace viscobar
