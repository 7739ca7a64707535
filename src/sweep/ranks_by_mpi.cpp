#include "sweep/ranks.hpp"

#define OMPI_SKIP_MPICXX 1  // the C interface alone
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <chrono>
#include <exception>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "input/described_scene.hpp"
#include "run/parts.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar {

void members(Like<SweepRow> auto& row, auto&& each) {
  each(row.index, row.completed, row.error, std::span(row.values.data(), row.values.size()), row.joints, row.chosen,
       row.derivatives, row.seconds, row.integration_seconds);
}
void members(Like<SweepCase> auto& one, auto&& each) {
  std::vector<std::string> texts;
  for (const Setting& setting : one.settings) texts.push_back(text_of(setting));
  each(one.index, texts);
  if constexpr (requires { one.settings.clear(); }) one.settings.assign(texts.begin(), texts.end());
}

namespace {

using namespace std::chrono_literals;

enum Tag {
  plan,   // manager: cases whose costs it wants; worker: these
  ready,  // worker: has nothing to tell, wants a case
  row,    // worker: a finished case, wants another
  left,   // worker: is gone
  begin,  // manager: all is planned
  job,    // manager: a case
  stop    // manager: leave, also in the middle of a case
};

struct PlannedCost {
  std::size_t index = 0;
  double seconds = 0.0;
  static void members(auto& self, auto&& each) { each(self.index, self.seconds); }
};

/// Inverse of archived(): all ranks run the same program. @throws ArchiveError
template <class Value>
Value unpack(std::string_view bytes) {
  Value value;
  ArchiveReader{bytes}(value);
  return value;
}

struct Message {
  int rank;
  Tag tag;
  std::string bytes;
};

void send(int rank, Tag tag, const std::string& bytes = {}) {
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, rank, tag, MPI_COMM_WORLD);
}

Message receive(const MPI_Status& status) {
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  Message message{status.MPI_SOURCE, static_cast<Tag>(status.MPI_TAG),
                  std::string(static_cast<std::size_t>(size), '\0')};
  MPI_Recv(message.bytes.data(), size, MPI_BYTE, message.rank, message.tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return message;
}

std::optional<Message> poll() {
  int there = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status);
  return there ? std::optional(receive(status)) : std::nullopt;
}

/// The next message. Asks and sleeps in turn: waiting in MPI itself would keep a core busy that a worker may need.
Message wait_for_message() {
  for (auto pause = 10us;; pause = std::min<std::chrono::microseconds>(2 * pause, 500us)) {
    if (auto message = poll()) return *std::move(message);
    std::this_thread::sleep_for(pause);
  }
}

void broadcast(std::string& text) {
  unsigned long long size = text.size();
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, 0, MPI_COMM_WORLD);
  text.resize(size);
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_BYTE, 0, MPI_COMM_WORLD);
}

}  // namespace

Ranks::Ranks(std::function<bool()> interrupted) : interrupted_(std::move(interrupted)) {
  int given = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &given);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

Ranks::~Ranks() {
  // Nothing to run, or an error before: the workers go home.
  std::string none;
  if (is_manager() && !scene_sent_) broadcast(none);
  if (is_manager() && scene_sent_ && !ran_) {
    const SweepFile nothing;
    SweepQueue no_cases(nothing, {});
    run({nothing.scene_text, no_cases, [](const SweepRow&) {}, [] {}, interrupted_});
  }
  MPI_Finalize();
}

std::vector<double> Ranks::plan(const SweepFile& sweep) {
  constexpr std::size_t at_a_time = 64;
  std::string text = sweep.scene_text;
  broadcast(text);
  scene_sent_ = true;
  std::vector<double> costs(sweep.plan.size());
  std::size_t next = 0;
  const auto send_some = [&](int rank) {
    std::vector<SweepCase> cases;
    while (next < costs.size() && cases.size() < at_a_time) cases.push_back(case_of(sweep, next++));
    if (!cases.empty()) send(rank, Tag::plan, archived(cases));
    return !cases.empty();
  };
  int busy = 0;
  for (int rank = 1; rank < size_; ++rank) busy += send_some(rank) ? 1 : 0;
  while (busy > 0) {
    const Message message = wait_for_message();
    for (const PlannedCost& one : unpack<std::vector<PlannedCost>>(message.bytes)) costs.at(one.index) = one.seconds;
    if (!send_some(message.rank)) --busy;
  }
  for (int rank = 1; rank < size_; ++rank) send(rank, begin);
  return costs;
}

bool Ranks::run(const SweepWork& work) {
  ran_ = true;
  std::set<int> stopping;  // told so, or gone
  const auto tell_to_stop = [&](int rank) {
    if (stopping.insert(rank).second) send(rank, stop);
  };
  bool given_up = false;
  std::exception_ptr error;
  const auto give_up = [&] {
    given_up = true;
    for (int rank = 1; rank < size_; ++rank) tell_to_stop(rank);
  };
  const auto guarded = [&](const auto& action) {
    if (error) return;
    try {
      action();
    } catch (...) {
      error = std::current_exception();
      give_up();
    }
  };
  const auto serve = [&](int rank) {
    if (const auto one = given_up ? std::nullopt : work.queue.take())
      send(rank, job, archived(*one));
    else
      tell_to_stop(rank);
  };
  auto next_tick = std::chrono::steady_clock::now();
  auto pause = 10us;
  for (int present = size_ - 1; present > 0;) {
    if (const auto now = std::chrono::steady_clock::now(); now >= next_tick) {
      next_tick = now + 100ms;
      guarded(work.tick);
    }
    if (interrupted_() && !given_up) give_up();
    const auto message = poll();
    if (!message) {
      std::this_thread::sleep_for(pause);
      pause = std::min<std::chrono::microseconds>(2 * pause, 500us);
      continue;
    }
    pause = 10us;
    if (message->tag == left) {
      --present;
      const bool by_itself = stopping.insert(message->rank).second;
      if (by_itself && !given_up) give_up();
      continue;
    }
    // The workers first, so that they do not wait for the disk.
    serve(message->rank);
    if (message->tag == row) guarded([&] { work.take(unpack<SweepRow>(message->bytes)); });
  }
  guarded(work.tick);
  if (error) std::rethrow_exception(error);
  return !given_up;
}

void Ranks::serve() {
  std::string scene_text;
  broadcast(scene_text);
  if (scene_text.empty()) return;
  for (Message message = wait_for_message(); message.tag == Tag::plan; message = wait_for_message()) {
    std::vector<PlannedCost> costs;
    for (const SweepCase& one : unpack<std::vector<SweepCase>>(message.bytes))
      costs.push_back({one.index, planned_seconds(scene_text, one)});
    send(0, Tag::plan, archived(costs));
  }
  send(0, ready);
  // Looks for messages twenty times a second.
  auto next_look = std::chrono::steady_clock::now();
  std::size_t calls = 0;
  int told = 0;
  const auto stopped = [&] {
    if (told == 0 && ++calls % 64 == 0 && std::chrono::steady_clock::now() >= next_look) {
      next_look = std::chrono::steady_clock::now() + 50ms;
      MPI_Iprobe(0, stop, MPI_COMM_WORLD, &told, MPI_STATUS_IGNORE);
    }
    return told != 0 || interrupted_();
  };
  for (;;) {
    const Message message = wait_for_message();
    if (message.tag == stop) break;
    const auto done = run_case(scene_text, unpack<SweepCase>(message.bytes), stopped);
    if (!done) break;
    send(0, row, archived(*done));
  }
  send(0, left);
}

}  // namespace viscobar
