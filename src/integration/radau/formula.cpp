#include "integration/radau/formula.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <utility>

namespace viscobar::radau {

namespace {

using Real = long double;
using Number = std::complex<Real>;
using Polynomial = std::array<Real, stages + 1>;

Real factorial(std::size_t n) { return n < 2 ? 1 : static_cast<Real>(n) * factorial(n - 1); }

// (-1)^j binomial(s, j) (2s-1-j)! / (2s-1)!
Polynomial denominator() {
  Polynomial q;
  for (std::size_t j = 0; j <= stages; ++j)
    q[j] = (j % 2 ? -1 : 1) * factorial(2 * stages - 1 - j) * factorial(stages) /
           (factorial(2 * stages - 1) * factorial(j) * factorial(stages - j));
  return q;
}

Number value(const Polynomial& p, Number z) {
  Number sum = 0;
  for (std::size_t j = stages + 1; j-- > 0;) sum = sum * z + p[j];
  return sum;
}

Number slope(const Polynomial& p, Number z) {
  Number sum = 0;
  for (std::size_t j = stages; j > 0; --j) sum = sum * z + static_cast<Real>(j) * p[j];
  return sum;
}

void set(Complex& numbers, std::size_t lane, Number z) {
  numbers.re[lane] = static_cast<double>(z.real());
  numbers.im[lane] = static_cast<double>(z.imag());
}

// Contribution of the parts of X to 2 Re(c X).
void set(Parts& weights, std::size_t lane, Number c) {
  weights[lane] = static_cast<double>(2 * c.real());
  weights[lanes + lane] = static_cast<double>(-2 * c.imag());
}

// Zeros of P_8 - P_7 of Legendre on [0, 1], from the right: Newton's method with the zeros found taken out.
std::array<double, stages> radau_nodes() {
  const auto difference = [](Real x) {
    Real before = 1, now = x;
    for (std::size_t k = 2; k <= stages; ++k) {
      const auto m = static_cast<Real>(k);
      const Real next = ((2 * m - 1) * x * now - (m - 1) * before) / m;
      before = now;
      now = next;
    }
    const auto m = static_cast<Real>(stages);
    const auto slope_of = [&](Real p, Real q, Real n) { return n * (x * p - q) / (x * x - 1); };  // of P_n, P_{n-1}
    const Real two_before = ((2 * m - 1) * x * before - m * now) / (m - 1);
    return std::pair{now - before, slope_of(now, before, m) - slope_of(before, two_before, m - 1)};
  };
  std::array<double, stages> nodes;
  std::array<Real, stages> found;
  found[stages - 1] = 1;
  for (std::size_t k = stages - 1; k-- > 0;) {
    Real x = found[k + 1] - Real(0.01);
    for (int step = 0; step < 200; ++step) {
      const auto [f, derivative] = difference(x);
      Real repelled = 0;
      for (std::size_t j = k + 1; j < stages; ++j) repelled += 1 / (x - found[j]);
      const Real change = f / (derivative - f * repelled);
      x -= change;
      if (std::abs(change) < Real(1e-18)) break;
    }
    found[k] = x;
  }
  for (std::size_t k = 0; k < stages; ++k) nodes[k] = static_cast<double>((1 + found[k]) / 2);
  return nodes;
}

// Coefficients of theta prod_{l != m} (theta - c_l), over its value at c_m.
Polynomial lagrange(const std::array<double, stages>& nodes, std::size_t m) {
  Polynomial p{};
  p[1] = Real(1) / nodes[m];
  std::size_t degree = 1;
  for (std::size_t l = 0; l < stages; ++l) {
    if (l == m) continue;
    const Real scale = 1 / (static_cast<Real>(nodes[m]) - nodes[l]);
    for (std::size_t j = degree + 2; j-- > 0;) {
      if (j > stages) continue;
      p[j] = scale * ((j > 0 ? p[j - 1] : 0) - nodes[l] * p[j]);
    }
    ++degree;
  }
  return p;
}

// Coefficients of T_m(2 theta - 1) of a polynomial in theta. Sums of powers would cancel.
std::array<Number, stages + 1> in_chebyshev(const std::array<Number, stages + 1>& powers) {
  constexpr std::size_t points = stages + 1;
  static const std::array<Real, points> zeros = [] {  // of T_{s+1}
    std::array<Real, points> x;
    for (std::size_t i = 0; i < points; ++i)
      x[i] = std::cos(std::numbers::pi_v<Real> * (static_cast<Real>(i) + Real(0.5)) / points);
    return x;
  }();
  std::array<Number, points> result{};
  for (const Real x : zeros) {
    const Real theta = (1 + x) / 2;
    Number value = 0;
    for (std::size_t m = points; m-- > 0;) value = value * theta + powers[m];
    value *= Real(1) / points;
    Real now = 1, before = x;  // T_m(x) and T_{m-1}(x) = T_{1-m}(x)
    for (std::size_t m = 0; m < points; ++m, before = std::exchange(now, 2 * x * now - before))
      result[m] += (m == 0 ? now : 2 * now) * value;
  }
  return result;
}

}  // namespace

const Formula& Formula::get() {
  static const Formula formula;
  return formula;
}

Formula::Formula() : nodes(radau_nodes()), weights_{}, rates_{} {
  for (auto& tables : samples_)
    for (auto& table : tables) table.fill(Samples::Zero());
  const Polynomial q = denominator();
  // Largest coefficient of z^9 in exp(theta z) Q(z), 0 <= theta <= 1.
  Real next_term = 0;
  for (int k = 0; k <= 100; ++k) {
    const Real theta = Real(k) / 100;
    Real c = 0;
    for (std::size_t j = 0; j <= stages; ++j) c = c * theta + q[j] / factorial(stages + 1 - j);
    c *= theta;
    next_term = std::max(next_term, std::abs(c));
  }
  std::array<Polynomial, stages> bases;
  for (std::size_t m = 0; m < stages; ++m) {
    bases[m] = lagrange(nodes, m);
    std::array<Number, stages + 1> powers;
    std::ranges::copy(bases[m], powers.begin());
    const std::array<Number, stages + 1> chebyshev = in_chebyshev(powers);
    for (std::size_t k = 0; k < 4; ++k) tail[m][k] = static_cast<double>(chebyshev[stages - 3 + k].real());
  }
  constexpr std::array<std::array<double, 2>, lanes> nearby = {
      {{10.1694, 1.6492}, {9.40637, 4.96922}, {7.73869, 8.37088}, {4.68549, 12.0106}}};
  for (std::size_t k = 0; k < lanes; ++k) {
    Number zeta(nearby[k][0], nearby[k][1]);
    for (int step = 0; step < 8; ++step) zeta -= value(q, zeta) / slope(q, zeta);
    const Number scale = Number(-1) / (zeta * slope(q, zeta));
    set(poles, k, zeta);
    set(inverse, k, Number(1) / zeta);
    std::array<Number, stages + 1> powers{};  // of theta, in c_k
    for (std::size_t m = 1; m <= stages; ++m) {
      for (std::size_t n = m; n <= stages; ++n) powers[m] += q[n - m] * std::pow(zeta, static_cast<int>(n));
      powers[m] *= scale / factorial(m);
    }
    set(end_, k, std::accumulate(powers.begin(), powers.end(), Number(0)));
    const std::array<Number, stages + 1> chebyshev = in_chebyshev(powers);
    for (std::size_t m = 0; m <= stages; ++m) set(weights_[m], k, chebyshev[m]);
    // T_m' = 2 m (T_{m-1} + T_{m-3} + ...), half of T_0, in 2 theta - 1.
    for (std::size_t m = 0; m < stages; ++m) {
      Number sum = 0;
      for (std::size_t n = m + 1; n <= stages; n += 2)
        sum += Real(m == 0 ? 2 : 4) * static_cast<Real>(n) * chebyshev[n];
      set(rates_[m], k, sum);
    }
    set(error_, k, 30 * next_term * scale * std::pow(zeta, static_cast<int>(stages)));
    for (std::size_t m = 0; m < stages; ++m) {
      Number sum = 0;
      for (std::size_t j = 1; j <= stages; ++j)
        sum += factorial(j) * bases[m][j] * std::pow(zeta, -static_cast<int>(j));
      set(of_load[m], k, sum);
    }
  }
  for (std::size_t j = 0; j <= stages; ++j)
    for (const int derivative : {0, 1}) {
      const Parts w = weights(static_cast<double>(j) / stages, derivative), u = weights_over_pole(w);
      for (std::size_t l = 0; l < parts; ++l)
        for (const bool over_pole : {false, true})
          samples_[static_cast<std::size_t>(derivative)][over_pole][l][static_cast<Eigen::Index>(j)] =
              (over_pole ? u : w)[l];
    }
}

Parts Formula::weights(double theta, int derivative) const {
  if (theta == 1.0 && derivative == 0) return end_;
  const std::array<Parts, stages + 1>& coefficients = derivative == 0 ? weights_ : rates_;
  // Clenshaw's sums of T_{2k}(x) = T_k(y) and T_{2k+1}(x), x = 2 theta - 1, y = 2 x^2 - 1: two short
  // chains in place of a long one.
  using Sum = Eigen::Array<double, parts, 1>;
  const auto coefficient = [&](std::size_t m) { return Sum::Map(coefficients[m].data()); };
  const double x = 2.0 * theta - 1.0, y = 1.0 - 8.0 * theta * (1.0 - theta);
  Sum even = coefficient(stages), even_after = Sum::Zero(), odd = coefficient(stages - 1), odd_after = Sum::Zero();
  for (std::size_t m = stages - 2; m > 0; m -= 2) {
    even_after = std::exchange(even, coefficient(m) + 2.0 * y * even - even_after);
    odd_after = std::exchange(odd, coefficient(m - 1) + 2.0 * y * odd - odd_after);
  }
  Parts result;
  Sum::Map(result.data()) = coefficient(0) + y * even - even_after + x * (odd - odd_after);
  return result;
}

// 2 Re(c X / zeta), the parts of c being weights[lane] / 2 and -weights[lanes + lane] / 2.
Parts Formula::weights_over_pole(const Parts& weights) const {
  const Lanes re = load_lanes(weights.data()), im = load_lanes(weights.data() + lanes);
  Parts result;
  store_lanes(re * inverse.re + im * inverse.im, result.data());
  store_lanes(im * inverse.re - re * inverse.im, result.data() + lanes);
  return result;
}

// By the sums of all parts, of four nodes at once.
Moved move_nodes(double h, std::span<const Complex> of, const std::array<std::size_t, 2>& with_mass,
                 std::span<const double> begin, std::span<double> end) {
  using Weights = std::array<Lanes, parts>;
  static const std::array<Weights, 4> at_end = [] {  // of w, u / h, their errors
    const Formula& formula = Formula::get();
    const Parts w = formula.weights(1.0, 0), &of_w = formula.error();
    const std::array<Parts, 4> of_parts = {w, formula.weights_over_pole(w), of_w, formula.weights_over_pole(of_w)};
    std::array<Weights, 4> weights;
    for (std::size_t c = 0; c < of_parts.size(); ++c)
      for (std::size_t l = 0; l < parts; ++l) weights[c][l] = Lanes{} + of_parts[c][l];
    return weights;
  }();
  Weights of_way, of_way_error;
  for (std::size_t l = 0; l < parts; ++l) of_way[l] = h * at_end[1][l], of_way_error[l] = h * at_end[3][l];
  const std::size_t n = of.size(), first = with_mass[0], last = with_mass[1];
  const double *const begin_u = begin.data(), *const begin_w = begin_u + n;
  double *const end_u = end.data(), *const end_w = end_u + n;
  const Complex* const x = of.data();
  std::array<Lanes, 4> largest{};
  const auto raise = [](Lanes & most, const Lanes& sum) __attribute__((always_inline)) {
    const Lanes size = sum < 0.0 ? -sum : sum;
    most = most > size ? most : size;
  };
  const auto move = [&](std::size_t i, bool massive) __attribute__((always_inline)) {
    const std::array<Lanes, 4> re = transposed({x[i].re, x[i + 1].re, x[i + 2].re, x[i + 3].re});
    const std::array<Lanes, 4> im = transposed({x[i].im, x[i + 1].im, x[i + 2].im, x[i + 3].im});
    const auto sum = [&](const Weights& by) __attribute__((always_inline)) {
      Lanes of_re = by[0] * re[0], of_im = by[lanes] * im[0];
      for (std::size_t l = 1; l < lanes; ++l) of_re += by[l] * re[l], of_im += by[lanes + l] * im[l];
      return of_re + of_im;
    };
    const Lanes velocity = load_lanes(begin_w + i), rate = sum(at_end[0]), way = sum(of_way);
    store_lanes(velocity + rate, end_w + i);
    store_lanes(load_lanes(begin_u + i) + (h * velocity + way), end_u + i);
    raise(largest[0], rate);
    raise(largest[1], way);
    Lanes of_rate = sum(at_end[2]);
    for (std::size_t k = 0; !massive && k < lanes; ++k)
      if (i + k < first || i + k >= last) of_rate[k] = 0.0;
    raise(largest[2], of_rate);
    raise(largest[3], sum(of_way_error));
  };
  // The last ones of the nodes twice, where they are no multiple of four; takes() wants five.
  move(0, first == 0);
  for (std::size_t i = lanes; i + lanes < n; i += lanes) move(i, true);
  move(n - lanes, last == n);
  const auto most = [&](std::size_t c) {
    const Lanes& lane = largest[c];
    return std::max({lane[0], lane[1], lane[2], lane[3]});
  };
  return {most(0), most(1), most(2), most(3)};
}

}  // namespace viscobar::radau
