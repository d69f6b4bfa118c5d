#include "runtime/store/hdf5/heaps.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cstdint>
#include <cstring>
#include <string_view>

#include "compiler/plan/descriptor.h"
#include "runtime/store/hdf5/object.h"

namespace cdb::hdf5 {
namespace {

constexpr std::string_view kHeapSignature("GCOL\1\0\0\0", 8);
constexpr std::size_t kHeapHeader = 16;  ///< of a heap, and of an object
constexpr std::size_t kObjectAlignment = 8;

template <typename Number>
Number At(std::span<const std::byte> bytes, std::size_t place) {
  Number number;
  std::memcpy(&number, bytes.data() + place,
              sizeof number);  // little-endian, as all that cdb runs on
  return number;
}

/// `heap`: from its signature to the end of the file.
void CheckHeap(std::span<const std::byte> heap) {
  const auto bytes = At<std::uint64_t>(heap, kHeapSignature.size());
  if (bytes > heap.size()) return;
  std::uint64_t place = kHeapHeader;
  while (place + kHeapHeader <= bytes) {
    const auto size = At<std::uint64_t>(heap, place + kObjectAlignment);
    const bool is_free = At<std::uint16_t>(heap, place) == 0;
    const std::uint64_t step =
        is_free ? size
                : kHeapHeader + (size + kObjectAlignment - 1) / kObjectAlignment * kObjectAlignment;
    if (step == 0) throw Error("a text in it has no size, and HDF5 would read it for ever");
    if (step > bytes - place) return;
    place += step;
  }
}

}  // namespace

void CheckGlobalHeaps(std::span<const std::byte> file) {
  const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
  for (std::size_t place = 0; (place = bytes.find(kHeapSignature, place)) != bytes.npos; ++place)
    if (place + kHeapHeader <= bytes.size()) CheckHeap(file.subspan(place));
}

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
  CheckGlobalHeaps({static_cast<const std::byte*>(begin), bytes});
}

}  // namespace cdb::hdf5
