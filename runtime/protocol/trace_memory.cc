#include "runtime/protocol/trace_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
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
#include "runtime/protocol/file_descriptor_io.h"
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

/// The end of the boxes, which is that of a trace without pairs. It does not depend on the pairs,
/// nor does its hash.
std::size_t BoxesEnd(const TraceShape& shape) {
  return BoxesBegin(shape) + shape.cycles * CycleBytes(shape);
}

// The part of the pairs: its head, the frames, the first pair of each cycle, the pairs, the text.
struct PairsHeader {
  static constexpr std::uint64_t kMagic = 0x31'52'49'41'50'54'43'00;  // "\0CTPAIR1"
  std::uint64_t magic, pairs, text_bytes, walls;
};

std::size_t PairsHeadBegin(const TraceShape& shape) { return WholeCacheLines(BoxesEnd(shape)); }
std::size_t FramesBegin(const TraceShape& shape) {
  return WholeCacheLines(PairsHeadBegin(shape) + sizeof(PairsHeader));
}
std::size_t FrameBytesOf(const TraceShape& shape) {
  return shape.FramesPerCycle() * shape.ItemBytes();
}
std::size_t FirstPairsBegin(const TraceShape& shape) {
  return WholeCacheLines(FramesBegin(shape) + shape.cycles * FrameBytesOf(shape));
}
std::size_t PairsBegin(const TraceShape& shape) {
  return FirstPairsBegin(shape) + (shape.cycles + 1) * sizeof(std::uint64_t);
}
std::size_t TextBegin(const TraceShape& shape) {
  return PairsBegin(shape) + shape.pairs * sizeof(TracePair);
}

// The part of a deforming mesh: its head, the corners of each body, the vertices of each frame.
struct MeshHeader {
  static constexpr std::uint64_t kMagic = 0x31'48'53'45'4d'54'43'00;  // "\0CTMESH1"
  std::uint64_t magic, primitives, vertices;
};

std::size_t CornersBegin(const TraceShape& shape) {
  return PairsHeadBegin(shape) + sizeof(MeshHeader);
}
std::size_t VerticesBegin(const TraceShape& shape) {
  return WholeCacheLines(CornersBegin(shape) + shape.bodies * sizeof(deforming::Corners));
}
std::size_t VertexBytesOf(const TraceShape& shape) {
  return shape.PerMeshFrame() * shape.ItemBytes();
}

std::size_t AllBytes(const TraceShape& shape) {
  if (shape.primitives) return VerticesBegin(shape) + shape.MeshFrames() * VertexBytesOf(shape);
  return shape.HasPairs() ? TextBegin(shape) + shape.text_bytes : BoxesEnd(shape);
}

void StoreReals(std::span<const double> reals, bool is_double, std::byte* to) {
  if (is_double) {
    std::ranges::copy(reals, reinterpret_cast<double*>(to));
  } else {
    std::ranges::transform(reals, reinterpret_cast<float*>(to),
                           [](double real) { return static_cast<float>(real); });
  }
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
  if (shape.HasPairs()) {
    const PairsHeader pairs = {PairsHeader::kMagic, shape.pairs, shape.text_bytes, 0};
    std::memcpy(trace.memory_ + PairsHeadBegin(shape), &pairs, sizeof pairs);
  }
  if (shape.primitives) {
    const MeshHeader mesh = {MeshHeader::kMagic, static_cast<std::uint64_t>(*shape.primitives),
                             shape.vertices};
    std::memcpy(trace.memory_ + PairsHeadBegin(shape), &mesh, sizeof mesh);
  }
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
  StoreReals(sides, shape_.is_double, memory_ + BoxesBegin(shape_) + cycle * CycleBytes(shape_));
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
  return plan::Sha256Hex({reinterpret_cast<const char*>(memory_),
                          shape_.primitives ? AllBytes(shape_) : BoxesEnd(shape_)});
}

