// -Wconversion and -Wshadow are not Boost's way.
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include "benchmark/odeint.hpp"

#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <utility>

namespace viscobar::baseline {

namespace odeint = boost::numeric::odeint;
namespace ublas = boost::numeric::ublas;

namespace {

// Steps across the kink, as a user of the library would.
template <class Stepper, class Rates, class State>
std::size_t run(const OrdinarySystem& system, Stepper stepper, Rates rates, State& y, std::vector<double>& first) {
  return odeint::integrate_times(stepper, rates, y, system.times.begin(), system.times.end(), 1e-6,
                                 [&](const State& now, double) { first.push_back(now[0]); });
}

}  // namespace

std::size_t odeint_rosenbrock4(const OrdinarySystem& system, double relative, double absolute,
                               std::vector<double>& first) {
  using Vector = ublas::vector<double>;
  Vector y(system.start.size());
  std::copy(system.start.begin(), system.start.end(), y.begin());
  const auto rates = [&](const Vector& now, Vector& rate, double) { system.rates(&now[0], &rate[0]); };
  const auto jacobian = [&](const Vector& now, ublas::matrix<double>& matrix, double, Vector& explicit_rate) {
    matrix.clear();
    explicit_rate.clear();
    system.jacobian(&now[0], &matrix(0, 0));
  };
  return run(system, odeint::make_dense_output<odeint::rosenbrock4<double>>(absolute, relative),
             std::make_pair(rates, jacobian), y, first);
}

std::size_t odeint_dopri5(const OrdinarySystem& system, double relative, double absolute, std::vector<double>& first) {
  std::vector<double> y = system.start;
  const auto rates = [&](const std::vector<double>& now, std::vector<double>& rate, double) {
    system.rates(now.data(), rate.data());
  };
  using Stepper = odeint::runge_kutta_dopri5<std::vector<double>>;
  return run(system, odeint::make_dense_output<Stepper>(absolute, relative), rates, y, first);
}

}  // namespace viscobar::baseline
