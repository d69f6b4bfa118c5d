// The part of a worker's confinement that the kernel's Landlock enforces.
#pragma once

namespace cdb::worker {

/// No file is written, made, removed or executed from now on, no TCP connection is opened, and no
/// signal or abstract socket reaches a process outside, as far as this kernel's Landlock knows
/// these. Without effect where it has none. Needs PR_SET_NO_NEW_PRIVS.
void RestrictByLandlock();

}  // namespace cdb::worker
