#include "runtime/results/files/safe_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "compiler/plan/descriptor.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/results/files/errors.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/files/temporary_file.h"

namespace cdb::files {
namespace {

namespace fs = std::filesystem;

std::string ErrorText(int error) { return std::generic_category().message(error); }

}  // namespace

void RequireFolder(const fs::path& folder, std::string_view use) {
  struct stat status = {};
  const int error = stat(folder.c_str(), &status) != 0 ? errno
                    : S_ISDIR(status.st_mode)          ? 0
                                                       : ENOTDIR;
  if (error == 0) return;
  throw StoreError(
      fmt::format("{}: the folder of {} cannot be used: {}; nothing was written: {}",
                  folder.string(), use, ErrorText(error),
                  error == ENOENT ? "make it, or choose another (-o)" : "choose another (-o)"));
}

void WriteWhole(std::string_view text, const fs::path& final_name) {
  WritePieces([text](const auto& write) { write(text); }, final_name);
}

void WritePieces(const std::function<void(const std::function<void(std::string_view)>&)>& fill,
                 const fs::path& final_name) {
  RemoveStaleTemporariesBeside(final_name);
  TemporaryFile file(final_name);
  fill([&](std::string_view piece) {
    if (!protocol::TryWriteAll(file.fd(), std::as_bytes(std::span(piece))))
      file.Fail("write it", errno);
  });
  file.Publish();
}

}  // namespace cdb::files
