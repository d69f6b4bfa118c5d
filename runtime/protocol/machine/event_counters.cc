#include "runtime/protocol/machine/event_counters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace cdb::machine {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Event {
  std::uint32_t type;
  std::uint64_t config;
};
/// In the order of schema::Counter.
constexpr Event kEvents[] = {{PERF_TYPE_HARDWARE, PERF_COUNT_HW_INSTRUCTIONS},
                             {PERF_TYPE_HARDWARE, PERF_COUNT_HW_CPU_CYCLES},
                             {PERF_TYPE_HARDWARE, PERF_COUNT_HW_CACHE_MISSES},
                             {PERF_TYPE_HARDWARE, PERF_COUNT_HW_BRANCH_MISSES},
                             {PERF_TYPE_SOFTWARE, PERF_COUNT_SW_PAGE_FAULTS}};
static_assert(std::size(kEvents) == protocol::kCounterCount);

std::vector<schema::Counter> AllCounters() {
  std::vector<schema::Counter> all;
  for (std::size_t i = 0; i < protocol::kCounterCount; ++i)
    all.push_back(static_cast<schema::Counter>(i));
  return all;
}

bool IsHardware(schema::Counter counter) {
  return kEvents[static_cast<std::size_t>(counter)].type == PERF_TYPE_HARDWARE;
}

/// A file descriptor that counts the event from now on, or -1 with errno. `leader`: of its group;
/// -1 for a new one.
int OpenEvent(schema::Counter counter, int leader) {
  const Event event = kEvents[static_cast<std::size_t>(counter)];
  perf_event_attr attr = {};
  attr.size = sizeof attr;
  attr.type = event.type;
  attr.config = event.config;
  attr.read_format =
      PERF_FORMAT_GROUP | PERF_FORMAT_TOTAL_TIME_ENABLED | PERF_FORMAT_TOTAL_TIME_RUNNING;
  // Counting the kernel, too, is a privilege.
  attr.exclude_kernel = 1;
  attr.exclude_hv = 1;
  // It counts whenever the thread runs, or is in an error state, in which read(2) returns 0. On a
  // hybrid processor it does not count on cores of the other kind.
  attr.pinned = leader < 0;
  return static_cast<int>(syscall(SYS_perf_event_open, &attr, 0, -1, leader, PERF_FLAG_FD_CLOEXEC));
}

constexpr const char* kHidden = "not available; most virtual machines hide them";
constexpr const char* kNoEvent =
    "the processor has no such events; a virtual machine may hide some";
constexpr const char* kNoRoom =
    "the processor cannot count all of them at once, or another program uses its counters";

std::string ReasonOf(int error, bool is_first) {
  switch (error) {
    case EINVAL:
      return is_first ? std::strerror(error) : kNoRoom;
    case ENOENT:
    case ENODEV:
    case EOPNOTSUPP:
      return kHidden;
    case EACCES:
    case EPERM:
      return "not permitted: set kernel.perf_event_paranoid to 2 or less by sysctl, or allow "
             "perf_event_open in the container";
    case ENOSYS:
      return "the system has no perf_event_open";
    default:
      return std::strerror(error);
  }
}

}  // namespace

EventCounters::EventCounters() : EventCounters(AllCounters()) {}

EventCounters::EventCounters(std::span<const schema::Counter> wanted) {
  std::vector<schema::Counter> group;
  for (const schema::Counter counter : wanted) {
    group.push_back(counter);
    std::string why = Open(group);
    if (why.empty()) continue;
    missing_.push_back({counter, std::move(why)});
    group.pop_back();
    // Meanwhile, another program may have taken one of the counters before it.
    if (why = Open(group); why.empty()) continue;
    Close();
    for (const schema::Counter lost : group) missing_.push_back({lost, why});
    group.clear();
  }
  const bool has_processor_events =
      std::ranges::any_of(members_, [](const Member& one) { return IsHardware(one.counter); }) ||
      std::ranges::find(missing_, kNoRoom, &MissingCounter::why) != missing_.end();
  if (!has_processor_events) return;
  for (MissingCounter& one : missing_)
    if (one.why == kHidden) one.why = kNoEvent;
}

EventCounters::~EventCounters() { Close(); }

std::string EventCounters::Open(std::span<const schema::Counter> group) {
  Close();
  for (const schema::Counter counter : group) {
    const bool is_first = members_.empty();
    const int fd = OpenEvent(counter, is_first ? -1 : members_.front().fd), error = errno;
    if (fd < 0) return ReasonOf(error, is_first);
    members_.push_back({counter, fd});
  }
  const bool is_counting =
      std::ranges::any_of(Read(), [](double count) { return !std::isnan(count); });
  return is_counting ? "" : kNoRoom;
}

void EventCounters::Close() {
  for (const Member& member : members_) close(member.fd);
  members_.clear();
}

Counts EventCounters::Read() const {
  Counts counts;
  counts.fill(kNone);
  if (members_.empty()) return counts;
  // Their number, the times for which they were enabled and have counted, and their values in the
  // order in which they were opened.
  constexpr std::size_t kHead = 3;
  std::array<std::uint64_t, kHead + protocol::kCounterCount> values;
  const std::size_t size = (kHead + members_.size()) * sizeof values[0];
  if (read(members_.front().fd, values.data(), sizeof values) != static_cast<ssize_t>(size))
    return counts;
  const auto [members, enabled, running] = std::array{values[0], values[1], values[2]};
  if (members != members_.size() || running == 0 || running < enabled) return counts;
  for (std::size_t i = 0; i < members_.size(); ++i)
    counts[static_cast<std::size_t>(members_[i].counter)] = static_cast<double>(values[kHead + i]);
  return counts;
}

std::string MissingText(std::span<const MissingCounter> missing) {
  std::vector<std::string> reasons, texts;
  for (const MissingCounter& one : missing)
    if (std::ranges::find(reasons, one.why) == reasons.end()) reasons.push_back(one.why);
  for (const std::string& why : reasons) {
    std::vector<std::string_view> names;
    for (const MissingCounter& one : missing)
      if (one.why == why) names.push_back(schema::kCounters[static_cast<std::size_t>(one.counter)]);
    texts.push_back(fmt::format("{} ({})", fmt::join(names, ", "), why));
  }
  return fmt::format("{}", fmt::join(texts, "; "));
}

}  // namespace cdb::machine
