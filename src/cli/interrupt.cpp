#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <ctime>
#include <string_view>

#include "cli/commands.hpp"
#include "results/directory_lock.hpp"

namespace viscobar::cli {

namespace {

// Signals that are ignored as the program begins. Libraries may catch some as they are loaded (UCX, which Debian 13's
// SUNDIALS loads with MPI, takes SIGHUP), and only what stands here comes before that.
std::array<bool, NSIG> ignored_at_first{};
void look_at_signals(int, char**, char**) {
  for (int signal = 1; signal < NSIG; ++signal) {
    struct sigaction now {};
    ignored_at_first[static_cast<std::size_t>(signal)] =
        sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
  }
}
[[gnu::used, gnu::section(".preinit_array")]] void (*const before_libraries)(int, char**, char**) = look_at_signals;

std::atomic<bool> was_heard = false;
std::atomic<double> heard_at = 0.0;
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<double>::is_always_lock_free,
              "a signal handler may touch nothing else");

double monotonic_seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// One request may arrive twice, to the process and to its group, as timeout(1) sends it. A later one is impatience.
void heard(int signal) {
  constexpr double same_request = 0.5;
  if (!was_heard.exchange(true))
    heard_at = monotonic_seconds();
  else if (monotonic_seconds() > heard_at + same_request)
    std::signal(signal, SIG_DFL), std::raise(signal);
}

void handle(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  // nohup has SIGHUP ignored, and wants that. The last two are how batch systems announce the end.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGXCPU}) {
    if (!ignored_at_first[static_cast<std::size_t>(signal)] || signal == SIGINT || signal == SIGTERM)
      sigaction(signal, &action, nullptr);
    else
      std::signal(signal, SIG_IGN);
  }
}

}  // namespace

void catch_interrupts() { handle(heard); }

void end_on_interrupt() {
  handle([](int) {
    constexpr std::string_view message = "viscobar: interrupted; nothing was changed\n";
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
    DirectoryLock::abandon();
    std::_Exit(stopped);
  });
}

bool interrupt_asked() { return was_heard.load(std::memory_order_relaxed); }

}  // namespace viscobar::cli
