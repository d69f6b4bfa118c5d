// A trace in memory: the boxes of a recorded run, cycle by cycle, and, if it is one of pairs, the
// input of its narrow phase, in an anonymous file that the runner fills once and every worker
// reads. A trace of a deforming mesh has the vertices of its bodies instead. Only the runner needs
// HDF5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/deforming/primitives.h"
#include "runtime/protocol/recording.h"

namespace cdb::protocol {

/// The pose of a body as a detector gets it: x y z of its centre of mass, then of each axis.
inline constexpr std::size_t kFrameSize = 12;

/// Two bodies, a < b, in the form of cdb::Pair.
struct TracePair {
  std::uint32_t a = 0, b = 0;
  auto operator<=>(const TracePair&) const = default;
};

struct TraceShape {
  std::uint64_t bodies = 0;  ///< including walls
  std::uint64_t cycles = 0;
  bool is_double = false;   ///< type of the sides of boxes; a float holds Bullet's single-precision
                            ///< values exactly
  std::uint64_t pairs = 0;  ///< of all cycles
  std::uint64_t text_bytes = 0;  ///< of the recorded run as YAML; 0 if it is no trace of pairs
  /// Of a deforming mesh: its bodies, and its vertices.
  std::optional<deforming::Primitives> primitives = {};
  std::uint64_t vertices = 0;

  bool HasPairs() const { return text_bytes > 0; }
  /// Of a deforming mesh: one more than the cycles if each is a step.
  std::uint64_t MeshFrames() const {
    return cycles + (primitives && deforming::IsSwept(*primitives) ? 1 : 0);
  }
  std::size_t ItemBytes() const { return is_double ? 8 : 4; }
  /// The number of values of one cycle.
  std::size_t PerCycle() const { return bodies * 6; }
  std::size_t FramesPerCycle() const { return bodies * kFrameSize; }
  std::size_t PerMeshFrame() const { return vertices * 3; }
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
  /// 64 hex digits: the hash of boxes and filters; of a deforming mesh, of everything.
  std::string Sha256() const;

  // Of a trace of pairs.

  /// The input of the narrow phase in a cycle; to be called for each cycle in turn. `frames`: of
  /// every body. `pairs`: in order, each once; they must fit into the shape.
  void SetPairs(std::uint64_t cycle, std::span<const double> frames,
                std::span<const TracePair> pairs);
  std::span<const std::byte> FrameBytes(std::uint64_t cycle) const;
  /// The first pair of each cycle, then the number of all.
  std::span<const std::uint64_t> first_pairs() const;
  std::span<const TracePair> pairs() const;
  /// `walls`: the bits of those among the bodies, -x +x -y +y -z +z from 1 on. `run_text`: of
  /// text_bytes.
  void SetRun(std::uint64_t walls, std::string_view run_text);
  std::uint64_t walls() const;
  /// The hash of everything.
  std::string PairsSha256() const;

  // Of a trace of a deforming mesh.

  /// The vertices of each body.
  std::span<deforming::Corners> corners() const;
  /// x y z of each vertex; rounded in single precision, as boxes are.
  void SetVertices(std::uint64_t frame, std::span<const double> coordinates);
  std::span<const std::byte> VertexBytes(std::uint64_t frame) const;

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

  // Of a trace of pairs; also valid until the next call.

  std::span<const double> ReadFrames(std::uint64_t cycle);
  std::span<const TracePair> ReadPairs(std::uint64_t cycle);
  std::uint64_t walls() const { return walls_; }
  /// The recorded run as YAML.
  std::string ReadRunText() const;

  // Of a trace of a deforming mesh.

  const std::vector<deforming::Corners>& corners() const { return corners_; }
  /// x y z of each vertex.
  std::vector<double> ReadVertices(std::uint64_t frame);

 private:
  void ReadPairsHead();
  void ReadMeshHead();
  void ReadReals(std::size_t at, std::vector<double>& to);

  int fd_;
  TraceShape shape_;
  std::vector<TraceFilter> filters_;
  std::vector<float> floats_;
  std::vector<double> sides_, frames_;
  std::uint64_t walls_ = 0;
  std::vector<std::uint64_t> first_pairs_;
  std::vector<TracePair> pairs_;
  std::vector<deforming::Corners> corners_;
};

// The input of the narrow phase, which a worker appends to a file cycle by cycle, because the
// number of pairs varies.

/// Begins the file. `walls`: as in TraceMemory::SetRun. Throws std::system_error.
void BeginNarrowInput(int fd, std::uint64_t walls);
/// Appends a cycle: `frames` has kFrameSize values of 4 or 8 bytes for each body. Throws
/// std::system_error.
void AppendNarrowInput(int fd, std::span<const std::byte> frames, std::span<const TracePair> pairs);

// The boxes of a recorded run as a trace.

/// The trace of a finished run of `scene` that records `boxes`. Walls that the run omitted are not
/// in the trace. Throws std::runtime_error if no body is left or a number is not finite, and
/// std::system_error.
TraceMemory TraceOf(const plan::Scene& scene, const Recording& recording);
/// The same with pairs, from the file of AppendNarrowInput. `run_text`: the run as YAML.
TraceMemory TraceOfPairs(const plan::Scene& scene, const Recording& recording, int narrow_input_fd,
                         std::string_view run_text);

/// The trace of a deforming mesh. Throws library::SceneError if the sequence is too short, and
/// std::system_error.
TraceMemory TraceOf(deforming::Primitives primitives, const deforming::MeshSequence& sequence);

// The alignment of arrays in shared memory.

/// `bytes`, rounded up to whole cache lines.
constexpr std::size_t WholeCacheLines(std::size_t bytes) {
  constexpr std::size_t kCacheLine = 64;
  return (bytes + kCacheLine - 1) / kCacheLine * kCacheLine;
}

}  // namespace cdb::protocol
