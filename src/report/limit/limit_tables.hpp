#pragma once

#include <span>
#include <string>
#include <vector>

#include "report/columns.hpp"
#include "report/page.hpp"
#include "text/table.hpp"
#include "viscobar/studies/limit/coupling.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {

std::span<const LimitRow> rows_of(const LimitResult& result, std::size_t mesh);

/// The mesh with most elements, whose verdict is the study's.
std::size_t finest(const LimitResult& result);

/// Powers of epsilon that theory has for a small epsilon, where the contact node answers alone, and for a large one,
/// where the mesh resolves the contact layer. Absent where there is no law (the pair that does not match) or none is
/// known.
struct LimitTheory {
  double penetration = 1.0;
  std::optional<double> difference;
  std::optional<double> layer = 2.0 / 3.0;
  const char* boundary = "ρh³/η²";  ///< the epsilon where the two meet
};
LimitTheory theory(const LimitStudy& study);

/// Why the verdict on the m-th mesh is what it is, with the numbers that it rests on. What helps against a plateau is
/// told once, on the finest mesh that has one.
std::string verdict_reason(const LimitStudy& study, const LimitResult& result, std::size_t mesh,
                           const NumberText& number);

/// Distance of the limits on a mesh, in a sentence to quote. Empty where it is not known.
std::string limit_sentence(const LimitOrders& orders, const NumberText& number);

/// The columns of limit.json, of which limit.csv and the table take theirs.
const std::vector<Column<LimitRow>>& limit_columns();
std::string limit_csv(const LimitResult& result);
Table limit_table(const LimitResult& result, const NumberText& number);
Table order_table(const LimitStudy& study, const LimitResult& result, const NumberText& number);
const std::vector<Column<OwnMotion::Mesh>>& own_motion_columns();
Table own_motion_table(const OwnMotion& motion, const NumberText& number);
std::string own_motion_sentence(const OwnMotion& motion, const NumberText& number);
const std::vector<Column<Coupling::Mesh>>& coupling_columns();
Table coupling_table(const Coupling& coupling, const NumberText& number);
std::string coupling_sentence(const CouplingResult& coupling, const NumberText& number);

// The pictures of the page, epsilon on a logarithmic axis.
Picture penetration_picture(const LimitStudy& study, const LimitResult& result);
Picture difference_picture(const LimitStudy& study, const LimitResult& result);
Picture events_picture(const LimitStudy& study, const LimitResult& result);
Picture cost_picture(const LimitStudy& study, const LimitResult& result);

}  // namespace viscobar
