#include "hard/hard_run.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>

#include "viscobar/input/scene_file.hpp"

namespace viscobar::hard {

namespace {

Outcome judged(const HardScene& scene, const Case& run) {
  const Recording result = record(run);
  Outcome outcome{Outcome::Kind::right, "", 0.0, result.statistics.steps, result.events.size(), 0.0};
  std::vector<Judgement> judgements = invariants({run, result});
  for (const Oracle& oracle : scene.oracles) std::ranges::copy(oracle({run, result}), std::back_inserter(judgements));
  for (const Judgement& judgement : judgements) {
    const double ratio = judgement.ratio();
    if (ratio > 1.0) outcome.kind = Outcome::Kind::wrong;
    if (ratio < outcome.ratio) continue;
    outcome.ratio = ratio;
    outcome.message = fmt::format("{}: {:.2g} of {:.2g}", judgement.what, judgement.error, judgement.tolerance);
  }
  return outcome;
}

Outcome attempted(const HardScene& scene, MethodName method, Mass mass) {
  try {
    return judged(scene, load(scene, method, mass));
  } catch (const SceneError& error) {
    const Diagnostic& first = error.diagnostics.front();
    return {Outcome::Kind::refused, first.key + ": " + first.message, 0.0, 0, 0, 0.0};
  } catch (const std::invalid_argument& error) {
    return {Outcome::Kind::refused, error.what(), 0.0, 0, 0, 0.0};
  } catch (const IntegrationError& error) {
    return {Outcome::Kind::error, error.what(), 0.0, error.statistics.steps, error.statistics.events, 0.0};
  }
}

double cpu_seconds(int who) {
  rusage used{};
  getrusage(who, &used);
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

[[noreturn]] void run_child(const HardScene& scene, MethodName method, Mass mass, unsigned limit, int pipe) {
  const rlimit cpu{limit, limit + 1};
  setrlimit(RLIMIT_CPU, &cpu);
  Outcome outcome;
  try {
    outcome = attempted(scene, method, mass);
  } catch (const std::exception& error) {
    outcome.message = fmt::format("an exception that no caller expects: {}", error.what());
  }
  // A ratio may be infinite, which JSON has no word for.
  const nlohmann::json told = {
      static_cast<int>(outcome.kind), outcome.message, fmt::format("{}", outcome.ratio), outcome.steps, outcome.changes,
      cpu_seconds(RUSAGE_SELF)};
  const std::string text = told.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  const bool complete = write(pipe, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  std::exit(complete ? 0 : 1);
}

std::string received(int pipe) {
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; (n = read(pipe, buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  return text;
}

}  // namespace

Case load(const HardScene& scene, MethodName method, Mass mass) {
  std::vector<std::string> overrides = scene.overrides;
  overrides.push_back(fmt::format("mesh.mass={}", name(mass)));
  overrides.push_back(fmt::format("method.name={}", name(method)));
  return read_scene(std::string(VISCOBAR_SOURCE_DIR "/tests/hard/scenes/") + scene.file + ".toml", overrides).run;
}

std::vector<MethodName> methods_for(const HardScene& scene) {
  return scene.methods.empty() ? std::vector(std::begin(all_methods), std::end(all_methods)) : scene.methods;
}

std::vector<Mass> masses_for(const HardScene& scene, MethodName method) {
  // An impact of a node with mass takes energy, which this scene is asked to hold.
  const bool held = scene.file == "period-3";
  // Nodes that meet a span obstacle together have one law of impact with the penalty on a diagonal mass only.
  const bool together = scene.file == "span" && method == MethodName::fully_discrete;
  if (method == MethodName::rigid && held) return {Mass::redistributed};
  if (method == MethodName::characteristics) return {Mass::consistent};  // there is none in the bar itself
  if (method == MethodName::rigid) return {Mass::redistributed, Mass::fourth_order};
  std::vector<Mass> masses = scene.masses;
  if (method != MethodName::finite_difference && !together &&
      std::ranges::find(masses, Mass::consistent) != masses.end())
    masses.push_back(Mass::fourth_order);
  return masses;
}

namespace {

struct Child {
  pid_t process;
  int answer;  // where it is to be read
};

Child start(const HardScene& scene, MethodName method, Mass mass, unsigned cpu_seconds) {
  static std::mutex one_at_a_time;  // a child started in between would keep this one's pipe open
  const std::lock_guard lock(one_at_a_time);
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  std::fflush(nullptr);
  const pid_t process = fork();
  if (process < 0) throw std::runtime_error("no process");
  if (process == 0) {
    close(ends[0]);
    run_child(scene, method, mass, cpu_seconds, ends[1]);
  }
  close(ends[1]);
  return {process, ends[0]};
}

}  // namespace

Outcome run_guarded(const HardScene& scene, MethodName method, Mass mass, unsigned cpu_seconds) {
  const Child child = start(scene, method, mass, cpu_seconds);
  const std::string text = received(child.answer);
  close(child.answer);
  int status = 0;
  waitpid(child.process, &status, 0);
  Outcome outcome;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    outcome.message = signal == SIGXCPU || signal == SIGKILL
                          ? fmt::format("no end within {} s of CPU time", cpu_seconds)
                          : fmt::format("ended by signal {}", signal);
    return outcome;
  }
  const nlohmann::json told = nlohmann::json::parse(text, nullptr, false);
  if (!told.is_array()) {
    outcome.message = "no outcome was told";
    return outcome;
  }
  return {static_cast<Outcome::Kind>(told[0].get<int>()),
          told[1],
          std::strtod(told[2].get<std::string>().c_str(), nullptr),
          told[3].get<std::size_t>(),
          told[4].get<std::size_t>(),
          told[5].get<double>()};
}

std::optional<std::string> complaint(const HardScene& scene, MethodName method, const Outcome& outcome) {
  const NamedError* expected = nullptr;
  for (const NamedError& error : scene.errors)
    if (error.methods.empty() || std::ranges::count(error.methods, method) > 0) expected = &error;
  switch (outcome.kind) {
    case Outcome::Kind::right:
      return expected && expected->certain
                 ? std::optional("an answer, where an error was to come: " + expected->message)
                 : std::nullopt;
    case Outcome::Kind::refused: return std::nullopt;
    case Outcome::Kind::error:
      if (expected && outcome.message.find(expected->message) != std::string::npos) return std::nullopt;
      return "stopped: " + outcome.message;
    case Outcome::Kind::wrong: return "wrong: " + outcome.message;
    case Outcome::Kind::killed: return outcome.message;
  }
  return std::nullopt;
}

}  // namespace viscobar::hard
