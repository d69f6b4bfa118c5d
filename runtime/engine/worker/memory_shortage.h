// Notes that an allocation failed, so that the runner can tell a run that reached its memory limit
// from one that crashed.
#pragma once

#include <atomic>
#include <cstdint>

namespace cdb::worker {

/// While it lives, a failed allocation is noted in `place` and throws std::bad_alloc, in Bullet
/// too, which would otherwise use the null pointer. What a plug-in allocates by malloc is not
/// noted. One at a time in a process. Threads: any may allocate.
class NotesMemoryShortage {
 public:
  explicit NotesMemoryShortage(std::atomic<std::uint32_t>& place);
  ~NotesMemoryShortage();
  NotesMemoryShortage(const NotesMemoryShortage&) = delete;
  NotesMemoryShortage& operator=(const NotesMemoryShortage&) = delete;
};

}  // namespace cdb::worker
