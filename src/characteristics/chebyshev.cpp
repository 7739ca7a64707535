#include "characteristics/chebyshev.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

namespace viscobar::characteristics {

namespace {

// For each number of values: the points, and the matrix that makes coefficients of values at them.
struct Transform {
  std::vector<double> points, matrix;
};

const Transform& transform(std::size_t n) {
  static const std::vector<Transform> all = [] {
    std::vector<Transform> list(Chebyshev::most_terms + 1);
    for (std::size_t size = 1; size < list.size(); ++size) {
      // cos(pi m / (2 size)), of angles up to pi / 4 only, so that each is right to its rounding.
      const auto cosine = [size](std::size_t m) {
        m %= 4 * size;
        if (m > 2 * size) m = 4 * size - m;
        const bool negative = m > size;
        if (negative) m = 2 * size - m;
        const double quarter = std::numbers::pi / 2 / static_cast<double>(size);
        const double value = 2 * m <= size ? std::cos(quarter * static_cast<double>(m))
                                           : std::sin(quarter * static_cast<double>(size - m));
        return negative ? -value : value;
      };
      Transform& one = list[size];
      for (std::size_t j = 0; j < size; ++j) one.points.push_back(cosine(2 * j + 1));
      for (std::size_t k = 0; k < size; ++k)
        for (std::size_t j = 0; j < size; ++j)
          one.matrix.push_back((k == 0 ? 1.0 : 2.0) / static_cast<double>(size) * cosine(k * (2 * j + 1)));
    }
    return list;
  }();
  assert(n >= 1 && n <= Chebyshev::most_terms);
  return all[n];
}

// p(from) >= 0 > p(to): a place between where that changes, to the number next to it.
double zero(const Chebyshev& p, double from, double to) {
  double low = p(from), high = p(to);
  for (int step = 0; step < 200; ++step) {
    const double width = to - from;
    if (width <= rounding) break;
    // The secant, pulled a little towards the middle, and a bisection now and then for what is no line.
    double z = step % 3 == 2 ? from + 0.5 * width : from + width * (low / (low - high));
    const double margin = std::max(0.25 * rounding, 1e-3 * rounding * width);
    z = std::clamp(z, from + margin, to - margin);
    if (!(z > from && z < to)) break;
    const double value = p(z);
    if (value == 0.0) return z;
    if (value > 0.0)
      from = z, low = value;
    else
      to = z, high = value;
    // A value of the other sign a rounding beside it shows that it is a zero.
    const double beside = value > 0.0 ? std::min(to, from + 2.0 * rounding) : std::max(from, to - 2.0 * rounding);
    if (beside <= from || beside >= to) continue;
    const double other = p(beside);
    if (other >= 0.0)
      from = beside, low = other;
    else
      to = beside, high = other;
  }
  return low <= -high ? from : to;
}

// p on part of its interval, which is halved depth first from the left.
struct Part {
  Chebyshev p;
  double begin = -1.0, end = 1.0;

  std::array<Part, 2> halves() const {
    const double middle = 0.5 * (begin + end);
    return {Part{p.restricted(-1.0, 0.0), begin, middle}, Part{p.restricted(0.0, 1.0), middle, end}};
  }
};

std::optional<double> first_descent(const Chebyshev& whole, const Part& part, double band) {
  const Chebyshev& p = part.p;
  // A sixteenth of the band is given away, so that what stays at its border is not halved for ever.
  if (p.lower() >= -1.0625 * band) return std::nullopt;
  if (p(-1.0) < -band) return part.begin;
  const Chebyshev slope = p.derivative();
  if (slope.upper() <= 0.0 || part.end - part.begin <= 4.0 * rounding) {
    if (p(1.0) >= -band) return std::nullopt;
    // Where the interval begins within the band, that is as near to a zero as anybody knows.
    return whole(part.begin) < 0.0 ? part.begin : zero(whole, part.begin, part.end);
  }
  if (slope.lower() >= 0.0) return std::nullopt;
  for (const Part& half : part.halves())
    if (const auto z = first_descent(whole, half, band)) return z;
  return std::nullopt;
}

double maximum(const Part& part, double known, double tolerance) {
  const Chebyshev& p = part.p;
  known = std::max({known, p(-1.0), p(1.0)});
  // A maximum inside so small a part is a rounding above its ends.
  if (!(p.upper() > known + tolerance) || p.terms() <= 2 || part.end - part.begin < 1e-8) return known;
  for (const Part& half : part.halves()) known = maximum(half, known, tolerance);
  return known;
}

}  // namespace

Chebyshev::Chebyshev(std::span<const double> coefficients) : terms_(coefficients.size()) {
  assert(terms_ <= most_terms);
  std::copy(coefficients.begin(), coefficients.end(), c_.begin());
}

std::span<const double> Chebyshev::points(std::size_t n) { return transform(n).points; }

Chebyshev Chebyshev::through(std::span<const double> values) {
  Chebyshev p;
  p.terms_ = values.size();
  const double* row = transform(p.terms_).matrix.data();
  for (std::size_t k = 0; k < p.terms_; ++k, row += p.terms_) {
    double sum = 0.0;
    for (std::size_t j = 0; j < p.terms_; ++j) sum += row[j] * values[j];
    p.c_[k] = sum;
  }
  return p;
}

double Chebyshev::operator()(double z) const {
  if (terms_ == 0) return 0.0;
  double next = 0.0, after = 0.0;
  for (std::size_t k = terms_ - 1; k > 0; --k) {
    const double now = c_[k] + 2.0 * z * next - after;
    after = next;
    next = now;
  }
  return c_[0] + z * next - after;
}

// Clenshaw's recurrence, place beside place.
void Chebyshev::at(std::span<const double> z, std::span<double> values) const {
  assert(z.size() <= most_places && values.size() == z.size());
  std::array<double, most_places> next{}, after{};
  const std::size_t count = z.size();
  for (std::size_t k = terms_; k-- > 1;)
    for (std::size_t j = 0; j < count; ++j) {
      const double now = c_[k] + 2.0 * z[j] * next[j] - after[j];
      after[j] = next[j];
      next[j] = now;
    }
  const double constant = terms_ == 0 ? 0.0 : c_[0];
  for (std::size_t j = 0; j < count; ++j) values[j] = constant + z[j] * next[j] - after[j];
}

double Chebyshev::integral() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < terms_; k += 2) sum -= 2.0 * c_[k] / (static_cast<double>(k * k) - 1.0);
  return sum;
}

