#include "characteristics/load_gain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>

#include "characteristics/gauss_legendre.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::characteristics {

namespace {

constexpr std::size_t most_breaks = 10'000;  // of a load, in one passage
constexpr std::size_t most_pairs = 400;      // of a break in x and one in t
constexpr double sums = 8.0;                 // roundings that a sum of some dozens of terms adds up
constexpr std::size_t most_evaluations = 200'000'000;

// Of a load at `place`, which says where and when.
double finite(double t, auto&& load, auto&& place) {
  double value = 0.0;
  try {
    value = load();
  } catch (const std::exception& error) {
    throw LoadError(t, fmt::format("{} cannot be evaluated: {}", place(), error.what()));
  }
  if (!std::isfinite(value))
    throw LoadError(t, fmt::format("{} is {}", place(), std::isnan(value) ? "not a number" : "infinite"));
  return value;
}

// The bar, in lengths of it and in passages.
struct Frame {
  double length, passage, start, factor;  // factor: L / (rho c)
  double x(double place) const { return length * place; }
  double t(double time) const { return start + passage * time; }
};

class SteadyGain final : public LoadGain {
 public:
  SteadyGain(const SteadyLoad& load, const Frame& frame) {
    const Piecewise& density = fit_.of([&](double place) {
      const double x = frame.x(place);
      return finite(
          frame.start, [&] { return load.profile(x); }, [&] { return fmt::format("the load at x = {}", x); });
    });
    evaluations_ = fit_.evaluations();
    errors_.arrivals = frame.factor * fit_.error();
    const double whole = frame.factor * density.integral();
    for (std::size_t i = 0; i < density.size(); ++i) {
      const Piecewise::Piece& piece = density[i];
      const double from = piece.middle - piece.half, to = piece.middle + piece.half;
      Chebyshev sum = density.polynomial(i).antiderivative();
      sum += piece.before / piece.half - sum(piece.z(piece.begin));
      sum *= piece.half * frame.factor;
      rightward_.append(piece.end, from, to, sum);
      sum *= -1.0;
      sum += whole;
      leftward_.append(piece.end, from, to, sum);
    }
    arriving_right_.append(1.0, 0.0, 1.0, Chebyshev::constant(whole));
    arriving_left_ = arriving_right_;
  }

  bool steady() const override { return true; }
  void look(double) override {}

 private:
  double gain(const Way&) override { return 0.0; }
  void arrivals() override {}
};

// Clenshaw and Curtis' formula with 17 points, exact to degree 17. Its points include the ends: what breaks close to
// them would pass between the points of Gauss' formula.
std::span<const GaussNode> clenshaw_curtis() {
  static const std::array<GaussNode, 17> formula = [] {
    constexpr std::size_t n = 16;
    std::array<GaussNode, n + 1> list;
    for (std::size_t k = 0; k <= n; ++k) {
      const double angle = std::numbers::pi * static_cast<double>(k) / n;
      double sum = 1.0;
      for (std::size_t j = 1; j <= n / 2; ++j)
        sum -= (2 * j == n ? 1.0 : 2.0) / static_cast<double>(4 * j * j - 1) *
               std::cos(2.0 * static_cast<double>(j) * angle);
      list[k] = {std::cos(angle), sum * (k == 0 || k == n ? 1.0 : 2.0) / n};
    }
    return list;
  }();
  return formula;
}

// Breaks of a load in time, in passages, of the present passage and the one before.
class Breaks {
 public:
  Breaks(NextBreak next, const Frame& frame) : next_(std::move(next)), frame_(frame) {}

  void enter(std::size_t passage) {
    const auto begin = static_cast<double>(passage);
    std::erase_if(times_, [&](double time) { return time < begin - 1.0; });
    if (passage == 0) times_.push_back(0.0);  // there the load begins
    if (!next_) return;
    const double until = frame_.t(begin + 1.0);
    const double apart = 64.0 * rounding * std::max(std::abs(until), std::abs(frame_.start));
    double after = frame_.t(begin) - (passage == 0 ? 0.0 : apart);
    for (std::size_t count = 0;; ++count) {
      const std::optional<double> at = next_(after, until);
      if (!at) return;
      if (count == most_breaks)
        throw LoadError(*at, fmt::format("the load breaks more than {} times in a passage of the wave", most_breaks));
      after = *at + apart;
      const double time = (*at - frame_.start) / frame_.passage;
      if (times_.empty() || time > times_.back()) times_.push_back(time);
    }
  }
  std::span<const double> times() const { return times_; }

