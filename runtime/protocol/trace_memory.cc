#include "runtime/protocol/trace_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "compiler/plan/input_file.h"
#include "dsl/text/check.h"
#include "runtime/protocol/series.h"

namespace cdb::protocol {
namespace {

struct Header {
  static constexpr std::uint64_t kMagic = 0x31'45'43'41'52'54'43'00;  // "\0CTRACE1"
  std::uint64_t magic, bodies, cycles, item_bytes;
};

std::size_t BoxesBegin(const TraceShape& shape) {
  return WholeCacheLines(sizeof(Header) + shape.bodies * sizeof(TraceFilter));
}

std::size_t CycleBytes(const TraceShape& shape) { return shape.PerCycle() * shape.ItemBytes(); }

std::size_t AllBytes(const TraceShape& shape) {
  return BoxesBegin(shape) + shape.cycles * CycleBytes(shape);
}

void ReadAt(int fd, std::size_t offset, std::span<std::byte> to) {
  while (!to.empty()) {
    const ssize_t got = pread(fd, to.data(), to.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw std::runtime_error("the trace of this run is incomplete");
    to = to.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::size_t>(got);
  }
}

}  // namespace

TraceMemory TraceMemory::Create(const TraceShape& shape) {
  const auto fail = [] {
    throw std::system_error(errno, std::generic_category(), "no memory for a trace");
  };
  const int fd = memfd_create("cdb-trace", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0) fail();
  TraceMemory trace(fd, nullptr, shape);
  const std::size_t bytes = AllBytes(shape);
  if (ftruncate(fd, static_cast<off_t>(bytes)) != 0) fail();
  // A reader must not find it truncated.
  fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW);
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) fail();
  trace.memory_ = static_cast<std::byte*>(memory);
  // Nor may one worker change it for the others. This mapping stays writable.
  fcntl(fd, F_ADD_SEALS, F_SEAL_FUTURE_WRITE);
  const Header header = {Header::kMagic, shape.bodies, shape.cycles, shape.ItemBytes()};
  std::memcpy(trace.memory_, &header, sizeof header);
  return trace;
}

TraceMemory::TraceMemory(TraceMemory&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      memory_(std::exchange(other.memory_, nullptr)),
      shape_(other.shape_) {}

TraceMemory::~TraceMemory() {
  if (memory_ != nullptr) munmap(memory_, AllBytes(shape_));
  if (fd_ >= 0) close(fd_);
}

std::span<TraceFilter> TraceMemory::filters() const {
  return {reinterpret_cast<TraceFilter*>(memory_ + sizeof(Header)), shape_.bodies};
}

void TraceMemory::SetBoxes(std::uint64_t cycle, std::span<const double> sides) {
  CDB_CHECK(cycle < shape_.cycles && sides.size() == shape_.PerCycle());
  std::byte* to = memory_ + BoxesBegin(shape_) + cycle * CycleBytes(shape_);
  if (shape_.is_double) {
    std::ranges::copy(sides, reinterpret_cast<double*>(to));
  } else {
    std::ranges::transform(sides, reinterpret_cast<float*>(to),
                           [](double side) { return static_cast<float>(side); });
  }
}

std::span<const std::byte> TraceMemory::BoxBytes(std::uint64_t cycle) const {
  return {memory_ + BoxesBegin(shape_) + cycle * CycleBytes(shape_), CycleBytes(shape_)};
}

std::vector<double> TraceMemory::Boxes(std::uint64_t cycle) const {
  const std::byte* from = BoxBytes(cycle).data();
  if (shape_.is_double) {
    const auto* sides = reinterpret_cast<const double*>(from);
    return {sides, sides + shape_.PerCycle()};
  }
  const auto* sides = reinterpret_cast<const float*>(from);
  return {sides, sides + shape_.PerCycle()};
}

std::string TraceMemory::Sha256() const {
  return plan::Sha256Hex({reinterpret_cast<const char*>(memory_), AllBytes(shape_)});
}

TraceReader::TraceReader(int fd) : fd_(fd) {
  Header header = {};
  ReadAt(fd_, 0, std::as_writable_bytes(std::span(&header, 1)));
  if (header.magic != Header::kMagic)
    throw std::runtime_error("the trace of this run is not a trace");
  shape_ = {header.bodies, header.cycles, header.item_bytes == 8};
  filters_.resize(shape_.bodies);
  ReadAt(fd_, sizeof header, std::as_writable_bytes(std::span(filters_)));
  sides_.resize(shape_.PerCycle());
  if (!shape_.is_double) floats_.resize(shape_.PerCycle());
}

std::span<const double> TraceReader::Read(std::uint64_t cycle) {
  const std::size_t at = BoxesBegin(shape_) + cycle * CycleBytes(shape_);
  if (shape_.is_double) {
    ReadAt(fd_, at, std::as_writable_bytes(std::span(sides_)));
  } else {
    ReadAt(fd_, at, std::as_writable_bytes(std::span(floats_)));
    std::ranges::copy(floats_, sides_.begin());
  }
  return sides_;
}

namespace {

/// Bodies without a filter were never in the world: they are omitted walls.
std::vector<std::size_t> BodiesOf(const Recording& recording) {
  const auto filters = recording.Reals("box_filters");
  std::vector<std::size_t> bodies;
  for (std::size_t i = 0; i < filters.size() / kFilterSize; ++i)
    if (!std::isnan(filters[i * kFilterSize])) bodies.push_back(i);
  return bodies;
}

}  // namespace

TraceMemory TraceOf(const plan::Scene& scene, const Recording& recording) {
  const std::vector<std::size_t> bodies = BodiesOf(recording);
  if (bodies.empty())
    throw std::runtime_error("the scene has no bodies, so there is nothing to trace");
  const std::uint64_t cycles = scene.world.Count("cycles");
  const bool is_double = scene.world.WordOr("precision") == "double";
  const auto filters = recording.Reals("box_filters"), boxes = recording.Reals("boxes");
  const std::size_t all = filters.size() / kFilterSize;
  TraceMemory trace = TraceMemory::Create({bodies.size(), cycles, is_double});
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double* filter = &filters[bodies[i] * kFilterSize];
    trace.filters()[i] = {static_cast<std::uint32_t>(filter[0]),
                          static_cast<std::uint32_t>(filter[1]),
                          static_cast<std::uint32_t>(filter[2])};
  }
  std::vector<double> sides(trace.shape().PerCycle());
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const auto box = boxes.subspan((cycle * all + bodies[i]) * kBoxSize, kBoxSize);
      if (std::ranges::any_of(box, [](double side) { return std::isnan(side); }))
        throw std::runtime_error(
            fmt::format("the box of body {} is not finite in cycle {}: the scene exploded; run it "
                        "by `cdb run` to see how",
                        bodies[i], cycle));
      std::ranges::copy(box, &sides[i * kBoxSize]);
    }
    trace.SetBoxes(cycle, sides);
  }
  return trace;
}

}  // namespace cdb::protocol
