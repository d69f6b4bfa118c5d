// Confines this process before it runs code that may be hostile: a plug-in or an importer.
#pragma once

namespace cdb::library {

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

// The part of a worker's confinement that uses the kernel's Landlock.

/// From now on, no file can be written, made, removed or executed, no TCP connection opened, and no
/// signal or abstract socket reaches other processes, as far as this kernel's Landlock supports
/// these restrictions. Has no effect without Landlock. Needs PR_SET_NO_NEW_PRIVS.
void RestrictByLandlock();

// The part of a worker's confinement that uses a seccomp filter.

/// From now on, system calls that are not on the list fail with EPERM in all threads. The list
/// contains the calls for computing, threads, memory, time, reading files and loading libraries.
/// Has no effect if the kernel has no seccomp, or for processors without a list. Needs
/// PR_SET_NO_NEW_PRIVS.
void FilterSystemCalls();

}  // namespace cdb::library