 private:
  NextBreak next_;
  Frame frame_;
  std::vector<double> times_;
};

class SeparableGain final : public LoadGain {
 public:
  SeparableGain(const SeparableLoad& load, const Frame& frame)
      : history_(load.history), frame_(frame), breaks_of_history_(load.breaks, frame) {
    profile_ = fit_.of([&](double place) {
      const double x = frame.x(place);
      return finite(
          frame.start, [&] { return load.profile(x); }, [&] { return fmt::format("the profile at x = {}", x); });
    });
    profile_error_ = fit_.error();
    profile_bound_ = profile_.bound();
    evaluations_ = profile_evaluations_ = fit_.evaluations();
    for (std::size_t i = 0; i + 1 < profile_.size(); ++i) places_.push_back(profile_[i].end);
  }

 private:
  void prepare(std::size_t passage) override {
    std::swap(before_, now_);
    breaks_of_history_.enter(passage);
    const auto begin = static_cast<double>(passage);
    cuts_.clear();
    for (const double time : breaks_of_history_.times())
      if (time > begin && time < begin + 1.0) cuts_.push_back(time - begin);
    now_ = history_fit_.of(
        [&](double s) {
          const double t = frame_.t(begin + s);
          return finite(
              t, [&] { return history_(t); }, [&] { return fmt::format("the history of the load at t = {}", t); });
        },
        {.breaks = cuts_,
         .apart = 64.0 * rounding * (begin + 2.0 + std::abs(frame_.start) / frame_.passage),
         .argument = begin + 1.0 + std::abs(frame_.start) / frame_.passage});
    errors_.arrivals += frame_.factor * (profile_error_ * now_.bound() + profile_bound_ * history_fit_.error());
    evaluations_ = profile_evaluations_ + history_fit_.evaluations();
    times_.clear();
    if (passage > 0)
      for (std::size_t i = 0; i < before_.size(); ++i) times_.push_back(begin - 1.0 + before_[i].begin);
    for (std::size_t i = 0; i < now_.size(); ++i) times_.push_back(begin + now_[i].begin);
  }

  double size() const override {
    return sums * frame_.factor * profile_bound_ * std::max(now_.bound(), before_.bound());
  }

  double gain(const Way& way) override {
    const auto begin = static_cast<double>(passage_);
    const double in_now = std::clamp(way.time - begin, 0.0, way.length);
    double sum = part(now_, way.place, way.time - begin, in_now, way.rightward);
    if (way.length > in_now)
      sum += part(before_, way.place + (way.rightward ? -in_now : in_now), 1.0, way.length - in_now, way.rightward);
    return frame_.factor * sum;
  }

  // int_0^length p(place -+ r) h(s - r) dr within one passage: between breaks of either a polynomial.
  double part(const Piecewise& history, double place, double s, double length, bool rightward) const {
    if (length <= 0.0 || history.empty()) return 0.0;
    std::size_t i = profile_.size() - 1, j = history.size() - 1;
    while (i > 0 && (rightward ? profile_[i].begin >= place : profile_[i].begin > place)) --i;
    while (j > 0 && history[j].begin >= s) --j;
    double sum = 0.0, r = 0.0;
    while (r < length) {
      double to = length;
      const double of_place = rightward ? place - profile_[i].begin : profile_[i].end - place;
      const double of_time = s - history[j].begin;
      const bool next_place = (rightward ? i > 0 : i + 1 < profile_.size()) && of_place <= to;
      if (next_place) to = std::max(r, of_place);
      const bool next_time = j > 0 && of_time <= to;
      if (next_time) to = std::max(r, of_time);
      const double half = 0.5 * (to - r), middle = 0.5 * (to + r);
      if (half > 0.0) {
        const Chebyshev p = profile_.polynomial(i), h = history.polynomial(j);
        const std::span<const GaussNode> formula = gauss_legendre((p.terms() + h.terms()) / 2 + 1);
        std::array<double, Chebyshev::most_places> of_p, of_h, values_p, values_h;
        const std::size_t count = formula.size();
        for (std::size_t k = 0; k < count; ++k) {
          const double way = middle + half * formula[k].node;
          of_p[k] = profile_[i].z(rightward ? place - way : place + way);
          of_h[k] = history[j].z(s - way);
        }
        p.at({of_p.data(), count}, {values_p.data(), count});
        h.at({of_h.data(), count}, {values_h.data(), count});
        double cell = 0.0;
        for (std::size_t k = 0; k < count; ++k) cell += formula[k].weight * values_p[k] * values_h[k];
        sum += half * cell;
      }
      r = to;
      if (next_time)
        --j;
      else if (next_place)
        rightward ? --i : ++i;
      else
        break;
    }
    return sum;
  }

  std::span<const double> places() const override { return places_; }
  std::span<const double> times() const override { return times_; }

