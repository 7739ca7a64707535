#include "studies/ensemble/lane_levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace viscobar::bars {

namespace {

constexpr double least_order = 0.7, most_order = 1.5;  // (2.8) has 2, and less where contacts decide
constexpr double safety = 1.4, rounding = 1e-12, share_of_steps = 0.03;
constexpr std::size_t crossing = 8;  // two runs by rigid cost less than those up to the next level

}  // namespace

LaneLevels::LaneLevels(const Members& members, const Layout& layout, const Shared& shared,
                       const std::function<bool()>& stop, std::function<void(std::size_t, Told)> tell,
                       std::function<void(std::size_t)> alone)
    : members_(members),
      layout_(layout),
      shared_(shared),
      stop_(stop),
      tell_(std::move(tell)),
      alone_(std::move(alone)),
      scheme_(*members.pattern()) {}

void LaneLevels::add(std::size_t bar, OwnMember own) {
  const std::size_t level = shared_.error ? first_level(own.member.bar) : 0;
  if (shared_.error && level + 2 > crossing && shared_.rigid_beside) return alone_(bar);
  waiting_[level].push_back({bar, std::move(own)});
}

std::size_t LaneLevels::steps_at(std::size_t level) const {
  return shared_.error ? base_steps << level
                       : static_cast<std::size_t>(std::ceil(shared_.end / shared_.step * (1.0 - 1e-12)));
}

double LaneLevels::step_at(std::size_t level) const {
  return shared_.error ? shared_.end / static_cast<double>(steps_at(level)) : shared_.step;
}

// The first of three: the last is about what most bars take.
std::size_t LaneLevels::first_level(const Bar& bar) const {
  const double h = bar.length / static_cast<double>(shared_.elements);
  const double transit = h / std::sqrt(bar.modulus / bar.density);
  const double wanted = shared_.end / transit * share_of_steps / std::sqrt(*shared_.error);
  const double level = std::ceil(std::log2(std::max(wanted / base_steps, 1.0)));
  return static_cast<std::size_t>(std::clamp(level, 0.0, static_cast<double>(most_level - 2)));
}

void LaneLevels::run() {
  for (std::size_t level = 0; level <= most_level; ++level) {
    // Whoever waits again does so on a finer level.
    const std::span<Waiting> all = waiting_[level];
    for (std::size_t begin = 0; begin < all.size(); begin += lane_count) {
      if (stop_ && stop_()) throw Stopped();
      const std::span<Waiting> pack = all.subspan(begin, std::min(lane_count, all.size() - begin));
      auto values = run_pack(pack, level);
      for (std::size_t l = 0; l < pack.size(); ++l) {
        Waiting& bar = pack[l];
        if (!values[l]) {
          alone_(bar.bar);
        } else if (!shared_.error) {
          tell_(bar.bar, {std::move(values[l]), std::numeric_limits<double>::quiet_NaN(), steps_at(level)});
        } else if (!bar.coarse || bar.coarse_level + 1 != level) {
          bar.coarse = std::move(values[l]), bar.coarse_level = level;
          waiting_[level + 1].push_back(std::move(bar));
        } else {
          judge(std::move(bar), std::move(values[l]), level);
        }
      }
    }
    waiting_[level].clear();
  }
}

// Two runs differ by (2^p - 1) of the error of the finer one, p the order that three runs show.
void LaneLevels::judge(Waiting bar, std::unique_ptr<BarValues> fine, std::size_t level) {
  const double now = difference(layout_, *bar.coarse, *fine, shared_.end);
  if (bar.difference && now > 0.0) bar.order = std::clamp(std::log2(*bar.difference / now), least_order, most_order);
  const double order = bar.order.value_or(least_order);
  const double found = std::max(safety * now / (std::exp2(order) - 1.0), rounding);
  const bool kept = found <= *shared_.error;
  if (kept || level == most_level) {
    if (!kept && shared_.rigid_beside) return alone_(bar.bar);
    return tell_(bar.bar, {std::move(fine), found, steps_at(level)});
  }
  const double more = bar.difference ? std::ceil(std::log2(found / *shared_.error) / order) : 1.0;
  bar.difference = now;
  const std::size_t next = level + static_cast<std::size_t>(std::clamp(more, 1.0, 30.0));
  if (next > crossing && shared_.rigid_beside) return alone_(bar.bar);
  const std::size_t target = std::min(next, most_level), onward = target <= level + 1 ? target : target - 1;
  if (onward == target)
    bar.coarse = std::move(fine), bar.coarse_level = level;
  else
    bar.difference.reset();
  waiting_[onward].push_back(std::move(bar));
}

// Null where a bar has no sound run.
std::vector<std::unique_ptr<BarValues>> LaneLevels::run_pack(std::span<const Waiting> pack, std::size_t level) {
  std::vector<Member> members;
  std::vector<std::unique_ptr<BarValues>> values;
  for (const Waiting& bar : pack) {
    members.push_back(bar.own.member);
    values.push_back(std::make_unique<BarValues>(layout_));
  }
  const Pattern& pattern = *members_.pattern();
  const std::size_t n = pattern.size();
  const bool fields = layout_.fields;
  const std::size_t before = fields && pattern.fixed(false) ? 1 : 0, after = fields && pattern.fixed(true) ? 1 : 0;
  std::vector<double> u(fields ? n + before + after : 2), v(u);
  std::size_t look = 0;
  LaneOutputs outputs;
  outputs.times = layout_.times;
  outputs.fields = fields;
  outputs.most_changes = layout_.most_changes;
  outputs.sample = [&](std::size_t, const LaneSample& at) {
    std::size_t next = look;
    for (std::size_t l = 0; l < pack.size(); ++l) {
      for (std::size_t i = 0; i < at.u.size(); ++i) u[i + before] = at.u[i][l], v[i + before] = at.v[i][l];
      if (pattern.fixed(false)) u.front() = members[l].wall[0], v.front() = 0.0;
      if (pattern.fixed(true)) u.back() = members[l].wall[1], v.back() = 0.0;
      next = values[l]->look(layout_, members[l].bar, look, {u, v, at.reaction[0][l], at.reaction[1][l]});
    }
    look = next;
  };
  LaneAccounts accounts;
  const bool second_order = shared_.error || shared_.start == Start::second_order;
  const bool definite = scheme_.run(members, {step_at(level), shared_.end, second_order}, outputs, accounts);
  for (std::size_t l = 0; l < pack.size(); ++l) {
    if (!definite || !accounts.finite[l]) {
      values[l].reset();
      continue;
    }
    const auto of_lane = [l](const std::array<Lanes, 2>& ends) {
      return std::array<double, 2>{ends[0][l], ends[1][l]};
    };
    values[l]->changes_at(layout_, accounts.changes[l]);
    values[l]->accounts(layout_, of_lane(accounts.impulse), of_lane(accounts.peak));
  }
  return values;
}

}  // namespace viscobar::bars
