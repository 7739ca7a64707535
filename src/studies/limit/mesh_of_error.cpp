#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {

AccuracyResult limit_to_accuracy(const LimitStudy& study, const AccuracyRequest& request) {
  AccuracyStudy inner;
  inner.scene = study.scene;
  inner.scene.mass = common_mass(study.scene);
  inner.scene.method = MethodName::rigid;
  if (!validate(inner.scene).empty()) inner.scene.method = MethodName::fully_discrete;
  inner.request = request;
  inner.request.given.method = inner.request.given.mass = inner.request.given.restitution = true;
  inner.request.given.tolerance = inner.request.given.step = false;
  inner.threads = study.threads;
  return solve(inner);
}

}  // namespace viscobar
