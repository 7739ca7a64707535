#include "characteristics/piecewise.hpp"

#include <algorithm>
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
  const double width = end - end_;
  if (width < shortest) {
    // At the beginning it is the next piece that reaches back.
    left_out_ += std::max(width, 0.0) * p.bound();
    if (pieces_.empty() || width <= 0.0) return;
    left_out_ += width * polynomial(size() - 1).bound();
    integral_ += width * (*this)(size() - 1, end);
    pieces_.back().end = end_ = end;
    return;
  }
  const auto first = static_cast<std::uint32_t>(coefficients_.size()), terms = static_cast<std::uint32_t>(p.terms());
  const Piece piece{end_, end, 0.5 * (from + to), 0.5 * (to - from), integral_, first, terms};
  coefficients_.insert(coefficients_.end(), p.coefficients().begin(), p.coefficients().end());
  if (end_ == from && end == to) {
    integral_ += piece.half * p.integral();
  } else {
    const Chebyshev sum = p.antiderivative();
    integral_ += piece.half * (sum(piece.z(end)) - sum(piece.z(end_)));
  }
  pieces_.push_back(piece);
  end_ = end;
}

Chebyshev Piecewise::polynomial(std::size_t i) const {
  return Chebyshev(std::span(coefficients_.data() + pieces_[i].first, pieces_[i].terms));
}

Chebyshev Piecewise::on(std::size_t i, double from, double to) const {
  const Piece& piece = pieces_[i];
  if (from == piece.from() && to == piece.to()) return polynomial(i);
  return polynomial(i).restricted(piece.z(from), piece.z(to));
}

double Piecewise::bound() const {
  double largest = 0.0;
  for (std::size_t i = 0; i < size(); ++i) {
    const double bound = polynomial(i).bound();
    if (!(bound < INFINITY)) return bound;
    largest = std::max(largest, bound);
  }
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
    Chebyshev sum = factor_f * f.on(i, from, to);
    out.append(to, from, to, sum += factor_g * g.on(j, from, to));
  });
}

Piecewise mirrored(const Piecewise& f) {
  Piecewise out;
  for (std::size_t i = f.size(); i-- > 0;)
    out.append(1.0 - f[i].begin, 1.0 - f[i].to(), 1.0 - f[i].from(), f.polynomial(i).mirrored());
  return out;
}

namespace {

// A piece by itself.
struct Stretch {
  Piecewise::Piece piece;
  Chebyshev p;

  double operator()(double s) const { return p(piece.z(s)); }
  double width() const { return piece.width(); }
  // So far into it.
  double at(double part) const { return piece.begin + part * width(); }
};

// One polynomial for two neighbours, where it is both to the tolerance, and int |change|.
std::optional<std::pair<Stretch, double>> merged(const Stretch& left, const Stretch& right, double tolerance) {
  const double from = left.piece.begin, to = right.piece.end, border = left.piece.end;
  if (std::abs(left(border) - right(right.piece.begin)) > tolerance) return std::nullopt;
  Stretch one{{from, to, 0.5 * (from + to), 0.5 * (to - from)}, {}};
  const auto value = [&](double z) {
    const double s = one.piece.middle + one.piece.half * z;
    return s <= border ? left(s) : right(s);
  };
  // A polynomial of the higher degree of the two is one, if any is; a higher one still, where series converge.
  const std::size_t least = std::max(left.p.terms(), right.p.terms());
  for (const std::size_t terms : {least, std::min<std::size_t>(2 * least + 2, Chebyshev::fitted_terms)}) {
    if (terms > Chebyshev::fitted_terms) break;
    one.p = Chebyshev::of(terms, value);
    double off = one.p.chop(0.1 * tolerance);
    for (const double part : {0.0, 0.13, 0.37, 0.61, 0.89, 1.0})
      for (const Stretch* half : {&left, &right})
        off = std::max(off, std::abs(one(half->at(part)) - (*half)(half->at(part))));
    if (off <= tolerance) return std::pair(one, off * (to - from));
    if (least <= 2) break;  // lines meet in a kink
  }
  return std::nullopt;
}

// int |change| where a piece is left to its neighbour.
double absence(const Stretch& left_out, const Stretch& neighbour) {
  double most = 0.0;
  const Piecewise::Piece& piece = left_out.piece;
  for (const double s : {piece.begin, 0.5 * (piece.begin + piece.end), piece.end})
    most = std::max(most, std::abs(left_out(s) - neighbour(s)));
  return most * piece.width();
}

}  // namespace

double simplify(Piecewise& f, double tolerance, double negligible, double brief, Piecewise& scratch) {
  if (f.empty()) return 0.0;
  double change = 0.0;
  scratch.clear();
  const double end = f.end();
  const auto part = [&](std::size_t i) { return Stretch{f[i], f.polynomial(i)}; };
  std::optional<Stretch> now;  // the piece that grows
  const auto flush = [&] { scratch.append(now->piece.end, now->piece, now->p); };
  for (std::size_t i = 0; i < f.size(); ++i) {
    Stretch next = part(i);
    if (next.width() < brief && (now || i + 1 < f.size())) {
      const double lost = absence(next, now ? *now : part(i + 1));
      if (lost <= negligible) {
        change += lost;
        if (now) now->piece.end = next.piece.end;
        continue;
      }
    }
    const auto one = now ? merged(*now, next, tolerance) : std::nullopt;
    if (one) {
      now = one->first;
      change += one->second;
      continue;
    }
    if (now) flush();
    next.piece.begin = now ? now->piece.end : 0.0;
    now = next;
  }
  now->piece.end = end;
  flush();
  std::swap(f, scratch);
  return change;
}

}  // namespace viscobar::characteristics
