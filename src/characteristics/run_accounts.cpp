#include <algorithm>
#include <tuple>
#include <utility>

#include "characteristics/run.hpp"
#include "discretisation/gauss.hpp"

namespace viscobar::characteristics {

namespace {

// Integral of f of a place over [0, 1], polynomial of degree 2 points - 1 between the breaks.
double integral(std::vector<double> breaks, auto&& f, std::size_t points = 36) {
  breaks.insert(breaks.end(), {0.0, 1.0});
  std::ranges::sort(breaks);
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const double half = 0.5 * (breaks[k + 1] - breaks[k]), middle = 0.5 * (breaks[k + 1] + breaks[k]);
    if (!(half > 0.0)) continue;
    for (const auto [node, weight] : gauss(points)) sum += half * weight * f(middle + half * node);
  }
  return sum;
}

void add_breaks(const Piecewise& f, std::vector<double>& breaks) {
  for (std::size_t i = 0; i + 1 < f.size(); ++i) breaks.push_back(f[i].end);
}

}  // namespace

double Run::moment(std::vector<double> breaks, auto&& displacement) const {
  const Piecewise& gain = load_->rightward();
  add_breaks(gain, breaks);
  add_breaks(data_.displacement, breaks);
  std::size_t i = 0;
  return impedance_ * integral(std::move(breaks), [&](double place) {
           while (i + 1 < gain.size() && gain[i].end <= place) ++i;
           while (i > 0 && gain[i].begin > place) --i;
           return gain.polynomial(i).derivative()(gain[i].z(place)) / gain[i].half * displacement(place);
         });
}

void Run::account(EndAccount& account, const BarEnd& bar_end) const {
  const auto& [end, driven] = bar_end.now;
  account.displacement = end.displacement() + bar_end.driven.displacement(t_);
  std::tie(account.lowest, account.highest) = end.range();
  if (bar_end.driven.moves()) account.lowest = driven.lowest, account.highest = driven.highest;
  account.impulse = impedance_ * bar_end.driven.force_factor() * passage_ * end.impulse();
  account.peak_reaction = impedance_ * bar_end.driven.force_factor() * end.max_reaction();
  account.latest = peak_of(bar_end, end.latest());
}

void Run::begin() {
  // The waves on their way at the start, as if the ends had sent them in the passage before.
  Piecewise rightward, leftward;
  combine(data_.velocity, 1.0, data_.strain_velocity, -1.0, rightward);
  combine(data_.velocity, 1.0, data_.strain_velocity, 1.0, leftward);
  if (load_ && load_->steady()) {
    combine(Piecewise(rightward), 1.0, load_->rightward(), -1.0, rightward);
    combine(Piecewise(leftward), 1.0, load_->leftward(), -1.0, leftward);
  }
  left_.sent_before = mirrored(rightward);
  right_.sent_before = leftward;
  now_.place_scale = data_.displacement.bound();
  now_.velocity_scale = std::max(data_.velocity.bound(), data_.strain_velocity.bound());
  if (observers_.account) statistics_.account.emplace();
  if (observers_.energy) {
    std::vector<double> breaks;
    for (const Piecewise* f : {&rightward, &leftward, &data_.velocity, &data_.strain_velocity}) add_breaks(*f, breaks);
    Cursor v(data_.velocity), e(data_.strain_velocity);
    statistics_.energy.emplace().initial =
        0.5 * scene_.bar.density * scene_.bar.length * integral(breaks, [&](double place) {
          const double of_velocity = v.value(place), of_strain = e.value(place);
          return of_velocity * of_velocity + of_strain * of_strain;
        });
    statistics_.energy->initial += kinetic(left_, v.value(0.0)) + kinetic(right_, v.value(1.0));
    if (load_ && load_->steady())
      initial_moment_ = moment({}, [u = Cursor(data_.displacement)](double place) mutable { return u.value(place); });
  }
}

double Run::arrived_work(const Piecewise& sent, const Piecewise& gain, double until) const {
  double sum = 0.0;
  for_common_pieces(sent, gain, until, [&](double from, double to, std::size_t i, std::size_t j) {
    const Chebyshev w = sent.polynomial(i), g = gain.polynomial(j);
    const double half = 0.5 * (to - from), middle = 0.5 * (to + from);
    for (const auto [node, weight] : gauss(Chebyshev::most_terms)) {
      const double s = middle + half * node, gained = g(gain[j].z(s));
      sum += half * weight * gained * (2.0 * w(sent[i].z(s)) + gained);
    }
  });
  return 0.25 * scene_.bar.density * scene_.bar.length * sum;
}

