// The destination of a file that HDF5 writes: a driver whose writes never fail, and which keeps the
// first error. See File::Create.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace cdb::hdf5 {

/// A file that is written from scratch. Not thread-safe.
class Sink {
 public:
  explicit Sink(const std::filesystem::path& path);
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  ~Sink() { Close(); }

  /// Throws Error for the first failure.
  void Check() const;
  void Close();

  // For the driver. Addresses are bytes from the beginning of the file.

  /// Bytes that were never written read as zeros, as in any file. False if the system fails.
  bool Read(std::uint64_t address, std::size_t bytes, char* out) const;
  void Write(std::uint64_t address, std::size_t bytes, const char* data);
  void Truncate(std::uint64_t size);
  std::uint64_t end() const { return end_; }

 private:
  int fd_;
  int error_ = 0;
  std::uint64_t end_ = 0;
};

/// Directs a file that is created with the file access properties `access` to `sink`, whose address
/// must not change before that. Negative if HDF5 fails.
int SetSink(std::int64_t access, const std::shared_ptr<Sink>& sink);

}  // namespace cdb::hdf5
