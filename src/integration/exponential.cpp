#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "dynamics/stopwatch.hpp"
#include "integration/exponential/energy_integral.hpp"
#include "integration/exponential/passage.hpp"
#include "integration/exponential/propagator.hpp"
#include "viscobar/dynamics/errors.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace {

using namespace exponential;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Series = LinearLeg<double>::Series;

constexpr std::size_t max_unknowns = 400;
constexpr std::size_t table_bytes = std::size_t{1} << 28;  // of all contact states kept, about
constexpr int patience = 8;             // steps before a length that failed is tried again
constexpr int max_instant_changes = 20;
constexpr int max_load_jumps = 1000;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

double largest_inverse_inertia(const BarSystem& system) {
  const auto begin = static_cast<Index>(system.massive_begin());
  const Index count = static_cast<Index>(system.massive_end()) - begin;
  const SymmetricTridiagonal& inertia = system.inertia();
  const VectorXd diagonal = Eigen::Map<const VectorXd>(inertia.diagonal.data() + begin, count);
  if (inertia.off_diagonal.empty() || count == 1) return 1.0 / diagonal.minCoeff();
  const VectorXd off = Eigen::Map<const VectorXd>(inertia.off_diagonal.data() + begin, count - 1);
  Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum;
  spectrum.computeFromTridiagonal(diagonal, off, Eigen::EigenvaluesOnly);
  return 1.0 / spectrum.eigenvalues().minCoeff();
}

// Steps through legs of constant contact states. A leg begins with steps that one Taylor series covers and doubles
// them as long as nothing is left unresolved inside: the load, a possible contact change, the energy flow, a new
// maximum of the penetration. What a longer step leaves unresolved is found by shorter ones, at last by the series.
class Run {
 public:
  Run(const BarSystem& system, const State& start, std::span<const double> times, const Penalty& penalty,
      const Observers& observers)
      : system_(system), times_(times), observers_(observers), load_(system), t_(times.front()) {
    const std::vector<double> masses =
        penalty.restitution < 1.0 ? system.effective_masses() : std::vector<double>(system.size(), 0.0);
    for (const Contact& contact : system.contacts())
      contacts_.push_back({static_cast<Index>(contact.unknown), contact.gap,
                           penalty_law(penalty, contact.weight, masses[contact.unknown])});
    closed_.assign(contacts_.size(), false);
    changes_.assign(contacts_.size(), {t_, 0});
    inverse_inertia_ = largest_inverse_inertia(system);
    choose_propagator();
    y_ = leg().pack(Eigen::Map<const VectorXd>(start.u.data(), static_cast<Index>(system.size())),
                    Eigen::Map<const VectorXd>(start.v.data(), static_cast<Index>(system.size())));
    statistics_.unknowns = static_cast<std::size_t>(y_.size());
    if (observers.energy) statistics_.energy.emplace();
  }

  Statistics operator()() {
    try {
      begin();
      while (t_ < times_.back()) advance();
    } catch (const LoadError& error) {
      fail(error.what());
    }
    statistics_.completed = true;
    return finished();
  }

 private:
  const LinearLeg<double>& leg() const { return propagator_->leg(); }

  Statistics finished() {
    statistics_.reached_time = t_;
    statistics_.load_evaluations = load_.evaluations();
    statistics_.integration_seconds = watch_.seconds();
    return statistics_;
  }

  [[noreturn]] void fail(const std::string& what) {
    throw IntegrationError(fmt::format("exponential: {} (reached t = {})", what, t_), finished());
  }

  template <class Call>
  void tell(Call&& call) {
    watch_.outside(call);
  }

  // Displacement below which the sign of a gap is rounding.
  double band(std::size_t c) const { return 8.0 * epsilon * (std::abs(contacts_[c].gap) + largest_displacement_); }

  void update_largest_displacement() {
    if (contacts_.empty()) return;
    largest_displacement_ = std::max(largest_displacement_, y_.head(leg().displacements()).cwiseAbs().maxCoeff());
  }

  void choose_propagator() {
    const auto known = std::ranges::find(propagators_, closed_, &Cached::closed);
    if (known != propagators_.end()) {
      std::rotate(known, known + 1, propagators_.end());
    } else {
      std::vector<ContactLaw> closed;
      for (std::size_t c = 0; c < contacts_.size(); ++c)
        if (closed_[c]) closed.push_back(contacts_[c]);
      propagators_.push_back({closed_, std::make_unique<Propagator>(system_, inverse_inertia_, load_,
                                                                    std::move(closed),
                                                                    statistics_.matrix_factorisations)});
      const std::size_t m = 2 * system_.size(), keep = std::max<std::size_t>(4, table_bytes / (200 * m * m));
      if (propagators_.size() > keep) propagators_.erase(propagators_.begin());
    }
    propagator_ = propagators_.back().propagator.get();
    level_ = pause_ = 0;
  }

