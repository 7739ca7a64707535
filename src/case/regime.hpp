#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/end_kinds.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// True if a penetration is a tenth or more of the largest displacement, or of the gap where that is larger: the bar
/// goes through the obstacle rather than to it.
inline bool is_no_obstacle(double penetration, double displacement) {
  constexpr double share = 0.1;
  return penetration > 0.0 && penetration >= share * displacement;
}

/// The bar at an end, of several in line the nearest, as whole_section() there and as long as all of them.
struct EndBar {
  Bar bar;
  double element = 0.0;  ///< h of the last one
};
EndBar end_bar(const BarSystem& system, bool right);
/// The largest A of the ends of bars, where contacts are.
double largest_end(const Scene& scene);
/// natural_epsilon() in letters.
inline const char* natural_epsilon_words(const Scene& scene) { return is_penalty_of_span(scene) ? "L^2/E" : "L/E"; }

/// Remedies for an epsilon at which the bar goes through the obstacle, in keys of the scene.
std::string stiffer_advice(const Setup& setup);

/// Largest penetration of the first impact at a given speed, within a factor of two.
struct ImpactPrediction {
  /// The part of the bar that the contact sets in motion first: a viscous layer, an elastic wave, the end node alone,
  /// or, on a spring that is softer than the bar, the whole bar.
  enum class Layer { viscous, elastic, node, bar };
  double speed = 0.0;         ///< V > 0, towards the obstacle
  double penetration = 0.0;   ///< at its peak
  Layer layer = Layer::node;  ///< on which it rests
};

/// The answer of a stop with a law of its own to a bar of the mass rho L that comes at a given speed, with the mass m
/// of that end: of the lone masses m and m + rho L, whose motion is integrated, and of the bar on the penalty that is
/// as stiff at that depth, by predict_impact().
struct StopForecast {
  double speed = 0.0;          ///< V > 0
  double penetration = 0.0;    ///< about the deepest: that of m, or the less of the other two
  double force = 0.0;          ///< about the largest, on a bar of section 1
  double damping_ratio = 0.0;  ///< zeta of the lone mass m + rho L at its deepest, dN/dd' / (2 sqrt((m + rho L) dN/dd))
  double restitution = 0.0;    ///< speed that the law leaves to a lone mass m + rho L, as a part of V
};
/// @param node_mass effective mass of the end node
StopForecast forecast(const EndBar& end, double end_mass, double node_mass, const Stop& stop, double speed);

/// How a penalised contact behaves on its mesh, judged by the oscillator that its node is: mass m, spring k = w /
/// epsilon, dashpot to the next node.
struct ContactRegime {
  Where where = Where::left;    ///< of the obstacle
  double effective_mass = 0.0;  ///< m = 1 / (e . (rho M)^{-1} e); 0 for a massless node, which cannot bounce
  /// zeta = (eta/h) / (2 sqrt(k m)) + zeta of the contact's own dashpot; absent without mass. Of a span obstacle only
  /// the latter counts: a bar that falls flat does not strain.
  std::optional<double> damping_ratio{};
  /// zeta < 1 at an epsilon below quiet_epsilon: the node rebounds, and as epsilon goes to 0 contact changes come in
  /// the hundreds.
  bool chatters = false;
  /// The epsilon from which an end with mass does not chatter: viscosity alone gives zeta = 1 from 4 m h^2 / eta^2 on,
  /// and from h / E on the spring is softer than the element behind it, so that the bar decides and not the node.
  double quiet_epsilon = 0.0;
  /// Absent where the initial velocity does not point to the obstacle.
  std::optional<ImpactPrediction> impact{};
  std::optional<Stop> stop{};              ///< its own law, then with a forecast instead of the impact, and no ratio
  std::optional<StopForecast> forecast{};  ///< absent as the impact is
};

