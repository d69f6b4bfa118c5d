// Runs work in a separate process with limits of time and memory: a copy of this one. If a damaged
// file crashes HDF5, only the copy ends.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace cdb::files {

struct WorkLimits {
  std::uint64_t cpu_s = 10;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  ///< in addition to that of this process
};

/// The limits for reading a file of `bytes`.
WorkLimits LimitsForFile(std::uint64_t bytes);

/// Returns an empty text if `work` succeeded in the copy, else the reason: its exception, its
/// crash, or the limit that it reached. Nothing else is returned. Throws std::runtime_error if
/// no process can be started, or the system ends it. Must not be called while another thread is in
/// HDF5 or allocates memory.
std::string RunLimited(const std::function<void()>& work, const WorkLimits& limits);

}  // namespace cdb::files
