#include "viscobar/run/run.hpp"

namespace viscobar {

void RunAccount::count(const Event& event) {
  const bool closing = event.change == Change::closing;
  if (event.where == Where::span) {
    ++(closing ? span.closings : span.openings);
    if (closing) span.contact.close(event.time);
    if (span.closed() == 0) span.contact.open(event.time);
    return;
  }
  EndAccount& end = event.where == Where::left ? left : right;
  if (closing) {
    ++end.closings;
    end.contact.close(event.time);
  } else {
    end.contact.open(event.time);
  }
}

}  // namespace viscobar
