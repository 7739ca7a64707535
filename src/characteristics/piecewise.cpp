#include "characteristics/piecewise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace viscobar::characteristics {

void Piecewise::clear() {
  pieces_.clear();
  coefficients_.clear();
  end_ = integral_ = left_out_ = 0.0;
}

void Piecewise::append(double end, double from, double to, const Chebyshev& p) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  const double width = end - end_;
  if (width < shortest) {
    // At the beginning it is the next piece that reaches back.
    left_out_ += std::max(width, 0.0) * p.bound();
    if (pieces_.empty() || width <= 0.0) return;
    left_out_ += width * polynomial(size() - 1).bound();
    Piece& last = pieces_.back();
    integral_ += width * polynomial(size() - 1)(last.z(end));
    last.end = end_ = end;
    return;
  }
  Piece piece{end_,
              end,
              middle,
              half,
              integral_,
              static_cast<std::uint32_t>(coefficients_.size()),
              static_cast<std::uint32_t>(p.terms())};
  coefficients_.insert(coefficients_.end(), p.coefficients().begin(), p.coefficients().end());
  if (end_ == from && end == to) {
    integral_ += half * p.integral();
  } else {
    const Chebyshev sum = p.antiderivative();
    integral_ += half * (sum(piece.z(end)) - sum(piece.z(end_)));
  }
  pieces_.push_back(piece);
  end_ = end;
}

Chebyshev Piecewise::polynomial(std::size_t i) const {
  return Chebyshev(std::span(coefficients_.data() + pieces_[i].first, pieces_[i].terms));
}

Chebyshev Piecewise::on(std::size_t i, double from, double to) const {
  const Piece& piece = pieces_[i];
  const bool all = from == piece.middle - piece.half && to == piece.middle + piece.half;
  return all ? polynomial(i) : polynomial(i).restricted(piece.z(from), piece.z(to));
}

double Piecewise::bound() const {
  double largest = 0.0;
  for (std::size_t i = 0; i < size(); ++i) largest = std::max(largest, polynomial(i).bound());
  return largest;
}

void Cursor::move(double s) {
  std::size_t i = at_ < f_.size() ? at_ : 0;
  while (i + 1 < f_.size() && s > f_[i].end) ++i;
  while (i > 0 && s <= f_[i].begin) --i;
  if (i == at_) return;
  at_ = i;
  p_ = f_.polynomial(i);
  integrated_ = false;
}

double Cursor::value(double s) {
  move(s);
  return p_(f_[at_].z(s));
}

double Cursor::integral(double s) {
  move(s);
  const Piecewise::Piece& piece = f_[at_];
  if (!integrated_) {
    sum_ = p_.antiderivative();
    at_begin_ = sum_(piece.z(piece.begin));
    integrated_ = true;
  }
  return piece.before + piece.half * (sum_(piece.z(s)) - at_begin_);
}

void combine(const Piecewise& f, double factor_f, const Piecewise& g, double factor_g, Piecewise& out) {
  out.clear();
  for_common_pieces(f, g, std::min(f.end(), g.end()), [&](double from, double to, std::size_t i, std::size_t j) {
    Chebyshev sum = f.on(i, from, to), other = g.on(j, from, to);
    sum *= factor_f;
    other *= factor_g;
    sum += other;
    out.append(to, from, to, sum);
  });
}

Piecewise mirrored(const Piecewise& f) {
  Piecewise out;
  for (std::size_t i = f.size(); i-- > 0;) {
    const Piecewise::Piece& piece = f[i];
    out.append(1.0 - piece.begin, 1.0 - (piece.middle + piece.half), 1.0 - (piece.middle - piece.half),
               f.polynomial(i).mirrored());
  }
  return out;
}

namespace {

struct Merged {
  Chebyshev p;
  double change;
};

// One polynomial for the pieces i and j = i + 1 from `from` to `to`, where it is both to the tolerance.
std::optional<Merged> merged(const Chebyshev& p, const Piecewise::Piece& left, const Chebyshev& q,
                             const Piecewise::Piece& right, double tolerance) {
  const double from = left.begin, to = right.end;
  if (std::abs(p(left.z(left.end)) - q(right.z(right.begin))) > tolerance) return std::nullopt;
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  const auto value = [&](double s) { return s <= left.end ? p(left.z(s)) : q(right.z(s)); };
  const auto fit = [&](std::size_t terms) {
    std::array<double, Chebyshev::fitted_terms> values;
    const std::span<const double> points = Chebyshev::points(terms);
    for (std::size_t j = 0; j < terms; ++j) values[j] = value(middle + half * points[j]);
    return Chebyshev::through({values.data(), terms});
  };
  // A polynomial of the higher degree of the two is one, if any is; a higher one still, where series converge.
  const std::size_t least = std::max(p.terms(), q.terms());
  for (const std::size_t terms : {least, std::min<std::size_t>(2 * least + 2, Chebyshev::fitted_terms)}) {
    if (terms > Chebyshev::fitted_terms) break;
    Chebyshev sum = fit(terms);
    const double left_out = sum.chop(0.1 * tolerance);
    double off = left_out;
    for (const double part : {0.0, 0.13, 0.37, 0.61, 0.89, 1.0}) {
      const double a = left.begin + part * (left.end - left.begin), b = right.begin + part * (right.end - right.begin);
      off = std::max(
          {off, std::abs(sum((a - middle) / half) - p(left.z(a))), std::abs(sum((b - middle) / half) - q(right.z(b)))});
    }
    if (off <= tolerance) return Merged{sum, off * (to - from)};
    if (least <= 2) break;  // lines meet in a kink
  }
  return std::nullopt;
}

// int |change| where a piece p is left to its neighbour q.
double absence(const Chebyshev& p, const Piecewise::Piece& piece, const Chebyshev& q,
               const Piecewise::Piece& neighbour) {
  double most = 0.0;
  for (const double s : {piece.begin, 0.5 * (piece.begin + piece.end), piece.end})
    most = std::max(most, std::abs(p(piece.z(s)) - q(neighbour.z(s))));
  return most * (piece.end - piece.begin);
}

}  // namespace

double simplify(Piecewise& f, double tolerance, double negligible, double brief, Piecewise& scratch) {
  double change = 0.0;
  scratch.clear();
  const auto end = f.end();
  // The piece that grows.
  Piecewise::Piece now;
  Chebyshev p;
  bool any = false;
  const auto flush = [&] {
    if (any) scratch.append(now.end, now.middle - now.half, now.middle + now.half, p);
  };
  for (std::size_t i = 0; i < f.size(); ++i) {
    const Piecewise::Piece& next = f[i];
    const Chebyshev q = f.polynomial(i);
    if (next.end - next.begin < brief && (any || i + 1 < f.size())) {
      const double lost = any ? absence(q, next, p, now) : absence(q, next, f.polynomial(i + 1), f[i + 1]);
      if (lost <= negligible) {
        change += lost;
        if (any) now.end = next.end;
        continue;
      }
    }
    if (any) {
      if (auto one = merged(p, now, q, next, tolerance)) {
        change += one->change;
        p = one->p;
        now.end = next.end;
        now.middle = 0.5 * (now.begin + now.end);
        now.half = 0.5 * (now.end - now.begin);
        continue;
      }
    }
    flush();
    const double begin = any ? now.end : 0.0;
    now = next;
    now.begin = begin;
    p = q;
    any = true;
  }
  if (any) now.end = end;
  flush();
  std::swap(f, scratch);
  return change;
}

}  // namespace viscobar::characteristics
