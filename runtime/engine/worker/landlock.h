// The part of a worker's confinement that uses the kernel's Landlock.
#pragma once

namespace cdb::worker {

/// From now on, no file can be written, made, removed or executed, no TCP connection opened, and no
/// signal or abstract socket reaches other processes, as far as this kernel's Landlock supports
/// these restrictions. Has no effect without Landlock. Needs PR_SET_NO_NEW_PRIVS.
void RestrictByLandlock();

}  // namespace cdb::worker
