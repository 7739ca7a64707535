#pragma once

#include <Eigen/Core>
#include <complex>

namespace viscobar::testing_support {

// Eigen's decompositions by the names of their outcomes, compiled here alone: they cost the compiler up to half a
// minute in each file that names one.
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

LongMatrix inverse(const LongMatrix& a);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);

/// a^-1 b.
LongMatrix quotient(const LongMatrix& a, const LongMatrix& b);

Eigen::Matrix<std::complex<long double>, Eigen::Dynamic, 1> eigenvalues(const LongMatrix& a);

/// T of a = U T U^T, triangular but for blocks of two rows, where a pair of eigenvalues is complex.
LongMatrix schur_form(const LongMatrix& a);

/// stiffness vectors = inertia vectors diag(values), where vectors^T inertia vectors is the identity.
struct Modes {
  LongVector values;
  LongMatrix vectors;
};
Modes modes(const LongMatrix& stiffness, const LongMatrix& inertia);

}  // namespace viscobar::testing_support
