#include "characteristics/load_gain.hpp"

#include <array>
#include <variant>

#include "discretisation/gauss.hpp"

namespace viscobar::characteristics {

namespace {

constexpr std::size_t most_pairs = 400;  // of a break in x and one in t

const Piecewise& fitted(PiecewiseFit& fit, const SpaceFunction& profile, const Places& places, const Frame& frame,
                        const char* what) {
  const std::vector<double> breaks = shares_of(places.breaks, frame.length),
                            guards = shares_of(places.detail, frame.length);
  return fit.of(
      [&](double place) {
        const double x = frame.x(place);
        return finite_load(
            frame.start, [&] { return profile(x); }, [&] { return fmt::format("{} at x = {}", what, x); });
      },
      {.breaks = breaks, .guards = guards});
}

class SteadyGain final : public LoadGain {
 public:
  SteadyGain(const SteadyLoad& load, const Frame& frame) : LoadGain(frame.delay) {
    const Piecewise& density = fitted(fit_, load.profile, load.places, frame, "the load");
    evaluations_ = fit_.evaluations();
    memory.arrivals = frame.factor * fit_.error();
    const double whole = frame.factor * density.integral();
    for (std::size_t i = 0; i < density.size(); ++i) {
      const Piecewise::Piece& piece = density[i];
      Chebyshev sum = density.polynomial(i).antiderivative();
      sum += piece.before / piece.half - sum(piece.z(piece.begin));
      sum *= piece.half * frame.factor;
      rightward_.append(piece.end, piece, sum);
      leftward_.append(piece.end, piece, -sum + whole);
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

class SeparableGain final : public LoadGain {
 public:
  SeparableGain(const SeparableLoad& load, const Frame& frame)
      : LoadGain(frame.delay),
        history_(load.history),
        frame_(frame),
        breaks_of_history_(load.breaks, frame),
        recent_(static_cast<std::size_t>(std::ceil(frame.delay)) + 1) {
    profile_ = fitted(fit_, load.profile, load.places, frame, "the profile");
    profile_error_ = fit_.error();
    profile_bound_ = profile_.bound();
    evaluations_ = profile_evaluations_ = fit_.evaluations();
    for (std::size_t i = 0; i + 1 < profile_.size(); ++i) places_.push_back(profile_[i].end);
  }

 private:
  void prepare() override {
    std::rotate(recent_.begin(), recent_.end() - 1, recent_.end());
    breaks_of_history_.enter(window_);
    cuts_.clear();
    for (const double break_time : breaks_of_history_.times())
      if (break_time > time(0.0) && break_time < time(1.0)) cuts_.push_back((break_time - time(0.0)) * delay_);
    const double argument = (time(1.0) + std::abs(frame_.start) / frame_.passage) * delay_;  // in windows
    recent_.front() = history_fit_.of(
        [&](double s) {
          const double t = frame_.t(time(s));
          return finite_load(
              t, [&] { return history_(t); }, [&] { return fmt::format("the history of the load at t = {}", t); });
        },
        {.breaks = cuts_,
         .apart = 64.0 * rounding * (argument + 1.0),
         .argument = argument,
         .what = "the history of the load"});
    memory.arrivals +=
        frame_.factor / delay_ * (profile_error_ * recent_.front().bound() + profile_bound_ * history_fit_.error());
    evaluations_ = profile_evaluations_ + history_fit_.evaluations();
    // Where windows are shorter than a passage the history goes on from one to the next.
    const bool passages = delay_ == 1.0;
    times_.clear();
    for (std::size_t j = recent_.size(); j-- > 0;)
      for (std::size_t i = passages ? 0 : 1; i < recent_[j].size(); ++i)
        times_.push_back((static_cast<double>(window_) - static_cast<double>(j) + recent_[j][i].begin) / delay_);
    if (!passages) times_.insert(times_.end(), breaks_of_history_.times().begin(), breaks_of_history_.times().end());
  }

  double size() const override {
    double largest = 0.0;
    for (const Piecewise& history : recent_) largest = std::max(largest, history.bound());
    return sums * frame_.factor * profile_bound_ * largest;
  }

  double gain(const Way& way) override {
    const double now = way.time * delay_ - static_cast<double>(window_);
    double sum = 0.0, come = 0.0;
    for (std::size_t j = 0; j < recent_.size() && come < way.length; ++j) {
      const double s = j == 0 ? now : 1.0, length = std::clamp(s / delay_, 0.0, way.length - come);
      sum += part(recent_[j], way.place + (way.rightward ? -come : come), s, length, way.rightward);
      come += length;
    }
    return frame_.factor * sum;
  }

  // int_0^length p(place -+ r) h(s - delay r) dr within one window: between breaks of either a polynomial.
  double part(const Piecewise& history, double place, double s, double length, bool rightward) const {
    if (length <= 0.0 || history.empty()) return 0.0;
    std::size_t i = profile_.size() - 1, j = history.size() - 1;
    while (i > 0 && (rightward ? profile_[i].begin >= place : profile_[i].begin > place)) --i;
    while (j > 0 && history[j].begin >= s) --j;
    double sum = 0.0, r = 0.0;
    while (r < length) {
      double to = length;
      const double of_place = rightward ? place - profile_[i].begin : profile_[i].end - place;
      const double of_time = (s - history[j].begin) / delay_;
      const bool next_place = (rightward ? i > 0 : i + 1 < profile_.size()) && of_place <= to;
      if (next_place) to = std::max(r, of_place);
      const bool next_time = j > 0 && of_time <= to;
      if (next_time) to = std::max(r, of_time);
      const double half = 0.5 * (to - r), middle = 0.5 * (to + r);
      if (half > 0.0) {
        const Chebyshev p = profile_.polynomial(i), h = history.polynomial(j);
        const std::span<const GaussPoint> formula = gauss((p.terms() + h.terms()) / 2 + 1);
        std::array<double, Chebyshev::most_places> of_p, of_h, values_p, values_h;
        const std::size_t count = formula.size();
        for (std::size_t k = 0; k < count; ++k) {
          const double way = middle + half * formula[k].node;
          of_p[k] = profile_[i].z(rightward ? place - way : place + way);
          of_h[k] = history[j].z(s - way * delay_);
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
  Piecewise profile_;
  std::vector<Piecewise> recent_;  // the history in this window and in those of the passage before, the newest first
  double profile_error_ = 0.0, profile_bound_ = 0.0;
  std::size_t profile_evaluations_ = 0;
  std::vector<double> places_, times_, cuts_;
};

}  // namespace

std::unique_ptr<LoadGain> LoadGain::of(const Load& load, const Bar& bar, double passage, double delay, double start,
                                       double end) {
  const Frame frame{bar.length, passage, delay, start, passage / bar.density};
  if (const auto* steady = std::get_if<SteadyLoad>(&load)) return std::make_unique<SteadyGain>(*steady, frame);
  if (const auto* separable = std::get_if<SeparableLoad>(&load))
    return std::make_unique<SeparableGain>(*separable, frame);
  return general_gain(std::get<GeneralLoad>(load), frame, (end - start) / passage);
}

void LoadGain::recall(std::size_t window) {
  window_ = window;
  prepare();
}

void LoadGain::enter(std::size_t window) {
  recall(window);
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
  const bool pairs = places().size() * times().size() <= most_pairs;
  for (const bool rightward : {true, false}) {
    breaks_.clear();
    const auto add = [this](double at) { add_break((at - time(0.0)) * delay_); };
    for (const double at : times()) {
      add(at);
      add(at + 1.0);
      if (pairs)
        for (const double place : places()) add(at + (rightward ? 1.0 - place : place));
    }
    Piecewise& arriving = rightward ? arriving_right_ : arriving_left_;
    arriving = represented([&](double s) {
      return gain({rightward ? 1.0 : 0.0, time(s), std::min(1.0, time(s)), rightward});
    });
    memory.arrivals += fit_.error() / delay_;
  }
}

void LoadGain::look(double s) {
  const double now = time(s);
  const bool pairs = places().size() * times().size() <= most_pairs;
  for (const bool onward : {true, false}) {
    breaks_.clear();
    for (const double place : places()) add_break(place);
    for (const double at : times()) {
      const double way = now - at;
      add_break(onward ? way : 1.0 - way);
      if (pairs)
        for (const double place : places()) add_break(onward ? place + way : place - way);
    }
    Piecewise& on_the_way = onward ? rightward_ : leftward_;
    on_the_way = represented([&](double place) {
      return gain({place, now, std::min(onward ? place : 1.0 - place, now), onward});
    });
    memory.looked_at = std::max(memory.looked_at, fit_.error());
  }
}

}  // namespace viscobar::characteristics
