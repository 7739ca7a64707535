#pragma once

#include <Eigen/Core>

namespace viscobar {

// Dense linear algebra of small matrices by Eigen, compiled here alone: its decompositions cost the compiler seconds in
// each file that names one.

/// a^-1, by elimination with partial pivoting.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);

/// x of a x = b, where a is symmetric and positive definite but for rounding.
Eigen::VectorXd definite_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// a = U diag(values) directions^T: as many values as a has columns, falling, those beyond its rows 0.
struct SingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd directions;
};
SingularValues singular_values(const Eigen::MatrixXd& a);

}  // namespace viscobar
