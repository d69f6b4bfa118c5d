// Confines this process before the code of a stranger's plug-in runs in it.
#pragma once

namespace cdb::worker {

/// In the environment: plug-ins keep the rights of the user, for debuggers that start programs, for
/// detectors on a graphics card, and the like.
inline constexpr const char* kUnconfined = "CDB_UNCONFINED_PLUGINS";

/// From now on, and for good, this process may compute, allocate, start threads, read files and
/// write to the descriptors that it has. It may not open files for writing, create, change or
/// remove them, use sockets or devices, start programs or processes, or act on other processes:
/// such a system call fails with EPERM. By a seccomp filter and Landlock, each where the kernel has
/// it; what it lacks is done without. Nothing happens where kUnconfined is set. A filter of x86-64
/// or AArch64; on other processors Landlock alone. Computing is as fast as before. Source:
/// seccomp(2), landlock(7).
void Confine();

}  // namespace cdb::worker
