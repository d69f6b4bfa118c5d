#include "runtime/results/hdf5/dataset.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <string>

#include "runtime/results/hdf5/calls.h"

namespace cdb::hdf5 {
namespace {

/// Transfer properties for `n` values that HDF5 converts. By default, its buffer is 1 MiB, which it
/// fills with zeros each time.
Id Transfer(std::size_t n) {
  Id transfer = NewProperties(H5P_DATASET_XFER);
  const std::size_t bytes = std::clamp<std::size_t>(n * 16, 1 << 10, 1 << 20);
  Check(H5Pset_buffer(transfer.get(), bytes, nullptr, nullptr), "set up HDF5");
  return transfer;
}

Type TypeOf(const Id& type) {
  const std::size_t bytes = H5Tget_size(type.get());
  switch (H5Tget_class(type.get())) {
    case H5T_INTEGER:
      if (bytes == 1) return Type::kInt8;
      if (bytes == 4) return Type::kInt32;
      break;
    case H5T_FLOAT:
      if (bytes == 4) return Type::kFloat32;
      if (bytes == 8) return Type::kFloat64;
      break;
    case H5T_STRING:
      if (H5Tis_variable_str(type.get()) > 0) return Type::kText;
      break;
    default:
      break;
  }
  throw Error("it holds a type of value that results files do not have");
}

void Select(const Id& space, const Shape& start, const Shape& count) {
  Check(
      H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, Dims(start), nullptr, Dims(count), nullptr),
      "find a part of an array");
}

void CheckPart(const Shape& shape, const Shape& start, const Shape& count) {
  bool is_within = start.size() == shape.size() && count.size() == shape.size();
  for (std::size_t d = 0; is_within && d < shape.size(); ++d)
    is_within = start[d] <= shape[d] && count[d] <= shape[d] - start[d];
  if (!is_within) throw Error("it is smaller than it should be");
}

/// The space of an array, with a part of it selected.
Id Part(const Id& dataset, const Shape& start, const Shape& count) {
  Id space(H5Dget_space(dataset.get()), H5Sclose, "read an array's shape");
  Select(space, start, count);
  return space;
}

}  // namespace

Dataset::Dataset(Id id, std::uint64_t foreign_bytes)
    : Object(std::move(id)), foreign_bytes_(foreign_bytes) {
  if (foreign_bytes_ > 0) CheckStorage(id_, foreign_bytes_);
  type_ = TypeOf({H5Dget_type(id_.get()), H5Tclose, "read an array's type"});
  shape_ = ShapeOf({H5Dget_space(id_.get()), H5Sclose, "read an array's shape"});
}

Shape Dataset::ChunkShape() const {
  const Id creation(H5Dget_create_plist(id_.get()), H5Pclose, "read an array's layout");
  if (H5Pget_layout(creation.get()) != H5D_CHUNKED) return {};
  Shape chunk(shape_.size());
  Check(H5Pget_chunk(creation.get(), static_cast<int>(chunk.size()),
                     reinterpret_cast<hsize_t*>(chunk.data())),
        "read an array's layout");
  return chunk;
}

void Dataset::CheckCount(std::uint64_t values) const {
  if (foreign_bytes_ > 0) CheckReadable(id_, values, ItemBytes(type_), foreign_bytes_);
}

void Dataset::Write(std::span<const double> values) {
  if (values.size() != Product(shape_)) throw Error("an array of another size");
  if (values.empty()) return;
  Check(H5Dwrite(id_.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, Transfer(values.size()).get(),
                 values.data()),
        "write an array");
}

void Dataset::WriteText(std::span<const std::string> values) {
  if (values.size() != Product(shape_)) throw Error("an array of another size");
  std::vector<const char*> pointers;
  for (const std::string& value : values) pointers.push_back(value.c_str());
  Check(H5Dwrite(id_.get(), NewText(H5T_VARIABLE).get(), H5S_ALL, H5S_ALL,
                 Transfer(pointers.size()).get(), pointers.data()),
        "write an array of text");
}

std::vector<double> Dataset::Read() const {
  if (type_ == Type::kText) throw Error("it holds text where numbers should be");
  CheckCount(Product(shape_));
  std::vector<double> values(Product(shape_));
  if (values.empty()) return values;
  Check(H5Dread(id_.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, Transfer(values.size()).get(),
                values.data()),
        "read an array");
  return values;
}

std::vector<std::string> Dataset::ReadText() const {
  if (type_ != Type::kText) throw Error("it holds numbers where text should be");
  CheckCount(Product(shape_));
  std::vector<char*> pointers(Product(shape_));
  if (pointers.empty()) return {};
  const Id type = NewText(H5T_VARIABLE);
  Check(H5Dread(id_.get(), type.get(), H5S_ALL, H5S_ALL, Transfer(pointers.size()).get(),
                pointers.data()),
        "read an array of text");
  std::vector<std::string> values;
  for (const char* pointer : pointers) values.emplace_back(pointer != nullptr ? pointer : "");
  const Id space = NewSpace({pointers.size()});
  H5Dvlen_reclaim(type.get(), space.get(), H5P_DEFAULT, pointers.data());
  return values;
}

