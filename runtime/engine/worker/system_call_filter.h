// The part of a worker's confinement that a seccomp filter enforces.
#pragma once

namespace cdb::worker {

/// System calls that are not on the list fail with EPERM from now on, in all threads. The list has
/// what computing, threads, memory, time, reading files and loading libraries need. Without effect
/// where the kernel has no seccomp, or the list is not written for the processor. Needs
/// PR_SET_NO_NEW_PRIVS.
void FilterSystemCalls();

}  // namespace cdb::worker
