#include "discretisation/dense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace viscobar {

Eigen::MatrixXd inverse(const Eigen::MatrixXd& a) { return a.inverse(); }

Eigen::VectorXd definite_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return a.ldlt().solve(b); }

SingularValues singular_values(const Eigen::MatrixXd& a) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> factors(a, Eigen::ComputeFullV);
  SingularValues found{Eigen::VectorXd::Zero(a.cols()), factors.matrixV()};
  found.values.head(factors.singularValues().size()) = factors.singularValues();
  return found;
}

}  // namespace viscobar
