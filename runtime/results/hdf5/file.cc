#include "runtime/results/hdf5/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "compiler/plan/input_file.h"
#include "runtime/results/hdf5/calls.h"
#include "runtime/results/hdf5/dataset.h"

namespace cdb::hdf5 {
namespace {

constexpr unsigned kCompression = 1;
/// Links and attributes of an object are kept in its header: faster and smaller than HDF5's dense
/// form.
constexpr unsigned kMostCompact = 1 << 12;

/// Call before any other HDF5 function in a thread. HDF5 prints every error to stderr by default,
/// and its exit handler closes open objects. The only one left would be a file that failed to
/// close, on which the handler crashes.
void SetUpLibrary() {
  [[maybe_unused]] static const herr_t no_exit_handler = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// Links and attributes of a group, in the order of creation.
void SetUpGroup(const Id& creation) {
  Check(H5Pset_link_creation_order(creation.get(), kCreationOrder), "set up HDF5");
  Check(H5Pset_link_phase_change(creation.get(), kMostCompact, 0), "set up HDF5");
  Check(H5Pset_attr_creation_order(creation.get(), kCreationOrder), "set up HDF5");
  Check(H5Pset_attr_phase_change(creation.get(), kMostCompact, 0), "set up HDF5");
}

Id FileCreation() {
  Id creation = NewProperties(H5P_FILE_CREATE);
  SetUpGroup(creation);
  return creation;
}

}  // namespace

bool Group::Has(const std::string& name) const {
  return H5Lexists(id_.get(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Group::MemberNames() const {
  H5G_info_t info = {};
  Check(H5Gget_info(id_.get(), &info), "list a group");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const auto name_by_index = [&](char* name, std::size_t bytes) {
      return Checked(H5Lget_name_by_idx(id_.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name, bytes,
                                        H5P_DEFAULT),
                     "list a group");
    };
    std::string name(static_cast<std::size_t>(name_by_index(nullptr, 0)), '\0');
    name_by_index(name.data(), name.size() + 1);
    names.push_back(std::move(name));
  }
  return names;
}

Dataset Group::OpenDataset(const std::string& name) const {
  Id id(H5Dopen2(id_.get(), name.c_str(), H5P_DEFAULT), H5Dclose,
        fmt::format("open the array {}", name));
  try {
    return Dataset(std::move(id), foreign_bytes_);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", name, error.what()));
  }
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
    Check(H5Pset_fletcher32(creation.get()), "set up checksums");
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
                  fmt::format("open the group {}", name)),
               foreign_bytes_);
}

Group Group::CreateGroup(const std::string& name) {
  const Id creation = NewProperties(H5P_GROUP_CREATE);
  SetUpGroup(creation);
  return Group(Id(H5Gcreate2(id_.get(), name.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                  H5Gclose, fmt::format("make the group {}", name)));
}

void Group::AttachScales(const std::vector<Attachment>& attachments) {
  // The two attributes of the dimension scale specification, as written by H5DSattach_scale: each
  // dataset names its scales, and each scale names its datasets.
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

Group::Names Group::List() const {
  if (foreign_bytes_ > 0) CheckLinks(id_);
  Names names;
  const auto visit = [](hid_t group, const char* name, const H5L_info_t*, void* out) -> herr_t {
    try {
      const Id object(H5Oopen(group, name, H5P_DEFAULT), H5Oclose, "open what is in a group");
      const H5I_type_t type = H5Iget_type(object.get());
      if (type != H5I_DATASET && type != H5I_GROUP) return -1;
      Names& all = *static_cast<Names*>(out);
      (type == H5I_DATASET ? all.datasets : all.groups).emplace_back(name);
      return 0;
    } catch (const std::exception&) {
      return -1;  // exceptions must not pass through HDF5
    }
  };
  Check(H5Literate(id_.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, visit, &names),
        "read what is in a group");
  return names;
}

File::File(Id file, std::shared_ptr<Sink> sink, std::uint64_t foreign_bytes)
    : Group(Id(H5Gopen2(file.get(), "/", H5P_DEFAULT), H5Gclose, "open the root of the file"),
            foreign_bytes),
      sink_(std::move(sink)),
      file_(std::move(file)) {}

bool IsHdf5(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  constexpr std::string_view kBegin = "\x89HDF\r\n\x1a\n";
  char begin[kBegin.size()] = {};
  std::ifstream(path, std::ios::binary).read(begin, sizeof(begin));
  return std::string_view(begin, sizeof(begin)) == kBegin;
}

File::~File() { id_.Reset(); }

File File::Create(const std::filesystem::path& path) {
  SetUpLibrary();
  auto sink = std::make_shared<Sink>(path);
  sink->Check();
  const Id access = NewProperties(H5P_FILE_ACCESS);
  // Every reader since HDF5 1.8 understands the file.
  Check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_EARLIEST, H5F_LIBVER_V18), "set up HDF5");
  Check(SetSink(access.get(), sink), "set up HDF5");
  Id file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, FileCreation().get(), access.get()), H5Fclose,
          "make the file");
  return File(std::move(file), std::move(sink));
}

