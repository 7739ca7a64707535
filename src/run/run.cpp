#include "viscobar/run/run.hpp"

namespace viscobar {

Unfit::Unfit(std::string_view method, Finding why)
    : std::invalid_argument(std::string(method) + " cannot take the system: " + why.key + ": " + why.problem),
      finding(std::move(why)) {}

ContactAccount& RunAccount::of(const Event& event) {
  switch (event.where) {
    case Where::left: return left;
    case Where::right: return right;
    case Where::span: return span;
    case Where::joint: break;
  }
  if (joints.size() < event.node) joints.resize(event.node);
  return joints[event.node - 1];
}

void RunAccount::count(const Event& event) {
  const bool closing = event.change == Change::closing, of_span = event.where == Where::span;
  ContactAccount& account = of(event);
  account.closings += closing;
  span.openings += of_span && !closing;
  if (closing && !account.contact.closed_since) account.latest = {0.0, event.time};
  if (closing)
    account.contact.close(event.time);
  else if (!of_span || span.closed() == 0)
    account.contact.open(event.time);
}

}  // namespace viscobar
