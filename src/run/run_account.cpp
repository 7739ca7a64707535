#include "viscobar/run/run.hpp"

namespace viscobar {

void RunAccount::count(const Event& event) {
  const bool closing = event.change == Change::closing;
  if (event.where == Where::span) {
    ++(closing ? span_closings : span_openings);
    return;
  }
  EndAccount& end = event.where == Where::left ? left : right;
  if (closing) {
    ++end.closings;
    if (!end.closed_since) end.closed_since = event.time;
  } else if (end.closed_since) {
    end.time_until_opening += event.time - *end.closed_since;
    end.closed_since.reset();
  }
}

}  // namespace viscobar
