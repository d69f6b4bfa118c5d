// The part of a worker's confinement that uses a seccomp filter.
#pragma once

namespace cdb::worker {

/// From now on, system calls that are not on the list fail with EPERM in all threads. The list
/// contains the calls for computing, threads, memory, time, reading files and loading libraries.
/// Has no effect if the kernel has no seccomp, or for processors without a list. Needs
/// PR_SET_NO_NEW_PRIVS.
void FilterSystemCalls();

}  // namespace cdb::worker
