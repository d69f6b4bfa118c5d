#include "runtime/protocol/recording.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <limits>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "runtime/protocol/trace_memory.h"

namespace cdb::protocol {

namespace {

[[noreturn]] void FailToMap() {
  throw std::system_error(errno, std::generic_category(), "cannot map the recording of a run");
}

/// Guard on each side of a recording: a multiple of the page size on any system.
constexpr std::size_t kGuardBytes = 64 << 10;

/// The size of the address range of a recording with its guards.
std::size_t GuardedBytes(std::size_t bytes) {
  return (bytes + kGuardBytes - 1) / kGuardBytes * kGuardBytes + 2 * kGuardBytes;
}

/// Maps the recording between inaccessible pages: a process that writes beyond an adjacent buffer
/// crashes before it changes a measurement.
std::byte* MapBetweenGuards(int fd, std::size_t bytes) {
  void* room = mmap(nullptr, GuardedBytes(bytes), PROT_NONE,
                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) FailToMap();
  std::byte* place = static_cast<std::byte*>(room) + kGuardBytes;
  if (mmap(place, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE | MAP_FIXED, fd, 0) ==
      MAP_FAILED) {
    const int error = errno;
    munmap(room, GuardedBytes(bytes));
    errno = error;
    FailToMap();
  }
  return place;
}

void Unmap(void* place, std::size_t bytes) {
  munmap(static_cast<std::byte*>(place) - kGuardBytes, GuardedBytes(bytes));
}

}  // namespace

Recording::Recording(int fd, const plan::Scene& scene, bool create) : fd_(fd) {
  bytes_ = WholeCacheLines(sizeof(RecordingHeader));
  for (const Series& series : AllSeries()) {
    if (!IsRecordedBy(series, scene)) continue;
    const std::size_t bytes = series.ItemBytes() * series.ValueCount(ExtentsOf(scene));
    places_[static_cast<std::size_t>(&series - AllSeries().data())] = {bytes_, bytes};
    bytes_ += WholeCacheLines(bytes);
  }
  if (const auto shape = SampleShapeOf(scene)) {
    samples_offset_ = bytes_;
    samples_count_ = shape->Count();
    bytes_ += WholeCacheLines(samples_count_ * sizeof(double));
  }
  if (create && ftruncate(fd_, static_cast<off_t>(bytes_)) != 0)
    throw std::system_error(errno, std::generic_category(), "no memory for the recording of a run");
  struct stat status = {};
  if (fstat(fd_, &status) != 0 || static_cast<std::size_t>(status.st_size) != bytes_)
    throw std::runtime_error("the recording does not belong to this run");
  header_ = reinterpret_cast<RecordingHeader*>(MapBetweenGuards(fd_, bytes_));
}

Recording Recording::Create(const plan::Scene& scene) {
  const int fd = memfd_create("cdb-recording", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0)
    throw std::system_error(errno, std::generic_category(), "no memory for the recording of a run");
  Recording recording(fd, scene, true);
  // If a worker truncated the file, reading it would crash the runner.
  fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW);
  recording.Clear();
  return recording;
}

void Recording::Clear() {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  header_ = new (header_) RecordingHeader{};
  header_->magic = RecordingHeader::kMagic;
  header_->bytes = bytes_;
  for (const Series& series : AllSeries()) {
    if (series.type == SeriesType::kInt32) {
      std::ranges::fill(Values<std::int32_t>(series), -1);
    } else {
      std::ranges::fill(Values<double>(series), kNone);
    }
  }
  std::ranges::fill(SampleValues(), kNone);
}

Recording Recording::Open(int fd, const plan::Scene& scene) {
  Recording recording(fd, scene, false);
  if (recording.header().magic != RecordingHeader::kMagic ||
      recording.header().bytes != recording.bytes_)
    throw std::runtime_error("the recording does not belong to this run");
  // The mapping is enough, and the code of a plug-in needs no descriptor of it.
  close(std::exchange(recording.fd_, -1));
  return recording;
}

Recording::Recording(Recording&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      header_(std::exchange(other.header_, nullptr)),
      bytes_(other.bytes_),
      places_(other.places_),
      samples_offset_(other.samples_offset_),
      samples_count_(other.samples_count_) {}

Recording::~Recording() {
  if (header_ != nullptr) Unmap(header_, bytes_);
  if (fd_ >= 0) close(fd_);
}

std::span<std::byte> Recording::Find(const Series& series) const {
  const Place& place = places_[static_cast<std::size_t>(&series - AllSeries().data())];
  return {reinterpret_cast<std::byte*>(header_) + place.offset, place.bytes};
}

std::span<double> Recording::SampleValues() const {
  auto* memory = reinterpret_cast<std::byte*>(header_);
  return {reinterpret_cast<double*>(memory + samples_offset_), samples_count_};
}

std::string SettlingText(const Settling& settling) {
  switch (settling.phase.load(std::memory_order_relaxed)) {
    case SettlingPhase::kWaiting:
      return "another run settles the same pile";
    case SettlingPhase::kSettling:
      return fmt::format("{} of {} objects at rest",
                         settling.at_rest.load(std::memory_order_relaxed),
                         settling.objects.load(std::memory_order_relaxed));
    case SettlingPhase::kNone:
      break;
  }
  return {};
}

namespace {

constexpr const char* kNames[] = {
    "",           "loading",         "making",    "Prepare of", "FindPairs of",
    "Handles of", "FindContacts of", "destroying"};
constexpr std::uint32_t kCalls = std::size(kNames);

}  // namespace

std::uint32_t PluginCallCode(PluginCall call, std::size_t index) {
  return static_cast<std::uint32_t>(index) * kCalls + static_cast<std::uint32_t>(call);
}

std::string PluginCallText(std::uint32_t code, const plan::Scene& scene) {
  const std::uint32_t call = code % kCalls, index = code / kCalls;
  if (call == 0 || index >= scene.plugins.size()) return {};
  const schema::PluginDetector& plugin = scene.plugins[index];
  return std::string(kNames[call]) + " detector `" + plugin.name + "` (" + plugin.path + ")";
}

}  // namespace cdb::protocol
