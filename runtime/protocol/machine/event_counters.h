// Counts of the processor's and the system's events, by perf_event_open(2).
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "runtime/protocol/series.h"

namespace cdb::machine {

/// One value for each counter, in the order of schema::kCounters. NaN: it is not counted.
using Counts = std::array<double, protocol::kCounterCount>;

/// A counter that this machine, or this process, does not have.
struct MissingCounter {
  schema::Counter counter = {};
  std::string why;
  bool operator==(const MissingCounter&) const = default;
};

/// Counts the events of the thread that constructs it, in user mode. The counters are one group, so
/// that no count is an estimate from a part of the time: a counter that the processor cannot count
/// beside those before it in the list is left out.
/// Source: perf_event_open(2); the generic events of its `config`.
/// Threads: Read is of the thread that constructed it; events of other threads are not counted.
/// Errors: none; what cannot be counted is in missing().
class EventCounters {
 public:
  explicit EventCounters(std::span<const schema::Counter> wanted);
  EventCounters();  ///< all
  ~EventCounters();
  EventCounters(const EventCounters&) = delete;
  EventCounters& operator=(const EventCounters&) = delete;

  /// The number of events so far; all NaN if the group did not count all the time.
  Counts Read() const;
  const std::vector<MissingCounter>& missing() const { return missing_; }
  bool CountsNothing() const { return members_.empty(); }

 private:
  struct Member {
    schema::Counter counter;
    int fd;
  };
  /// Opens the group in place of the one before. Returns the reason why not all of it counts, which
  /// is that of its last counter if the others count; empty if all count.
  std::string Open(std::span<const schema::Counter> group);
  void Close();

  std::vector<Member> members_;  ///< the first leads the group
  std::vector<MissingCounter> missing_;
};

/// The missing counters as a line: `instructions, cpu_cycles (the reason)`.
/// Empty if there are none.
std::string MissingText(std::span<const MissingCounter> missing);

}  // namespace cdb::machine
