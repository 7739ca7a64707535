#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "viscobar/characteristics/characteristics.hpp"
#include "viscobar/discretisation/mass.hpp"
#include "viscobar/integration/integrate.hpp"
#include "viscobar/run/run.hpp"
#include "viscobar/scene/scene.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar {

/// A method with its options.
using Method = std::variant<Cvode, Ida, Arkode, Odeint, Rigid, Exponential, Characteristics, FullyDiscrete>;

std::string_view name(MethodName method);  ///< in a scene file
bool is_penalised(MethodName method);      ///< takes epsilon where the scene has an obstacle
bool is_adaptive(MethodName method);       ///< uses the tolerances
bool is_scheme(MethodName method);         ///< uses the step

/// Elements of a scene that says nothing: docs/scene-file.md has what they are good for.
inline constexpr std::size_t default_elements = 100;

/// The files that a run leaves beside summary.json.
struct OutputFiles {
  bool ends = true;    ///< ends.csv
  bool events = true;  ///< events.csv
  bool field = true;   ///< field.h5 and field.xdmf
  bool energy = true;  ///< energy.csv
  bool report = true;  ///< report.html, and its pictures
};

/// A scene together with everything that a run of it needs. Values that the chosen method does not use may be set:
/// another method can then be chosen without editing the scene.
struct Case {
  Scene scene;  ///< the physical problem

  std::size_t elements = default_elements;  ///< J
  double grading = 1.0;                     ///< of the mesh towards the ends with an obstacle; 1: uniform
  /// Nodes of the mesh in parts of the length, see Mesh::given; null: none.
  std::shared_ptr<const std::vector<double>> nodes;
  /// Mesh of each member of a chain of bars: its elements, none of a rigid one, in the ratio of which it shares
  /// `elements`, and given nodes, or a grading towards its contacts. Its length is that of the bar. Empty for one bar.
  std::vector<Mesh> bar_meshes;
  std::optional<Mass> mass;  ///< absent: see resolve()

  std::optional<double> epsilon;      ///< reaction = penetration / epsilon; absent: see resolve()
  std::optional<double> restitution;  ///< absent: an undamped spring in the penalty, the implicit constraint in (2.8)

  MethodName method = MethodName::cvode;    ///< how it is integrated
  bool automatic = false;                   ///< method was asked to be chosen, by automatic_method()
  std::string warning;                      ///< of that choice: what to warn of
  Tolerance tolerance;                      ///< of adaptive methods
  Formulas formulas = Formulas::automatic;  ///< of cvode
  Stepper stepper = Stepper::automatic;     ///< of odeint
  std::optional<double> step;               ///< dt of schemes, absent: see resolve()
  Start start = Start::first_order;         ///< of the schemes
  Impact impact = Impact::paoli_schatzman;  ///< of the schemes

  /// Parameters whose sensitivities record() and record_run() tell; see direction().
  std::vector<Direction> directions;

  double end = 1.0;            ///< T
  double output_every = 0.1;   ///< interval of the output times
  OutputFiles files;           ///< that are written
  std::vector<double> gauges;  ///< places in [0, L], each once, that gauges.csv is of

  /// With the given nodes, or graded towards the ends that have an obstacle, or a contact in a chain.
  Mesh mesh() const;
  /// True if no row of the bar differs from the next one.
  bool rows_alike() const { return grading == 1.0 && !nodes && !scene.section && scene.chain.empty(); }

  /// 0, every, 2 every, ..., and the end, which is always there. The last interval may be shorter.
  std::vector<double> output_times() const;
};

/// The word of a scene file for it.
inline constexpr std::string_view automatic = "automatic";

/// The method for a case that names none, whatever its own is, and a sentence to warn with where it is not the first
/// choice:
///
///     no epsilon, a span obstacle                       fully_discrete, whose nodes do not bounce
///     no epsilon, no span obstacle, no viscosity        characteristics, which is exact; rigid where it does not take
///                                                       the data, or where the waves break without end, see roughens()
///     no epsilon, no span obstacle, viscosity           rigid
///     else, of the penalised methods:
///       viscosity, or contact nodes without mass        arkode, which passes over what is stiff by L-stable formulas
///       neither                                         cvode, whose Adams formulas of order up to 12 follow
///                                                       oscillations best
///
/// The choice does not depend on sensitivities: a method without them is not exchanged for another. Measured in
/// docs/methods.md.
struct AutomaticMethod {
  MethodName method;    ///< that suits the case
  std::string warning;  ///< the sentence, or empty
};
/// Chooses it, see AutomaticMethod.
AutomaticMethod automatic_method(const Case& run);