  TimeFunction history_;
  Frame frame_;
  Breaks breaks_of_history_;
  PiecewiseFit history_fit_;
  Piecewise profile_, now_, before_;  // the history in this passage and in the one before
  double profile_error_ = 0.0, profile_bound_ = 0.0;
  std::size_t profile_evaluations_ = 0;
  std::vector<double> places_, times_, cuts_;
};

class GeneralGain final : public LoadGain {
 public:
  GeneralGain(const GeneralLoad& load, const Frame& frame, double passages)
      : density_(load.density), frame_(frame), breaks_of_density_(load.breaks, frame) {
    // What is nothing beside the load at other times need not be known to its own rounding.
    constexpr int samples = 300;
    double largest = 0.0;
    for (int k = 0; k < samples; ++k) {
      const double place = std::fmod(0.5 + 0.6180339887498949 * k, 1.0), time = passages * (k + 0.5) / samples;
      try {
        if (const double f = density_(frame_.x(place), frame_.t(time)); std::isfinite(f))
          largest = std::max(largest, std::abs(f));
      } catch (const std::exception&) {  // the run may end before
      }
    }
    evaluations_ = samples;
    small_ = 0.01 * largest;
  }

 private:
  void prepare(std::size_t passage) override {
    evaluations_before_ = evaluations_;
    breaks_of_density_.enter(passage);
  }
  void look(double s) override {
    evaluations_before_ = evaluations_;
    LoadGain::look(s);
  }

  double at(const Way& way, double r) {
    if (++evaluations_ - evaluations_before_ > most_evaluations)
      throw LoadError(frame_.t(way.time),
                      fmt::format("the load was evaluated {} times for one output or passage: it is too rough to be "
                                  "followed to rounding; tell where it breaks, or use rigid",
                                  most_evaluations));
    r = inside_.first < inside_.second ? std::clamp(r, inside_.first, inside_.second) : r;
    const double x = frame_.x(std::clamp(way.rightward ? way.place - r : way.place + r, 0.0, 1.0));
    const double t = frame_.t(std::max(0.0, way.time - r));
    const double value = finite(
        t, [&] { return density_(x, t); }, [&] { return fmt::format("the load at x = {}, t = {}", x, t); });
    largest_ = std::max(largest_, std::abs(value));
    return value;
  }
  // What roundings of the time do to it counts like its own.
  double argument() const { return static_cast<double>(passage_) + 1.0 + std::abs(frame_.start) / frame_.passage; }
  double size() const override { return sums * frame_.factor * std::max(small_, largest_ + argument() * steepest_); }

  struct Sum {
    double value, size;
  };
  Sum formula(const Way& way, double from, double to) {
    Sum sum{0.0, 0.0};
    const double half = 0.5 * (to - from), middle = 0.5 * (to + from);
    double last = 0.0, place = 2.0;
    for (const auto [node, weight] : clenshaw_curtis()) {
      const double f = at(way, middle + half * node), value = half * weight * f;
      sum.value += value;
      sum.size += std::abs(value);
      // A jump is no slope, so only what changes over a tenth of the bar counts as one.
      if (place < 2.0) steepest_ = std::max(steepest_, std::abs(f - last) / std::max(half * (place - node), 0.1));
      last = f;
      place = node;
    }
    return sum;
  }
  // Halves until both halves make what the whole does, to rounding of the whole way's size.
  double halved(const Way& way, double from, double to, const Sum& whole, double size, int depth) {
    const double middle = 0.5 * (from + to);
    const Sum left = formula(way, from, middle), right = formula(way, middle, to);
    size = std::max(size, left.size + right.size);
    // To roundings of the load, and of the time at which it is evaluated.
    const double of_time = argument() * steepest_ * (to - from);
    const double tolerance = rounding * (32.0 * std::max(size, small_ * way.length) + 8.0 * of_time);
    if (std::abs(left.value + right.value - whole.value) <= tolerance || depth >= 48 || !(from < middle && middle < to))
      return left.value + right.value;
    if (depth >= shallow)
      if (const auto sum = across_a_jump(way, from, to, tolerance)) return *sum;
    return halved(way, from, middle, left, size, depth + 1) + halved(way, middle, to, right, size, depth + 1);
  }

