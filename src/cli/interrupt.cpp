#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <string_view>

#include "cli/commands.hpp"
#include "results/directory_lock.hpp"

namespace viscobar::cli {

namespace {

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
    struct sigaction before {};
    const bool ignored = sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN;
    if (!ignored || signal == SIGINT || signal == SIGTERM) sigaction(signal, &action, nullptr);
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
