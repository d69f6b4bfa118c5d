#include "runtime/store/hdf5/file.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "runtime/store/hdf5/sink.h"

namespace cdb::hdf5 {

namespace {

static_assert(sizeof(hid_t) == sizeof(std::int64_t) && sizeof(hsize_t) == sizeof(std::uint64_t));

constexpr std::size_t kLongestText = 32 << 10;
constexpr unsigned kCompression = 1;
/// All attributes of an object stand in its header: quicker and smaller than HDF5's dense form.
constexpr unsigned kMostCompact = 1 << 12;

const hsize_t* Dims(const Shape& shape) { return reinterpret_cast<const hsize_t*>(shape.data()); }

/// What failed first, from HDF5's stack of errors; the system's words where it was the system.
std::string Cause() {
  std::string cause;
  const auto visit = [](unsigned depth, const H5E_error2_t* error, void* out) -> herr_t {
    if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, visit, &cause);
  H5Eclear2(H5E_DEFAULT);
  constexpr std::string_view kSystem = "error message = '";
  if (const std::size_t begin = cause.find(kSystem); begin != std::string::npos) {
    cause.erase(0, begin + kSystem.size());
    cause.erase(std::min(cause.find('\''), cause.size()));
  }
  return cause.empty() ? "HDF5 does not say why" : cause;
}

[[noreturn]] void Fail(std::string_view doing) {
  throw Error(fmt::format("cannot {}: {}", doing, Cause()));
}

void Check(herr_t result, std::string_view doing) {
  if (result < 0) Fail(doing);
}

template <typename Number>
Number Checked(Number result, std::string_view doing) {
  if (result < 0) Fail(doing);
  return result;
}

/// HDF5 prints every error to stderr unless told not to, thread by thread.
void BeQuiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Id NewProperties(hid_t kind) { return {H5Pcreate(kind), H5Pclose, "set up HDF5"}; }

/// For `n` values that HDF5 converts: its buffer is otherwise 1 MiB, which it fills with zeros each
/// time.
Id Transfer(std::size_t n) {
  Id transfer = NewProperties(H5P_DATASET_XFER);
  const std::size_t bytes = std::clamp<std::size_t>(n * 16, 1 << 10, 1 << 20);
  Check(H5Pset_buffer(transfer.get(), bytes, nullptr, nullptr), "set up HDF5");
  return transfer;
}

Id NewSpace(const Shape& shape) {
  const int rank = static_cast<int>(shape.size());
  return {rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, Dims(shape), nullptr),
          H5Sclose, "describe an array"};
}

Id NewText(std::size_t bytes) {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose, "describe text");
  Check(H5Tset_size(type.get(), bytes), "describe text");
  Check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "describe text");
  if (bytes != H5T_VARIABLE) Check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "describe text");
  return type;
}

/// The types of HDF5 are made anew for each use: text needs a copy of its own.
Id FileType(Type type) {
  switch (type) {
    case Type::kInt8:
      return {H5Tcopy(H5T_STD_I8LE), H5Tclose, "describe numbers"};
    case Type::kInt32:
      return {H5Tcopy(H5T_STD_I32LE), H5Tclose, "describe numbers"};
    case Type::kFloat32:
      return {H5Tcopy(H5T_IEEE_F32LE), H5Tclose, "describe numbers"};
    case Type::kFloat64:
      return {H5Tcopy(H5T_IEEE_F64LE), H5Tclose, "describe numbers"};
    case Type::kText:
      break;
  }
  return NewText(H5T_VARIABLE);
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

Shape ShapeOf(const Id& space) {
  const int rank = Checked(H5Sget_simple_extent_ndims(space.get()), "read an array's shape");
  Shape shape(static_cast<std::size_t>(rank));
  if (rank > 0)
    Check(H5Sget_simple_extent_dims(space.get(), reinterpret_cast<hsize_t*>(shape.data()), nullptr),
          "read an array's shape");
  return shape;
}

/// Cut at the beginning of a UTF-8 character.
std::string_view Shortened(std::string_view text) {
  if (text.size() <= kLongestText) return text;
  std::size_t end = kLongestText;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end);
}

