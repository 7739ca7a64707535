#include "characteristics/end.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace viscobar::characteristics {

namespace {

constexpr double roundings = 64.0 * rounding;

}  // namespace

void End::answer(const Piecewise& arriving, double until, const Scale& scale, Piecewise& sent) {
  sent.clear();
  marks_.clear();
  turns_.clear();
  marks_.push_back({0.0, place_, 0.0, borne_.impulse, closed_});
  borne_.lowest = std::min(borne_.lowest, place_);
  borne_.highest = std::max(borne_.highest, place_);
  for (std::size_t i = 0; i < arriving.size() && arriving[i].begin < until; ++i) {
    const double end = std::min(until, arriving[i].end);
    if (kind_ == Kind::obstacle)
      meet(arriving, i, end, scale, sent);
    else
      send(arriving[i], arriving.polynomial(i), end, sent);
  }
  const Mark& last = marks_.back();
  place_ = last.place;
  if (kind_ != Kind::fixed && !last.closed) place_ += passage_ * (of_sent(sent.integral()) - last.sent);
}

void End::send(const Piecewise::Piece& piece, const Chebyshev& arriving, double until, Piecewise& sent) {
  Chebyshev p = arriving;
  if (kind_ == Kind::fixed || closed_) p *= -1.0;
  const double from = piece.middle - piece.half, to = piece.middle + piece.half;
  const double before = of_sent(sent.integral()), begin = sent.end();
  if (until <= begin) return;
  if (sign_ < 0.0) {
    Chebyshev turned = p;
    turned *= -1.0;
    sent.append(until, from, to, turned);
  } else {
    sent.append(until, from, to, p);
  }
  if (kind_ == Kind::fixed) return;
  const double z_begin = piece.z(begin), z_end = piece.z(until);
  if (!closed_) {
    const Mark& last = marks_.back();
    const auto place = [&](double integral) { return last.place + passage_ * (integral - last.sent); };
    return widen(p.restricted(z_begin, z_end), until - begin, place(before), place(of_sent(sent.integral())));
  }
  borne_.impulse += of_sent(sent.integral()) - before;
  if (p.upper() > borne_.max_reaction)
    borne_.max_reaction = maximum(p.restricted(z_begin, z_end), borne_.max_reaction, roundings * p.bound());
}

// The range of places by a path that leads from one to another; within it is looked for an extreme only where the
// velocity may have a zero that leads beyond what is known.
void End::widen(const Chebyshev& velocity, double duration, double from, double to) {
  for (const double place : {from, to}) {
    borne_.lowest = std::min(borne_.lowest, place);
    borne_.highest = std::max(borne_.highest, place);
  }
  if (velocity.lower() >= 0.0 || velocity.upper() <= 0.0) return;
  const double reach = passage_ * duration * velocity.bound();
  if (from - reach >= borne_.lowest && from + reach <= borne_.highest) return;
  Chebyshev path = velocity.antiderivative();
  path *= 0.5 * duration * passage_;
  path += from;
  const double tolerance = roundings * path.bound();
  borne_.highest = maximum(path, borne_.highest, tolerance);
  path *= -1.0;
  borne_.lowest = -maximum(path, -borne_.lowest, tolerance);
}

void End::turn(double s, double velocity, const Piecewise& sent) {
  closed_ = !closed_;
  turns_.push_back({s, closed_ ? Change::closing : Change::opening, sign_ * velocity});
  marks_.push_back({s, 0.0, of_sent(sent.integral()), borne_.impulse, closed_});
}

// Piece i of what arrives, from where `sent` ends up to `end`.
void End::meet(const Piecewise& arriving, std::size_t i, double end, const Scale& scale, Piecewise& sent) {
  const Piecewise::Piece& piece = arriving[i];
  Chebyshev whole = arriving.polynomial(i);
  if (sign_ < 0.0) whole *= -1.0;
  const double band = roundings * scale.velocity, touch = roundings * scale.place;
  // What is sent lags behind by less than the shortest piece, where it begins with one that is shorter.
  for (double begin = sent.end(); begin < end;) {
    const double half = 0.5 * (end - begin);
    if (half < 0.5 * Piecewise::shortest) return send(piece, whole, end, sent);
    // A zero after the beginning that rounds to it would be met again and again.
    const auto place = [&](double z) {
      if (z <= -1.0) return begin;
      return z >= 1.0 ? end : std::min(end, begin + std::max(half * (z + 1.0), Piecewise::shortest));
    };
    if (closed_) {
      if (whole.upper() <= band) return send(piece, whole, end, sent);
      ++searched_;
      const Chebyshev p = whole.restricted(piece.z(begin), piece.z(end));
      Chebyshev pressed = p;
      pressed *= -1.0;
      const auto z = first_descent(pressed, band);
      if (!z) return send(piece, whole, end, sent);
      begin = place(*z);
      send(piece, whole, begin, sent);
      turn(begin, p(*z), sent);
      continue;
    }
    const Mark& last = marks_.back();
    const double clearance = last.place + passage_ * (of_sent(sent.integral()) - last.sent);
    if (clearance + 2.0 * half * passage_ * std::min(0.0, whole.lower()) >= -touch && clearance > touch)
      return send(piece, whole, end, sent);
    ++searched_;
    const Chebyshev p = whole.restricted(piece.z(begin), piece.z(end));
    Chebyshev path = p.antiderivative();
    path *= half * passage_;
    path += clearance;
    std::optional<double> z;
    // What touches and is pressed closes where the pressure begins: the path tells no more than that it falls.
    if (clearance <= touch)
      if (const auto pressed = first_descent(p, band); pressed && path(*pressed) <= touch) z = pressed;
    if (!z) z = first_descent(path, touch);
    if (!z) return send(piece, whole, end, sent);
    begin = place(*z);
    send(piece, whole, begin, sent);
    turn(begin, p(*z), sent);
  }
}

const End::Mark& End::mark_at(double s) const {
  auto next = std::ranges::lower_bound(marks_, s, {}, &Mark::s);           // a change tells the side before it,
  if (s <= 0.0) next = std::ranges::upper_bound(marks_, s, {}, &Mark::s);  // but at the beginning there is none
  return next == marks_.begin() ? *next : *(next - 1);
}

double End::impulse_at(double s, Cursor& sent) const {
  const Mark& mark = mark_at(s);
  return sign_ * (mark.impulse + (mark.closed ? of_sent(sent.integral(s)) - mark.sent : 0.0));
}

double End::place_at(double s, Cursor& sent) const {
  const Mark& mark = mark_at(s);
  if (kind_ == Kind::fixed || mark.closed) return mark.place;
  return mark.place + passage_ * (of_sent(sent.integral(s)) - mark.sent);
}

double End::velocity_at(double s, Cursor& sent) const {
  return kind_ == Kind::fixed || mark_at(s).closed ? 0.0 : sent.value(s);
}

double End::force_at(double s, Cursor& sent) const {
  if (kind_ == Kind::fixed) return sent.value(s);
  return mark_at(s).closed ? sign_ * std::max(0.0, of_sent(sent.value(s))) : 0.0;
}

}  // namespace viscobar::characteristics
