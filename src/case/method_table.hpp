#pragma once

#include <span>
#include <string_view>

#include "case/findings.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// What makes a method's error small.
enum class Accuracy {
  tolerances,
  step,     ///< a fixed time step, with the constraint solved in each
  rounding  ///< nothing: exact in time
};

/// What a step costs: step + node * (number of nodes) seconds.
struct StepSeconds {
  double step, node;
};

/// All that is said about one method. Scene files, validation, runs, studies and estimates go by this table. A pointer
/// that is null stands for "as every other method".
struct MethodRow {
  MethodName method;
  std::string_view name, meaning;  ///< in a scene file
  bool penalised;
  Accuracy accuracy;
  StepSeconds seconds;
  Statistics (*run)(const Case&, const BarSystem&, const StartingPoint& start, std::span<const double> times,
                    const Observers&);
  double (*vectors)(const Case&, double nodes) = nullptr;  ///< own memory, in vectors with an entry a node
  Mass (*mass)(const Case&) = nullptr;                     ///< that it runs on, where not the case's
  /// Of a penalised method: whether it takes massless contact nodes, whose rows are algebraic without viscosity.
  bool algebraic = false;
  /// Adds what the method, known to be meant, cannot take.
  void (*refuse)(const Case&, Findings&) = nullptr;

  bool takes_massless(const Case& on) const { return algebraic || on.scene.bar.viscosity > 0.0; }
};

/// In the order of all_methods.
std::span<const MethodRow> method_table();

const MethodRow& method_row(MethodName method);

}  // namespace viscobar
