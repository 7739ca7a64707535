#include "cli/interrupt.hpp"

#include <atomic>
#include <csignal>
#include <cstdlib>

#include "cli/commands.hpp"

namespace viscobar::cli {

namespace {

std::atomic<bool> asked = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing else");

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { asked = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

void end_on_interrupt() {
  struct sigaction action {};
  action.sa_handler = [](int) { std::_Exit(stopped); };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupt_asked() { return asked.load(std::memory_order_relaxed); }

}  // namespace viscobar::cli
