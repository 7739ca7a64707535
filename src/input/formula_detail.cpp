#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "input/formula_tree.hpp"
#include "input/known.hpp"

namespace viscobar {

namespace {

constexpr double far_from_linear = 1.0 / 50, coarse = 1.0 / 128, shorter = coarse / 8.0, pulses = 0.5, finest = 1e-9,
                 narrowest = 1e-4;  // shares
constexpr std::size_t most_halvings = 20000, most_stretches = 1000;

}  // namespace

FormulaDetail::FormulaDetail(std::shared_ptr<const FormulaTree> tree, bool along_x, Interval other)
    : tree_(std::move(tree)),
      switches_(tree_, along_x ? FormulaSwitches::Of::along_x : FormulaSwitches::Of::of_all_x),
      travelling_(tree_, FormulaSwitches::Of::at_x),
      jets_(tree_->size()),
      middle_(jets_),
      along_x_(along_x),
      whole_(other),
      other_{other, {0.0, 0.0}} {
  constexpr int some = 8;
  if (along_x || travelling_.empty())
    others_ = {other};
  else
    for (int k = 0; k <= some; ++k) others_.emplace_back(other.low + (other.high - other.low) * k / some);
}

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
    // The scene, its estimates and its judges have copies of one density, and all look in the same interval.
    static Known<std::tuple<std::shared_ptr<const FormulaTree>, double, double>, Places> all;
    places_ = along_x_ ? find() : all({tree_, whole_.high, until_}, [this] { return find(); });
  }
  const auto next = std::ranges::upper_bound(*places_, after);
  return next != places_->end() && *next < until ? std::optional(*next) : std::nullopt;
}

FormulaDetail::Places FormulaDetail::find() {
  constexpr int levels = 4;
  std::vector<double> places;
  rounding_ = 64.0 * std::numeric_limits<double>::epsilon() * until_;
  Stretches rest{{0.0, until_}};
  for (int level = 0; level < (along_x_ ? 1 : levels); ++level) {
    const double largest = this->largest(rest);
    if (largest == 0.0) break;
    allowed_ = far_from_linear * largest;
    search(rest);
    take_shorter_than(coarse);
    // Beside what goes on all the time a pulse is far shorter.
    if (!along_x_ && quiet_ < pulses * until_) take_shorter_than(shorter);
    if (found_.empty() || (!along_x_ && covered_ > pulses * until_)) break;
    for (const Stretch& one : found_)
      if (!is_flank(one, rest)) places.insert(places.end(), one.places.begin(), one.places.end());
    rest = without(rest, found_);
  }
  std::ranges::sort(places);
  return std::make_shared<const std::vector<double>>(std::move(places));
}

// True if it goes on from a larger pulse, and is largest there.
bool FormulaDetail::is_flank(const Stretch& one, const Stretches& rest) {
  const auto size_at = [&](double s) {
    const Interval of = over({Interval(s), Interval(1.0)}, whole_).value;
    return std::max(of.high, -of.low);
  };
  double beside = -1.0;
  for (const Stretch& of : rest) {
    if (of.begin > 0.0 && of.begin == one.begin) beside = std::max(beside, size_at(one.begin));
    if (of.end < until_ && of.end == one.end) beside = std::max(beside, size_at(one.end));
  }
  return beside >= 0.0 && std::ranges::all_of(one.places, [&](double s) { return size_at(s) <= beside; });
}

FormulaDetail::Stretches FormulaDetail::without(const Stretches& all, const Stretches& some) {
  Stretches rest;
  for (const Stretch& one : all) {
    double begin = one.begin;
    for (const Stretch& other : some) {
      if (other.begin < one.begin || other.end > one.end) continue;
      if (other.begin > begin) rest.push_back({begin, other.begin});
      begin = other.end;
    }
    if (one.end > begin) rest.push_back({begin, one.end});
  }
  return rest;
}

