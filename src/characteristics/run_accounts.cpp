#include <utility>

#include "characteristics/run.hpp"

namespace viscobar::characteristics {

namespace {

// Integral of f of a place over [0, 1], polynomial of degree 2 points - 1 between the breaks.
template <class Function>
double integral(std::vector<double>& breaks, Function&& f, std::size_t points = 36) {
  breaks.push_back(0.0);
  breaks.push_back(1.0);
  std::ranges::sort(breaks);
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const double half = 0.5 * (breaks[k + 1] - breaks[k]), middle = 0.5 * (breaks[k + 1] + breaks[k]);
    if (!(half > 0.0)) continue;
    for (const auto [node, weight] : gauss_legendre(points)) sum += half * weight * f(middle + half * node);
  }
  return sum;
}

void add_breaks(const Piecewise& f, std::vector<double>& breaks) {
  for (std::size_t i = 0; i + 1 < f.size(); ++i) breaks.push_back(f[i].end);
}

}  // namespace

template <class Make>
double Run::moment(Make&& make) {
  const Piecewise& gain = load_->rightward();
  auto displacement = make();
  std::vector<double> breaks = moment_breaks_;
  add_breaks(gain, breaks);
  add_breaks(data_.displacement, breaks);
  std::size_t i = 0;
  double sum = 0.0;
  sum = integral(breaks, [&](double place) {
    while (i + 1 < gain.size() && gain[i].end <= place) ++i;
    while (i > 0 && gain[i].begin > place) --i;
    return gain.polynomial(i).derivative()(gain[i].z(place)) / gain[i].half * displacement(place);
  });
  return impedance_ * sum;
}

void Run::account(EndAccount& account, const End& end, const DrivenEnd& driven, const EndCondition& condition) const {
  const Borne& borne = end.borne();
  account.displacement = displacement_at(condition, end.place()) + driven.displacement(t_);
  account.lowest = displacement_at(condition, borne.lowest);
  account.highest = displacement_at(condition, borne.highest);
  if (sign_of(condition) < 0.0) std::swap(account.lowest, account.highest);
  if (driven.moves()) account.lowest = driven.account().lowest, account.highest = driven.account().highest;
  account.impulse = impedance_ * driven.force_factor() * passage_ * end.impulse();
  account.peak_reaction = impedance_ * driven.force_factor() * borne.max_reaction;
}

void Run::begin() {
  // The waves on their way at the start, as if the ends had sent them in the passage before.
  Piecewise rightward, leftward;
  combine(data_.velocity, 1.0, data_.strain_velocity, -1.0, rightward);
  combine(data_.velocity, 1.0, data_.strain_velocity, 1.0, leftward);
  if (load_ && load_->steady()) {
    Piecewise without;
    combine(rightward, 1.0, load_->rightward(), -1.0, without);
    rightward = without;
    combine(leftward, 1.0, load_->leftward(), -1.0, without);
    leftward = without;
  }
  sent_left_before_ = mirrored(rightward);
  sent_right_before_ = leftward;
  place_scale_ = data_.displacement.bound();
  velocity_scale_ = std::max(data_.velocity.bound(), data_.strain_velocity.bound());
  if (observers_.account) statistics_.account.emplace();
  if (observers_.energy) {
    std::vector<double> breaks;
    add_breaks(rightward, breaks);
    add_breaks(leftward, breaks);
    add_breaks(data_.velocity, breaks);
    add_breaks(data_.strain_velocity, breaks);
    Cursor v(data_.velocity), e(data_.strain_velocity);
    statistics_.energy.emplace().initial =
        0.5 * scene_.bar.density * scene_.bar.length * integral(breaks, [&](double place) {
          const double of_velocity = v.value(place), of_strain = e.value(place);
          return of_velocity * of_velocity + of_strain * of_strain;
        });
    if (load_ && load_->steady())
      initial_moment_ =
          moment([&] { return [u = Cursor(data_.displacement)](double place) mutable { return u.value(place); }; });
  }
}

double Run::arrived_work(const Piecewise& sent, const Piecewise& gain, double until) const {
  double sum = 0.0;
  for_common_pieces(sent, gain, until, [&](double from, double to, std::size_t i, std::size_t j) {
    const Chebyshev w = sent.polynomial(i), g = gain.polynomial(j);
    const double half = 0.5 * (to - from), middle = 0.5 * (to + from);
    for (const auto [node, weight] : gauss_legendre(Chebyshev::most_terms)) {
      const double s = middle + half * node, gained = g(gain[j].z(s));
      sum += half * weight * gained * (2.0 * w(sent[i].z(s)) + gained);
    }
  });
  return 0.25 * scene_.bar.density * scene_.bar.length * sum;
}