  // Contact states and energy at the start.
  void begin() {
    update_largest_displacement();
    double tau = std::min(propagator_->step(0), times_.back() - t_);
    while (!load_.fit(t_, tau, p_) && tau > shortest_step()) tau /= 2;
    const Series motion = propagator_->expand(y_, p_, tau, 2);
    std::vector<std::size_t> closing;
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const Index i = contacts_[c].unknown;
      const double gap = motion(i, 0) + contacts_[c].gap, v = motion(i, 1);
      const bool touching = std::abs(gap) <= band(c) && (v < 0.0 || (v == 0.0 && motion(i, 2) < 0.0));
      closed_[c] = gap < -band(c) || touching;
      if (closed_[c]) statistics_.max_penetration = std::max(statistics_.max_penetration, -gap);
      if (touching) closing.push_back(c);
    }
    if (std::ranges::find(closed_, true) != closed_.end()) {
      choose_propagator();
      for (const std::size_t c : closing) log_change(c, motion(contacts_[c].unknown, 1) / tau);
    }
    if (statistics_.energy) {
      const Series settled = propagator_->expand(y_, p_, tau, 2);
      statistics_.energy->initial = energy_scale_ =
          energy(leg().displacement(settled, 0.0), leg().velocity(settled, 0.0, tau));
    }
  }

  double shortest_step() const { return 4.0 * epsilon * std::max({std::abs(t_), times_.back() - times_.front()}); }

  void advance() {
    update_largest_displacement();
    const double remaining = times_.back() - t_;
    // A varying load that vanishes at all points of a long step could hide a pulse between them.
    const double longest =
        load_.varies() ? std::min(remaining, (times_.back() - times_.front()) / 64) : remaining;
    while (level_ > 0 && propagator_->step(level_) > longest) --level_;
    const double tau = std::min(propagator_->step(level_), remaining);
    if (t_ + tau == t_) fail("the step vanishes against the time");
    const bool resolved = load_.fit(t_, tau, p_);
    if (!resolved && tau > shortest_step()) return shorten();
    // A step of a few roundings of t carries nothing: that is how a jump of the load is crossed.
    if (!resolved && ++load_jumps_ > max_load_jumps)
      fail(fmt::format("the load is too rough at t = {}: no polynomial in time follows it to rounding", t_));

    if (level_ > 0) {
      if (!take_long_step(tau)) return shorten();
    } else {
      take_short_step(tau);
    }
    ++statistics_.steps;
    if (!y_.allFinite()) fail("the solution is not finite");
    if (observers_.progress) tell([&] { observers_.progress(t_); });
  }

  void shorten() {
    --level_;
    pause_ = patience;
  }

  void lengthen() {
    if (pause_ > 0)
      --pause_;
    else
      ++level_;
  }

  // A step by matrix exponentials, unless it may hide something.
  bool take_long_step(double tau) {
    VectorXd end = y_;
    propagator_->advance(level_, end, p_);
    double penetration = statistics_.max_penetration;
    HermiteFlow flow;
    if (!contacts_.empty() || flows()) {
      VectorXd middle = y_;
      propagator_->advance(level_ - 1, middle, rescaled(p_, 0.0, 0.5));
      const std::array<LoadPolynomial, 3> p = {p_, rescaled(p_, 0.5, 1.0), rescaled(p_, 1.0, 1.0)};
      const Index order = flows() ? 3 : 2;
      const std::array<Series, 3> motion = {propagator_->expand(y_, p[0], tau, order),
                                            propagator_->expand(middle, p[1], tau, order),
                                            propagator_->expand(end, p[2], tau, order)};
      if (!contacts_.empty()) ++statistics_.event_evaluations;
      for (std::size_t c = 0; c < contacts_.size(); ++c)
        if (!stays(c, motion, penetration)) return false;
      if (flows()) {
        flow = hermite_flow(leg(), motion, {nodal_load(p[0]), nodal_load(p[1]), nodal_load(p[2])}, tau);
        const double share = tau / (times_.back() - times_.front());
        if (flow.error > 1e-12 * energy_scale_ * share) return false;
      }
    }
    output_until(t_ + tau, tau);
    statistics_.max_penetration = penetration;
    add(flow.flow);
    y_ = std::move(end);
    t_ += tau;
    lengthen();
    return true;
  }

  // Whether contact c surely keeps its state during a step and its penetration's maximum is known.
  bool stays(std::size_t c, const std::array<Series, 3>& motion, double& penetration) const {
    const Index i = contacts_[c].unknown;
    const double sign = closed_[c] ? -1.0 : 1.0;
    const auto distance = [&](const Series& s) { return sign * (s(i, 0) + contacts_[c].gap); };
    const auto jet = [&](const Series& s) {
      return std::array<double, 3>{distance(s), sign * s(i, 1), 2.0 * sign * s(i, 2)};
    };
    const HermiteRange range(jet(motion[0]), distance(motion[1]), jet(motion[2]));
    if (range.lowest() < -band(c)) return false;
    if (!closed_[c]) return true;
    if (range.highest() > penetration * (1.0 + 1e-13) && !range.monotone()) return false;
    penetration = std::max(penetration, distance(motion[2]));
    return true;
  }

  // A step that one Taylor series covers, cut at the first contact change.
  void take_short_step(double tau) {
    const Series series = propagator_->expand(y_, p_, tau);
    double sigma = 1.0;
    std::optional<std::size_t> changing;
    if (!contacts_.empty()) ++statistics_.event_evaluations;
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const std::optional<double> passage = first_passage(distance_series(c, series), band(c));
      if (passage && (*passage < sigma || (*passage == sigma && !changing))) sigma = *passage, changing = c;
    }
    const double t = t_ + tau * sigma;
    output_until(t, tau);
    for (std::size_t c = 0; c < contacts_.size(); ++c)
      if (closed_[c])
        statistics_.max_penetration =
            std::max(statistics_.max_penetration, largest_value(distance_series(c, series), sigma));
    if (flows()) add(gauss_flow(leg(), series, nodal_load(p_), tau, sigma));
    const VectorXd v = leg().velocity(series, sigma, tau), u = leg().displacement(series, sigma);
    y_ = leg().pack(u, v);
    t_ = t;
    if (changing)
      change_contacts(*changing, u, v);
    else
      lengthen();
  }

  // Distance of contact c from its next change, u_c + gap while open and the penetration while closed.
  VectorXd distance_series(std::size_t c, const Series& series) const {
    VectorXd distance = series.row(contacts_[c].unknown).transpose();
    distance[0] += contacts_[c].gap;
    return closed_[c] ? VectorXd(-distance) : distance;
  }

  // On [0, sigma] of a series that no rate of the leg lets turn twice.
  static double largest_value(const VectorXd& c, double sigma) {
    const Series row = c.transpose();
    const auto rate = [&](double at) { return LinearLeg<double>::velocity(row, at, 1.0)[0]; };
    double low = 0.0, high = sigma;
    if (rate(low) > 0.0 && rate(high) < 0.0)
      for (int i = 0; i < 60; ++i) (rate((low + high) / 2) > 0.0 ? low : high) = (low + high) / 2;
    return std::max(LinearLeg<double>::displacement(row, low)[0], LinearLeg<double>::displacement(row, sigma)[0]);
  }

  // Contact `first` reaches its change; so do those that are at theirs up to rounding and go on.
  void change_contacts(std::size_t first, const VectorXd& u, const VectorXd& v) {
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const Index i = contacts_[c].unknown;
      const bool leaving = closed_[c] ? v[i] > 0.0 : v[i] < 0.0;
      if (c != first && !(std::abs(u[i] + contacts_[c].gap) <= band(c) && leaving)) continue;
      closed_[c] = !closed_[c];
      log_change(c, v[i]);
    }
    choose_propagator();
  }

  void log_change(std::size_t c, double velocity) {
    const Contact& contact = system_.contacts()[c];
    const std::size_t node = contact.unknown + system_.first_node();
    if (t_ - changes_[c].time > shortest_step()) changes_[c] = {t_, 0};
    if (++changes_[c].count > max_instant_changes)
      fail(fmt::format("the contact at node {} opens and closes without end", node));
    ++statistics_.events;
    if (observers_.event)
      tell([&] {
        observers_.event({t_, contact.where, node, closed_[c] ? Change::closing : Change::opening, velocity});
      });
  }

  // From the begin of the current step, of length tau, by bisection: the solution goes its way undisturbed.
  void output_until(double t, double tau) {
    while (next_ < times_.size() && times_[next_] <= t) {
      VectorXd y = y_;
      LoadPolynomial p = p_;
      double s = times_[next_] - t_, width = tau;
      for (int level = level_ - 1; level >= 0; --level) {
        width /= 2;
        if (s >= width) {
          propagator_->advance(level, y, rescaled(p, 0.0, 0.5));
          p = rescaled(p, 0.5, 0.5);
          s -= width;
        } else {
          p = rescaled(p, 0.0, 0.5);
        }
      }
      const Series series = propagator_->expand(y, p, width);
      const VectorXd u = leg().displacement(series, s / width), v = leg().velocity(series, s / width, width);
      if (observers_.snapshot) snapshot(times_[next_], u, v);
      if (++next_ == times_.size() && statistics_.energy) statistics_.energy->final = energy(u, v);
    }
  }

  void snapshot(double t, const VectorXd& u, const VectorXd& v) {
    nodal_u_.resize(system_.mesh().nodes());
    nodal_v_.resize(system_.mesh().nodes());
    system_.expand_displacement({u.data(), system_.size()}, nodal_u_);
    system_.expand_velocity({v.data(), system_.size()}, nodal_v_);
    const auto stress = [&](std::size_t j) {
      return (system_.bar().modulus * (nodal_u_[j + 1] - nodal_u_[j]) +
              system_.bar().viscosity * (nodal_v_[j + 1] - nodal_v_[j])) /
             system_.mesh().spacing();
    };
    const auto contact_force = [&](Index node) {
      double sum = 0.0;
      for (std::size_t c = 0; c < contacts_.size(); ++c)
        if (closed_[c] && contacts_[c].unknown == node)
          sum -= contacts_[c].law.stiffness * (u[node] + contacts_[c].gap) + contacts_[c].law.damping * v[node];
      return sum;
    };
    Snapshot result{t, nodal_u_, nodal_v_};
    result.reaction_left = system_.left_fixed() ? -stress(0) : contact_force(0);
    result.reaction_right = system_.right_fixed() ? stress(system_.mesh().elements - 1) : contact_force(u.size() - 1);
    tell([&] { observers_.snapshot(result); });
  }

  double energy(const VectorXd& u, const VectorXd& v) const {
    double sum = system_.energy({u.data(), system_.size()}, {v.data(), system_.size()});
    for (std::size_t c = 0; c < contacts_.size(); ++c)
      if (closed_[c]) sum += contacts_[c].law.energy(-(u[contacts_[c].unknown] + contacts_[c].gap));
    return sum;
  }

  // Whether energy flows that somebody wants to know.
  bool flows() const {
    return statistics_.energy && (system_.damped() || system_.loaded() ||
                                  std::ranges::any_of(contacts_, [](const auto& c) { return c.law.damping > 0.0; }));
  }

  void add(const EnergyFlow& flow) {
    if (!statistics_.energy) return;
    statistics_.energy->dissipated += flow.dissipated;
    statistics_.energy->work += flow.work;
    energy_scale_ = std::max(energy_scale_, statistics_.energy->initial + std::abs(statistics_.energy->work));
  }

  MatrixXd nodal_load(const LoadPolynomial& p) const {
    if (load_.varies()) return load_.basis() * p;
    return Eigen::Map<const VectorXd>(load_.steady().data(), static_cast<Index>(load_.steady().size()));
  }

  struct Cached {
    std::vector<bool> closed;
    std::unique_ptr<Propagator> propagator;
  };
  struct InstantChanges {
    double time;
    int count;
  };

  const BarSystem& system_;
  std::span<const double> times_;
  const Observers& observers_;
  Stopwatch watch_;
  Statistics statistics_;

  std::vector<ContactLaw> contacts_;
  std::vector<bool> closed_;
  std::vector<InstantChanges> changes_;  // of each contact at about one time
  double inverse_inertia_ = 0.0;
  LoadInterpolation load_;
  std::vector<Cached> propagators_;  // the last used at the end
  Propagator* propagator_ = nullptr;

  double t_;
  VectorXd y_;
  LoadPolynomial p_;      // on the current step
  int level_ = 0;         // of the current step; below 0 where the load asks for less than a Taylor series could
  int pause_ = 0;         // steps until a longer one is tried
  int load_jumps_ = 0;
  std::size_t next_ = 0;  // output
  double largest_displacement_ = 0.0;
  double energy_scale_ = 0.0;
  std::vector<double> nodal_u_, nodal_v_;
};

}  // namespace

Statistics integrate(const BarSystem& system, const State& start, std::span<const double> times,
                     const Exponential& method, const Observers& observers) {
  if (system.size() > max_unknowns)
    throw std::invalid_argument(fmt::format("exponential works with dense matrices and takes up to {} unknown nodes; "
                                            "the mesh has {}",
                                            max_unknowns, system.size()));
  return Run(system, start, times, method.penalty, observers)();
}

}  // namespace viscobar