Chebyshev Chebyshev::antiderivative() const {
  Chebyshev p;
  if (terms_ == 0) return p;
  assert(terms_ < most_terms);
  p.terms_ = terms_ + 1;
  const auto at = [this](std::size_t k) { return k < terms_ ? c_[k] : 0.0; };
  double at_minus_one = 0.0;
  for (std::size_t k = 1; k < p.terms_; ++k) {
    p.c_[k] = ((k == 1 ? 2.0 : 1.0) * at(k - 1) - at(k + 1)) / (2.0 * static_cast<double>(k));
    at_minus_one += k % 2 == 0 ? p.c_[k] : -p.c_[k];
  }
  p.c_[0] = -at_minus_one;
  return p;
}

Chebyshev Chebyshev::derivative() const {
  Chebyshev p;
  if (terms_ < 2) return p;
  p.terms_ = terms_ - 1;
  for (std::size_t k = p.terms_; k-- > 0;)
    p.c_[k] = (k + 2 < p.terms_ ? p.c_[k + 2] : 0.0) + 2.0 * static_cast<double>(k + 1) * c_[k + 1];
  p.c_[0] *= 0.5;
  return p;
}

Chebyshev Chebyshev::restricted(double from, double to) const {
  if (from == -1.0 && to == 1.0) return *this;
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  Chebyshev p = *this;
  if (terms_ <= 2) {
    if (terms_ == 2) p.c_[0] += c_[1] * middle, p.c_[1] *= half;
    return p;
  }
  const std::span<const double> places = points(terms_);
  std::array<double, most_terms> z, values;
  for (std::size_t j = 0; j < terms_; ++j) z[j] = middle + half * places[j];
  at({z.data(), terms_}, {values.data(), terms_});
  return through({values.data(), terms_});
}

Chebyshev Chebyshev::mirrored() const {
  Chebyshev p = *this;
  for (std::size_t k = 1; k < terms_; k += 2) p.c_[k] = -p.c_[k];
  return p;
}

double Chebyshev::spread() const {
  double sum = 0.0;
  for (std::size_t k = 1; k < terms_; ++k) sum += std::abs(c_[k]);
  return sum;
}

double Chebyshev::bound() const { return terms_ == 0 ? 0.0 : std::abs(c_[0]) + spread(); }

Chebyshev& Chebyshev::operator+=(const Chebyshev& other) {
  for (; terms_ < other.terms_; ++terms_) c_[terms_] = 0.0;
  for (std::size_t k = 0; k < other.terms_; ++k) c_[k] += other.c_[k];
  return *this;
}

Chebyshev& Chebyshev::operator+=(double constant) {
  if (terms_ == 0) c_[0] = 0.0, terms_ = 1;
  c_[0] += constant;
  return *this;
}

Chebyshev& Chebyshev::operator*=(double factor) {
  for (std::size_t k = 0; k < terms_; ++k) c_[k] *= factor;
  return *this;
}

double Chebyshev::chop(double tolerance) {
  double left_out = 0.0;
  while (terms_ > 1 && left_out + std::abs(c_[terms_ - 1]) <= tolerance) left_out += std::abs(c_[--terms_]);
  return left_out;
}

std::optional<double> first_descent(const Chebyshev& p, double band) {
  if (p.lower() >= -band) return std::nullopt;
  if (p(-1.0) < -band) return -1.0;
  return first_descent(p, Part{p}, band);
}

double maximum(const Chebyshev& p, double known, double tolerance) {
  return p.upper() <= known ? known : maximum(Part{p}, known, tolerance);
}

}  // namespace viscobar::characteristics
