#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace viscobar::plot {

struct Point {
  double x, y;
  static void members(auto& point, auto&& each) { each(point.x, point.y); }
};

/// (x_k, y_k), but for those that are not finite; of more than `most_points` those that a ThinnedLine keeps, no more.
std::vector<Point> points_of(std::span<const double> x, std::span<const double> y);
constexpr std::size_t most_points = 1000;
/// A sentence for the caption of so many points, with a space before it; empty where all are drawn.
inline std::string_view thinned_remark(std::size_t count) {
  return count > most_points ? " Of many points those are drawn that bound the others." : "";
}

/// Items without end, kept in at most `capacity` buckets of `stride` items each, a power of 2: full, neighbours are
/// joined. A bucket begins as one item and takes the next ones in by join().
template <class Bucket>
class Thinned {
 public:
  explicit Thinned(std::size_t capacity) : capacity_(capacity) {}

  void add(const Bucket& item) {
    if (!buckets_.empty() && in_last_ < stride_) {
      buckets_.back().join(item);
      ++in_last_;
      return;
    }
    if (buckets_.size() == capacity_) {
      std::size_t kept = 0;
      for (std::size_t i = 0; i < buckets_.size(); i += 2) {
        buckets_[kept] = buckets_[i];
        if (i + 1 < buckets_.size()) buckets_[kept].join(buckets_[i + 1]);
        ++kept;
      }
      buckets_.resize(kept);
      stride_ *= 2;
    }
    buckets_.push_back(item);
    in_last_ = 1;
  }
  const std::vector<Bucket>& buckets() const { return buckets_; }
  std::size_t stride() const { return stride_; }
  std::size_t in_last() const { return in_last_; }

  static void members(auto& self, auto&& each) { each(self.stride_, self.in_last_, self.buckets_); }

 private:
  std::size_t capacity_, stride_ = 1, in_last_ = 0;
  std::vector<Bucket> buckets_;
};

/// A polyline that grows without bound in x. A bucket keeps its first, lowest, highest and last point, so no peak is
/// lost. Points that are not finite are left out.
class ThinnedLine {
 public:
  explicit ThinnedLine(std::size_t capacity = 600) : thinned_(capacity) {}

  void add(Point point);
  /// The points kept, in their order: at most four a bucket.
  std::vector<Point> points() const;
  bool empty() const { return thinned_.buckets().empty(); }

  static void members(auto& line, auto&& each) { each(line.thinned_); }

 private:
  struct Bucket {
    Point first, lowest, highest, last;
    void join(const Bucket& next);
    static void members(auto& bucket, auto&& each) { each(bucket.first, bucket.lowest, bucket.highest, bucket.last); }
  };
  Thinned<Bucket> thinned_;
};

struct Interval {
  double begin, end;
  Point peak{0.0, 0.0};  ///< the largest in size of what happens in it, where that is told
  static void members(auto& interval, auto&& each) { each(interval.begin, interval.end, interval.peak); }
};

/// Intervals in increasing order, never more than 2000: gaps that a picture of the whole could not show are closed, and
/// the larger peak stays.
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
