#include "integration/accounts/contact_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "integration/accounts/peak.hpp"

namespace viscobar {

// Private functions that a step calls for each sample are inline.

ContactWatch::ContactWatch(const PenalisedSystem& system, RunAccount& account, AccountExtremes extremes, bool apart)
    : contacts_(system.contacts()),
      load_(system.load()),
      bar_(system.bar()),
      extremes_(extremes),
      apart_(apart),
      span_(contacts_, account.span),
      joints_(contacts_, load_, account) {
  for (const bool right : {false, true}) {
    EndAccount& end = right ? account.right : account.left;
    const std::optional<double>& wall = bar_.unknowns().wall(right);
    if (!wall)
      watch(end, right);
    else if (bar_.inputs()[right].motion)
      ends_.push_back({&end, right, *wall});
    else
      end.displacement = end.lowest = end.highest = *wall;
  }
}

void ContactWatch::ask_for(std::vector<std::size_t>& entries) {
  for (const End& end : ends_)
    for (const std::size_t entry : end.entries) positions_.push_back(position_of(entry, entries));
  span_.ask_for(entries);
  joints_.ask_for(entries);
  places_.resize(2 * bar_.size());
  for (std::size_t k = 0; k < entries.size(); ++k) places_[entries[k]] = k;
}

void ContactWatch::select(std::vector<std::size_t>& positions) const {
  auto first = positions_.begin();
  for (const End& end : ends_) {
    positions.insert(positions.end(), first, first + static_cast<std::ptrdiff_t>(needed(end)));
    first += static_cast<std::ptrdiff_t>(end.entries.size());
  }
  span_.select(positions);
}

inline std::array<double, 6> ContactWatch::values_of(const End& end, std::span<const double> u,
                                                     std::span<const double> w) {
  std::array<double, 6> values{};
  for (std::size_t k = 0; k < end.entries.size(); ++k) {
    const std::size_t entry = end.entries[k];
    values[k] = entry < u.size() ? u[entry] : w[entry - u.size()];
  }
  return values;
}

void ContactWatch::enter_frame(std::span<const double> u, std::span<const double> w) {
  for (End& end : ends_) end.stored = stored(end, values_of(end, u, w));
}

void ContactWatch::begin(double t, std::span<const double> u, std::span<const double> w) {
  seen_ = t;
  joints_.begin(u, w);
  const auto holds = [this](std::size_t i) { return contacts_.closed(i) && contacts_[i].holds; };
  springs_ = !bar_.frame().moving() && !span_.closed() && !joints_.closed() &&
             std::ranges::none_of(
                 ends_, [&](const End& end) { return end.follows || std::ranges::any_of(end.contacts, holds); });
  for (End& end : ends_) {
    const std::array<double, 6> values = values_of(end, u, w);
    const double now = displacement(end, t, values);
    end.account->displacement = now;
    end.account->lowest = std::min(end.account->lowest, now);
    end.account->highest = std::max(end.account->highest, now);
    end.stored = stored(end, values);
    end.shut = closed(end);
  }
  idle_ = !extremes_.ranges && !span_.closed() && !joints_.closed() && std::ranges::none_of(ends_, &End::shut);
}

bool ContactWatch::within(std::span<const double> lowest, std::span<const double> highest,
                          std::span<const double> last) const {
  const std::size_t* position = positions_.data();
  for (const End& end : ends_) {
    const EndAccount& account = *end.account;
    const double low = lowest[*position], high = highest[*position], now = last[*position];
    const bool inside = (!extremes_.ranges || ((low == now || low + end.origin >= account.lowest) &&
                                               (high == now || high + end.origin <= account.highest))) &&
                        (!extremes_.peaks || !end.shut ||
                         largest_reaction(end, position, lowest, highest) <= std::abs(account.latest.reaction));
    if (!inside) return false;
    position += end.entries.size();
  }
  return true;
}

// A bound of |R|.
double ContactWatch::largest_reaction(const End& end, const std::size_t* position, std::span<const double> lowest,
                                      std::span<const double> highest) const {
  double most = 0.0, least = 0.0;
  for (const std::size_t i : end.contacts) {
    if (!contacts_.closed(i)) continue;
    const auto& [stiffness, damping] = contacts_[i].law.linear();
    const Contact& contact = contacts_[i];
    const double rest = contact.sign * contact.clearance(end.origin);
    most -= stiffness * (lowest[position[0]] + rest), least -= stiffness * (highest[position[0]] + rest);
    if (end.entries.size() > 2) most -= damping * lowest[position[2]], least -= damping * highest[position[2]];
    if (!contacts_[i].law.bent()) continue;
    // Monotone in the depth, linear in its rate: the extremes are at corners.
    for (const double u : {lowest[position[0]], highest[position[0]]})
      for (const double w : {lowest[position[2]], highest[position[2]]}) {
        const double force = contacts_[i].law.force(contact.sign * (u + rest), w);
        most = std::max(most, force), least = std::min(least, force);
      }
  }
  return std::max(most, -least);
}

void ContactWatch::pass(double to, std::span<const double> last) {
  seen_ = to;
  const std::size_t* position = positions_.data();
  for (End& end : ends_) {
    EndAccount& account = *end.account;
    account.displacement = last[*position] + end.origin;
    if (extremes_.ranges) {
      account.lowest = std::min(account.lowest, account.displacement);
      account.highest = std::max(account.highest, account.displacement);
    }
    position += end.entries.size();
  }
  each_shut(last, [this](End& end, std::span<const double> y) { end.stored_now = stored(end, y); });
}

void ContactWatch::add_rates(double weight, double t, std::span<const double> y) {
  each_shut(y,
            [&](End& end, std::span<const double> values) { end.account->impulse += weight * rate(end, t, values); });
}

bool ContactWatch::concerned(double to, double fastest) const {
  return bar_.frame().moving() || span_.closed() || std::ranges::any_of(ends_, [&](const End& end) {
           const EndAccount& account = *end.account;
           const double room = std::min(account.highest - account.displacement, account.displacement - account.lowest);
           return (extremes_.ranges && fastest * (to - seen_) >= room) || closed(end);
         });
}

void ContactWatch::select_rates(std::vector<std::size_t>& positions) const {
  const std::size_t* first = positions_.data();
  for (const End& end : ends_) {
    for (std::size_t k = 3; extremes_.peaks && holds_mass(end) && k < std::min<std::size_t>(5, end.entries.size()); ++k)
      if (std::ranges::find(positions, first[k]) == positions.end()) positions.push_back(first[k]);
    first += end.entries.size();
  }
}

void ContactWatch::look_at(double from, double to, std::size_t order, std::span<const PointValues> y,
                           std::span<const PointValues> rates) {
  length_ = to - from, end_ = to, order_ = order;
  const std::size_t* position = positions_.data();
  for (End& end : ends_) {
    end.shut = closed(end);
    if (end.shut || extremes_.ranges) look_at(end, position, from, y);
    if (end.shut && extremes_.peaks && holds_mass(end)) add_inertia(end, position, rates);
    position += end.entries.size();
  }
  span_.look_at(order, y);
}

bool ContactWatch::resolved() const {
  const auto smooth = [this](const PointValues& values, double scale) {
    PointValues rest = values;
    double largest = 0.0;
    for (const double value : used(values)) largest = std::max(largest, std::abs(value));
    for (std::size_t r = order_; r > 0; --r)
      for (std::size_t j = 0; j < r; ++j) rest[j] = rest[j + 1] - rest[j];
    return std::abs(rest[0]) <= std::max(1e-8 * largest, 1e-12 * scale);
  };
  if (span_.closed() && !smooth(span_.samples(), span_.peak())) return false;
  return std::ranges::all_of(ends_, [&](const End& end) {
    const double range = std::max(std::abs(end.account->lowest), std::abs(end.account->highest));
    if (!smooth(end.u, range)) return false;
    const double force = std::max(end.account->peak_reaction, end.modulus * range);
    return !end.shut || (smooth(end.force, force) && smooth(end.rate, force));
  });
}

void ContactWatch::strike(std::size_t i, double impulse, std::span<const double> change) {
  for (End& end : ends_) {
    if (std::ranges::find(end.contacts, i) != end.contacts.end())
      end.account->impulse += impulse;
    else if (holds_mass(end))
      end.account->impulse += gained(end, change);
  }
  joints_.strike(i, impulse, change);
}

void ContactWatch::add() {
  if (!(length_ > 0.0)) return;
  seen_ = end_;
  span_.add(end_, length_, order_);
  if (!forms_.empty()) add_joints(end_ - length_, end_, order_, form_points_);
  for (End& end : ends_) {
    if (extremes_.ranges) add_range(end);
    if (end.shut && extremes_.peaks) raise_peak(*end.account, used(end.force), end_, length_);
    if (!end.shut || (apart_ && springs_)) continue;
    end.account->impulse += end.stored_now - end.stored + length_ * Bernstein::mean(used(end.rate));
    end.stored = end.stored_now;
  }
}

void ContactWatch::add_range(End& end) {
  EndAccount& account = *end.account;
  account.displacement = end.u[order_];
  const auto [most, least] = beyond(end.u);
  if (most > account.highest || least < account.lowest) {
    const Bernstein u = through(end.u);
    account.highest = u.largest(account.highest);
    account.lowest = u.smallest(account.lowest);
  }
}

void ContactWatch::watch(EndAccount& account, bool right) {
  const std::size_t n = bar_.size(), unknown = bar_.unknowns().end(right);
  const double h = bar_.elements().stretch_beside(unknown);
  const BandedMatrix& inertia = bar_.inertia().matrix();
  const bool massless = bar_.inertia().massless(unknown);
  const std::array<double, 3> row = inertia.one_sided_entries(unknown, unknown > 0);
  End& end = ends_.emplace_back(End{&account, right, bar_.unknowns().wall(!right).value_or(0.0), unknown});
  if (n > 1) end.next = right ? unknown - 1 : 1;
  end.follows = massless && !bar_.bar().damped();
  end.modulus = bar_.bar().modulus / h,
  end.viscosity = bar_.bar().viscosity / bar_.elements().rate_stretch(bar_.elements().beside(unknown));
  end.mass = inertia.diagonal[unknown] + row[0], end.beyond = row[2];
  if (end.next && !inertia.is_diagonal()) end.coupling = inertia.off_diagonal[std::min(unknown, *end.next)] + row[1];
  for (const Support& support : bar_.supports())
    if (support.unknown == unknown) end.stiffness = support.stiffness, end.dashpot = support.dashpot;
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (contacts_[i].unknown == unknown && contacts_[i].joint == 0 && !contacts_[i].has_joint_row())
      end.contacts.push_back(i);
  end.direct = end.follows || std::ranges::all_of(end.contacts, [&](std::size_t i) {
                 return contacts_[i].by_law || (contacts_[i].relative_stiffness < 1.0 && !contacts_[i].law.bent());
               });
  if (end.follows)
    end.entries = {*end.next};
  else if (end.contacts.empty())
    end.entries = {unknown};
  else if (end.next)
    end.entries = {unknown, *end.next, n + unknown, n + *end.next};
  else
    end.entries = {unknown, unknown, n + unknown};
  // Without inertia, dashpot and rigidity no velocity counts.
  if (end.entries.size() > 2 && massless && std::ranges::none_of(end.contacts, [&](std::size_t i) {
        return contacts_[i].law.linear().damping > 0.0 || contacts_[i].holds;
      }))
    end.entries.resize(2);
  end.sided = bar_.side() && !massless && !end.contacts.empty();
  const std::size_t beyond = unknown == 0 ? 2 : unknown - 2;
  if (!inertia.one_sided.empty() && end.entries.size() == 4) end.entries.push_back(n + beyond);
  if (!inertia.one_sided.empty() && end.sided) end.entries.push_back(beyond);
}

inline bool ContactWatch::closed(const End& end) const {
  return std::ranges::any_of(end.contacts, [this](std::size_t i) { return contacts_.closed(i); });
}

// Where the inertia of the node's neighbours has a share in its reaction.
inline bool ContactWatch::holds_mass(const End& end) const {
  return end.coupling != 0.0 &&
         std::ranges::any_of(end.contacts, [this](std::size_t i) { return contacts_.holds_mass(i); });
}

inline double ContactWatch::stored(const End& end, std::span<const double> y) const {
  if (end.direct || end.contacts.empty()) return 0.0;
  const double without_viscosity = momentum(end, y) + end.dashpot * (y[0] + end.origin);
  return bar_.bar().damped() ? without_viscosity + end.viscosity * end.stretch(y) : without_viscosity;
}

// (E / h) p of a contact that the neighbour decides on, from its u and w.
inline double ContactWatch::pull(const End& end, double t, double u, double w, std::size_t i) const {
  const Contact& contact = contacts_[i];
  return end.modulus * (contact.sign * u + contact.clearance(end.origin_next)) + end.stiffness * contact.gap +
         contact.sign * (end.viscosity * w + load_.alone(end.unknown, t));
}

inline double ContactWatch::displacement(const End& end, double t, std::span<const double> y) const {
  if (end.entries.empty()) return end.wall + lift(end, t);
  if (!end.follows) return y[0] + end.origin + lift(end, t);
  const std::size_t i = end.contacts.front();
  const double share = contacts_.closed(i) ? contacts_[i].penetration_share() : 1.0;
  const Contact& contact = contacts_[i];
  return contact.sign * (share * pull(end, t, y[0], 0.0, i) / end.modulus - contact.gap) + lift(end, t);
}

inline double ContactWatch::reaction(const End& end, double t, std::span<const double> y) const {
  double sum = 0.0;
  for (const std::size_t i : end.contacts) {
    if (!contacts_.closed(i)) continue;
    const Contact& contact = contacts_[i];
    if (end.follows)
      sum -= contact.sign * (1.0 - contacts_[i].penetration_share()) * pull(end, t, y[0], 0.0, i);
    else if (contacts_[i].holds)
      sum += (end.sided ? side_row(end, y) : 0.0) -
             contact.sign * (1.0 - contacts_[i].penetration_share()) * pull(end, t, y[1], y[3], i);
    else
      sum += contacts_[i].law.force(contact.sign * y[0] + contact.clearance(end.origin), y[2]);
  }
  return sum;
}

// Rate of the impulse, beside what is stored.
inline double ContactWatch::rate(const End& end, double t, std::span<const double> y) const {
  if (end.direct) return reaction(end, t, y);
  const double side = end.sided ? side_row(end, y) : 0.0;
  return side + end.modulus * end.stretch(y) + end.stiffness * (y[0] + end.origin) - load_.alone(end.unknown, t);
}

// (M (k u + c w))_e
inline double ContactWatch::side_row(const End& end, std::span<const double> y) const {
  const SideRows& side = *bar_.side();
  const std::size_t last = bar_.mesh().elements;
  return side.at_end(end.right, [&](std::size_t j) {
    const std::size_t away = end.right ? last - j : j;
    if (away == 0) return side.stiffness(j) * (y[0] + end.origin) + side.drag(j) * y[2];
    if (away == 1 && !end.next) return side.stiffness(j) * end.wall;
    if (away == 1) return side.stiffness(j) * (y[1] + end.origin_next) + side.drag(j) * y[3];
    return side.stiffness(j) * (y[5] + end.origin_beyond) + side.drag(j) * y[4];
  });
}

inline void ContactWatch::look_at(End& end, const std::size_t* first, double from,
                                  std::span<const PointValues> y) const {
  const std::size_t entries = needed(end);
  const bool rates = end.shut && !(apart_ && springs_) && !add_alike_rates(end, first, y);
  const bool forces = end.shut && extremes_.peaks && !take_holding_force(end, first, from, y);
  const bool moves = extremes_.ranges && (end.follows || end.entries.empty() || bar_.frame().moving());
  for (std::size_t j = 0; extremes_.ranges && !moves && j < end.u.size(); ++j) end.u[j] = y[first[0]][j] + end.origin;
  for (std::size_t j = moves || rates || forces ? 0 : order_; j <= order_; ++j) {
    const double t = point_of(from, end_, order_, j);
    std::array<double, 6> values{};
    for (std::size_t e = 0; e < entries; ++e) values[e] = y[first[e]][j];
    if (moves) end.u[j] = displacement(end, t, std::span(values).first(entries));
    if (rates) end.rate[j] = rate(end, t, values);
    if (forces) end.force[j] = reaction(end, t, values);
    if (end.shut && j == order_) end.stored_now = stored(end, values);
  }
}

// reaction() at all points at once, where one contact that holds is all that is closed, without a side. False: it is
// not.
inline bool ContactWatch::take_holding_force(End& end, const std::size_t* first, double from,
                                             std::span<const PointValues> y) const {
  if (end.contacts.size() != 1 || !contacts_[end.contacts.front()].holds || end.follows || end.sided || !end.next)
    return false;
  const Contact& contact = contacts_[end.contacts.front()];
  const double share = 1.0 - contacts_[end.contacts.front()].penetration_share(), by_u = share * end.modulus,
               by_w = share * end.viscosity,
               rest = share * contact.sign *
                      (end.modulus * contact.clearance(end.origin_next) + end.stiffness * contact.gap);
  const PointValues &u = y[first[1]], &w = y[first[3]];
  for (std::size_t j = 0; j < u.size(); ++j) end.force[j] = -(by_u * u[j] + by_w * w[j] + rest);
  for (std::size_t j = 0; load_.acts() && j <= order_; ++j)
    end.force[j] -= share * load_.alone(end.unknown, point_of(from, end_, order_, j));
  return true;
}

// Adds the share of its neighbours, by their inertia, in the force of a held node with mass.
inline void ContactWatch::add_inertia(End& end, const std::size_t* first, std::span<const PointValues> rates) const {
  const PointValues& next = rates[first[3]];
  for (std::size_t j = 0; j < next.size(); ++j) end.force[j] += end.coupling * next[j];
  if (end.entries.size() < 5) return;
  const PointValues& beyond = rates[first[4]];
  for (std::size_t j = 0; j < beyond.size(); ++j) end.force[j] += end.beyond * beyond[j];
}

// rate() at all points at once, where it is one sum without a load or a side. False: it is not.
inline bool ContactWatch::add_alike_rates(End& end, const std::size_t* first, std::span<const PointValues> y) const {
  if (end.direct || end.sided || load_.acts() || !end.next) return false;
  const PointValues &own = y[first[0]], &next = y[first[1]];
  const double apart = end.origin - end.origin_next;
  for (std::size_t j = 0; j < own.size(); ++j)
    end.rate[j] = end.stiffness * (own[j] + end.origin) + end.modulus * (own[j] - next[j] + apart);
  return true;
}

// Bounds of the polynomial, above and below.
inline std::pair<double, double> ContactWatch::beyond(const PointValues& values) const {
  const auto [least, most] = std::ranges::minmax(used(values));
  const double excess = Bernstein::excess(order_) * (most - least);
  return {most + excess, least - excess};
}
}  // namespace viscobar