File File::Open(const std::filesystem::path& path) {
  SetUpLibrary();
  CloseBackdoors();
  if (const std::string why = plan::WhyNotReadable(path); !why.empty()) throw Error(why);
  const Id access = NewProperties(H5P_FILE_ACCESS);
  // Files get their final names only when they are complete, so HDF5's locks would add nothing, and
  // a network file system may not support them.
  Check(H5Pset_file_locking(access.get(), false, true), "set up HDF5");
  Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose, "open it");
  hsize_t bytes = 0;
  Check(H5Fget_filesize(file.get(), &bytes), "read the length of the file");
  return File(std::move(file), nullptr, std::max<std::uint64_t>(bytes, 1));
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

void SplitEvenly(Shape& chunk, std::size_t i, std::size_t item_bytes) {
  std::uint64_t& n = chunk[i];
  const std::uint64_t others = Product(chunk) / n * item_bytes;
  const std::uint64_t most = std::max<std::uint64_t>(1, kLargestChunk / others);
  const std::uint64_t pieces = (n + most - 1) / most;
  n = (n + pieces - 1) / pieces;
}

namespace {

struct DriverFile {
  H5FD_t base;  // first: HDF5 accesses a DriverFile through it
  std::shared_ptr<Sink>* sink;
  haddr_t allocated;
};

Sink& SinkOf(const H5FD_t* file) { return **reinterpret_cast<const DriverFile*>(file)->sink; }

H5FD_t* OpenDriver(const char*, unsigned, hid_t access, haddr_t) {
  const auto* sink = static_cast<std::shared_ptr<Sink>* const*>(H5Pget_driver_info(access));
  if (sink == nullptr) return nullptr;
  auto* file = new DriverFile{};
  file->sink = new std::shared_ptr<Sink>(**sink);
  return &file->base;
}

herr_t CloseDriver(H5FD_t* base) {
  auto* file = reinterpret_cast<DriverFile*>(base);
  delete file->sink;
  delete file;
  return 0;
}

herr_t QueryDriver(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t GetAllocated(const H5FD_t* file, H5FD_mem_t) {
  return reinterpret_cast<const DriverFile*>(file)->allocated;
}

herr_t SetAllocated(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  reinterpret_cast<DriverFile*>(file)->allocated = address;
  return 0;
}

haddr_t GetEnd(const H5FD_t* file, H5FD_mem_t) { return SinkOf(file).end(); }

herr_t ReadDriver(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t bytes, void* out) {
  return SinkOf(file).Read(address, bytes, static_cast<char*>(out)) ? 0 : -1;
}

herr_t WriteDriver(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t bytes,
                   const void* data) {
  SinkOf(file).Write(address, bytes, static_cast<const char*>(data));
  return 0;
}

herr_t TruncateDriver(H5FD_t* file, hid_t, hbool_t) {
  SinkOf(file).Truncate(GetAllocated(file, H5FD_MEM_DEFAULT));
  return 0;
}

constexpr H5FD_class_t MakeDriver() {
  H5FD_class_t driver = {};
#ifdef H5FD_CLASS_VERSION  // HDF5 1.14 checks it; 1.10 has no such member
  driver.version = H5FD_CLASS_VERSION;
#endif
  driver.name = "cdb";
  driver.maxaddr = (haddr_t{1} << 62) - 1;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.fapl_size = sizeof(std::shared_ptr<Sink>*);
  driver.open = OpenDriver;
  driver.close = CloseDriver;
  driver.query = QueryDriver;
  driver.get_eoa = GetAllocated;
  driver.set_eoa = SetAllocated;
  driver.get_eof = GetEnd;
  driver.read = ReadDriver;
  driver.write = WriteDriver;
  driver.truncate = TruncateDriver;
  constexpr H5FD_mem_t kMap[] = H5FD_FLMAP_DICHOTOMY;
  std::ranges::copy(kMap, driver.fl_map);
  return driver;
}
constexpr H5FD_class_t kDriver = MakeDriver();

}  // namespace

Sink::Sink(const std::filesystem::path& path)
    : fd_(open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
  if (fd_ < 0) error_ = errno;
}

void Sink::Check() const {
  if (error_ != 0) throw Error("cannot write the file: " + std::generic_category().message(error_));
}

void Sink::Close() {
  if (fd_ >= 0 && close(std::exchange(fd_, -1)) != 0 && error_ == 0) error_ = errno;
}

bool Sink::Read(std::uint64_t address, std::size_t bytes, char* out) const {
  while (bytes > 0) {
    const ssize_t n = pread(fd_, out, bytes, static_cast<off_t>(address));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) std::fill_n(out, bytes, '\0');
    if (n == 0) return true;
    out += n;
    address += static_cast<std::uint64_t>(n);
    bytes -= static_cast<std::size_t>(n);
  }
  return true;
}

void Sink::Write(std::uint64_t address, std::size_t bytes, const char* data) {
  end_ = std::max(end_, address + bytes);
  while (bytes > 0 && error_ == 0) {
    const ssize_t n = pwrite(fd_, data, bytes, static_cast<off_t>(address));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) error_ = errno;
    if (n < 0) return;
    data += n;
    address += static_cast<std::uint64_t>(n);
    bytes -= static_cast<std::size_t>(n);
  }
}

void Sink::Truncate(std::uint64_t size) {
  end_ = size;
  if (error_ == 0 && ftruncate(fd_, static_cast<off_t>(size)) != 0) error_ = errno;
}

int SetSink(std::int64_t access, const std::shared_ptr<Sink>& sink) {
  static const hid_t kDriverId = H5FDregister(&kDriver);
  const std::shared_ptr<Sink>* info = &sink;
  return H5Pset_driver(access, kDriverId, &info);
}

}  // namespace cdb::hdf5
