// The header of an object in the bytes of an HDF5 file, without HDF5: where its values lie, and
// which bytes its checksums cover.
//
// Source: HDF5 File Format Specification 3.0: object header version 2 (IV.A.1.b), data layout
// messages of versions 3 and 4 (IV.A.2.i), attribute message of version 3 (IV.A.2.m).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace cdb::hdf5 {

/// Bytes of a file.
struct Extent {
  std::uint64_t begin = 0, bytes = 0;
};

/// Throws Error if the bytes are not as HDF5 1.10 writes them.
class ObjectHeader {
 public:
  /// `image`, the bytes of the file, must outlive it. `address`: of the object.
  ObjectHeader(std::span<const std::byte> image, std::uint64_t address);

  /// The blocks of the header. Each ends with the checksum of its other bytes.
  const std::vector<Extent>& blocks() const { return blocks_; }
  /// The values of a dataset that are stored in the header.
  Extent CompactValues() const;
  /// The description of the only chunk of a dataset with filters: its size (8 bytes), filter mask
  /// (4 bytes) and address (8 bytes).
  std::uint64_t SingleChunk() const;
  /// The value of an attribute.
  Extent Attribute(std::string_view name) const;

 private:
  struct Message {
    std::uint8_t type;
    Extent body;
  };
  template <typename Number>
  Number At(const Extent& within, std::uint64_t offset) const;
  void ReadMessages(Extent messages);
  const Extent& Layout() const;

  std::span<const std::byte> image_;
  bool has_order_ = false;  ///< messages state the order of creation
  std::vector<Extent> blocks_;
  std::vector<Message> messages_;
};

}  // namespace cdb::hdf5
