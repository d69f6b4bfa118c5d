#include "runtime/results/hdf5/heaps.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "compiler/plan/descriptor.h"
#include "runtime/results/hdf5/object.h"

namespace cdb::hdf5 {
namespace {

/// A global heap (III.E of the specification): a head with signature and size, and objects, each
/// with a head. Objects begin at multiples of kAlignment.
constexpr std::string_view kHeapSignature("GCOL\1\0\0\0", 8);
constexpr std::uint64_t kHeapHead = 16, kHeapObjectHead = 16, kAlignment = 8;

std::uint64_t Aligned(std::uint64_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

template <typename Number>
Number Get(std::span<const std::byte> bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, &bytes[at], sizeof number);
  return number;
}

/// `heap`: from its signature to the end of the file.
void CheckHeap(std::span<const std::byte> heap) {
  const auto bytes = Get<std::uint64_t>(heap, kHeapSignature.size());
  if (bytes > heap.size()) return;
  std::uint64_t at = kHeapHead;
  while (at + kHeapObjectHead <= bytes) {
    const bool is_free = Get<std::uint16_t>(heap, at) == 0;  // its size includes the head
    const auto size = Get<std::uint64_t>(heap, at + 8);
    const std::uint64_t step = is_free ? size : kHeapObjectHead + Aligned(size);
    if (step == 0) throw Error("a text in it has no size, and HDF5 would read it for ever");
    if (step > bytes - at) return;
    at += step;
  }
}

/// The same bytes as text, whose find is faster than a search for bytes.
std::string_view AsText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void CheckHeapsIn(std::span<const std::byte> file) {
  const std::string_view bytes = AsText(file);
  for (std::size_t at = 0; (at = bytes.find(kHeapSignature, at)) != bytes.npos; ++at)
    if (at + kHeapHead <= bytes.size()) CheckHeap(file.subspan(at));
}

}  // namespace

void CheckGlobalHeaps(const std::filesystem::path& path) {
  const plan::Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts = {};
  if (file.get() < 0 || fstat(file.get(), &facts) != 0 || facts.st_size <= 0) return;
  const auto bytes = static_cast<std::size_t>(facts.st_size);
  void* const begin = mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (begin == MAP_FAILED) return;
  struct Mapping {
    void* begin;
    std::size_t bytes;
    ~Mapping() { munmap(begin, bytes); }
  } const mapping{begin, bytes};
  CheckHeapsIn({static_cast<const std::byte*>(begin), bytes});
}

}  // namespace cdb::hdf5