std::vector<double> Dataset::Read(const Shape& start, const Shape& count) const {
  if (type_ == Type::kText) throw Error("it holds text where numbers should be");
  CheckPart(shape_, start, count);
  CheckCount(Product(count));
  std::vector<double> values(Product(count));
  if (values.empty()) return values;
  const Id file_space = Part(id_, start, count);
  // Of the same shape: if the shapes differ, HDF5 processes the selection value by value.
  const Id memory_space = NewSpace(count);
  Check(H5Dread(id_.get(), H5T_NATIVE_DOUBLE, memory_space.get(), file_space.get(),
                Transfer(values.size()).get(), values.data()),
        "read an array");
  return values;
}

void Dataset::Write(const Shape& start, const Shape& count, std::span<const double> values) {
  if (values.size() != Product(count)) throw Error("an array of another size");
  if (values.empty()) return;
  const Id file_space = Part(id_, start, count);
  const Id memory_space = NewSpace(count);
  Check(H5Dwrite(id_.get(), H5T_NATIVE_DOUBLE, memory_space.get(), file_space.get(),
                 Transfer(values.size()).get(), values.data()),
        "write an array");
}

void Dataset::Write(const Shape& start, const Shape& count, const std::byte* data,
                    const Shape& data_shape) {
  if (Product(count) == 0) return;
  const Id file_space = Part(id_, start, count);
  const Id memory_space = NewSpace(data_shape);
  Select(memory_space, Shape(data_shape.size(), 0), count);
  Check(H5Dwrite(id_.get(), FileType(type_).get(), memory_space.get(), file_space.get(),
                 H5P_DEFAULT, data),
        "write an array");
}

void Dataset::ForEachStoredChunk(const VisitPart& visit) const {
  const Shape chunk = ChunkShape();
  const auto visit_at = [&](const Shape& start) {
    Shape count(start.size());
    for (std::size_t d = 0; d < start.size(); ++d) {
      if (start[d] >= shape_[d]) throw Error("a chunk is outside of its array");
      count[d] = std::min(chunk[d], shape_[d] - start[d]);
    }
    visit(start, count);
  };
  Shape chunks(chunk.size());
  for (std::size_t d = 0; d < chunk.size(); ++d) chunks[d] = (shape_[d] + chunk[d] - 1) / chunk[d];
  const std::size_t places = Product(chunks);
  if (places == 0) return;
  const Id space(H5Dget_space(id_.get()), H5Sclose, "read an array's shape");
  hsize_t stored = 0;
  Check(H5Dget_num_chunks(id_.get(), space.get(), &stored), "count the chunks");
  // Looking up a chunk by index walks all chunks before it, so this is only done if there are few;
  // looking up a position takes logarithmic time.
  if (stored * stored <= places) {
    for (hsize_t i = 0; i < stored; ++i) {
      std::vector<hsize_t> start(chunk.size());
      unsigned mask = 0;
      haddr_t address = HADDR_UNDEF;
      hsize_t bytes = 0;
      Check(H5Dget_chunk_info(id_.get(), space.get(), i, start.data(), &mask, &address, &bytes),
            "find a chunk");
      if (bytes > 0) visit_at(Shape(start.begin(), start.end()));
    }
    return;
  }
  for (std::size_t place = 0; place < places; ++place) {
    Shape start(chunk.size());
    std::size_t rest = place;
    for (std::size_t d = chunk.size(); d-- > 0; rest /= chunks[d])
      start[d] = rest % chunks[d] * chunk[d];
    hsize_t bytes = 0;
    // Fails if the file holds no chunk there.
    if (H5Dget_chunk_storage_size(id_.get(), Dims(start), &bytes) >= 0 && bytes > 0)
      visit_at(start);
  }
}

bool Dataset::ReadChunk(const Shape& start, RawChunk& chunk) const {
  hsize_t bytes = 0;
  // Looks up one chunk; H5Dget_chunk_info_by_coord would search all of them.
  if (H5Dget_chunk_storage_size(id_.get(), Dims(start), &bytes) < 0) {
    // The call also fails if there is no such chunk.
    unsigned mask = 0;
    haddr_t address = HADDR_UNDEF;
    Check(H5Dget_chunk_info_by_coord(id_.get(), Dims(start), &mask, &address, &bytes),
          "find a chunk");
    if (address != HADDR_UNDEF && bytes > 0) Fail("find a chunk");
    return false;
  }
  if (bytes == 0) return false;
  chunk.bytes.resize(bytes);
  Check(H5Dread_chunk(id_.get(), H5P_DEFAULT, Dims(start), &chunk.filter_mask, chunk.bytes.data()),
        "read a chunk");
  return true;
}

void Dataset::WriteChunk(const Shape& start, std::uint32_t filter_mask,
                         std::span<const std::byte> bytes) {
  Check(
      H5Dwrite_chunk(id_.get(), H5P_DEFAULT, filter_mask, Dims(start), bytes.size(), bytes.data()),
      "write a chunk");
}

void Dataset::MakeScale(const std::string& name) {
  Check(H5DSset_scale(id_.get(), name.c_str()), "make a dimension scale");
}

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

void CheckStorage(const Id& dataset, std::uint64_t file_bytes, Accept accept) {
  const Id creation(H5Dget_create_plist(dataset.get()), H5Pclose, "read an array's layout");
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
    throw Error("it is a view of other arrays, which results files do not have");
  if (H5Pget_external_count(creation.get()) != 0)
    throw Error("its values are in other files, which results files do not have");
  CheckFilters(creation.get());
  const Id type(H5Dget_type(dataset.get()), H5Tclose, "read an array's type");
  if (accept == Accept::kOurs && !HasOurType(type.get()))
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
