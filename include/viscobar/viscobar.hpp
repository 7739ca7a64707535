#pragma once

// The whole library. viscobar/testing/ is apart: it needs GoogleTest.

#include "viscobar/case/accuracy.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/case/recorder.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/characteristics/characteristics.hpp"
#include "viscobar/discretisation/mass.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/penalty_law.hpp"
#include "viscobar/dynamics/sensitivity.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/integration/integrate.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/results/io_error.hpp"
#include "viscobar/results/outcome.hpp"
#include "viscobar/results/versions.hpp"
#include "viscobar/run/run.hpp"
#include "viscobar/scene/scene.hpp"
#include "viscobar/schemes/schemes.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"
#include "viscobar/studies/compare/compare.hpp"
#include "viscobar/studies/compare/difference.hpp"
#include "viscobar/studies/compare/examine.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"
#include "viscobar/studies/fit/fit.hpp"
#include "viscobar/studies/judge/judge.hpp"
#include "viscobar/studies/limit/coupling.hpp"
#include "viscobar/studies/limit/limit.hpp"
#include "viscobar/studies/orders/observed_order.hpp"
#include "viscobar/studies/orders/orders.hpp"
#include "viscobar/studies/precision/precision.hpp"
#include "viscobar/sweep/sweep.hpp"

/// Motion of a viscoelastic bar against rigid obstacles: scenes, methods, and what is known about their results. A
/// scene and a method are values (Case), a run is one call (record(), simulate(), record_run()).
namespace viscobar {}
