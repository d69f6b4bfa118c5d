// Work in a process of its own, with limits of time and memory: a copy of this one, so that what
// HDF5 does not survive of a damaged file ends the copy only.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace cdb::files {

struct WorkLimits {
  std::uint64_t cpu_s = 10;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  ///< beyond that of this process
};

/// Of reading a file of `bytes`.
WorkLimits LimitsForFile(std::uint64_t bytes);

/// Empty where `work` ended well in the copy; else why it did not: what it threw, how it crashed,
/// or the limit that it met. Nothing else comes back. Throws CannotRead where no process can be
/// started, or the system ends it. Not while another thread is in HDF5 or allocates memory.
std::string RunLimited(const std::function<void()>& work, const WorkLimits& limits);

}  // namespace cdb::files
