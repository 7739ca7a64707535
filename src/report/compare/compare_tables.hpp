#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "report/columns.hpp"
#include "viscobar/studies/compare/compare.hpp"

namespace viscobar {

/// Units of norms in L2 over the bar: of the root of the integral of u^2, u_x^2 or v^2 over x.
inline constexpr UnitPowers u_norm{1.5, 0.0, 0.0, 0.0}, strain_norm{0.5, 0.0, 0.0, 0.0}, v_norm{1.5, -1.0, 0.0, 0.0};

/// Contacts of a span come node by node; a table of them all would tell nobody anything.
inline constexpr std::size_t most_contacts = 30;

/// A run beside its difference to another; null: there is none.
struct ComparedRun {
  const MethodRun* run;
  const Difference* difference;
};
using DifferenceOf = std::function<const Difference*(std::size_t run)>;
std::vector<ComparedRun> compared_runs(const Comparison& check, const DifferenceOf& difference);
/// The columns of compare.csv, of which the two tables take theirs.
const std::vector<Column<ComparedRun>>& compare_columns();

/// Mesh, cost and end of each method.
Table method_table(const Comparison& check, const NumberText& number);
/// Each method against the reference; or each run, called `what`, by another `difference`, null where there is none.
Table difference_table(const Comparison& check, const NumberText& number);
Table difference_table(const Comparison& check, const NumberText& number, const std::string& what,
                       const DifferenceOf& difference);
/// Contact periods of the reference and, matched with them, of each other method.
Table contact_table(const Comparison& check, const NumberText& number);
/// The same for the terminal, with its heading; empty without contact.
std::string contact_text(const Comparison& check, const NumberText& number);

/// Remarks by which to judge the differences: methods left out, steps chosen, masses that are not the same.
std::vector<std::string> remarks(const MethodChoice& choice, const Comparison& check);

/// left, right or span:<mesh node>
std::string place(const ContactPeriod& period);

}  // namespace viscobar
