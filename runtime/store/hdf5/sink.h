// Where HDF5 writes a file: a driver to which no write ever fails, and which keeps the first error.
// See File::Create.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace cdb::hdf5 {

/// A file that is written anew. Not for several threads.
class Sink {
 public:
  explicit Sink(const std::filesystem::path& path);
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  ~Sink() { Close(); }

  /// Throws Error for the first that went wrong.
  void Check() const;
  void Close();

  // For the driver. Addresses are bytes from the file's beginning.

  /// What was never written is zeros, as in any file. False where the system fails.
  bool Read(std::uint64_t address, std::size_t bytes, char* out) const;
  void Write(std::uint64_t address, std::size_t bytes, const char* data);
  void Truncate(std::uint64_t size);
  std::uint64_t end() const { return end_; }

 private:
  int fd_;
  int error_ = 0;
  std::uint64_t end_ = 0;
};

/// A file that is made with the file access properties `access` goes to `sink`, which stays where
/// it is until then. Negative where HDF5 fails.
int SetSink(std::int64_t access, const std::shared_ptr<Sink>& sink);

}  // namespace cdb::hdf5
