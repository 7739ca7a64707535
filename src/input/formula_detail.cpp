#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "input/formula_tree.hpp"

namespace viscobar {

namespace {

constexpr double far_from_linear = 1.0 / 50, coarse = 1.0 / 128, pulses = 0.5, finest = 1e-9;  // shares
constexpr std::size_t most_halvings = 20000, most_stretches = 1000;

}  // namespace

FormulaDetail::FormulaDetail(FormulaTree tree, bool along_x, Interval other)
    : tree_(std::move(tree)),
      switches_(along_x ? FormulaSwitches::along_x(tree_) : FormulaSwitches(tree_, false)),
      jets_(tree_.nodes.size()),
      along_x_(along_x),
      other_{other, {0.0, 0.0}} {}

void FormulaDetail::bound(const Jet& s) { tree_.bound(along_x_ ? s : other_, along_x_ ? other_ : s, jets_); }

std::optional<double> FormulaDetail::operator()(double after, double until) {
  // Waves ask for one passage after the other.
  if (until > until_) {
    until_ = until_ > 0.0 ? 2.0 * until : until;
    find();
  }
  const auto next = std::ranges::upper_bound(places_, after);
  return next != places_.end() && *next < until ? std::optional(*next) : std::nullopt;
}

void FormulaDetail::find() {
  constexpr int parts = 64;
  places_.clear();
  rounding_ = 64.0 * std::numeric_limits<double>::epsilon() * until_;
  double largest = 0.0;
  for (int i = 0; i < parts; ++i) {
    const Jet s{{until_ * i / parts, until_ * (i + 1) / parts}, {1.0, 1.0}};
    bound(s);
    largest = std::max({largest, jets_.back().value.high, -jets_.back().value.low});
  }
  if (largest == 0.0 || !std::isfinite(largest)) return;
  allowed_ = far_from_linear * largest;
  search(coarse);
  // Beside what goes on all the time a pulse is far shorter.
  if (!along_x_ && quiet_ < pulses * until_) search(coarse / 8.0);
  if (!along_x_ && covered_ > pulses * until_) places_.clear();
}

void FormulaDetail::search(double share) {
  places_.clear();
  effort_ = 0;
  covered_ = quiet_ = 0.0;
  coarse_ = share * until_;
  // Breaks may have a limit, as those of sin(1/x) > 0.
  std::size_t stretches = 0;
  for (double begin = 0.0, end = 0.0; begin < until_ && ++stretches < most_stretches; begin = end) {
    end = switches_.first(0.0, begin + rounding_, until_).value_or(until_);
    divide(begin, end);
  }
}

void FormulaDetail::divide(double begin, double end) {
  const double size = end - begin;
  if (size < 4.0 * rounding_ || (!along_x_ && covered_ > pulses * until_)) return;
  const Jet s{{begin + rounding_, end - rounding_}, {1.0, 1.0}};
  bound(s);
  const auto [value, slope] = jets_.back();
  const double apart = std::min(value.high - value.low, (slope.high - slope.low) * size / 4.0);
  if (apart > allowed_ && size > finest * until_ && ++effort_ < most_halvings) {
    divide(begin, begin + size / 2.0);
    divide(begin + size / 2.0, end);
    return;
  }
  if (value.high - value.low <= allowed_) quiet_ += size;
  if (size < coarse_) {
    covered_ += size;
    if (places_.empty() || places_.back() < begin) places_.push_back(begin);
    places_.push_back(end);
  }
}

}  // namespace viscobar
