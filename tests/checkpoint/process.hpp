#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace viscobar::testing_checkpoint {

/// The built command as a process of its own, to be sent signals.
class Process {
 public:
  /// Its output goes to the file out.txt, its messages to err.txt, in `directory`. `environment` is NAME=VALUE.
  Process(const std::filesystem::path& directory, const std::vector<std::string>& arguments,
          const std::vector<std::string>& environment = {}) {
    child_ = fork();
    if (child_ != 0) return;
    bool ready = chdir(directory.c_str()) == 0;
    for (const auto& [descriptor, file] : {std::pair{1, "out.txt"}, {2, "err.txt"}})
      ready = ready && dup2(open(file, O_WRONLY | O_CREAT | O_TRUNC, 0666), descriptor) == descriptor;
    for (const std::string& variable : environment) putenv(const_cast<char*>(variable.c_str()));
    std::vector<char*> words = {const_cast<char*>("viscobar")};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    if (ready) execv(VISCOBAR_COMMAND, words.data());
    _exit(127);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    if (child_ > 0) signal(SIGKILL), wait();
  }

  void signal(int number) const { kill(child_, number); }

  /// Processor time so far.
  double processor_seconds() const {
    clockid_t clock{};
    timespec time{};
    if (clock_getcpuclockid(child_, &clock) == 0) clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

  /// Exit code; minus the signal for a process that a signal ended.
  int wait() {
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  bool ended() const {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == child_;
  }

 private:
  pid_t child_ = -1;
};

}  // namespace viscobar::testing_checkpoint