void TraceMemory::SetPairs(std::uint64_t cycle, std::span<const double> frames,
                           std::span<const TracePair> pairs) {
  CDB_CHECK(shape_.HasPairs() && cycle < shape_.cycles && frames.size() == shape_.FramesPerCycle());
  auto* first = reinterpret_cast<std::uint64_t*>(memory_ + FirstPairsBegin(shape_));
  CDB_CHECK(pairs.size() <= shape_.pairs - first[cycle]);
  StoreReals(frames, shape_.is_double,
             memory_ + FramesBegin(shape_) + cycle * FrameBytesOf(shape_));
  std::ranges::copy(pairs,
                    reinterpret_cast<TracePair*>(memory_ + PairsBegin(shape_)) + first[cycle]);
  first[cycle + 1] = first[cycle] + pairs.size();
}

std::span<const std::byte> TraceMemory::FrameBytes(std::uint64_t cycle) const {
  return {memory_ + FramesBegin(shape_) + cycle * FrameBytesOf(shape_), FrameBytesOf(shape_)};
}

std::span<const std::uint64_t> TraceMemory::first_pairs() const {
  return {reinterpret_cast<const std::uint64_t*>(memory_ + FirstPairsBegin(shape_)),
          shape_.cycles + 1};
}

std::span<const TracePair> TraceMemory::pairs() const {
  return {reinterpret_cast<const TracePair*>(memory_ + PairsBegin(shape_)), shape_.pairs};
}

void TraceMemory::SetRun(std::uint64_t walls, std::string_view run_text) {
  CDB_CHECK(shape_.HasPairs() && run_text.size() == shape_.text_bytes);
  reinterpret_cast<PairsHeader*>(memory_ + PairsHeadBegin(shape_))->walls = walls;
  std::ranges::copy(run_text, reinterpret_cast<char*>(memory_ + TextBegin(shape_)));
}

std::uint64_t TraceMemory::walls() const {
  return reinterpret_cast<const PairsHeader*>(memory_ + PairsHeadBegin(shape_))->walls;
}

std::string TraceMemory::PairsSha256() const {
  return plan::Sha256Hex({reinterpret_cast<const char*>(memory_), AllBytes(shape_)});
}

std::span<deforming::Corners> TraceMemory::corners() const {
  CDB_CHECK(shape_.primitives.has_value());
  return {reinterpret_cast<deforming::Corners*>(memory_ + CornersBegin(shape_)), shape_.bodies};
}

void TraceMemory::SetVertices(std::uint64_t frame, std::span<const double> coordinates) {
  CDB_CHECK(frame < shape_.MeshFrames() && coordinates.size() == shape_.PerMeshFrame());
  StoreReals(coordinates, shape_.is_double,
             memory_ + VerticesBegin(shape_) + frame * VertexBytesOf(shape_));
}

std::span<const std::byte> TraceMemory::VertexBytes(std::uint64_t frame) const {
  return {memory_ + VerticesBegin(shape_) + frame * VertexBytesOf(shape_), VertexBytesOf(shape_)};
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
  struct stat status = {};
  if (fstat(fd_, &status) != 0 || static_cast<std::size_t>(status.st_size) == BoxesEnd(shape_))
    return;
  std::uint64_t magic = 0;
  ReadAt(fd_, PairsHeadBegin(shape_), std::as_writable_bytes(std::span(&magic, 1)));
  if (magic == PairsHeader::kMagic)
    ReadPairsHead();
  else if (magic == MeshHeader::kMagic)
    ReadMeshHead();
  else
    throw std::runtime_error("the trace of this run is neither one of pairs nor of a mesh");
}

void TraceReader::ReadMeshHead() {
  MeshHeader mesh = {};
  ReadAt(fd_, PairsHeadBegin(shape_), std::as_writable_bytes(std::span(&mesh, 1)));
  shape_.primitives = static_cast<deforming::Primitives>(mesh.primitives);
  shape_.vertices = mesh.vertices;
  corners_.resize(shape_.bodies);
  ReadAt(fd_, CornersBegin(shape_), std::as_writable_bytes(std::span(corners_)));
}

