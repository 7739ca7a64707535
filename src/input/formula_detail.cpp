#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "input/formula_tree.hpp"

namespace viscobar {

namespace {

constexpr double far_from_linear = 1.0 / 50, coarse = 1.0 / 128, pulses = 0.5, finest = 1e-9;  // shares
constexpr std::size_t most_halvings = 20000, most_stretches = 1000;

}  // namespace

FormulaDetail::FormulaDetail(std::shared_ptr<const FormulaTree> tree, bool along_x, Interval other)
    : tree_(std::move(tree)),
      switches_(tree_, along_x ? FormulaSwitches::Of::along_x : FormulaSwitches::Of::of_all_x),
      jets_(tree_->size()),
      middle_(jets_),
      along_x_(along_x),
      other_{other, {0.0, 0.0}} {}

// Each part of the formula by its mean value form as well: what it is in the middle, and its slope times the way from
// there. So (t - 1)*(t - 1) is bounded like (t - 1)^2.
void FormulaDetail::bound(const Jet& s) {
  const double middle = s.value.low + (s.value.high - s.value.low) / 2.0;
  const Jet point{{middle, middle}, s.slope};
  const Interval way{s.value.low - middle, s.value.high - middle};
  Jet *const at_middle = tree_->of_nodes(middle_.data()), *const over = tree_->of_nodes(jets_.data());
  const auto evaluate = [&](const Jet& along, Jet* out, auto&& done) {
    tree_->evaluate(along_x_ ? along : other_, along_x_ ? other_ : along, out, FormulaTree::bound, done);
  };
  evaluate(point, at_middle, [](std::size_t, Jet&) {});
  evaluate(s, over,
           [&](std::size_t i, Jet& jet) { jet.value = common(jet.value, at_middle[i].value + jet.slope * way); });
}

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
  places_.clear();
  rounding_ = 64.0 * std::numeric_limits<double>::epsilon() * until_;
  const double largest = this->largest();
  if (largest == 0.0) return;
  allowed_ = far_from_linear * largest;
  search(coarse);
  // Beside what goes on all the time a pulse is far shorter.
  if (!along_x_ && quiet_ < pulses * until_) search(coarse / 8.0);
  if (!along_x_ && covered_ > pulses * until_) places_.clear();
}

// A bound of |f| that is at most twice a value of it: where bounds are greatest they are halved. Where that does not
// come to an end, the greatest value that was met. Beside a pole nothing counts: 0.
double FormulaDetail::largest() {
  constexpr int parts = 64, most = 4000;
  const auto size = [](Interval of) { return std::max(of.high, -of.low); };
  double met = 0.0;
  std::priority_queue<std::tuple<double, double, double>> bounds;  // each with its interval
  const auto add = [&](double begin, double end) {
    bound({{begin, end}, {1.0, 1.0}});
    if (const double value = size(tree_->of_nodes(middle_.data())[tree_->root].value); std::isfinite(value))
      met = std::max(met, value);
    bounds.emplace(size(tree_->of_nodes(jets_.data())[tree_->root].value), begin, end);
  };
  for (int i = 0; i < parts; ++i) add(until_ * i / parts, until_ * (i + 1) / parts);
  for (int i = 0; i < most && std::get<0>(bounds.top()) > 2.0 * met; ++i) {
    const auto [most_there, begin, end] = bounds.top();
    bounds.pop();
    const double middle = begin + (end - begin) / 2.0;
    add(begin, middle);
    add(middle, end);
  }
  const double most_of_all = std::get<0>(bounds.top());
  return std::isfinite(most_of_all) ? std::min(most_of_all, 2.0 * met) : 0.0;
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
  const auto [value, slope] = tree_->of_nodes(jets_.data())[tree_->root];
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
