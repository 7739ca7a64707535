#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <string>

#include "cli/messages.hpp"

namespace viscobar::cli {

std::string duration(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} s", whole);
}

void Progress::operator()(double time, std::size_t steps) {
  constexpr std::size_t between_looks = 16;
  if (steps % between_looks != 0) return;
  const auto now = Clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(200);
  const double share = std::clamp(time / end_, 0.0, 1.0);
  const double elapsed = std::chrono::duration<double>(now - started_).count();
  const std::string left = share > 0.0 ? duration(elapsed * (1.0 - share) / share) + " left" : "";
  line_.show(fmt::format("{:5.1f} %  t = {:.6g} of {:.6g}  {} steps  {}", 100.0 * share, time, end_, steps, left));
}

void StatusLine::show(std::string_view what) {
  show_status(what);
  shown_ = true;
}

void StatusLine::clear() {
  if (shown_) show_status("");
  shown_ = false;
}

bool on_terminal() { return isatty(STDERR_FILENO) == 1; }

}  // namespace viscobar::cli