void TraceReader::ReadPairsHead() {
  PairsHeader pairs = {};
  ReadAt(fd_, PairsHeadBegin(shape_), std::as_writable_bytes(std::span(&pairs, 1)));
  shape_.pairs = pairs.pairs;
  shape_.text_bytes = pairs.text_bytes;
  walls_ = pairs.walls;
  frames_.resize(shape_.FramesPerCycle());
  first_pairs_.resize(shape_.cycles + 1);
  ReadAt(fd_, FirstPairsBegin(shape_), std::as_writable_bytes(std::span(first_pairs_)));
}

void TraceReader::ReadReals(std::size_t at, std::vector<double>& to) {
  if (shape_.is_double) {
    ReadAt(fd_, at, std::as_writable_bytes(std::span(to)));
  } else {
    floats_.resize(to.size());
    ReadAt(fd_, at, std::as_writable_bytes(std::span(floats_)));
    std::ranges::copy(floats_, to.begin());
  }
}

std::span<const double> TraceReader::Read(std::uint64_t cycle) {
  ReadReals(BoxesBegin(shape_) + cycle * CycleBytes(shape_), sides_);
  return sides_;
}

std::span<const double> TraceReader::ReadFrames(std::uint64_t cycle) {
  ReadReals(FramesBegin(shape_) + cycle * FrameBytesOf(shape_), frames_);
  return frames_;
}

std::span<const TracePair> TraceReader::ReadPairs(std::uint64_t cycle) {
  const std::uint64_t first = first_pairs_.at(cycle);
  pairs_.resize(first_pairs_.at(cycle + 1) - first);
  ReadAt(fd_, PairsBegin(shape_) + first * sizeof(TracePair),
         std::as_writable_bytes(std::span(pairs_)));
  return pairs_;
}

std::string TraceReader::ReadRunText() const {
  std::string text(shape_.text_bytes, '\0');
  ReadAt(fd_, TextBegin(shape_), std::as_writable_bytes(std::span(text)));
  return text;
}

std::vector<double> TraceReader::ReadVertices(std::uint64_t frame) {
  std::vector<double> coordinates(shape_.PerMeshFrame());
  ReadReals(VerticesBegin(shape_) + frame * VertexBytesOf(shape_), coordinates);
  return coordinates;
}

void BeginNarrowInput(int fd, std::uint64_t walls) {
  WriteAll(fd, std::as_bytes(std::span(&walls, 1)), "cannot write the pairs");
}

void AppendNarrowInput(int fd, std::span<const std::byte> frames,
                       std::span<const TracePair> pairs) {
  constexpr const char* kWhat = "cannot write the pairs";
  const std::uint64_t count = pairs.size();
  WriteAll(fd, std::as_bytes(std::span(&count, 1)), kWhat);
  WriteAll(fd, frames, kWhat);
  WriteAll(fd, std::as_bytes(pairs), kWhat);
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

constexpr std::size_t kWallBytes = sizeof(std::uint64_t);

/// The number of pairs in the file of AppendNarrowInput.
std::uint64_t CountPairs(int fd, const TraceShape& shape) {
  std::uint64_t all = 0;
  std::size_t at = kWallBytes;
  for (std::uint64_t cycle = 0; cycle < shape.cycles; ++cycle) {
    std::uint64_t count = 0;
    ReadAt(fd, at, std::as_writable_bytes(std::span(&count, 1)));
    at += sizeof count + FrameBytesOf(shape) + count * sizeof(TracePair);
    all += count;
  }
  return all;
}

void TakePairs(int fd, TraceMemory& trace) {
  const TraceShape& shape = trace.shape();
  std::vector<float> floats(shape.is_double ? 0 : shape.FramesPerCycle());
  std::vector<double> frames(shape.FramesPerCycle());
  std::vector<TracePair> pairs;
  std::size_t at = kWallBytes;
  const auto read = [&](auto& to) {
    const auto bytes = std::as_writable_bytes(std::span(to));
    ReadAt(fd, at, bytes);
    at += bytes.size();
  };
  for (std::uint64_t cycle = 0; cycle < shape.cycles; ++cycle) {
    std::array<std::uint64_t, 1> count = {};
    read(count);
    if (shape.is_double) {
      read(frames);
    } else {
      read(floats);
      std::ranges::copy(floats, frames.begin());
    }
    if (!std::ranges::all_of(frames, [](double part) { return std::isfinite(part); }))
      throw std::runtime_error(
          fmt::format("a pose is not finite in cycle {}: the scene exploded; run it by `cdb run` "
                      "to see how",
                      cycle));
    pairs.resize(count[0]);
    read(pairs);
    trace.SetPairs(cycle, frames, pairs);
  }
}

void TakeBoxes(const Recording& recording, const std::vector<std::size_t>& bodies,
               TraceMemory& trace) {
  const auto filters = recording.Reals("box_filters"), boxes = recording.Reals("boxes");
  const std::size_t all = filters.size() / kFilterSize;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double* filter = &filters[bodies[i] * kFilterSize];
    trace.filters()[i] = {static_cast<std::uint32_t>(filter[0]),
                          static_cast<std::uint32_t>(filter[1]),
                          static_cast<std::uint32_t>(filter[2])};
  }
  std::vector<double> sides(trace.shape().PerCycle());
  for (std::uint64_t cycle = 0; cycle < trace.shape().cycles; ++cycle) {
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
}

std::vector<std::size_t> SomeBodiesOf(const Recording& recording) {
  std::vector<std::size_t> bodies = BodiesOf(recording);
  if (bodies.empty())
    throw std::runtime_error("the scene has no bodies, so there is nothing to trace");
  return bodies;
}

TraceShape ShapeOf(const plan::Scene& scene, const std::vector<std::size_t>& bodies) {
  return {bodies.size(), scene.world.Count("cycles"), scene.world.WordOr("precision") == "double"};
}

}  // namespace

