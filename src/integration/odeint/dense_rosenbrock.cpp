#include "integration/odeint/dense_rosenbrock.hpp"

#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/matrix_proxy.hpp>
#include <boost/numeric/ublas/vector.hpp>
#include <utility>

namespace viscobar {

using Vector = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;

struct DenseRosenbrock::Dense {
  std::size_t size;  // of y; time comes behind
  Rate rate;
  TimeRate time_rate;
  Vector zero{size + 1, 0.0};
  Vector state = zero, next = zero, error = zero, time_column = zero, bent[2] = {zero, zero};
  Matrix jacobian{size + 1, size + 1, 0.0};
  double length = 0.0;
  boost::numeric::odeint::rosenbrock4<double> stepper = {};
};

DenseRosenbrock::DenseRosenbrock(std::size_t size, Rate rate, TimeRate time_rate)
    : dense_(new Dense{size, std::move(rate), std::move(time_rate)}) {}

DenseRosenbrock::~DenseRosenbrock() = default;

double* DenseRosenbrock::state() { return &dense_->state[0]; }
double& DenseRosenbrock::jacobian(std::size_t row, std::size_t column) { return dense_->jacobian(row, column); }
const double* DenseRosenbrock::next() const { return &dense_->next[0]; }
const double* DenseRosenbrock::error() const { return &dense_->error[0]; }

void DenseRosenbrock::attempt(double t, double h) {
  Dense& dense = *dense_;
  const auto rate = [&dense](const Vector& y, Vector& out, double) {
    dense.rate(y[dense.size], &y[0], &out[0]);
    out[dense.size] = 1.0;
  };
  const auto jacobian = [&dense](const Vector&, Matrix& out, double at, Vector& time_rate) {
    dense.time_rate(at, &dense.time_column[0]);
    noalias(column(dense.jacobian, dense.size)) = dense.time_column;
    noalias(out) = dense.jacobian;
    time_rate.clear();
  };
  dense.state[dense.size] = t;
  dense.length = h;
  dense.stepper.do_step(std::make_pair(rate, jacobian), dense.state, t, dense.next, h, dense.error);
}

void DenseRosenbrock::accept() { dense_->state.swap(dense_->next); }

void DenseRosenbrock::rate(double* out) {
  Dense& dense = *dense_;
  // The interpolation is (1 - s) y_0 + s y_1 + b(s), b = s (1 - s) (c + d s), and b'(1) = -c - d.
  const Vector& zero = dense.zero;
  dense.stepper.prepare_dense_output();
  dense.stepper.calc_state(0.5, dense.bent[0], zero, 0.0, zero, 1.0);
  dense.stepper.calc_state(2.0, dense.bent[1], zero, 0.0, zero, 1.0);
  for (std::size_t i = 0; i < dense.size; ++i)
    out[i] = (dense.next[i] - dense.state[i] - (16.0 * dense.bent[0][i] - dense.bent[1][i]) / 6.0) / dense.length;
}

}  // namespace viscobar