std::vector<double> Run::breaks_at(double s) const {
  std::vector<double> breaks{s, 1.0 - s};
  const auto add = [&](const Piecewise& sent, auto&& place) {
    for (std::size_t i = 0; i < sent.size(); ++i) breaks.push_back(place(sent[i].begin));
  };
  add(left_.sent, [s](double begin) { return s - begin; });
  add(right_.sent, [s](double begin) { return 1.0 - (s - begin); });
  add(left_.sent_before, [s](double begin) { return 1.0 + s - begin; });
  add(right_.sent_before, [s](double begin) { return begin - s; });
  if (load_) {
    add_breaks(load_->rightward(), breaks);
    add_breaks(load_->leftward(), breaks);
  }
  std::erase_if(breaks, [](double place) { return !(place > 0.0 && place < 1.0); });
  return breaks;
}

double Run::work_at(double s, Field& now, const std::vector<double>& breaks) const {
  if (load_->steady()) return moment(breaks, [&](double place) { return now.displacement(place); }) - initial_moment_;
  Cursor right_gain(load_->rightward()), left_gain(load_->leftward());
  const double arrived = begin_.work + arrived_work(right_.sent_before, load_->arriving_left(), s) +
                         arrived_work(left_.sent_before, load_->arriving_right(), s);
  return arrived + 0.25 * scene_.bar.density * scene_.bar.length * integral(breaks, [&](double place) {
                     const double g = right_gain.value(place), h = left_gain.value(place);
                     return g * (2.0 * now.rightward(place) - g) + h * (2.0 * now.leftward(place) - h);
                   });
}

std::size_t Run::most_terms() const {
  std::vector<const Piecewise*> parts{&left_.sent, &right_.sent, &left_.sent_before, &right_.sent_before};
  if (load_) parts.insert(parts.end(), {&load_->rightward(), &load_->leftward()});
  std::size_t most = 1;
  for (const Piecewise* f : parts)
    for (std::size_t i = 0; i < f->size(); ++i) most = std::max<std::size_t>(most, (*f)[i].terms);
  return most;
}

EnergyState Run::energy_at(double s, Field& now) const {
  const std::vector<double> breaks = breaks_at(s);
  const std::size_t points = std::min<std::size_t>(most_terms(), 36);
  const auto energy_of = [&](double sign) {
    const auto square = [&](double place) {
      const double sum = now.rightward(place) + sign * now.leftward(place);
      return sum * sum;
    };
    return 0.125 * scene_.bar.density * scene_.bar.length * integral(breaks, square, points);
  };
  EnergyState energy;
  energy.kinetic = energy_of(1.0);
  energy.elastic = energy_of(-1.0);
  if (load_) energy.work = work_at(s, now, breaks);
  for (const BarEnd* end : {&left_, &right_}) {
    if (!end->driven.active()) continue;
    Cursor along(end->moved());
    energy.kinetic += kinetic(*end, end->now.end.velocity_at(s, along));
    const DrivenEnd::Flow since = end->driven.flow(end->now.end, end->moved(), s);
    energy.work += end->begin.driven.work + since.work;
    energy.dissipated += end->begin.driven.dissipated + since.dissipated;
  }
  return energy;
}

void Run::finish() {
  t_ = times_.back();
  statistics_.completed = true;
  if (!statistics_.energy) return;
  const double s = left_.sent.end();
  Field now = field(s, t_);
  const std::vector<double> breaks = breaks_at(s);
  EnergyAccount& energy = *statistics_.energy;
  energy.final = 0.25 * scene_.bar.density * scene_.bar.length * integral(breaks, [&](double place) {
                   const double a = now.rightward(place), b = now.leftward(place);
                   return a * a + b * b;
                 });
  for (const BarEnd* end : {&left_, &right_}) {
    Cursor along(end->moved());
    energy.final += kinetic(*end, end->now.end.velocity_at(s, along));
  }
  const DrivenEnd::Account &left = left_.now.driven, &right = right_.now.driven;
  energy.dissipated = left.dissipated + right.dissipated;
  energy.work = left.work + right.work;
  if (load_) energy.work += work_at(s, now, breaks);
}

}  // namespace viscobar::characteristics
