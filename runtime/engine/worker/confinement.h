// Confines this process before it runs the code of a plug-in.
#pragma once

namespace cdb::worker {

/// Environment variable that leaves plug-ins the rights of the user, for debuggers that start
/// programs, detectors on a graphics card, and the like.
inline constexpr const char* kUnconfined = "CDB_UNCONFINED_PLUGINS";

/// Restricts this process permanently. It may compute, allocate, start threads, read files and
/// write to its open descriptors. It may not open files for writing, create, change or remove them,
/// use sockets or devices, start programs or processes, or act on other processes: such a system
/// call fails with EPERM. Uses a seccomp filter and Landlock, each if the kernel supports it. Does
/// nothing if kUnconfined is set. The filter is for x86-64 and AArch64; on other processors only
/// Landlock is used. Computing is as fast as before. Source: seccomp(2), landlock(7).
void Confine();

}  // namespace cdb::worker