/// Name of the method of a run, with "automatic" where it was chosen by automatic_method().
std::string method_words(const Case& run);

/// The penalised method that a study of a case takes: the case's own; if that does not penalise, arkode with viscosity,
/// else cvode; and arkode where that one cannot take the scene (massless contact nodes without viscosity).
MethodName penalised_method(const Case& run);

/// The mass that a study of several methods gives all that take it: that of its penalised_method().
Mass common_mass(const Case& run);

/// The unit of epsilon, at which the spring gives way as the bar does: L / E, and L^2 / E under a span obstacle alone,
/// whose reaction is that of a length.
double natural_epsilon(const Scene& scene);

/// A case with the value of all that it leaves open: what a run goes by, and what is written of it.
///
/// mass      a penalised method, an obstacle at an end   redistributed, where the method takes massless nodes
///           no penalised contact                        fourth_order, on three equal elements or more
///           else                                        redistributed for an obstacle at an end, or consistent
///           `finite_difference` takes the lumped one for "consistent" or nothing: (3.22) is (2.8) with a diagonal
///           product. So do schemes under a span obstacle with restitution or without viscosity.
/// epsilon   the first of natural_epsilon() 10^-k by which a bar that is thrown at the obstacle at speed V penetrates
///           by less than (h / L)^2 / 8 of V L / c, about what the mesh is wrong by
/// step      h / (100 c), a hundredth of the time of a wave through an element, or end / 1000, whichever is less
struct Setup {
  Case run;        ///< as asked
  Mesh mesh;       ///< of its elements
  Mass mass;       ///< of the semi-discrete system; `characteristics` has none
  double epsilon;  ///< of penalised methods
  double step;     ///< of schemes
  Method method;   ///< with its options; the penalty is a spring without dashpot where the case has no restitution

  /// Why each of these is what it is, in half a sentence.
  struct Reasons {
    std::string_view method;   ///< cvode, rigid, ...
    std::string_view mass;     ///< lumped, redistributed, ...
    std::string_view epsilon;  ///< of penalised methods
    std::string_view step;     ///< of schemes
  };
  Reasons why;  ///< the reasons of this setup

  /// The semi-discrete system of a sound setup.
  BarSystem system() const { return BarSystem(run.scene, mesh, mass); }
  /// The case that asks for these values, those that its method uses: it resolves to the same, and on its own.
  Case settled() const;
};

/// Decides what the case leaves open. A faulty case has a setup, too, whose values say nothing.
Setup resolve(Case run);

/// All faults of a setup at once: those of the scene, and those of the mesh, the contact parameters, the method or the
/// memory of the machine. Empty when simulate() can start.
///
/// `faulty` are keys already known to be wrong. Neither they nor faults that depend on them are reported. Their values
/// are arbitrary, except that bar.length and mesh.elements must make a mesh.
std::vector<Finding> faults(const Setup& setup, const std::vector<std::string>& faulty = {});
/// True if simulate() can start.
inline bool sound(Case run) { return faults(resolve(std::move(run))).empty(); }

/// The direction of a key of a scene file that has a number: bar.*, left.gap, right.gap, span.gap, contact.epsilon and
/// contact.restitution. The functions of x are differenced for bar.length.
/// @throws std::invalid_argument for another key, and for one that the case does not have
Direction direction(const Case& run, std::string_view key);

/// Remedy for the scene of a run that could not go on, in its keys.
std::string remedy(const Case& run, Failure why);

/// Runs a sound setup by its method, on its own output times or on others. `system` is that of the setup.
/// @throws IntegrationError, whose message ends with the remedy
Statistics simulate(const Setup& setup, const BarSystem& system, const Observers& observers);
/// The same on those times.
Statistics simulate(const Setup& setup, const BarSystem& system, std::span<const double> times,
                    const Observers& observers);
/// Both on a system of their own.
inline Statistics simulate(const Setup& setup, const Observers& observers) {
  return simulate(setup, setup.system(), observers);
}
/// The same on other output times.
inline Statistics simulate(const Setup& setup, std::span<const double> times, const Observers& observers) {
  return simulate(setup, setup.system(), times, observers);
}
/// The same from a checkpoint of a run of this setup on its own output times.
/// @throws std::invalid_argument when it is of another run
Statistics simulate(const Setup& setup, const BarSystem& system, const Checkpoint& from, const Observers& observers);

}  // namespace viscobar
