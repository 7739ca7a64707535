#include "viscobar/run/run.hpp"

namespace viscobar {

namespace {

const char* words(Refusal why) {
  switch (why) {
    case Refusal::algebraic_rows: return "the equations of massless contact nodes without viscosity are algebraic";
    case Refusal::viscosity: return "it conserves what viscosity dissipates";
    case Refusal::span: return "it takes contacts at the ends only";
    case Refusal::end_springs: return "it takes ends without a spring";
    case Refusal::rigid_contacts: return "it needs a positive epsilon";
    case Refusal::many_unknowns: return "its matrices are dense, and the unknown nodes are too many";
    case Refusal::many_steps: return "it would make too many steps";
    case Refusal::directions: return "it has no derivatives; cvode, ida, arkode and rigid have";
  }
  return "";
}

}  // namespace

Unfit::Unfit(std::string_view method, Refusal why)
    : std::invalid_argument(std::string(method) + " cannot take the system: " + words(why)), refusal(why) {}

void RunAccount::count(const Event& event) {
  const bool closing = event.change == Change::closing;
  if (event.where == Where::span) {
    ++(closing ? span.closings : span.openings);
    if (closing && !span.contact.closed_since) span.latest = {0.0, event.time};
    if (closing) span.contact.close(event.time);
    if (span.closed() == 0) span.contact.open(event.time);
    return;
  }
  EndAccount& end = event.where == Where::left ? left : right;
  end.closings += closing;
  if (closing && !end.contact.closed_since) end.latest = {0.0, event.time};
  closing ? end.contact.close(event.time) : end.contact.open(event.time);
}

}  // namespace viscobar
