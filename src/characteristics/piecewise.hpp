#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "characteristics/chebyshev.hpp"

namespace viscobar::characteristics {

/// A function on [0, 1] of polynomial pieces, with its integral from 0. Made by append() from the left; what it has
/// once grown to needs no further memory.
class Piecewise {
 public:
  struct Piece {
    double begin = 0.0, end = 0.0;    // where it holds,
    double middle = 0.0, half = 1.0;  // of the interval that its polynomial is written on
    double before = 0.0;              // integral from 0 to begin
    std::uint32_t first = 0, terms = 0;

    double z(double s) const { return (s - middle) / half; }
    double from() const { return middle - half; }  ///< start of that interval
    double to() const { return middle + half; }    ///< end of that interval
    double width() const { return end - begin; }

    static void members(auto& piece, auto&& each) {
      each(piece.begin, piece.end, piece.middle, piece.half, piece.before, piece.first, piece.terms);
    }
  };

  /// No piece is shorter, but for the last of a function that was appended up to there only.
  static constexpr double shortest = 1e-15;

  void clear();
  /// The next piece, from end() on: `p` is written on [from, to]. A piece that is too short is left to its neighbours.
  void append(double end, double from, double to, const Chebyshev& p);
  /// The same with `p` written on the interval of a piece.
  void append(double end, const Piece& on, const Chebyshev& p) { append(end, on.from(), on.to(), p); }

  bool empty() const { return pieces_.empty(); }
  std::size_t size() const { return pieces_.size(); }
  std::size_t coefficients() const { return coefficients_.size(); }
  const Piece& operator[](std::size_t i) const { return pieces_[i]; }
  double end() const { return end_; }
  double integral() const { return integral_; }               ///< from 0 to end()
  Chebyshev polynomial(std::size_t i) const;                  ///< as it is written
  Chebyshev on(std::size_t i, double from, double to) const;  ///< written on [from, to]
  double operator()(std::size_t i, double s) const { return polynomial(i)(pieces_[i].z(s)); }  ///< of piece i
  double bound() const;                                                                        ///< of |f|
  double left_out() const { return left_out_; }  ///< int |change| of the pieces too short since clear()

  static void members(auto& f, auto&& each) { each(f.pieces_, f.coefficients_, f.end_, f.integral_, f.left_out_); }

 private:
  std::vector<Piece> pieces_;
  std::vector<double> coefficients_;
  double end_ = 0.0, integral_ = 0.0, left_out_ = 0.0;
};

/// Values and integrals of a Piecewise at places that follow each other, in either direction. At a break it is the
/// piece before it that counts.
class Cursor {
 public:
  explicit Cursor(const Piecewise& f) : f_(f) {}
  double value(double s);
  double integral(double s);  ///< from 0

 private:
  void move(double s);

  const Piecewise& f_;
  std::size_t at_ = static_cast<std::size_t>(-1);
  bool integrated_ = false;
  Chebyshev p_, sum_;
  double at_begin_ = 0.0;  // of sum_
};

/// Calls each(from, to, i, j) for the pieces i of f and j of g between their common breaks up to `until`.
template <class Each>
void for_common_pieces(const Piecewise& f, const Piecewise& g, double until, Each&& each) {
  std::size_t i = 0, j = 0;
  for (double from = 0.0; from < until;) {
    while (i + 1 < f.size() && f[i].end <= from) ++i;
    while (j + 1 < g.size() && g[j].end <= from) ++j;
    double to = until;
    if (i + 1 < f.size() && f[i].end < to) to = f[i].end;
    if (j + 1 < g.size() && g[j].end < to) to = g[j].end;
    each(from, to, i, j);
    from = to;
  }
}

/// out = f * factor_f + g * factor_g
void combine(const Piecewise& f, double factor_f, const Piecewise& g, double factor_g, Piecewise& out);

/// f(1 - s)
Piecewise mirrored(const Piecewise& f);

/// Neighbours that one polynomial represents to `tolerance` become one piece, and pieces shorter than `brief` whose
/// absence changes the integral of |f| by no more than `negligible` are left to their neighbours. Returns int |change|.
/// `scratch` is for its memory.
double simplify(Piecewise& f, double tolerance, double negligible, double brief, Piecewise& scratch);

}  // namespace viscobar::characteristics
