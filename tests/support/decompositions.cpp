#include "support/decompositions.hpp"

#include <Eigen/Dense>

namespace viscobar::testing_support {

LongMatrix inverse(const LongMatrix& a) { return a.inverse(); }

Eigen::MatrixXd inverse(const Eigen::MatrixXd& a) { return a.inverse(); }

LongMatrix quotient(const LongMatrix& a, const LongMatrix& b) { return a.partialPivLu().solve(b); }

Eigen::Matrix<std::complex<long double>, Eigen::Dynamic, 1> eigenvalues(const LongMatrix& a) { return a.eigenvalues(); }

LongMatrix schur_form(const LongMatrix& a) { return Eigen::RealSchur<LongMatrix>(a, false).matrixT(); }

Modes modes(const LongMatrix& stiffness, const LongMatrix& inertia) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<LongMatrix> solver(stiffness, inertia);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace viscobar::testing_support
