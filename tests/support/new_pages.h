// Page faults on request.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <system_error>

namespace cdb::tests {

/// Memory whose pages can be touched for the first time again and again. It keeps its address, so
/// that a sanitizer's own memory for it is touched only once, by the constructor.
class NewPages {
 public:
  static constexpr std::size_t kMost = 512;

  NewPages()
      : size_(static_cast<std::size_t>(sysconf(_SC_PAGESIZE))),
        memory_(mmap(nullptr, kMost * size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS,
                     -1, 0)) {
    if (memory_ == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "mmap");
    madvise(memory_, kMost * size_, MADV_NOHUGEPAGE);
    Touch(kMost);
  }
  ~NewPages() { munmap(memory_, kMost * size_); }
  NewPages(const NewPages&) = delete;
  NewPages& operator=(const NewPages&) = delete;

  /// Causes `count` page faults.
  void Touch(std::size_t count) {
    madvise(memory_, kMost * size_, MADV_DONTNEED);
    for (std::size_t i = 0; i < count; ++i) static_cast<volatile char*>(memory_)[i * size_] = 1;
  }

 private:
  const std::size_t size_;
  void* const memory_;
};

}  // namespace cdb::tests
