#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// Control of a method's error in time: tolerances, a fixed time step with the constraint solved in each, or none, as
/// the method is exact to rounding.
enum class Accuracy { tolerances, step, rounding };

/// Cost of a step: step + node * (number of nodes) seconds.
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
  Method (*options)(const Setup&);                         ///< from all but its own method
  double (*vectors)(const Case&, double nodes) = nullptr;  ///< own memory, in vectors with an entry a node
  Mass (*mass)(const Case&) = nullptr;                     ///< that it runs on, where not the case's
  bool differentiates = false;                             ///< tells sensitivities
  bool takes_algebraic_rows = true;                        ///< massless contact nodes without viscosity
  bool takes_laws = false;                                 ///< stops with a law of their own

  /// True if it takes massless contact nodes, whose rows are algebraic without viscosity.
  bool takes_massless(const Case& on) const { return takes_algebraic_rows || on.scene.bar.viscosity > 0.0; }
};

/// True if the case has massless contact nodes without viscosity, whose equations are algebraic.
bool has_algebraic_rows(const Case& run);

/// The mass `fourth_order` takes elements of at most this many times their neighbours, measured by int dx / A.
inline constexpr double largest_jump = 3.0;
bool fourth_order_fits(const Case& run);

/// In the order of all_methods.
std::span<const MethodRow> method_table();

const MethodRow& method_row(MethodName method);

/// Why characteristics does not take the case, whatever its own method; absent where it does.
std::optional<Finding> refusal_by_characteristics(const Case& run);

}  // namespace viscobar