void WriteAttribute(const Id& object, const char* name, const Id& type, hid_t memory_type,
                    const Id& space, const void* data) {
  const std::string doing = fmt::format("write the attribute {}", name);
  const Id attribute(
      H5Acreate2(object.get(), name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      doing);
  Check(H5Awrite(attribute.get(), memory_type, data), doing);
}

/// Nothing where it is not text of fixed length.
std::string ReadTextAttribute(const Id& attribute) {
  const Id type(H5Aget_type(attribute.get()), H5Tclose, "read an attribute");
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0) return {};
  const Id space(H5Aget_space(attribute.get()), H5Sclose, "read an attribute");
  if (Product(ShapeOf(space)) != 1) return {};
  std::string text(H5Tget_size(type.get()), '\0');
  Check(H5Aread(attribute.get(), type.get(), text.data()), "read an attribute");
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

/// Library bounds that every reader since HDF5 1.8 understands.
void SetBounds(const Id& access) {
  Check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_EARLIEST, H5F_LIBVER_V18), "set up HDF5");
}

constexpr unsigned kCreationOrder = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;

Id FileCreation() {
  Id creation = NewProperties(H5P_FILE_CREATE);
  Check(H5Pset_link_creation_order(creation.get(), kCreationOrder), "set up HDF5");
  Check(H5Pset_attr_creation_order(creation.get(), kCreationOrder), "set up HDF5");
  return creation;
}

/// HDF5 takes files in memory for the same where their names are.
std::string UniqueName() {
  static std::atomic<std::uint64_t> next = 0;
  return fmt::format("cdb-in-memory-{}", next++);
}

}  // namespace

std::size_t ItemBytes(Type type) {
  switch (type) {
    case Type::kInt8:
      return 1;
    case Type::kInt32:
    case Type::kFloat32:
      return 4;
    case Type::kFloat64:
      return 8;
    case Type::kText:
      break;
  }
  return sizeof(hvl_t);
}

std::uint64_t Product(const Shape& shape) {
  std::uint64_t product = 1;
  for (const std::uint64_t n : shape) product *= n;
  return product;
}

// ---- identifiers and attributes -----------------------------------------------------------------

Id::Id(std::int64_t id, Close close, std::string_view doing) : id_(id), close_(close) {
  if (id < 0) Fail(doing);
}

Id::Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}

Id& Id::operator=(Id&& other) noexcept {
  if (this != &other) {
    Reset();
    id_ = std::exchange(other.id_, -1);
    close_ = other.close_;
  }
  return *this;
}

bool Id::Reset() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }

void Object::SetText(const char* name, std::string_view text) {
  text = Shortened(text);
  if (text.empty()) return;
  const Id type = NewText(text.size());
  WriteAttribute(id_, name, type, type.get(), NewSpace({}), text.data());
}

void Object::SetNumber(const char* name, Type type, double value) {
  WriteAttribute(id_, name, FileType(type), H5T_NATIVE_DOUBLE, NewSpace({}), &value);
}

void Object::SetNumbers(const char* name, Type type, std::span<const double> values) {
  WriteAttribute(id_, name, FileType(type), H5T_NATIVE_DOUBLE, NewSpace({values.size()}),
                 values.data());
}

std::string Object::Text(const char* name) const {
  if (H5Aexists(id_.get(), name) <= 0) return {};
  return ReadTextAttribute({H5Aopen(id_.get(), name, H5P_DEFAULT), H5Aclose,
                            fmt::format("read the attribute {}", name)});
}

double Object::Number(const char* name) const {
  double value = std::numeric_limits<double>::quiet_NaN();
  if (H5Aexists(id_.get(), name) <= 0) return value;
  const std::string doing = fmt::format("read the attribute {}", name);
  const Id attribute(H5Aopen(id_.get(), name, H5P_DEFAULT), H5Aclose, doing);
  const Id space(H5Aget_space(attribute.get()), H5Sclose, doing);
  if (Product(ShapeOf(space)) != 1) return value;
  Check(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value), doing);
  return value;
}

