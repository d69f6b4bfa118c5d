// HDF5 identifiers that close themselves, errors as exceptions, and attributes. Threads: any, for
// different files (Debian's HDF5 takes a global lock).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cdb::hdf5 {

/// An error reported by HDF5 or by the system below it.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The types of values in the file. Text is UTF-8 of variable length.
enum class Type { kInt8, kInt32, kFloat32, kFloat64, kText };
std::size_t ItemBytes(Type type);

using Shape = std::vector<std::uint64_t>;
std::uint64_t Product(const Shape& shape);

/// An HDF5 identifier, closed on destruction.
class Id {
 public:
  using Close = int (*)(std::int64_t);
  Id() = default;
  /// Throws Error if `id` is negative.
  Id(std::int64_t id, Close close, std::string_view doing);
  Id(Id&& other) noexcept;
  Id& operator=(Id&& other) noexcept;
  ~Id() { Reset(); }
  std::int64_t get() const { return id_; }
  /// False if closing failed.
  bool Reset();

 private:
  std::int64_t id_ = -1;
  Close close_ = nullptr;
};

/// The part of `text` that an attribute holds: 32 kB, cut at a character (HDF5 has room for 64 kB
/// in all).
std::string_view AttributeText(std::string_view text);

/// Any HDF5 object that can have attributes.
class Object {
 public:
  /// Scalar, fixed length, null-padded, UTF-8. Empty text makes no attribute; see AttributeText.
  void SetText(const char* name, std::string_view text);
  void SetNumber(const char* name, Type type, double value);
  void SetNumbers(const char* name, Type type, std::span<const double> values);
  /// Empty if there is none of that name, or it is not text.
  std::string Text(const char* name) const;
  /// NaN if there is none of that name.
  double Number(const char* name) const;
  /// All text attributes.
  std::map<std::string, std::string> Texts() const;

 protected:
  explicit Object(Id id) : id_(std::move(id)) {}
  Id id_;
};

// Global heaps, in which HDF5 keeps texts of variable length (HDF5 File Format Specification,
// III.E).

/// Rejects a heap with an object of size zero, on which HDF5 loops forever: it steps from object to
/// object by their sizes. Throws Error. A file that cannot be opened has no heaps.
void CheckGlobalHeaps(const std::filesystem::path& path);

}  // namespace cdb::hdf5
