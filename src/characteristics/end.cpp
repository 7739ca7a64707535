#include "characteristics/end.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

namespace viscobar::characteristics {

namespace {

constexpr double roundings = 64.0 * rounding;

// v on [-1, 1] from `velocity` on, dv/dz = rate (w - v): exp(-rate (z + 1)) velocity + int exp(-rate (z - y)) rate w
// dy. The rate is at most 1, so that 33 terms are those of w but for roundings.
Chebyshev behind(const Chebyshev& w, double rate, double velocity) {
  const Chebyshev sum = Chebyshev::of(Chebyshev::fitted_terms, [&](double z) {
                          return rate * std::exp(rate * z) * w(z);
                        }).antiderivative();
  Chebyshev v = Chebyshev::of(Chebyshev::fitted_terms, [&](double z) {
    return std::exp(-rate * (z + 1.0)) * velocity + std::exp(-rate * z) * sum(z);
  });
  v.chop(rounding * (std::abs(velocity) + w.bound()));
  return v;
}

}  // namespace

End::End(const EndCondition& condition, const Start& start, double passage, double rate)
    : passage_(passage), rate_(rate), place_(start.displacement), velocity_(start.velocity) {
  if (is_fixed(condition)) kind_ = Kind::fixed;
  const auto* obstacle = std::get_if<Obstacle>(&condition);
  if (!obstacle) return;
  kind_ = Kind::obstacle;
  sign_ = obstacle->side == Side::above ? -1.0 : 1.0;
  gap_ = obstacle->gap;
  velocity_ *= sign_;
  const double clearance = sign_ * start.displacement + gap_;
  const double touch = 4.0 * rounding * (std::abs(start.displacement) + gap_);
  place_ = clearance <= touch ? 0.0 : clearance;
}

void End::answer(const Piecewise& arriving, double until, const Scale& scale, Piecewise& sent) {
  sent.clear();
  marks_.clear();
  turns_.clear();
  latest_.time -= 1.0;
  marks_.push_back({0.0, place_, 0.0, borne_.impulse, closed_});
  widen_to(place_);
  for (std::size_t i = 0; i < arriving.size() && arriving[i].begin < until; ++i) {
    const double end = std::min(until, arriving[i].end);
    if (rate_ > 0.0)
      send_behind(arriving[i], sign_ * arriving.polynomial(i), end, scale, sent);
    else if (kind_ == Kind::obstacle)
      meet(arriving, i, end, scale, sent);
    else
      send(arriving[i], arriving.polynomial(i), end, sent);
  }
  const Mark& last = marks_.back();
  place_ = kind_ == Kind::fixed || last.closed ? last.place : place_after(last, sent.integral());
}

void End::send(const Piecewise::Piece& piece, const Chebyshev& arriving, double until, Piecewise& sent) {
  const Chebyshev p = kind_ == Kind::fixed || closed_ ? -arriving : arriving;
  const double before = sent.integral(), begin = sent.end();
  if (until <= begin) return;
  sent.append(until, piece, sign_ * p);
  if (kind_ == Kind::fixed) return;
  const double z_begin = piece.z(begin), z_end = piece.z(until);
  if (!closed_) {
    const Mark& last = marks_.back();
    return widen(p.restricted(z_begin, z_end), until - begin, place_after(last, before),
                 place_after(last, sent.integral()));
  }
  borne_.impulse += of_sent(sent.integral()) - of_sent(before);
  const double known = std::abs(latest_.reaction);
  if (p.upper() <= known) return;
  const double largest = maximum(p.restricted(z_begin, z_end), known, roundings * p.bound());
  const double middle = 0.5 * (begin + until);
  const double where =
      std::max({begin, middle, until}, [&](double a, double b) { return p(piece.z(a)) < p(piece.z(b)); });
  borne_.max_reaction = std::max(borne_.max_reaction, latest_.raise(sign_ * largest, where));
}

void End::widen_to(double place) {
  borne_.lowest = std::min(borne_.lowest, place);
  borne_.highest = std::max(borne_.highest, place);
}

// The range of places by a path that leads from one to another; within it is looked for an extreme only where the
// velocity may have a zero that leads beyond what is known.
void End::widen(const Chebyshev& velocity, double duration, double from, double to) {
  widen_to(from);
  widen_to(to);
  if (velocity.lower() >= 0.0 || velocity.upper() <= 0.0) return;
  const double reach = passage_ * duration * velocity.bound();
  if (from - reach >= borne_.lowest && from + reach <= borne_.highest) return;
  const Chebyshev path = (0.5 * duration * passage_) * velocity.antiderivative() + from;
  const double tolerance = roundings * path.bound();
  borne_.highest = maximum(path, borne_.highest, tolerance);
  borne_.lowest = -maximum(-path, -borne_.lowest, tolerance);
}

void End::turn(double s, double velocity, const Piecewise& sent) {
  closed_ = !closed_;
  turns_.push_back({s, closed_ ? Change::closing : Change::opening, sign_ * velocity, latest_});
  if (closed_) latest_ = {0.0, s};
  marks_.push_back({s, 0.0, of_sent(sent.integral()), borne_.impulse, closed_});
}

// Where in [-1, 1] an end closes that has this velocity there.
std::optional<double> End::closing(const Chebyshev& velocity, double duration, double clearance,
                                   const Scale& scale) const {
  const double band = roundings * scale.velocity, touch = roundings * scale.place;
  const Chebyshev path = (0.5 * duration * passage_) * velocity.antiderivative() + clearance;
  // A contact that touches and is pressed closes where the pressure begins: the path tells no more than that it falls.
  if (clearance <= touch)
    if (const auto pressed = first_descent(velocity, band); pressed && path(*pressed) <= touch) return pressed;
  return first_descent(path, touch);
}

// The same as meet() and send() of an end with a mass.
void End::send_behind(const Piecewise::Piece& piece, const Chebyshev& arriving, double until, const Scale& scale,
                      Piecewise& sent) {
  const double longest = 2.0 / rate_;
  for (double begin = sent.end(); begin < until;) {
    const double before = sent.integral();
    double end = closed_ ? until : std::min(until, begin + longest);
    // No piece is left that would be too short for itself.
    if (until - end < 2.0 * Piecewise::shortest) end = until;
    const Chebyshev w = arriving.restricted(piece.z(begin), piece.z(end));
    const auto at = [&](double z) {
      return z >= 1.0 ? end
             : z <= -1.0
                 ? begin
                 : std::min(end, std::max(begin + 0.5 * (end - begin) * (z + 1.0), begin + Piecewise::shortest));
    };
    if (closed_) {
      ++searched_;
      const auto opens = first_descent(-w, roundings * scale.velocity);
      const double stop = opens ? at(*opens) : end;
      send(piece, arriving, stop, sent);
      if (opens) turn(stop, 0.0, sent), velocity_ = 0.0;
      begin = std::max(stop, sent.end());
      continue;
    }
    const double clearance = place_after(marks_.back(), before);
    const Chebyshev v = behind(w, 0.5 * rate_ * (end - begin), velocity_);
    std::optional<double> closes;
    if (kind_ == Kind::obstacle) {
      const double fall = (end - begin) * passage_ * std::min(0.0, v.lower()), touch = roundings * scale.place;
      if (clearance <= touch || clearance + fall < -touch)
        ++searched_, closes = closing(v, end - begin, clearance, scale);
    }
    const double stop = closes ? at(*closes) : end;
    if (stop > begin) {
      sent.append(stop, begin, end, sign_ * v);
      widen(v.restricted(-1.0, 2.0 * (stop - begin) / (end - begin) - 1.0), stop - begin, clearance,
            place_after(marks_.back(), sent.integral()));
    }
    velocity_ = v(closes ? *closes : 1.0);
    if (closes) {
      borne_.impulse += std::max(0.0, -velocity_) / rate_;
      turn(stop, velocity_, sent);
      velocity_ = 0.0;
    }
    begin = stop;
  }
}

// Piece i of what arrives, from where `sent` ends up to `end`.
void End::meet(const Piecewise& arriving, std::size_t i, double end, const Scale& scale, Piecewise& sent) {
  const Piecewise::Piece& piece = arriving[i];
  const Chebyshev whole = sign_ * arriving.polynomial(i);
  const double band = roundings * scale.velocity, touch = roundings * scale.place;
  // The sent wave lags behind by less than the shortest piece, where it begins with one that is shorter.
  double begin = sent.end();
  while (begin < end) {
    const double half = 0.5 * (end - begin);
    if (half < 0.5 * Piecewise::shortest) break;
    const double clearance = closed_ ? 0.0 : place_after(marks_.back(), sent.integral());
    const double fall = 2.0 * half * passage_ * std::min(0.0, whole.lower());
    if (closed_ ? whole.upper() <= band : clearance + fall >= -touch && clearance > touch) break;
    ++searched_;
    const Chebyshev p = whole.restricted(piece.z(begin), piece.z(end));
    std::optional<double> z;
    if (closed_) {
      z = first_descent(-p, band);
    } else {
      z = closing(p, 2.0 * half, clearance, scale);
    }
    if (!z) break;
    // A zero after the beginning that rounds to it would be met again and again.
    if (*z >= 1.0)
      begin = end;
    else if (*z > -1.0)
      begin = std::min(end, begin + std::max(half * (*z + 1.0), Piecewise::shortest));
    send(piece, whole, begin, sent);
    turn(begin, p(*z), sent);
  }
  if (begin < end) send(piece, whole, end, sent);
}

const End::Mark& End::mark_at(double s) const {
  auto next = std::ranges::lower_bound(marks_, s, {}, &Mark::s);           // a change tells the side before it,
  if (s <= 0.0) next = std::ranges::upper_bound(marks_, s, {}, &Mark::s);  // but at the beginning there is none
  return next == marks_.begin() ? *next : *(next - 1);
}

std::pair<double, double> End::range() const {
  const double a = displacement_of(borne_.lowest), b = displacement_of(borne_.highest);
  return sign_ < 0.0 ? std::pair(b, a) : std::pair(a, b);
}

double End::impulse_at(double s, Cursor& sent) const {
  const Mark& mark = mark_at(s);
  return sign_ * (mark.impulse + (mark.closed ? of_sent(sent.integral(s)) - mark.sent : 0.0));
}

double End::displacement_at(double s, Cursor& sent) const {
  const Mark& mark = mark_at(s);
  const bool held = kind_ == Kind::fixed || mark.closed;
  return displacement_of(held ? mark.place : place_after(mark, sent.integral(s)));
}

double End::velocity_at(double s, Cursor& sent) const { return held_at(s) ? 0.0 : sent.value(s); }

double End::force_at(double s, Cursor& sent) const {
  if (kind_ == Kind::fixed) return sent.value(s);
  return mark_at(s).closed ? sign_ * std::max(0.0, of_sent(sent.value(s))) : 0.0;
}

}  // namespace viscobar::characteristics
