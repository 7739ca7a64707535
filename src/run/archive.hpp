#pragma once

#include <concepts>
#include <cstddef>
#include <cstring>
#include <optional>
#include <ranges>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "viscobar/run/run.hpp"

namespace viscobar {

/// Bytes that are not the values they are taken for.
struct ArchiveError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Numbers, flags and enumerators are archived as they lie in memory: what is archived is read by the same build.
template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// A class that has  static void members(auto& self, auto&& each) { each(self.a_, self.b_, ...); }
template <class T>
concept HasMembers = requires(T& value) {
  T::members(value, [](auto&&...) {});
};

/// The same for structures of public headers.
template <class T, class Value>
concept Like = std::is_same_v<std::remove_const_t<T>, Value>;

void members(Like<EnergyAccount> auto& energy, auto&& each) {
  each(energy.initial, energy.final, energy.dissipated, energy.work, energy.end_inertia, energy.largest, energy.growth,
       energy.growth_time);
}
void members(Like<TimeInContact> auto& contact, auto&& each) { each(contact.until_opening, contact.closed_since); }
void members(Like<ContactPeak> auto& peak, auto&& each) { each(peak.reaction, peak.time); }
void members(Like<Representation> auto& representation, auto&& each) {
  each(representation.error, representation.rounding, representation.velocity);
}
template <class Account>
requires std::derived_from<std::remove_const_t<Account>, ContactAccount>
void members(Account& account, auto&& each) {
  each(account.closings, account.contact, account.impulse, account.peak_reaction, account.latest);
  if constexpr (requires { account.lowest; }) each(account.displacement, account.lowest, account.highest);
  if constexpr (requires { account.openings; }) each(account.openings);
}
void members(Like<RunAccount> auto& account, auto&& each) {
  each(account.left, account.right, account.span, account.joints);
}
void members(Like<Statistics> auto& statistics, auto&& each) {
  each(statistics.unknowns, statistics.steps, statistics.rhs_evaluations, statistics.linear_solves,
       statistics.matrix_factorisations, statistics.event_evaluations, statistics.load_evaluations, statistics.events,
       statistics.integration_seconds, statistics.reached_time, statistics.completed, statistics.max_penetration,
       statistics.late_opening.ratio, statistics.late_opening.time, statistics.energy, statistics.account,
       statistics.representation, statistics.sensitivity);
}
void members(Like<ChangeSensitivity> auto& change, auto&& each) { each(change.time, change.velocity); }
void members(Like<SensitivityAccount> auto& account, auto&& each) {
  each(account.impulse_left, account.impulse_right, account.energy, account.lost, account.why);
}
void members(Like<Event> auto& event, auto&& each) {
  each(event.time, event.where, event.node, event.change, event.velocity, event.impulse, event.peak,
       event.sensitivities);
}
void members(Like<Checkpoint> auto& checkpoint, auto&& each) {
  each(checkpoint.time, checkpoint.outputs, checkpoint.statistics, checkpoint.state, checkpoint.frame);
}

/// Values to bytes: archive(a, b, ...). A span is read into a span of the same length only.
class ArchiveWriter {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (write(values), ...);
  }
  std::string take() { return std::move(bytes_); }

 private:
  void write_bytes(const void* data, std::size_t count) { bytes_.append(static_cast<const char*>(data), count); }

  template <class T>
  void write(const T& value) {
    if constexpr (Plain<T>)
      write_bytes(&value, sizeof value);
    else if constexpr (HasMembers<const T>)
      T::members(value, *this);
    else
      members(value, *this);
  }
  template <class T>
  void write(const std::optional<T>& value) {
    write(value.has_value());
    if (value) write(*value);
  }
  template <std::ranges::contiguous_range Values>
  void write(const Values& values) {
    write(values.size());
    using Value = std::ranges::range_value_t<Values>;
    if constexpr (Plain<Value>)
      write_bytes(values.data(), values.size() * sizeof(Value));
    else
      for (const Value& value : values) write(value);
  }

  std::string bytes_;
};

/// Bytes to the values they were made of, in the same order. @throws ArchiveError
class ArchiveReader {
 public:
  explicit ArchiveReader(std::string_view bytes) : rest_(bytes) {}

  template <class... T>
  void operator()(T&&... values) {
    (read(values), ...);
  }
  bool finished() const { return rest_.empty(); }

 private:
  void read_bytes(void* data, std::size_t count) {
    if (count > rest_.size()) throw ArchiveError("ends too early");
    if (count > 0) std::memcpy(data, rest_.data(), count);
    rest_.remove_prefix(count);
  }

  template <class T>
  void read(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      unsigned char byte = 0;
      read_bytes(&byte, 1);
      value = byte != 0;
    } else if constexpr (Plain<T>) {
      read_bytes(&value, sizeof value);
    } else if constexpr (HasMembers<T>) {
      T::members(value, *this);
    } else {
      members(value, *this);
    }
  }
  template <class T>
  void read(std::optional<T>& value) {
    bool there = false;
    read(there);
    value.reset();
    if (there) read(value.emplace());
  }
  template <std::ranges::contiguous_range Values>
  void read(Values& values) {
    using Value = std::ranges::range_value_t<Values>;
    // Each value has so many bytes at least: a count beyond the rest is wrong, before memory is asked for.
    constexpr std::size_t bytes = Plain<Value> ? sizeof(Value) : 1;
    std::size_t count = 0;
    read(count);
    if (count > rest_.size() / bytes) throw ArchiveError("ends too early");
    if constexpr (requires { values.resize(count); })
      values.resize(count);
    else if (count != values.size())
      throw ArchiveError("has another length");
    if constexpr (Plain<Value>)
      read_bytes(values.data(), count * sizeof(Value));
    else
      for (Value& value : values) read(value);
  }

  std::string_view rest_;
};

}  // namespace viscobar
