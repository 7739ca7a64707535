#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace viscobar::plot {

struct Point {
  double x, y;
  static void members(auto& point, auto&& each) { each(point.x, point.y); }
};

/// A polyline that grows without bound in x, kept in at most `capacity` buckets of equally many points. A bucket keeps
/// its first, lowest, highest and last point, so no peak is lost; full, neighbours are merged. Points that are not
/// finite are left out.
class ThinnedLine {
 public:
  explicit ThinnedLine(std::size_t capacity = 600) : capacity_(capacity) {}

  void add(Point point);
  /// The points kept, in their order: at most four a bucket.
  std::vector<Point> points() const;
  bool empty() const { return buckets_.empty(); }

  static void members(auto& line, auto&& each) { each(line.stride_, line.in_last_, line.buckets_); }

 private:
  struct Bucket {
    Point first, lowest, highest, last;
    void join(const Bucket& next);
    static void members(auto& bucket, auto&& each) { each(bucket.first, bucket.lowest, bucket.highest, bucket.last); }
  };
  std::size_t capacity_, stride_ = 1, in_last_ = 0;
  std::vector<Bucket> buckets_;
};

/// The same of a line that is there.
std::vector<Point> thin(std::span<const Point> line, std::size_t capacity = 600);

struct Interval {
  double begin, end;
  static void members(auto& interval, auto&& each) { each(interval.begin, interval.end); }
};

/// Intervals in increasing order, never more than 2000: gaps that a picture of the whole could not show are closed.
class ThinnedIntervals {
 public:
  void add(Interval interval);
  const std::vector<Interval>& intervals() const { return intervals_; }
  static void members(auto& thinned, auto&& each) { each(thinned.intervals_); }

 private:
  static constexpr std::size_t capacity = 1000;
  std::vector<Interval> intervals_;
};

}  // namespace viscobar::plot
