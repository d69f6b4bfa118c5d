#include "runtime/results/hdf5/foreign.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <string>

#include "runtime/results/hdf5/calls.h"

namespace cdb::hdf5 {
namespace {

/// A chunk written by cdb has at most kLargestChunk bytes, or a single item.
constexpr std::uint64_t kMostChunkBytes = 64 << 20;
/// Reads up to this size are not checked against the size of the file.
constexpr std::uint64_t kReadUnasked = 64 << 20;
/// Deflate's limit is 1032 to 1.
constexpr std::uint64_t kMostCompression = 1100;
constexpr std::uint64_t kMostValues = std::uint64_t{1} << 56;

bool HasOurType(hid_t type) {
  if (H5Tget_class(type) == H5T_STRING) return H5Tis_variable_str(type) > 0;
  for (const hid_t ours : {H5T_STD_I8LE, H5T_STD_I32LE, H5T_IEEE_F32LE, H5T_IEEE_F64LE})
    if (H5Tequal(type, ours) > 0) return true;
  return false;
}

void CheckFilters(hid_t creation) {
  const int filters = H5Pget_nfilters(creation);
  if (filters < 0 || filters > 3) throw Error("it has filters that results files do not have");
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0, values = 0;
    unsigned configuration = 0;
    std::size_t count = 0;
    char name[1] = {};
    const H5Z_filter_t filter = H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &count,
                                               &values, sizeof(name), name, &configuration);
    if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_DEFLATE &&
        filter != H5Z_FILTER_FLETCHER32)
      throw Error(fmt::format("it has the filter {}, which results files do not have",
                              static_cast<int>(filter)));
  }
}

void CheckChunks(hid_t creation, std::size_t rank, std::uint64_t item_bytes) {
  Shape chunk(H5S_MAX_RANK, 1);
  const int chunk_rank =
      H5Pget_chunk(creation, H5S_MAX_RANK, reinterpret_cast<hsize_t*>(chunk.data()));
  if (chunk_rank < 0 || static_cast<std::size_t>(chunk_rank) != rank)
    throw Error("its chunks do not fit its shape");
  std::uint64_t bytes = item_bytes;
  for (const std::uint64_t n : chunk) {
    if (n == 0 || n > kMostChunkBytes / bytes) throw Error("its chunks are too large");
    bytes *= n;
  }
}

void CheckContiguous(const Id& dataset, std::uint64_t bytes, std::uint64_t file_bytes) {
  const haddr_t begin = H5Dget_offset(dataset.get());
  if (begin == HADDR_UNDEF) return;  // never written, or stored in the header
  if (H5Dget_storage_size(dataset.get()) < bytes || bytes > file_bytes ||
      begin > file_bytes - bytes)
    throw Error("its values lie beyond the end of the file");
}

herr_t CheckLink(hid_t, const char* name, const H5L_info_t* info, void* out) {
  if (info->type == H5L_TYPE_HARD) return 0;
  try {
    *static_cast<std::string*>(out) = name;
  } catch (const std::exception&) {
    return -1;  // exceptions must not pass through HDF5
  }
  return 1;
}

}  // namespace

void CloseBackdoors() {
  static const bool are_closed = [] {
    H5PLset_loading_state(0);
    return H5Lunregister(H5L_TYPE_EXTERNAL) >= 0;
  }();
  if (!are_closed) throw Error("cannot set up HDF5: external links cannot be switched off");
}

void CheckLinks(const Id& group) {
  std::string foreign;
  if (Checked(H5Literate(group.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, CheckLink, &foreign),
              "read the names in a group") > 0)
    throw Error(fmt::format("'{}' is a link, and files of cdb have none", foreign));
}

void CheckStorage(const Id& dataset, std::uint64_t file_bytes) {
  const Id creation(H5Dget_create_plist(dataset.get()), H5Pclose, "read an array's layout");
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
    throw Error("it is a view of other arrays, which results files do not have");
  if (H5Pget_external_count(creation.get()) != 0)
    throw Error("its values are in other files, which results files do not have");
  CheckFilters(creation.get());
  const Id type(H5Dget_type(dataset.get()), H5Tclose, "read an array's type");
  if (!HasOurType(type.get()))
    throw Error("it holds a type of value that results files do not have");
  const Shape shape = ShapeOf({H5Dget_space(dataset.get()), H5Sclose, "read an array's shape"});
  const bool is_empty = std::ranges::find(shape, 0u) != shape.end();
  std::uint64_t values = 1;
  for (const std::uint64_t n : shape) {
    if (!is_empty && n > kMostValues / values) throw Error("it is larger than any file");
    values *= is_empty ? 1 : n;
  }
  const std::uint64_t item_bytes = H5Tget_size(type.get());
  if (layout == H5D_CHUNKED) return CheckChunks(creation.get(), shape.size(), item_bytes);
  if (layout == H5D_CONTIGUOUS && !is_empty)
    CheckContiguous(dataset, values * item_bytes, file_bytes);
}

void CheckReadable(const Id& dataset, std::uint64_t values, std::uint64_t item_bytes,
                   std::uint64_t file_bytes) {
  if (values <= kReadUnasked / std::max<std::uint64_t>(item_bytes, 8)) return;
  const std::uint64_t stored = H5Dget_storage_size(dataset.get());
  if (stored > file_bytes || values / kMostCompression > stored / item_bytes)
    throw Error(fmt::format("it claims {} values, more than the file can hold", values));
}

}  // namespace cdb::hdf5