std::map<std::string, std::string> Object::Texts() const {
  std::map<std::string, std::string> texts;
  const auto visit = [](hid_t object, const char* name, const H5A_info_t*, void* out) -> herr_t {
    try {
      const Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose, "read an attribute");
      std::string text = ReadTextAttribute(attribute);
      if (!text.empty()) static_cast<decltype(texts)*>(out)->emplace(name, std::move(text));
      return 0;
    } catch (const std::exception&) {
      return -1;  // nothing may be thrown through HDF5
    }
  };
  Check(H5Aiterate2(id_.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, visit, &texts),
        "read the attributes");
  return texts;
}

// ---- datasets -----------------------------------------------------------------------------------

Dataset::Dataset(Id id) : Object(std::move(id)) {
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
  std::vector<double> values(Product(shape_));
  if (values.empty()) return values;
  Check(H5Dread(id_.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, Transfer(values.size()).get(),
                values.data()),
        "read an array");
  return values;
}

std::vector<std::string> Dataset::ReadText() const {
  if (type_ != Type::kText) throw Error("it holds numbers where text should be");
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
  std::vector<double> values(Product(count));
  if (values.empty()) return values;
  const Id file_space(H5Dget_space(id_.get()), H5Sclose, "read an array's shape");
  Check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, Dims(start), nullptr, Dims(count),
                            nullptr),
        "find a part of an array");
  const Id memory_space = NewSpace({values.size()});
  Check(H5Dread(id_.get(), H5T_NATIVE_DOUBLE, memory_space.get(), file_space.get(),
                Transfer(values.size()).get(), values.data()),
        "read an array");
  return values;
}

void Dataset::Write(const Shape& start, const Shape& count, std::span<const double> values) {
  if (values.size() != Product(count)) throw Error("an array of another size");
  if (values.empty()) return;
  const Id file_space(H5Dget_space(id_.get()), H5Sclose, "read an array's shape");
  Check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, Dims(start), nullptr, Dims(count),
                            nullptr),
        "find a part of an array");
  const Id memory_space = NewSpace({values.size()});
  Check(H5Dwrite(id_.get(), H5T_NATIVE_DOUBLE, memory_space.get(), file_space.get(),
                 Transfer(values.size()).get(), values.data()),
        "write an array");
}

void Dataset::Write(const Shape& start, const Shape& count, const std::byte* data,
                    const Shape& data_shape) {
  if (Product(count) == 0) return;
  const Id file_space(H5Dget_space(id_.get()), H5Sclose, "read an array's shape");
  Check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, Dims(start), nullptr, Dims(count),
                            nullptr),
        "find a part of an array");
  const Id memory_space = NewSpace(data_shape);
  const Shape origin(data_shape.size(), 0);
  Check(H5Sselect_hyperslab(memory_space.get(), H5S_SELECT_SET, Dims(origin), nullptr, Dims(count),
                            nullptr),
        "find a part of an array");
  Check(H5Dwrite(id_.get(), FileType(type_).get(), memory_space.get(), file_space.get(),
                 H5P_DEFAULT, data),
        "write an array");
}

bool Dataset::ReadChunk(const Shape& start, RawChunk& chunk) const {
  hsize_t bytes = 0;
  unsigned mask = 0;
  haddr_t address = HADDR_UNDEF;
  Check(H5Dget_chunk_info_by_coord(id_.get(), Dims(start), &mask, &address, &bytes),
        "find a chunk");
  if (address == HADDR_UNDEF || bytes == 0) return false;
  chunk.bytes.resize(bytes);
  Check(H5Dread_chunk(id_.get(), H5P_DEFAULT, Dims(start), &chunk.filter_mask, chunk.bytes.data()),
        "read a chunk");
  return true;
}