  // On so short a way a load that jumps once is, but for that, as good as constant: where it jumps is found by halving
  // the way, a value each.
  std::optional<double> across_a_jump(const Way& way, double from, double to, double tolerance) {
    const double before = at(way, from), after = at(way, to);
    double low = from, high = to;
    for (int step = 0; step < 60; ++step) {
      const double r = 0.5 * (low + high), value = at(way, r);
      (std::abs(value - before) <= std::abs(value - after) ? low : high) = r;
    }
    double sum = 0.0;
    for (const auto& [begin, end] : {std::pair{from, low}, std::pair{high, to}}) {
      const double middle = 0.5 * (begin + end),
                   halves = formula(way, begin, middle).value + formula(way, middle, end).value;
      if (std::abs(halves - formula(way, begin, end).value) > tolerance) return std::nullopt;
      sum += halves;
    }
    return sum;
  }

  double gain(const Way& way) override {
    double sum = 0.0, from = 0.0;
    const std::span<const double> times = breaks_of_density_.times();
    for (std::size_t k = times.size(); k-- > 0 && from < way.length;) {
      const double to = way.time - times[k];
      if (to <= from || to >= way.length) continue;
      sum += over(way, from, to);
      from = to;
    }
    return frame_.factor * (sum + over(way, from, way.length));
  }
  double over(const Way& way, double from, double to) {
    if (!(from < to)) return 0.0;
    // A break that is told is at one end, and counts on its own side of it.
    const double apart = 64.0 * rounding * argument();
    inside_ = {from + apart, to - apart};
    const Sum whole = formula(way, from, to);
    return halved(way, from, to, whole, whole.size, 0);
  }

  std::span<const double> times() const override { return breaks_of_density_.times(); }

  SpaceTimeFunction density_;
  Frame frame_;
  static constexpr int shallow = 6;  // halvings
  Breaks breaks_of_density_;
  std::size_t evaluations_before_ = 0;     // the present look or passage
  std::pair<double, double> inside_{};     // where the load is evaluated
  double small_ = 0.0;                     // beside the load at other times
  double largest_ = 0.0, steepest_ = 0.0;  // of what has been seen
};

}  // namespace

std::unique_ptr<LoadGain> LoadGain::of(const Load& load, const Bar& bar, double passage, double start, double end) {
  const Frame frame{bar.length, passage, start, passage / bar.density};
  if (const auto* steady = std::get_if<SteadyLoad>(&load)) return std::make_unique<SteadyGain>(*steady, frame);
  if (const auto* separable = std::get_if<SeparableLoad>(&load))
    return std::make_unique<SeparableGain>(*separable, frame);
  return std::make_unique<GeneralGain>(std::get<GeneralLoad>(load), frame, (end - start) / passage);
}

void LoadGain::enter(std::size_t passage) {
  passage_ = passage;
  prepare(passage);
  arrivals();
}

void LoadGain::add_break(double s) {
  constexpr double apart = 1e-14;
  if (s > apart && s < 1.0 - apart) breaks_.push_back(s);
}

const Piecewise& LoadGain::represented(const std::function<double(double)>& f) {
  std::ranges::sort(breaks_);
  breaks_.erase(std::unique(breaks_.begin(), breaks_.end(), [](double a, double b) { return b - a < 1e-14; }),
                breaks_.end());
  return fit_.of(f, {.breaks = breaks_, .smooth = true, .size = size()});
}

// Kinks come from a break in time that meets one in x, the ends being such, or is met by the way's own beginning.
void LoadGain::arrivals() {
  const auto begin = static_cast<double>(passage_);
  const bool pairs = places().size() * times().size() <= most_pairs;
  for (const bool rightward : {true, false}) {
    breaks_.clear();
    for (const double time : times()) {
      add_break(time - begin);
      add_break(time - begin + 1.0);
      if (pairs)
        for (const double place : places()) add_break(time - begin + (rightward ? 1.0 - place : place));
    }
    Piecewise& arriving = rightward ? arriving_right_ : arriving_left_;
    arriving = represented([&](double s) {
      return gain({rightward ? 1.0 : 0.0, begin + s, std::min(1.0, begin + s), rightward});
    });
    errors_.arrivals += fit_.error();
  }
}

void LoadGain::look(double s) {
  const double now = static_cast<double>(passage_) + s;
  const bool pairs = places().size() * times().size() <= most_pairs;
  for (const bool onward : {true, false}) {
    breaks_.clear();
    for (const double place : places()) add_break(place);
    for (const double time : times()) {
      const double way = now - time;
      add_break(onward ? way : 1.0 - way);
      if (pairs)
        for (const double place : places()) add_break(onward ? place + way : place - way);
    }
    Piecewise& on_the_way = onward ? rightward_ : leftward_;
    on_the_way = represented([&](double place) {
      return gain({place, now, std::min(onward ? place : 1.0 - place, now), onward});
    });
    errors_.looked_at = std::max(errors_.looked_at, fit_.error());
  }
}

}  // namespace viscobar::characteristics
