// Stops with a law of their own in PenalisedSystem.
#include <cmath>
#include <optional>
#include <vector>

#include "dynamics/penalised_system.hpp"

namespace viscobar {

std::optional<PenalisedSystem::IndicatorWeights> PenalisedSystem::push_weights(std::size_t i) const {
  const Stop* law = stop(i);
  const auto push = law ? law->push(push_time()) : std::nullopt;
  if (!push) return std::nullopt;
  const double sign = contact(i).sign;
  if (contact(i).joint > 0)
    return IndicatorWeights{.values = {0.0, push->a, -push->a, push->b, -push->b},
                            .sided = true,
                            .alone = false,
                            .offset = push->a * offsets_[i] - push->e};
  return IndicatorWeights{
      .values = {0.0, sign * push->a, sign * push->b}, .alone = false, .offset = push->a * offsets_[i] - push->e};
}

double PenalisedSystem::push_rate(std::size_t i, double clearance, double w, double w_bar, const Stop& rates) const {
  const Stop::Push push = *stop(i)->push(push_time()), rate = stop(i)->push_rate(push_time(), rates);
  return push.a * clearance + contact(i).sign * (push.b * w + rate.b * w_bar) - rate.e;
}

// Time of a wave through the bar.
double PenalisedSystem::push_time() const {
  return bar_.bar().length * std::sqrt(bar_.bar().density / bar_.bar().modulus);
}

double PenalisedSystem::bent_force(std::size_t i, double clearance, double w) const {
  const Stop* law = bent(i);
  const double sign = contact(i).sign;
  return law ? sign * law->force(-clearance, -sign * w) : 0.0;
}

PenaltyLaw PenalisedSystem::tangent(std::size_t i, double clearance, double w) const {
  const Stop* law = bent(i);
  if (!law) return laws_[i];
  const double rate = -contact(i).sign * w;
  return {law->by_depth(-clearance, rate), law->by_rate(-clearance, rate)};
}

void PenalisedSystem::linearise(std::size_t i, const PenaltyLaw& tangent) {
  laws_[i] = tangent;
  std::erase_if(bent_, [i](const OwnStop& one) { return one.contact == i; });
}

}  // namespace viscobar
