#include "report/plot/thinning.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar::plot {

std::vector<Point> points_of(std::span<const double> x, std::span<const double> y) {
  const std::size_t count = std::min(x.size(), y.size());
  ThinnedLine line(count > most_points ? most_points / 4 : most_points);
  for (std::size_t k = 0; k < count; ++k) line.add({x[k], y[k]});
  return line.points();
}

void ThinnedLine::Bucket::join(const Bucket& next) {
  if (next.lowest.y < lowest.y) lowest = next.lowest;
  if (next.highest.y > highest.y) highest = next.highest;
  last = next.last;
}

void ThinnedLine::add(Point point) {
  if (!std::isfinite(point.x) || !std::isfinite(point.y)) return;
  thinned_.add({point, point, point, point});
}

std::vector<Point> ThinnedLine::points() const {
  std::vector<Point> kept;
  for (const Bucket& bucket : thinned_.buckets()) {
    const bool falling = bucket.highest.x < bucket.lowest.x;
    for (const Point& point : {bucket.first, falling ? bucket.highest : bucket.lowest,
                               falling ? bucket.lowest : bucket.highest, bucket.last})
      if (kept.empty() || point.x != kept.back().x || point.y != kept.back().y) kept.push_back(point);
  }
  return kept;
}

void ThinnedIntervals::add(Interval interval) {
  intervals_.push_back(interval);
  if (intervals_.size() < 2 * capacity) return;
  // An eye cannot tell apart what is closer than this.
  const double resolution = (intervals_.back().end - intervals_.front().begin) / static_cast<double>(capacity);
  std::vector<Interval> merged = {intervals_.front()};
  for (const Interval& next : intervals_) {
    Interval& last = merged.back();
    if (next.begin - last.end >= resolution) {
      merged.push_back(next);
      continue;
    }
    last.end = std::max(last.end, next.end);
    if (std::abs(next.peak.y) > std::abs(last.peak.y)) last.peak = next.peak;
  }
  intervals_ = std::move(merged);
}

}  // namespace viscobar::plot
