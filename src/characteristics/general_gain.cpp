#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "characteristics/load_gain.hpp"
#include "discretisation/gauss.hpp"

namespace viscobar::characteristics {

namespace {

// Clenshaw and Curtis' formula with 17 points, exact to degree 17. Its points include the ends: what breaks close to
// them would pass between the points of Gauss' formula.
std::span<const GaussPoint> clenshaw_curtis() {
  static const std::array<GaussPoint, 17> formula = [] {
    constexpr std::size_t n = 16;
    std::array<GaussPoint, n + 1> list;
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

class GeneralGain final : public LoadGain {
 public:
  GeneralGain(const GeneralLoad& load, const Frame& frame, double passages)
      : LoadGain(frame.delay),
        density_(load.density),
        frame_(frame),
        breaks_of_density_(load.breaks, frame, load.sharp) {
    // A load that is small beside its values at other times need not be known to its own rounding.
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
  void prepare() override {
    rough_ = 0;
    breaks_of_density_.enter(window_);
  }
  // It does not change what follows: a run that goes on from a checkpoint does not look again.
  void look(double s) override {
    rough_ = 0;
    const Memory before = memory;
    LoadGain::look(s);
    memory.largest = before.largest, memory.steepest = before.steepest;
  }

  double at(const Way& way, double r) {
    ++evaluations_;
    r = inside_.first < inside_.second ? std::clamp(r, inside_.first, inside_.second) : r;
    const double x = frame_.x(std::clamp(way.rightward ? way.place - r : way.place + r, 0.0, 1.0));
    const double t = frame_.t(std::max(0.0, way.time - r));
    const double value = finite_load(
        t, [&] { return density_(x, t); }, [&] { return fmt::format("the load at x = {}, t = {}", x, t); });
    memory.largest = std::max(memory.largest, std::abs(value));
    return value;
  }
  // Errors by roundings of the time count like its own.
  double argument() const { return time(1.0) + std::abs(frame_.start) / frame_.passage; }
  double size() const override {
    return sums * frame_.factor * std::max(small_, memory.largest + argument() * memory.steepest);
  }

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
      if (place < 2.0)
        memory.steepest = std::max(memory.steepest, std::abs(f - last) / std::max(half * (place - node), 0.1));
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
    const double of_time = argument() * memory.steepest * (to - from);
    const double tolerance = rounding * (32.0 * std::max(size, small_ * way.length) + 8.0 * of_time);
    if (std::abs(left.value + right.value - whole.value) <= tolerance || depth >= 48 || !(from < middle && middle < to))
      return left.value + right.value;
    if (depth >= shallow) rough_ += 100;  // of halves, and of a search for a jump
    if (rough_ > most_rough)
      throw StepFailure(
          Failure::detail,
          fmt::format("more than {} evaluations of the load for one output or passage of a wave went into "
                      "jumps and kinks that are not where the formula is known to break, as where its breaks "
                      "travel; method.name = \"rigid\" takes such a load on a mesh",
                      most_rough));
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
  std::size_t rough_ = 0;               // evaluations of the present look or window where it is
  std::pair<double, double> inside_{};  // where the load is evaluated
  double small_ = 0.0;                  // beside the load at other times
};

}  // namespace

std::unique_ptr<LoadGain> general_gain(const GeneralLoad& load, const Frame& frame, double passages) {
  return std::make_unique<GeneralGain>(load, frame, passages);
}

}  // namespace viscobar::characteristics