TraceMemory TraceOf(const plan::Scene& scene, const Recording& recording) {
  const std::vector<std::size_t> bodies = SomeBodiesOf(recording);
  TraceMemory trace = TraceMemory::Create(ShapeOf(scene, bodies));
  TakeBoxes(recording, bodies, trace);
  return trace;
}

TraceMemory TraceOfPairs(const plan::Scene& scene, const Recording& recording, int narrow_input_fd,
                         std::string_view run_text) {
  const std::vector<std::size_t> bodies = SomeBodiesOf(recording);
  TraceShape shape = ShapeOf(scene, bodies);
  shape.pairs = CountPairs(narrow_input_fd, shape);
  shape.text_bytes = run_text.size();
  TraceMemory trace = TraceMemory::Create(shape);
  TakeBoxes(recording, bodies, trace);
  std::uint64_t walls = 0;
  ReadAt(narrow_input_fd, 0, std::as_writable_bytes(std::span(&walls, 1)));
  trace.SetRun(walls, run_text);
  TakePairs(narrow_input_fd, trace);
  return trace;
}

TraceMemory TraceOf(deforming::Primitives primitives, const deforming::MeshSequence& sequence) {
  const std::vector<deforming::Corners> bodies = deforming::BodiesOf(primitives, sequence);
  TraceShape shape = {bodies.size(), deforming::CyclesOf(primitives, sequence),
                      !sequence.IsSingle()};
  shape.primitives = primitives;
  shape.vertices = sequence.vertices();
  TraceMemory trace = TraceMemory::Create(shape);
  std::ranges::copy(bodies, trace.corners().begin());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Filter filter = deforming::FilterOf(primitives, bodies[i]);
    trace.filters()[i] = {filter.group, filter.mask, filter.is_fixed};
  }
  std::vector<double> numbers;
  for (std::uint64_t cycle = 0; cycle < shape.cycles; ++cycle) {
    deforming::FillBoxes(primitives, sequence, bodies, cycle, numbers);
    trace.SetBoxes(cycle, numbers);
  }
  for (std::uint64_t frame = 0; frame < shape.MeshFrames(); ++frame) {
    numbers.clear();
    for (const Eigen::Vector3d& at : sequence.frames[frame])
      numbers.insert(numbers.end(), at.begin(), at.end());
    trace.SetVertices(frame, numbers);
  }
  return trace;
}

}  // namespace cdb::protocol
