#include "discretisation/lane_factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "discretisation/not_positive.hpp"

namespace viscobar {

namespace {

constexpr std::size_t fewest_rows = 3;  // fewer are not worth the interface
// Nor is one that has more than a third of the nodes.
bool worth(std::size_t rows, std::size_t nodes) { return rows >= fewest_rows && 3 * rows * lane_count >= 2 * nodes; }

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
  if (n < (fewest_rows + 1) * lane_count + 2 || matrix.off_diagonal.empty() || !matrix.skew.empty()) return;
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
  take_even(matrix, begin, end);
}

// An even order of nodes from `begin` on, the last of the interface between them being before `end`. No one-sided row
// of a lane has an entry for a node that is not in it, and none of the interface skips a node of it: the order is
// shifted until that holds.
bool LaneFactor::take_even(const BandedMatrix& matrix, std::size_t begin, std::size_t end) {
  if (end < begin + (fewest_rows + 1) * lane_count) return false;
  const std::size_t room = end - begin, most = room / lane_count - 1;
  const auto fits = [&](std::size_t first, std::size_t rows) {
    const std::size_t behind = first + lane_count * (rows + 1) - 1;
    const auto lane = [=](std::size_t i) {
      return i < first || i >= behind || (i - first) % (rows + 1) == rows ? lane_count : (i - first) / (rows + 1);
    };
    return std::ranges::all_of(matrix.one_sided, [&](const OneSidedRow& one) {
      const std::size_t own = lane(one.row), next = lane(one.column(1)), far = lane(one.column(2));
      return next == far && (own == next || own == lane_count);
    });
  };
  for (std::size_t rows = most; rows == most || (rows + 1 == most && worth(rows, order_.size)); --rows) {
    const std::size_t spare = room - lane_count * (rows + 1);
    for (std::size_t k = 0; k <= spare; ++k) {
      const std::size_t first = begin + (spare / 2 + k) % (spare + 1);
      if (!fits(first, rows)) continue;
      order_.first = first, order_.rows = rows;
      order_.runs = fill({{first, first + (rows + 1) * lane_count - 1}}, rows);
      return true;
    }
  }
  return false;
}

// As many rows as there are 16 lanes of.
void LaneFactor::take_all(const BandedMatrix& matrix, const std::vector<std::size_t>& kept) {
  const std::size_t n = matrix.size();
  order_.size = n;
  if (n < fewest_rows * lane_count || matrix.off_diagonal.empty()) return;
  const std::size_t end_columns = matrix.one_sided.empty() ? 1 : 3;
  if (std::ranges::all_of(kept, [n](std::size_t i) { return i == 0 || i + 1 == n; }) &&
      take_even(matrix, end_columns, n - end_columns))
    return;
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
  if (runs.empty() || !worth(rows, n)) return;
  order_.first = runs.front().node;
  order_.rows = rows;
  order_.runs = std::move(runs);
}

// each(k, l_k, u_{k+1}, scale w_k, g_k, q_k, L(k, k - 2), U(k, k + 2)) receives the rows.
LaneFactor::Reach LaneFactor::eliminate_run(const BandedMatrix& matrix, const Run& run, auto&& each) const {
  // Below the rounding of rounding a neighbour's influence changes nothing; it would end in denormal numbers.
  const double negligible = std::pow(std::numeric_limits<double>::epsilon(), 2);
  const std::size_t behind = run.node_behind();
  Reach reach{.coupling = matrix.above(run.node - 1), .symmetric = true};
  std::array<double, 2> c = {1.0, 0.0}, d = {matrix.below(behind - 1), 0.0};
  if (!matrix.skew.empty()) c[0] = std::exchange(reach.coupling, 1.0), reach.symmetric = false;
  for (const OneSidedRow& one : matrix.one_sided) {
    reach.symmetric &= one.row < run.node || one.row >= behind;
    if (one.leftwards ? one.row != behind : one.row + 1 != run.node) continue;
    reach.symmetric = false;
    if (one.leftwards)
      d = {d[0] + one.entries[1], one.entries[2]};
    else
      c = {c[0] * reach.coupling + one.entries[1], one.entries[2]}, reach.coupling = 1.0;
  }
  const double largest = std::abs(c[0]) + std::abs(c[1]);
  auto one = std::ranges::lower_bound(matrix.one_sided, run.node, {}, &OneSidedRow::row);
  struct {
    double pivot = std::numeric_limits<double>::infinity(), above = 0.0, skipping = 0.0;  // entries of D U
    double influence = 0.0, pull = 0.0;                                                   // of L^{-1} e_0 and U^{-T} c
    double upper() const { return above / pivot; }
  } last{}, before{};
  for (std::size_t k = 0; k < run.count; ++k) {
    const std::size_t i = run.node + k;
    double pivot = matrix.diagonal[i], below = k > 0 ? matrix.below(i - 1) : 0.0, above = matrix.above(i);
    std::array<double, 2> skipping{};
    for (; one != matrix.one_sided.end() && one->row == i; ++one) {
      pivot += one->entries[0];
      (one->leftwards ? below : above) += one->entries[1];
      skipping[!one->leftwards] = one->entries[2];
    }
    const double second = skipping[0] / before.pivot, lower = (below - second * before.above) / last.pivot;
    pivot -= second * before.skipping + lower * last.above;
    above -= lower * last.skipping;
    double influence = k > 0 ? -lower * last.influence - second * before.influence : 1.0;
    double pull = (k < 2 ? c[k] : 0.0) - last.upper() * last.pull - before.skipping / before.pivot * before.pull;
    if (!(pivot > 0.0)) throw NotPositive(matrix.finite());
    if (reach.rows == k && (std::abs(influence) > negligible || std::abs(pull) > negligible * largest))
      ++reach.rows;
    else
      influence = pull = 0.0;
    before = last;
    last = {pivot, above, skipping[1], influence, pull};
    reach.through = pull / pivot;
    reach.corner += influence * reach.through;
    reach.last = (d[0] - d[1] * before.upper()) / pivot;
    each(k, lower, last.upper(), scale_ / pivot, influence / pivot, reach.through, second, skipping[1] / pivot);
  }
  reach.back = reach.last * last.influence + d[1] * before.influence / before.pivot;
  reach.to_right = {scale_ * reach.last, scale_ * d[1] / before.pivot};
  if (run.count == 1) reach.beyond = {c[1], d[1]};
  return reach;
}

void LaneFactor::build(const BandedMatrix& matrix, bool alike) {
  if (order_.rows == 0) {
    condensed_ = matrix;
    return;
  }
  std::vector<Reach> reach;
  std::map<std::size_t, Second> seconds;
  const auto resize = [&]<class C>(Rows<C>& of) {
    for (auto* each : {&of.lower, &of.upper, &of.scaled_inverse_pivot, &of.from_left})
      each->assign(order_.rows, C(0.0));
  };
  if (alike) {
    resize(alike_);
    const auto take = [this](std::size_t k, double lower, double upper, double inverse_pivot, double g, auto&&...) {
      alike_.lower[k] = lower, alike_.upper[k] = upper;
      alike_.scaled_inverse_pivot[k] = inverse_pivot, alike_.from_left[k] = g;
    };
    reach.assign(order_.runs.size(), eliminate_run(matrix, order_.runs.front(), take));
  } else {
    resize(unlike_);
    unlike_.to_left = unlike_.from_left;
    for (const Run& run : order_.runs) {
      const auto take = [&](std::size_t k, double lower, double upper, double inverse_pivot, double g, double q,
                            double second_lower, double second_upper) {
        const std::size_t row = run.begin + k, lane = run.lane;
        unlike_.lower[row][lane] = k == 0 && row > 0 ? 1.0 : lower;
        unlike_.upper[row][lane] = upper;
        unlike_.scaled_inverse_pivot[row][lane] = inverse_pivot;
        unlike_.from_left[row][lane] = g, unlike_.to_left[row][lane] = q;
        if (second_lower != 0.0) seconds[row].lower[lane] = second_lower;
        if (second_upper != 0.0) seconds[row].upper[lane] = second_upper;
      };
      reach.push_back(eliminate_run(matrix, run, take));
    }
    if (std::ranges::all_of(reach, &Reach::symmetric)) unlike_.to_left.clear();
  }
  if (order_.even())
    cut_evenly(matrix, reach, seconds);
  else
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
    if (in_a_run(one.row)) continue;
    const bool taken = in_a_run(one.column(1));
    one.row = order_.interface_index(one.row);
    if (taken)
      diagonal[one.row] += one.entries[0];
    else
      condensed_.one_sided.push_back(one);
  }
}

// Into rows that are swept alike.
void LaneFactor::cut_evenly(const BandedMatrix& matrix, const std::vector<Reach>& reach,
                            const std::map<std::size_t, Second>& seconds) {
  const std::size_t felt = std::ranges::max(reach, {}, &Reach::rows).rows;
  std::set<std::size_t> ends = {felt, order_.rows};
  for (const auto& [row, second] : seconds) ends.insert(row);
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    if (end == 0) continue;
    pieces_.push_back({end, begin < felt});
    if (const auto second = seconds.find(begin); second != seconds.end()) pieces_.back().second = second->second;
    begin = end;
  }
  for (std::size_t l = 0; l < lane_count; ++l) {
    even_.coupling[l] = matrix.below(order_.runs[l].node - 1);
    even_.by_left[l] = reach[l].coupling;
    for (std::size_t k : {0, 1}) even_.to_right[k][l] = reach[l].to_right[k];
  }
}

// The same where runs end inside lanes.
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