// A bound of |f| that is at most twice a value of it: where bounds are greatest they are halved. Where that does not
// come to an end, the greatest value that was met. Beside a pole nothing counts: 0.
double FormulaDetail::largest(const Stretches& rest) {
  other_.value = whole_;
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
  for (const auto& [begin, end, of] : rest) {
    const int count = static_cast<int>(std::ceil(parts * (end - begin) / until_));
    for (int i = 0; i < count; ++i)
      add(begin + (end - begin) * i / count, i + 1 == count ? end : begin + (end - begin) * (i + 1) / count);
  }
  if (bounds.empty()) return 0.0;
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

void FormulaDetail::search(const Stretches& rest) {
  parts_.clear();
  effort_ = 0;
  covered_ = 0.0, quiet_ = until_;
  // Breaks may have a limit, as those of sin(1/x) > 0.
  std::size_t stretches = 0;
  const std::size_t others = others_.size();
  for (const Stretch& one : rest) quiet_ -= one.end - one.begin;
  for (const Stretch& one : rest)
    for (double begin = one.begin, end = begin; begin < one.end && ++stretches < most_stretches; begin = end) {
      end = switches_.first(0.0, begin + rounding_, one.end).value_or(one.end);
      for (std::size_t k = 0; k < others && others > 1; ++k)
        end = travelling_.first(others_[k].low, begin + rounding_, end).value_or(end);
      divide(begin, end, 0, others);
    }
}

// Neighbours make one stretch, which has no place within it where steps see all.
void FormulaDetail::take_shorter_than(double share) {
  found_.clear();
  covered_ = 0.0;
  bool steady_before = false;
  for (const auto& [begin, end, steady] : parts_) {
    if (end - begin < share * until_) {
      covered_ += end - begin;
      if (found_.empty() || found_.back().end < begin)
        found_.push_back({begin, end, {begin}});
      else if (steady && steady_before)
        found_.back().places.pop_back();
      found_.back().places.push_back(end);
      found_.back().end = end;
    }
    steady_before = steady;
  }
}

// Bounds there, for those values of the other variable.
Jet FormulaDetail::over(const Jet& s, Interval other) {
  other_.value = other;
  bound(s);
  return tree_->of_nodes(jets_.data())[tree_->root];
}

// Values of the other variable for which there may be more than a straight line are looked at: in halves, where that is
// most of all its own doing, as of a wave that travels, and else in halves of the interval. Where something goes on
// that always changes about as fast, a step sees it, wherever it ends.
void FormulaDetail::divide(double begin, double end, std::size_t first, std::size_t count) {
  const double size = end - begin;
  if (size < 4.0 * rounding_ || (!along_x_ && covered_ > pulses * until_)) return;
  const Jet s{{begin + rounding_, end - rounding_}, {1.0, 1.0}};
  const auto apart = [&](const Jet& f) {
    return std::min(f.value.high - f.value.low, (f.slope.high - f.slope.low) * size / 4.0);
  };
  const std::size_t rough = others_.size();
  pending_.clear();
  for (std::size_t k = count; k-- > 0;) pending_.push_back(others_[first + k]);
  double range = 0.0, slowest = 0.0, fastest = 0.0;
  while (!pending_.empty()) {
    const Interval other = pending_.back();
    pending_.pop_back();
    const Jet f = over(s, other);
    const double middle = other.low + (other.high - other.low) / 2.0;
    if (apart(f) > allowed_ && other.high - other.low > narrowest * whole_.high && ++effort_ < most_halvings &&
        apart(over(s, Interval(middle))) < apart(f) / 2.0) {
      pending_.push_back({middle, other.high});
      pending_.push_back({other.low, middle});
      continue;
    }
    range = std::max(range, f.value.high - f.value.low);
    slowest = std::max({slowest, f.slope.low, -f.slope.high});
    fastest = std::max({fastest, f.slope.high, -f.slope.low});
    if (apart(f) > allowed_) others_.push_back(other);
  }
  const std::size_t left = others_.size() - rough;
  if (left > 0 && size > finest * until_ && ++effort_ < most_halvings) {
    divide(begin, begin + size / 2.0, rough, left);
    divide(begin + size / 2.0, end, rough, left);
    return others_.resize(rough);
  }
  others_.resize(rough);
  if (range <= allowed_) quiet_ += size;
  if (size < shorter * until_) covered_ += size;
  parts_.push_back({begin, end, !along_x_ && slowest > fastest / 4.0});
}

}  // namespace viscobar
