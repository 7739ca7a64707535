#include "discretisation/lane_factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "discretisation/not_positive.hpp"

namespace viscobar {

namespace {

constexpr std::size_t fewest_rows = 3;  // fewer are not worth the interface

using Run = LaneOrder::Run;

// The runs of 16 lanes of so many rows, filled with the free nodes, which are given as [begin, end); empty: there are
// too few. A node between two lanes stays in the interface. It is not the last of those that are free together: the row
// behind them may have an entry for the one before it.
std::vector<Run> fill(const std::vector<std::pair<std::size_t, std::size_t>>& free, std::size_t rows) {
  std::vector<Run> runs;
  std::size_t lane = 0, row = 0;
  for (auto [node, end] : free) {
    while (node < end) {
      std::size_t count = std::min(end - node, rows - row);
      if (node + count + 1 == end && --count == 0) break;
      runs.push_back({node, lane, row, count});
      node += count + 1, row += count;
      if (row < rows) break;
      row = 0;
      if (++lane == lane_count) return runs;
    }
  }
  return {};
}

}  // namespace

LaneFactor::LaneFactor(const BandedMatrix& matrix, double scale) : scale_(scale) {
  take_alike(matrix);
  build(matrix, true);
}

LaneFactor::LaneFactor(const BandedMatrix& matrix, double scale, const std::vector<std::size_t>& kept) : scale_(scale) {
  take_all(matrix, kept);
  build(matrix, false);
}

LaneFactor LaneFactor::without_rows(const BandedMatrix& matrix) {
  LaneFactor factor;
  factor.order_.size = matrix.size();
  factor.condensed_ = matrix;
  return factor;
}

// Rows that are alike, with what couples them to their neighbours, divided evenly; the rest goes to the ends.
void LaneFactor::take_alike(const BandedMatrix& matrix) {
  const std::size_t n = matrix.size();
  order_.size = n;
  constexpr std::size_t fewest = (fewest_rows + 1) * lane_count;
  if (n < fewest + 2 || matrix.off_diagonal.empty() || !matrix.skew.empty()) return;
  const auto& diagonal = matrix.diagonal;
  const auto& off = matrix.off_diagonal;
  const std::size_t middle = n / 2;
  const auto alike = [&](std::size_t i) {
    return diagonal[i] == diagonal[middle] && off[i - 1] == off[middle] && off[i] == off[middle];
  };
  std::size_t begin = middle, end = middle;
  while (begin > 1 && alike(begin - 1)) --begin;
  while (end + 1 < n && alike(end)) ++end;
  if (!matrix.one_sided.empty())
    begin = std::max<std::size_t>(begin, 3), end = std::min(end, n - 3);  // their entries stay
  if (end < begin + fewest) return;
  const std::size_t rest = (end - begin) % lane_count;
  order_.first = begin + rest / 2;
  order_.rows = (end - begin) / lane_count - 1;
  order_.runs = fill({{order_.first, order_.first + (order_.rows + 1) * lane_count - 1}}, order_.rows);
}

// As many rows as there are 16 lanes of; more than a third of the nodes in the interface is not worth it.
void LaneFactor::take_all(const BandedMatrix& matrix, const std::vector<std::size_t>& kept) {
  const std::size_t n = matrix.size();
  order_.size = n;
  if (n < fewest_rows * lane_count || matrix.off_diagonal.empty()) return;
  std::vector<bool> stays(n, false);
  stays[0] = stays[n - 2] = stays[n - 1] = true;
  for (const std::size_t node : kept) stays[node] = true;
  for (const OneSidedRow& one : matrix.one_sided) {
    stays[one.row] = true;
    if (one.row == 0 || one.row + 1 == n) stays[one.column(1)] = true;
  }
  // The third column of a row stays where the second does.
  for (bool more = true; more;) {
    more = false;
    for (const OneSidedRow& one : matrix.one_sided)
      if (stays[one.column(1)] && !stays[one.column(2)]) more = stays[one.column(2)] = true;
  }
  std::vector<std::pair<std::size_t, std::size_t>> free;
  for (std::size_t i = 1; i < n; ++i) {
    if (stays[i]) continue;
    if (stays[i - 1]) free.push_back({i, i});
    free.back().second = i + 1;
  }
  std::vector<Run> runs;
  std::size_t rows = n / lane_count;
  while (rows >= fewest_rows && (runs = fill(free, rows)).empty()) --rows;
  if (runs.empty() || 3 * rows * lane_count < 2 * n) return;
  order_.first = runs.front().node;
  order_.rows = rows;
  order_.runs = std::move(runs);
}

// each(k, l_k, u_{k+1}, scale w_k, g_k, q_k) receives the rows.
LaneFactor::Reach LaneFactor::eliminate_run(const BandedMatrix& matrix, const Run& run, auto&& each) const {
  // Below the rounding of rounding a neighbour's influence changes nothing; it would end in denormal numbers.
  const double negligible = std::pow(std::numeric_limits<double>::epsilon(), 2);
  const std::size_t behind = run.node_behind();
  Reach reach{.coupling = matrix.above(run.node - 1), .symmetric = true};
  std::array<double, 2> c = {1.0, 0.0}, d = {matrix.below(behind - 1), 0.0};
  if (!matrix.skew.empty()) c[0] = std::exchange(reach.coupling, 1.0), reach.symmetric = false;
  for (const OneSidedRow& one : matrix.one_sided) {
    if (one.leftwards ? one.row != behind : one.row + 1 != run.node) continue;
    reach.symmetric = false;
    if (one.leftwards)
      d = {d[0] + one.entries[1], one.entries[2]};
    else
      c = {c[0] * reach.coupling + one.entries[1], one.entries[2]}, reach.coupling = 1.0;
  }
  const double largest = std::abs(c[0]) + std::abs(c[1]);
  double influence = 1.0, pull = c[0];
  struct {
    double lower, upper, w, g;  // l and u of the next row
  } last{}, before{};
  for (std::size_t k = 0; k < run.count; ++k) {
    const std::size_t i = run.node + k;
    double pivot = matrix.diagonal[i];
    if (k > 0) {
      pivot -= last.lower * matrix.above(i - 1);
      influence *= -last.lower;
      pull *= -last.upper;
      if (k == 1) pull += c[1];
    }
    if (!(pivot > 0.0)) throw NotPositive(matrix.finite());
    if (reach.rows == k && (std::abs(influence) > negligible || std::abs(pull) > negligible * largest))
      ++reach.rows;
    else
      influence = pull = 0.0;
    before = last;
    last = {matrix.below(i) / pivot, matrix.above(i) / pivot, 1.0 / pivot, influence / pivot};
    reach.through = pull / pivot;
    reach.corner += influence * reach.through;
    reach.last = (d[0] - d[1] * before.upper) / pivot;
    each(k, before.lower, last.upper, scale_ / pivot, last.g, reach.through);
  }
  reach.back = (d[0] - d[1] * before.upper) * last.g + d[1] * before.g;
  reach.to_right = {scale_ * reach.last, scale_ * d[1] * before.w};
  if (run.count == 1) reach.beyond = {c[1], d[1]};
  return reach;
}

void LaneFactor::build(const BandedMatrix& matrix, bool alike) {
  if (order_.rows == 0) {
    condensed_ = matrix;
    return;
  }
  std::vector<Reach> reach;
  const auto resize = [&]<class C>(Rows<C>& of) {
    for (auto* each : {&of.lower, &of.upper, &of.scaled_inverse_pivot, &of.from_left})
      each->assign(order_.rows, C(0.0));
  };
  if (alike) {
    resize(alike_);
    const auto take = [this](std::size_t k, double lower, double upper, double inverse_pivot, double g, double) {
      alike_.lower[k] = lower, alike_.upper[k] = upper;
      alike_.scaled_inverse_pivot[k] = inverse_pivot, alike_.from_left[k] = g;
    };
    reach.assign(order_.runs.size(), eliminate_run(matrix, order_.runs.front(), take));
  } else {
    resize(unlike_);
    unlike_.to_left = unlike_.from_left;
    for (const Run& run : order_.runs) {
      const auto take = [&](std::size_t k, double lower, double upper, double inverse_pivot, double g, double q) {
        const std::size_t row = run.begin + k, lane = run.lane;
        unlike_.lower[row][lane] = k == 0 && row > 0 ? 1.0 : lower;
        unlike_.upper[row][lane] = upper;
        unlike_.scaled_inverse_pivot[row][lane] = inverse_pivot;
        unlike_.from_left[row][lane] = g, unlike_.to_left[row][lane] = q;
      };
      reach.push_back(eliminate_run(matrix, run, take));
    }
  }
  cut(matrix, reach);
  condense(matrix, reach);
}

void LaneFactor::condense(const BandedMatrix& matrix, const std::vector<Reach>& reach) {
  const std::size_t n = order_.interface_size();
  std::vector<double>&diagonal = condensed_.diagonal, &off = condensed_.off_diagonal, skew(n - 1, 0.0);
  std::size_t node = 0;
  const auto take_up_to = [&](std::size_t end) {
    for (; node < end; ++node) {
      diagonal.push_back(matrix.diagonal[node]);
      if (diagonal.size() == n) continue;
      off.push_back(matrix.off_diagonal[node]);
      if (!matrix.skew.empty()) skew[off.size() - 1] = matrix.skew[node];
    }
  };
  double pulled = 0.0;  // from the diagonal of the node behind the last run
  bool symmetric = matrix.skew.empty();
  for (std::size_t r = 0; r < order_.runs.size(); ++r) {
    const Run& run = order_.runs[r];
    const Reach& of = reach[r];
    const std::size_t behind = diagonal.size();
    take_up_to(run.node);
    diagonal[behind] -= pulled;
    const double left = matrix.below(run.node - 1), right = matrix.above(run.node_behind() - 1);
    diagonal.back() -= left * of.coupling * of.corner;
    off.back() = -of.coupling * right * of.through;
    if (!of.symmetric) {
      const double above = off.back() + of.beyond[0], below = of.beyond[1] - left * of.back;
      off.back() = (above + below) / 2, skew[off.size() - 1] = (above - below) / 2;
      symmetric = false;
    }
    pulled = right * of.last;
    node = run.node_behind();
  }
  const std::size_t behind = diagonal.size();
  take_up_to(matrix.size());
  diagonal[behind] -= pulled;
  if (!symmetric) condensed_.skew = std::move(skew);
  const auto in_a_run = [this](std::size_t i) {
    return std::ranges::any_of(order_.runs, [i](const Run& run) { return run.node <= i && i < run.node_behind(); });
  };
  for (OneSidedRow one : matrix.one_sided) {
    const bool taken = in_a_run(one.column(1));
    one.row = order_.interface_index(one.row);
    if (taken)
      diagonal[one.row] += one.entries[0];
    else
      condensed_.one_sided.push_back(one);
  }
}

// Into rows that are swept alike.
void LaneFactor::cut(const BandedMatrix& matrix, const std::vector<Reach>& reach) {
  const auto& runs = order_.runs;
  std::vector<std::size_t> ends;
  for (std::size_t r = 0; r < runs.size(); ++r)
    for (const std::size_t row : {runs[r].begin + reach[r].rows, runs[r].end()})
      if (row > 0) ends.push_back(row);
  std::ranges::sort(ends);
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  pieces_.clear();
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    Piece piece{end, false, {}};
    for (std::size_t r = 0; r < runs.size(); ++r)
      piece.felt |= runs[r].begin <= begin && begin < runs[r].begin + reach[r].rows;
    pieces_.push_back(std::move(piece));
    begin = end;
  }
  for (std::size_t r = 0, left = order_.first - 1; r < runs.size(); ++r) {
    const Run& run = runs[r];
    const Ends ends_of{run.lane, left, left + 1, matrix.below(run.node - 1), reach[r].coupling, reach[r].to_right};
    if (r + 1 < runs.size()) left += runs[r + 1].node - run.node_behind();
    if (run.end() == order_.rows)
      last_[run.lane] = ends_of;
    else
      std::ranges::find(pieces_, run.end(), &Piece::end)->ended.push_back(ends_of);
  }
}

}  // namespace viscobar
