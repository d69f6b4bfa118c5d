#include "compiler/plan/kept_files.h"

#include <sys/stat.h>

#include <atomic>

namespace cdb::plan {
namespace {

std::atomic<std::uint64_t> g_kept_bytes{0};

std::int64_t Nanoseconds(const timespec& time) {
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

void KeepFiles(std::uint64_t bytes) { g_kept_bytes = bytes; }
std::uint64_t KeptBytes() { return g_kept_bytes; }

std::optional<FileStamp> FileStamp::Of(const std::string& path) {
  if (path.ends_with(".gltf")) return std::nullopt;  // one of several files (gltf_buffers.h)
  struct stat found = {};
  if (stat(path.c_str(), &found) != 0) return std::nullopt;
  return FileStamp{found.st_dev, found.st_ino, static_cast<std::uint64_t>(found.st_size),
                   Nanoseconds(found.st_mtim), Nanoseconds(found.st_ctim)};
}

}  // namespace cdb::plan