void Dataset::WriteChunk(const Shape& start, const RawChunk& chunk) {
  Check(H5Dwrite_chunk(id_.get(), H5P_DEFAULT, chunk.filter_mask, Dims(start), chunk.bytes.size(),
                       chunk.bytes.data()),
        "write a chunk");
}

void Dataset::MakeScale(const std::string& name) {
  Check(H5DSset_scale(id_.get(), name.c_str()), "make a dimension scale");
}

// ---- groups -------------------------------------------------------------------------------------

bool Group::Has(const std::string& name) const {
  return H5Lexists(id_.get(), name.c_str(), H5P_DEFAULT) > 0;
}

Dataset Group::OpenDataset(const std::string& name) const {
  return Dataset(Id(H5Dopen2(id_.get(), name.c_str(), H5P_DEFAULT), H5Dclose,
                    fmt::format("open the array {}", name)));
}

Dataset Group::CreateDataset(const DatasetSpec& spec) {
  const Id creation = NewProperties(H5P_DATASET_CREATE);
  Check(H5Pset_attr_creation_order(creation.get(), kCreationOrder), "set up HDF5");
  Check(H5Pset_attr_phase_change(creation.get(), kMostCompact, 0), "set up HDF5");
  if (!spec.chunk.empty()) {
    Check(H5Pset_chunk(creation.get(), static_cast<int>(spec.chunk.size()), Dims(spec.chunk)),
          "set up chunks");
    Check(H5Pset_shuffle(creation.get()), "set up compression");
    Check(H5Pset_deflate(creation.get(), kCompression), "set up compression");
  }
  if (spec.type != Type::kText)
    Check(H5Pset_fill_value(creation.get(), H5T_NATIVE_DOUBLE, &spec.fill), "set the fill value");
  return Dataset(
      Id(H5Dcreate2(id_.get(), spec.name.c_str(), FileType(spec.type).get(),
                    NewSpace(spec.shape).get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
         H5Dclose, fmt::format("make the array {}", spec.name)));
}

Group Group::OpenGroup(const std::string& name) const {
  return Group(Id(H5Gopen2(id_.get(), name.c_str(), H5P_DEFAULT), H5Gclose,
                  fmt::format("open the group {}", name)));
}

Group Group::CreateGroup(const std::string& name) {
  const Id creation = NewProperties(H5P_GROUP_CREATE);
  Check(H5Pset_link_creation_order(creation.get(), kCreationOrder), "set up HDF5");
  Check(H5Pset_attr_creation_order(creation.get(), kCreationOrder), "set up HDF5");
  return Group(Id(H5Gcreate2(id_.get(), name.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                  H5Gclose, fmt::format("make the group {}", name)));
}

void Group::AttachScales(const std::vector<Attachment>& attachments) {
  // The two attributes of the dimension scale specification, as H5DSattach_scale writes them: each
  // dataset names its scales, each scale names its datasets.
  struct BackReference {
    hobj_ref_t dataset;
    int dimension;
  };
  const auto refer = [this](const std::string& name) {
    hobj_ref_t reference = 0;
    Check(H5Rcreate(&reference, id_.get(), name.c_str(), H5R_OBJECT, -1), "refer to an array");
    return reference;
  };
  const auto attach = [this](const std::string& name, const char* attribute, const Id& type,
                             std::size_t count, const void* data) {
    const Id dataset(H5Dopen2(id_.get(), name.c_str(), H5P_DEFAULT), H5Dclose, "open an array");
    WriteAttribute(dataset, attribute, type, type.get(), NewSpace({count}), data);
  };
  const Id list_type(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose, "describe references");
  std::map<std::string, hobj_ref_t> scales;
  std::map<std::string, std::vector<BackReference>> back;
  for (const Attachment& attachment : attachments) {
    if (attachment.scales.empty()) continue;
    const hobj_ref_t dataset = refer(attachment.dataset);
    std::vector<hvl_t> list;
    for (const std::string& scale : attachment.scales) {
      auto [found, is_new] = scales.try_emplace(scale);
      if (is_new) found->second = refer(scale);
      back[scale].push_back({dataset, static_cast<int>(list.size())});
      list.push_back({1, &found->second});
    }
    attach(attachment.dataset, "DIMENSION_LIST", list_type, list.size(), list.data());
  }
  const Id back_type(H5Tcreate(H5T_COMPOUND, sizeof(BackReference)), H5Tclose,
                     "describe references");
  Check(H5Tinsert(back_type.get(), "dataset", HOFFSET(BackReference, dataset), H5T_STD_REF_OBJ),
        "describe references");
  Check(H5Tinsert(back_type.get(), "dimension", HOFFSET(BackReference, dimension), H5T_NATIVE_INT),
        "describe references");
  for (const auto& [scale, references] : back)
    attach(scale, "REFERENCE_LIST", back_type, references.size(), references.data());
}

void Group::AttachScalesLate(const Attachment& attachment) {
  const auto open = [this](const std::string& name) {
    return Id(H5Dopen2(id_.get(), name.c_str(), H5P_DEFAULT), H5Dclose, "open an array");
  };
  const Id dataset = open(attachment.dataset);
  for (std::size_t i = 0; i < attachment.scales.size(); ++i)
    Check(
        H5DSattach_scale(dataset.get(), open(attachment.scales[i]).get(), static_cast<unsigned>(i)),
        "attach a dimension scale");
}

// ---- files --------------------------------------------------------------------------------------

File::File(Id file, std::shared_ptr<Sink> sink)
    : Group(Id(H5Gopen2(file.get(), "/", H5P_DEFAULT), H5Gclose, "open the root of the file")),
      sink_(std::move(sink)),
      file_(std::move(file)) {}

File::~File() { id_.Reset(); }

File File::CreateInMemory() {
  BeQuiet();
  const Id access = NewProperties(H5P_FILE_ACCESS);
  SetBounds(access);
  Check(H5Pset_fapl_core(access.get(), 1 << 18, false), "set up HDF5");
  return File(Id(H5Fcreate(UniqueName().c_str(), H5F_ACC_TRUNC, FileCreation().get(), access.get()),
                 H5Fclose, "make a file in memory"));
}

File File::Create(const std::filesystem::path& path) {
  BeQuiet();
  auto sink = std::make_shared<Sink>(path);
  sink->Check();
  const Id access = NewProperties(H5P_FILE_ACCESS);
  SetBounds(access);
  Check(SetSink(access.get(), sink), "set up HDF5");
  Id file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, FileCreation().get(), access.get()), H5Fclose,
          "make the file");
  return File(std::move(file), std::move(sink));
}

