#include <algorithm>
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

double Run::moment(std::size_t bar, std::vector<double> breaks, auto&& displacement) const {
  const Piecewise& gain = loads_[bar]->rightward();
  add_breaks(gain, breaks);
  add_breaks(data_[bar].displacement, breaks);
  std::size_t i = 0;
  return bars_[bar].impedance() * integral(std::move(breaks), [&](double place) {
           while (i + 1 < gain.size() && gain[i].end <= place) ++i;
           while (i > 0 && gain[i].begin > place) --i;
           return gain.polynomial(i).derivative()(gain[i].z(place)) / gain[i].half * displacement(place);
         });
}

ContactPeak Run::peak_of(std::size_t junction, std::size_t link, const ContactPeak& latest) const {
  return {junctions_[junction].sign(link) * latest.reaction,
          std::clamp(time_at(latest.time), times_.front(), times_.back())};
}

void Run::account() {
  if (!statistics_.account) return;
  RunAccount& account = *statistics_.account;
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    const Junction& junction = junctions_[j];
    const Junction::Memory& memory = junction.memory();
    for (std::size_t i = 0; i < memory.bodies.size(); ++i) {
      if (!junction.is_end(i)) continue;
      EndAccount& end = j == 0 ? account.left : account.right;
      end.displacement = memory.bodies[i].place;
      end.lowest = memory.bodies[i].lowest, end.highest = memory.bodies[i].highest;
    }
    for (std::size_t l = 0; l < junction.links().size(); ++l) {
      const Junction::Link& link = junction.links()[l];
      if (!link.touches()) continue;
      const Junction::LinkMemory& of_link = memory.links[l];
      account.joints.resize(std::max(account.joints.size(), link.joint));
      const auto take = [&](auto& contact) {
        contact.impulse = junction.sign(l) * of_link.impulse;
        contact.peak_reaction = of_link.peak_force;
        contact.latest = peak_of(j, l, of_link.latest);
      };
      if (link.joint > 0)
        take(account.joints[link.joint - 1]);
      else
        take(j == 0 ? account.left : account.right);
    }
  }
}

void Run::begin() {
  if (observers_.account) statistics_.account.emplace();
  if (observers_.energy) statistics_.energy.emplace();
  for (std::size_t b = 0; b < bars_.size(); ++b) {
    // The waves on their way at the start, as if the faces had sent them before.
    const InitialData& data = data_[b];
    Piecewise rightward, leftward;
    combine(data.velocity, 1.0, data.strain_velocity, -1.0, rightward);
    combine(data.velocity, 1.0, data.strain_velocity, 1.0, leftward);
    if (!loads_.empty() && loads_[b]->steady()) {
      combine(Piecewise(rightward), 1.0, loads_[b]->rightward(), -1.0, rightward);
      combine(Piecewise(leftward), 1.0, loads_[b]->leftward(), -1.0, leftward);
    }
    lines_[b].rightward.fill(mirrored(rightward));
    lines_[b].leftward.fill(leftward);
    now_.place_scale = std::max(now_.place_scale, data.displacement.bound());
    now_.velocity_scale = std::max({now_.velocity_scale, data.velocity.bound(), data.strain_velocity.bound()});
    if (!observers_.energy) continue;
    std::vector<double> breaks;
    for (const auto* f : {&std::as_const(rightward), &std::as_const(leftward), &data.velocity, &data.strain_velocity})
      add_breaks(*f, breaks);
    Cursor v(data.velocity), e(data.strain_velocity);
    statistics_.energy->initial += 0.5 * bars_[b].mass() * integral(breaks, [&](double place) {
                                     const double of_velocity = v.value(place), of_strain = e.value(place);
                                     return of_velocity * of_velocity + of_strain * of_strain;
                                   });
    if (!loads_.empty() && loads_[b]->steady())
      initial_moment_ +=
          moment(b, {}, [u = Cursor(data.displacement)](double place) mutable { return u.value(place); });
  }
  if (observers_.energy)
    for (const Junction& junction : junctions_) statistics_.energy->initial += junction.energy_at(0.0).total();
}