std::vector<double> Run::breaks_at(double s) const {
  std::vector<double> breaks{s, 1.0 - s};
  for (std::size_t i = 0; i < sent_left_.size(); ++i) breaks.push_back(s - sent_left_[i].begin);
  for (std::size_t i = 0; i < sent_right_.size(); ++i) breaks.push_back(1.0 - (s - sent_right_[i].begin));
  for (std::size_t i = 0; i < sent_left_before_.size(); ++i) breaks.push_back(1.0 + s - sent_left_before_[i].begin);
  for (std::size_t i = 0; i < sent_right_before_.size(); ++i) breaks.push_back(sent_right_before_[i].begin - s);
  if (load_) {
    add_breaks(load_->rightward(), breaks);
    add_breaks(load_->leftward(), breaks);
  }
  std::erase_if(breaks, [](double place) { return !(place > 0.0 && place < 1.0); });
  return breaks;
}

double Run::work_at(double s, Field& now) {
  if (load_->steady())
    return moment([&] { return [&](double place) { return now.displacement(place); }; }) - initial_moment_;
  Cursor right_gain(load_->rightward()), left_gain(load_->leftward());
  const double arrived = work_begin_ + arrived_work(sent_right_before_, load_->arriving_left(), s) +
                         arrived_work(sent_left_before_, load_->arriving_right(), s);
  return arrived + 0.25 * scene_.bar.density * scene_.bar.length * integral(moment_breaks_, [&](double place) {
                     const double g = right_gain.value(place), h = left_gain.value(place);
                     return g * (2.0 * now.rightward(place) - g) + h * (2.0 * now.leftward(place) - h);
                   });
}

std::size_t Run::most_terms() const {
  std::size_t most = 1;
  const auto look = [&](const Piecewise& f) {
    for (std::size_t i = 0; i < f.size(); ++i) most = std::max<std::size_t>(most, f[i].terms);
  };
  for (const Piecewise* sent : {&sent_left_, &sent_right_, &sent_left_before_, &sent_right_before_}) look(*sent);
  if (load_) look(load_->rightward()), look(load_->leftward());
  return most;
}

EnergyState Run::energy_at(double s, Field& now) {
  std::vector<double> breaks = moment_breaks_ = breaks_at(s);
  const double share = 0.125 * scene_.bar.density * scene_.bar.length;
  const std::size_t points = std::min<std::size_t>(most_terms(), 36);
  EnergyState energy;
  energy.kinetic = share * integral(
                               breaks,
                               [&](double place) {
                                 const double v = now.rightward(place) + now.leftward(place);
                                 return v * v;
                               },
                               points);
  breaks = moment_breaks_;
  energy.elastic = share * integral(
                               breaks,
                               [&](double place) {
                                 const double e = now.rightward(place) - now.leftward(place);
                                 return e * e;
                               },
                               points);
  if (load_) energy.work = work_at(s, now);
  for (const bool left : {true, false}) {
    const DrivenEnd& driven = left ? driven_left_ : driven_right_;
    if (!driven.active()) continue;
    const DrivenEnd::Account& begin = left ? driven_left_begin_ : driven_right_begin_;
    const DrivenEnd::Flow since = driven.flow(left ? left_ : right_, moved(left), s);
    energy.work += begin.work + since.work;
    energy.dissipated += begin.dissipated + since.dissipated;
  }
  return energy;
}

void Run::finish() {
  t_ = times_.back();
  statistics_.completed = true;
  if (!statistics_.energy) return;
  const double s = sent_left_.end();
  Field now = field(s, t_);
  std::vector<double> breaks = moment_breaks_ = breaks_at(s);
  const double share = 0.25 * scene_.bar.density * scene_.bar.length;
  EnergyAccount& energy = *statistics_.energy;
  energy.final = share * integral(breaks, [&](double place) {
                   const double a = now.rightward(place), b = now.leftward(place);
                   return a * a + b * b;
                 });
  energy.dissipated = driven_left_.account().dissipated + driven_right_.account().dissipated;
  energy.work = driven_left_.account().work + driven_right_.account().work;
  if (load_) energy.work += work_at(s, now);
}

}  // namespace viscobar::characteristics
