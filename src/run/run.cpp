#include "viscobar/run/run.hpp"

namespace viscobar {

Unfit::Unfit(std::string_view method, Finding why)
    : std::invalid_argument(std::string(method) + " cannot take the system: " + why.key + ": " + why.problem),
      finding(std::move(why)) {}

void RunAccount::count(const Event& event) {
  const bool closing = event.change == Change::closing;
  if (event.where == Where::span) {
    ++(closing ? span.closings : span.openings);
    if (closing && !span.contact.closed_since) span.latest = {0.0, event.time};
    if (closing) span.contact.close(event.time);
    if (span.closed() == 0) span.contact.open(event.time);
    return;
  }
  if (event.where == Where::joint) {
    if (joints.size() < event.node) joints.resize(event.node);
    JointAccount& joint = joints[event.node - 1];
    joint.closings += closing;
    if (closing && !joint.contact.closed_since) joint.latest = {0.0, event.time};
    closing ? joint.contact.close(event.time) : joint.contact.open(event.time);
    return;
  }
  EndAccount& end = event.where == Where::left ? left : right;
  end.closings += closing;
  if (closing && !end.contact.closed_since) end.latest = {0.0, event.time};
  closing ? end.contact.close(event.time) : end.contact.open(event.time);
}

}  // namespace viscobar