double Run::arrived_work(std::size_t bar, const Piecewise& sent, const Piecewise& gain, double until) const {
  double sum = 0.0;
  for_common_pieces(sent, gain, until, [&](double from, double to, std::size_t i, std::size_t j) {
    const Chebyshev w = sent.polynomial(i), g = gain.polynomial(j);
    const double half = 0.5 * (to - from), middle = 0.5 * (to + from);
    for (const auto [node, weight] : gauss(Chebyshev::most_terms)) {
      const double s = middle + half * node, gained = g(gain[j].z(s));
      sum += half * weight * gained * (2.0 * w(sent[i].z(s)) + gained);
    }
  });
  return 0.25 * bars_[bar].mass() / lines_[bar].rightward.delay() * sum;
}

std::vector<double> Run::breaks_at(std::size_t bar, double s) const {
  std::vector<double> breaks;
  const auto add = [&](const DelayLine& line, const Piecewise& now, bool rightward) {
    for (std::size_t j = 0; j <= line.windows(); ++j) {
      const Piecewise& sent = j == 0 ? now : line.before(j);
      for (std::size_t i = 0; i < sent.size(); ++i) {
        const double way = (static_cast<double>(j) + s - sent[i].begin) / line.delay();
        breaks.push_back(rightward ? way : 1.0 - way);
      }
    }
  };
  add(lines_[bar].rightward, sent_right(bar), true);
  add(lines_[bar].leftward, sent_left(bar), false);
  if (!loads_.empty()) {
    add_breaks(loads_[bar]->rightward(), breaks);
    add_breaks(loads_[bar]->leftward(), breaks);
  }
  std::erase_if(breaks, [](double place) { return !(place > 0.0 && place < 1.0); });
  return breaks;
}

double Run::work_at(std::size_t bar, double s, Field& now, const std::vector<double>& breaks) {
  const LoadGain& load = *loads_[bar];
  if (load.steady()) return moment(bar, breaks, [&](double place) { return now.displacement(place); });
  Cursor right_gain(load.rightward()), left_gain(load.leftward());
  const double arrived = arrived_work(bar, lines_[bar].leftward.arriving(), load.arriving_left(), s) +
                         arrived_work(bar, lines_[bar].rightward.arriving(), load.arriving_right(), s);
  return arrived + 0.25 * bars_[bar].mass() * integral(breaks, [&](double place) {
                     const double g = right_gain.value(place), h = left_gain.value(place);
                     return g * (2.0 * now.rightward(place) - g) + h * (2.0 * now.leftward(place) - h);
                   });
}

std::size_t Run::most_terms(std::size_t bar) const {
  std::size_t most = 1;
  const auto see = [&](const Piecewise& f) {
    for (std::size_t i = 0; i < f.size(); ++i) most = std::max<std::size_t>(most, f[i].terms);
  };
  see(sent_right(bar)), see(sent_left(bar));
  for (const DelayLine* line : {&lines_[bar].rightward, &lines_[bar].leftward})
    for (std::size_t j = 1; j <= line->windows(); ++j) see(line->before(j));
  if (!loads_.empty()) see(loads_[bar]->rightward()), see(loads_[bar]->leftward());
  return most;
}

EnergyState Run::energy_at(double s, std::vector<Field>& fields) {
  EnergyState energy;
  energy.work = begin_.work - initial_moment_;
  for (std::size_t b = 0; b < bars_.size(); ++b) {
    Field& now = fields[b];
    const std::vector<double> breaks = breaks_at(b, s);
    const std::size_t points = std::min<std::size_t>(most_terms(b), 36);
    const auto energy_of = [&](double sign) {
      const auto square = [&](double place) {
        const double sum = now.rightward(place) + sign * now.leftward(place);
        return sum * sum;
      };
      return 0.125 * bars_[b].mass() * integral(breaks, square, points);
    };
    energy.kinetic += energy_of(1.0);
    energy.elastic += energy_of(-1.0);
    if (!loads_.empty()) energy.work += work_at(b, s, now, breaks);
  }
  for (const Junction& junction : junctions_) {
    const EnergyState own = junction.energy_at(s);
    energy.kinetic += own.kinetic, energy.elastic += own.elastic, energy.contact += own.contact;
    energy.work += own.work, energy.dissipated += own.dissipated;
  }
  return energy;
}

void Run::finish() {
  t_ = times_.back();
  statistics_.completed = true;
  if (!statistics_.energy) return;
  const double s = sent_right(0).end();
  std::vector<Field> now = fields(s, t_);
  const EnergyState energy = energy_at(s, now);
  statistics_.energy->final = energy.total();
  statistics_.energy->dissipated = energy.dissipated;
  statistics_.energy->work = energy.work;
}

}  // namespace viscobar::characteristics