File File::Open(const std::filesystem::path& path) {
  BeQuiet();
  return File(Id(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "open it"));
}

File File::OpenImage(std::span<const std::byte> image) {
  BeQuiet();
  const Id access = NewProperties(H5P_FILE_ACCESS);
  Check(H5Pset_fapl_core(access.get(), 1 << 16, false), "set up HDF5");
  // HDF5 copies the image and does not change this one.
  Check(H5Pset_file_image(access.get(), const_cast<std::byte*>(image.data()), image.size()),
        "set up HDF5");
  return File(Id(H5Fopen(UniqueName().c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose, "open it"));
}

std::vector<std::byte> File::Image() {
  Check(H5Fflush(file_.get(), H5F_SCOPE_LOCAL), "write the file");
  const ssize_t bytes = Checked(H5Fget_file_image(file_.get(), nullptr, 0), "write the file");
  std::vector<std::byte> image(static_cast<std::size_t>(bytes));
  Checked(H5Fget_file_image(file_.get(), image.data(), image.size()), "write the file");
  return image;
}

void File::CheckWritten() const {
  if (sink_ != nullptr) sink_->Check();
}

void File::Close() {
  Check(H5Fflush(file_.get(), H5F_SCOPE_LOCAL), "write the file");
  id_.Reset();
  if (!file_.Reset()) Fail("write the file");
  if (sink_ != nullptr) sink_->Close();
  CheckWritten();
}

}  // namespace cdb::hdf5
