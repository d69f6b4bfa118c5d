// Records failed allocations, so that the runner can tell a run that reached its memory limit from
// one that crashed.
#pragma once

#include <atomic>
#include <cstdint>

namespace cdb::worker {

/// While it lives, a failed allocation is noted in `place` and throws std::bad_alloc, also in
/// Bullet, which would otherwise use the null pointer. Allocations of a plug-in by malloc are not
/// noted. Only one may exist in a process at a time. Threads: any may allocate.
class NotesMemoryShortage {
 public:
  explicit NotesMemoryShortage(std::atomic<std::uint32_t>& place);
  ~NotesMemoryShortage();
  NotesMemoryShortage(const NotesMemoryShortage&) = delete;
  NotesMemoryShortage& operator=(const NotesMemoryShortage&) = delete;
};

}  // namespace cdb::worker
