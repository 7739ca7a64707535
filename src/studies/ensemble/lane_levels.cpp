#include "studies/ensemble/lane_levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace viscobar::bars {

namespace {

constexpr double safety = 1.5, margin = 1.1, share_of_steps = 0.025;
constexpr double fits = 1.5;         // times the difference that order 2 tells beforehand
constexpr double crossing = 1400.0;  // steps of a wave's way through the bar; two runs by rigid cost no more

double lane(const Lanes& lanes, std::size_t l) { return reinterpret_cast<const double*>(&lanes)[l]; }

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
      scheme_(*members.pattern()),
      values_(layout.width, Lanes(std::numeric_limits<double>::quiet_NaN())) {
  for (std::size_t e = 0; e < layout.mesh.elements; ++e)
    finest_ = std::min(finest_, layout.mesh.element(e) / layout.mesh.length);
}

void LaneLevels::add(std::size_t bar, OwnMember own) {
  const std::size_t level = shared_.error ? first_level(own.member.bar) : 0;
  if (shared_.error && shared_.rigid_beside && is_of_rigid(own.member)) return alone_(bar);
  if (shared_.error && shared_.rigid_beside &&
      4.0 * static_cast<double>(steps_at(level)) > crossing * ways(own.member.bar))
    return alone_(bar);
  waiting_[level].push_back({bar, std::move(own)});
}

double LaneLevels::ways(const Bar& bar) const { return shared_.end * bar.wave_speed() / bar.length; }

std::size_t LaneLevels::multiple(std::size_t level) {
  return level < 4 ? level + 1 : (4 + (level + 1) % 4) << ((level + 1) / 4 - 1);
}

double LaneLevels::step_at(std::size_t level) const {
  return shared_.error ? layout_.period / static_cast<double>(multiple(level)) : shared_.step;
}

std::size_t LaneLevels::steps_at(std::size_t level) const {
  return static_cast<std::size_t>(std::ceil(shared_.end / step_at(level) * (1.0 - 1e-12)));
}

// At the end of a step a displacement has no error of interpolation, which is of first order where an end stops.
bool LaneLevels::meets_outputs(std::size_t level) const {
  constexpr std::size_t too_many = 64;
  return layout_.intervals > too_many || multiple(level) % layout_.intervals == 0;
}

// The first with so many steps.
std::size_t LaneLevels::level_of(double steps) const {
  const double wanted = steps * layout_.period / shared_.end * (1.0 - 1e-12);
  std::size_t level = 0;
  while (level < most_level && static_cast<double>(multiple(level)) < wanted) ++level;
  return level;
}

// The first of three: the last is about what most bars take.
std::size_t LaneLevels::first_level(const Bar& bar) const {
  const double of_elements = ways(bar) * static_cast<double>(shared_.elements);
  return std::min(level_of(of_elements * share_of_steps / std::sqrt(*shared_.error)), most_level - 4);
}

// A node that rebounds does so two steps late, and one with a mass that is pulled off as it strikes is back within a
// step or two: no run side by side tells these contact changes. The first force of an impact is over within a step, and
// one on a node with mass grows with their number.
// Nor do two runs tell their error where no step resolves the waves of the smallest of unequal elements and viscosity
// does not damp them. At damping ratios 0, 0.01 and 0.03 errors are up to 6, 1.9 and 1.3 times the estimate.
bool LaneLevels::is_of_rigid(const Member& bar) const {
  const Pattern& pattern = *members_.pattern();
  const double damping = bar.bar.viscosity * bar.bar.wave_speed() / (bar.bar.modulus * bar.bar.length * finest_);
  if (damping < 0.03 && !pattern.is_of_alike()) return true;
  const bool weighted = (pattern.contact[0] && bar.mass[0] > 0.0) || (pattern.contact[1] && bar.mass[1] > 0.0);
  return bar.restitution > 0.0 || layout_.peaks || (layout_.most_changes > 0 && weighted);
}

void LaneLevels::run() {
  for (std::size_t level = 0; level <= most_level; ++level) {
    // Whoever waits again does so on a finer level.
    const std::span<Waiting> all = waiting_[level];
    for (std::size_t begin = 0; begin < all.size(); begin += lane_count) {
      if (stop_ && stop_()) throw StudyStopped();
      const std::span<Waiting> pack = all.subspan(begin, std::min(lane_count, all.size() - begin));
      auto values = run_pack(pack, level);
      for (std::size_t l = 0; l < pack.size(); ++l) {
        Waiting& bar = pack[l];
        if (!values[l]) {
          alone_(bar.bar);
        } else if (!shared_.error) {
          told(bar.bar, l, std::move(values[l]), std::numeric_limits<double>::quiet_NaN(), level);
        } else if (!bar.coarse) {
          bar.coarse = std::move(values[l]), bar.coarse_level = level;
          waiting_[level_of(2.0 * static_cast<double>(steps_at(level)))].push_back(std::move(bar));
        } else {
          judge(std::move(bar), l, std::move(values[l]), level);
        }
      }
    }
    waiting_[level].clear();
  }
}

void LaneLevels::told(std::size_t bar, std::size_t lane_of, std::unique_ptr<BarValues> values, double error,
                      std::size_t level) {
  values->values.resize(layout_.width);
  for (std::size_t k = 0; k < layout_.width; ++k) values->values[k] = lane(values_[k], lane_of);
  values->changes_at(layout_, accounts_.changes[lane_of]);
  const std::array<double, 2> impulse = values->impulse;
  values->accounts(layout_, impulse, std::array{lane(accounts_.peak[0], lane_of), lane(accounts_.peak[1], lane_of)});
  tell_(bar, {std::move(values), error, steps_at(level)});
}

// Two runs with n and r n steps differ by r^p - 1 times the error of the finer one. The order p is 2 where the run
// before them fits that, else 1.
void LaneLevels::judge(Waiting bar, std::size_t lane_of, std::unique_ptr<BarValues> fine, std::size_t level) {
  const double now = difference(layout_, *bar.coarse, *fine, shared_.end);
  const double ratio = static_cast<double>(steps_at(level)) / static_cast<double>(steps_at(bar.coarse_level));
  const double second = now / (ratio * ratio - 1.0), first = now / (ratio - 1.0);
  // Contact changes are at ends of steps, and a node that rebounds does so two steps late.
  const bool of_order_1 = layout_.most_changes > 0 || bar.own.member.restitution > 0.0;
  const double expected = bar.error ? *bar.error / (ratio * ratio) : 0.0;
  const bool of_order_2 = bar.error && !of_order_1 && second <= fits * expected;
  // Both may put a change at the end of one and the same step, which tells no time better than to a step.
  const double resolution = fine->changes.empty() ? 0.0 : step_at(level) / shared_.end;
  const double found = std::max({safety * (of_order_2 ? second : first), expected, resolution, rounding});
  const bool kept = found <= *shared_.error && meets_outputs(level);
  if (kept || level == most_level) {
    // An end mass that is pulled off as it strikes leaves with a velocity of order 1, by the phase of the step.
    if ((!kept || fine->brief) && shared_.rigid_beside) return alone_(bar.bar);
    return told(bar.bar, lane_of, std::move(fine), found, level);
  }
  const double more =
      of_order_1 ? std::max(safety * first, resolution) / *shared_.error : std::sqrt(safety * second / *shared_.error);
  const double steps = std::clamp(margin * more, 1.4, 64.0) * static_cast<double>(steps_at(level));
  if (steps > crossing * ways(bar.own.member.bar) && shared_.rigid_beside) return alone_(bar.bar);
  std::size_t next = std::max(level_of(steps), level + 1);
  while (next < most_level && !meets_outputs(next)) ++next;
  bar.error = second;
  bar.coarse = std::move(fine), bar.coarse_level = level;
  waiting_[next].push_back(std::move(bar));
}

void LaneLevels::look(std::span<const Waiting> pack, const LaneSample& at) {
  const Pattern& pattern = *members_.pattern();
  std::array<Lanes, 2> u = {at.u.front(), at.u.back()}, v = {at.v.front(), at.v.back()};
  for (const bool right : {false, true}) {
    if (!pattern.fixed(right)) continue;
    for (std::size_t l = 0; l < lane_count; ++l)
      u[right][l] = pack[std::min(l, pack.size() - 1)].own.member.wall[right];
    v[right] = 0.0;
  }
  const double time = layout_.looks[next_look_].time;
  for (; next_look_ < layout_.looks.size() && layout_.looks[next_look_].time == time; ++next_look_) {
    const auto [when, i, k] = layout_.looks[next_look_];
    if (i == Layout::Look::probe) {
      for (const bool right : {false, true})
        if (k < BarValues::probes) ends_[right][k] = u[right], ways_[right][k] = at.way[right];
      largest_ = larger(largest_, larger(abs(u[0]), abs(u[1])));
      continue;
    }
    const EnsembleOutput& output = layout_.outputs[i];
    Lanes* const to = &values_[layout_.first[i]];
    if (output.kind == EnsembleOutput::Kind::trace) {
      const std::array<Lanes, 6> columns = {u[0], v[0], at.reaction[0], u[1], v[1], at.reaction[1]};
      to[k] = columns[static_cast<std::size_t>(output.column)];
      continue;
    }
    const std::size_t n = pattern.size(), before = pattern.fixed(false), after = pattern.fixed(true);
    u_.assign(n + before + after, 0.0), v_.assign(n + before + after, 0.0), reading_.resize(output.width());
    for (std::size_t l = 0; l < pack.size(); ++l) {
      for (std::size_t j = 0; j < n; ++j) u_[j + before] = lane(at.u[j], l), v_[j + before] = lane(at.v[j], l);
      for (const bool right : {false, true})
        if (pattern.fixed(right)) (right ? u_.back() : u_.front()) = lane(u[right], l);
      const Bar& bar = pack[l].own.member.bar;
      std::optional<Gauge> gauge = layout_.gauges[i];
      if (gauge && bar.length == layout_.mesh.length) {
        gauge->take(bar);
      } else if (gauge) {  // bars of any section have one length
        Mesh mesh = layout_.mesh;
        mesh.length = bar.length;
        gauge.emplace(mesh, bar, output.place);
      }
      write_fields(gauge ? &*gauge : nullptr, u_, v_, reading_.data());
      const std::size_t first = gauge ? 4 * k : 0, count = gauge ? 4 : output.width();
      for (std::size_t j = 0; j < count; ++j) to[first + j][l] = reading_[j];
    }
  }
}

// Null where a bar has no sound run.
std::vector<std::unique_ptr<BarValues>> LaneLevels::run_pack(std::span<const Waiting> pack, std::size_t level) {
  std::vector<Member> members;
  for (const Waiting& bar : pack) members.push_back(bar.own.member);
  LaneOutputs outputs;
  outputs.times = layout_.times;
  outputs.fields = layout_.fields;
  outputs.most_changes = layout_.most_changes;
  outputs.sample = [&](std::size_t, const LaneSample& at) { look(pack, at); };
  next_look_ = 0, largest_ = 0.0;
  const bool second_order = shared_.error || shared_.start == Start::second_order;
  const bool definite = scheme_.run(members, {step_at(level), shared_.end, second_order}, outputs, accounts_);
  std::vector<std::unique_ptr<BarValues>> values(pack.size());
  for (std::size_t l = 0; definite && l < pack.size(); ++l) {
    if (!accounts_.finite[l]) continue;
    values[l] = std::make_unique<BarValues>();
    BarValues& one = *values[l];
    for (const bool right : {false, true}) {
      double before = 0.0;
      for (std::size_t k = 0; k < BarValues::probes; ++k) {
        one.ends[right][k] = lane(ends_[right][k], l);
        const double way = lane(ways_[right][k], l) / static_cast<double>(multiple(level));
        one.means[right][k] = way - std::exchange(before, way);
      }
      one.impulse[right] = lane(accounts_.impulse[right], l);
    }
    for (const std::size_t k : layout_.inside) one.inside.push_back(lane(values_[k], l));
    one.changes = accounts_.changes[l], one.largest = lane(largest_, l), one.brief = lane(accounts_.brief, l) > 0.0;
  }
  return values;
}

}  // namespace viscobar::bars
