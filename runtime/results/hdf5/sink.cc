#include "runtime/results/hdf5/sink.h"

#include <fcntl.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "runtime/results/hdf5/file.h"

namespace cdb::hdf5 {
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