/// Peak of the penetration of a long bar that meets a penalised obstacle at speed V > 0 (docs/penalty-limit.md).
///
/// The bar's impedance is Z = sqrt(rho (E + eta s)). A short contact sees Z = sqrt(rho eta s), a long one sqrt(rho E):
///     d = 0.858 V (epsilon sqrt(rho eta))^(2/3)     or     d = V epsilon sqrt(rho E).
/// This is seen on a mesh where the strained layer exceeds h: epsilon > rho h^3 / eta^2, or epsilon > h / E. At
/// epsilon > L / E the bar as a whole is softer than its own strain: d = V sqrt(rho L epsilon), all its energy.
///
/// Otherwise the end node stops alone, its neighbour going on at V: m d'' + (eta/h)(d' - V) + d/epsilon = 0 has the
/// peak
///     d = (V / omega) (2 zeta + exp(-zeta (pi - arccos zeta) / sqrt(1 - zeta^2))),   omega = 1 / sqrt(m epsilon),
/// and without mass d = V epsilon max(eta / h, sqrt(rho E)). A contact's own dashpot is left out.
ImpactPrediction predict_impact(const Bar& bar, double spacing, double effective_mass, double epsilon, double speed);

/// One for each end with an obstacle and one, its worst, for a span obstacle, of a penalised method with epsilon > 0;
/// empty otherwise.
std::vector<ContactRegime> contact_regimes(const Setup& setup, const BarSystem& system);

/// The first contact at a place of the bar, before which no penalty has acted there.
struct FirstImpact {
  Where where = Where::left;  ///< of the obstacle
  std::size_t joint = 0;      ///< its number, from 1, where that is a joint
  double time = 0.0;          ///< of the closing
  double speed = 0.0;         ///< towards the obstacle
  double time_error = 0.0;    ///< at most; 0 where the run's own method found it
  double speed_error = 0.0;   ///< of the speed, as time_error
};

/// First contacts of a run, and its chatter, foreseen.
struct Foresight {
  std::vector<FirstImpact> impacts;  ///< at the left end, the right end and under the span, before the end
  std::optional<bool> chatters{};    ///< true if a contact chatters within 2 L / c after them
};

/// By the run's own method, as long as that takes no more than 3 10^6 nodal steps; what it has not met by then, by the
/// fully discrete scheme with steps in which a wave crosses an element (or the end / 500) and with half as many, whose
/// difference is the error. That says nothing of chatter. Absent when it were more than 10^8 nodal steps. `stop`, which
/// may be empty, ends it early.
std::optional<Foresight> foresee(const Setup& setup, const std::function<bool()>& stop = {});

/// The law of contact that a penalised run has, in words: whether its nodes are thrown back. Two laws are two motions,
/// and an estimate of the error is of one.
std::string contact_law(const Setup& setup);

/// Why the peak reaction of an impact at an end of this run has no limit as the discretisation is refined, in a
/// sentence; absent where it has one. Reactions of an impact with speed V, m the effective mass of the contact node:
///
///     a scheme, a node with mass       m V / dt
///     a dashpot b = 2 zeta sqrt(k m)   b V at once
///     a spring k = 1 / epsilon, m > 0  V sqrt(k m), where that is more than the bar's own V sqrt(rho E)
///     a viscous bar                    V sqrt(rho eta / (pi t))
///     an elastic bar on a mesh         V sqrt(rho E) and what the mesh disperses of the front, whatever the mesh
std::optional<std::string> peak_remark(const Setup& setup, const BarSystem& system);

/// Warns of strains that the model does not hold for, V / c of an impact or those of the initial data and loads, in a
/// scene that names its unit of length: without units a scene may be scaled at will.
std::optional<std::string> strain_remark(const Setup& setup, const BarSystem& system);

/// Warns of a free end whose force jumps, at the start or where a load breaks, on the mass `fourth_order` of a mesh
/// that no JumpFilter acts on: the first end row whose force b_0 less the smooth part m_0/m_1 b_1 exceeds 0.05 U c / L
/// times the impedance, unless viscosity, a dashpot or a mass at that end lets no high mode ring.
std::optional<std::string> jump_remark(const Setup& setup, const BarSystem& system);

}  // namespace viscobar
