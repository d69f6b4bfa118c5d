// A trace in memory: the boxes of a recorded run, cycle by cycle, in an anonymous file that the
// runner fills once and every worker reads. Only the runner needs HDF5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"

namespace cdb::protocol {

struct TraceShape {
  std::uint64_t bodies = 0;  ///< including walls
  std::uint64_t cycles = 0;
  bool is_double = false;  ///< type of the sides of boxes; a float holds Bullet's single-precision
                           ///< values exactly

  std::size_t ItemBytes() const { return is_double ? 8 : 4; }
  /// The number of values of one cycle.
  std::size_t PerCycle() const { return bodies * 6; }
  bool operator==(const TraceShape&) const = default;
};

/// The bodies that a body may meet, in the form of cdb::Filter.
struct TraceFilter {
  std::uint32_t group = 1, mask = ~0u, is_fixed = 0;
  bool operator==(const TraceFilter&) const = default;
};

/// The runner's side. Not copyable; unmapped and closed on destruction. Not thread-safe.
class TraceMemory {
 public:
  /// Filled with zeros. Throws std::system_error.
  static TraceMemory Create(const TraceShape& shape);
  TraceMemory(TraceMemory&& other) noexcept;
  TraceMemory& operator=(TraceMemory&&) = delete;
  ~TraceMemory();

  int fd() const { return fd_; }
  const TraceShape& shape() const { return shape_; }
  std::span<TraceFilter> filters() const;
  /// Lower x y z and upper x y z of every body. Sides may be infinite. In single precision they are
  /// rounded, which does not change values that came from single precision.
  void SetBoxes(std::uint64_t cycle, std::span<const double> sides);
  /// The stored bytes of a cycle.
  std::span<const std::byte> BoxBytes(std::uint64_t cycle) const;
  std::vector<double> Boxes(std::uint64_t cycle) const;
  /// 64 hex digits: the hash of the whole trace.
  std::string Sha256() const;

 private:
  TraceMemory(int fd, std::byte* memory, const TraceShape& shape)
      : fd_(fd), memory_(memory), shape_(shape) {}

  int fd_ = -1;
  std::byte* memory_ = nullptr;
  TraceShape shape_;
};

/// The worker's side: reads cycle by cycle, so that the trace does not count as the worker's
/// memory. Not thread-safe.
class TraceReader {
 public:
  /// Throws std::runtime_error if `fd` is not a trace. Does not own it.
  explicit TraceReader(int fd);

  const TraceShape& shape() const { return shape_; }
  const std::vector<TraceFilter>& filters() const { return filters_; }
  /// The sides of every box of a cycle, valid until the next call. Throws std::runtime_error.
  std::span<const double> Read(std::uint64_t cycle);

 private:
  int fd_;
  TraceShape shape_;
  std::vector<TraceFilter> filters_;
  std::vector<float> floats_;
  std::vector<double> sides_;
};

// The boxes of a recorded run as a trace.

/// The trace of a finished run of `scene` that records `boxes`. Walls that the run omitted are not
/// in the trace. Throws std::runtime_error if no body is left or a side is NaN, and
/// std::system_error.
TraceMemory TraceOf(const plan::Scene& scene, const Recording& recording);

// The alignment of arrays in shared memory.

/// `bytes`, rounded up to whole cache lines.
constexpr std::size_t WholeCacheLines(std::size_t bytes) {
  constexpr std::size_t kCacheLine = 64;
  return (bytes + kCacheLine - 1) / kCacheLine * kCacheLine;
}

}  // namespace cdb::protocol
