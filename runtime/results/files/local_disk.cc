#include "runtime/results/files/local_disk.h"

#include <linux/magic.h>
#include <sys/vfs.h>

#include <algorithm>
#include <iterator>

namespace cdb::files {
namespace {

#ifndef XFS_SUPER_MAGIC
constexpr long XFS_SUPER_MAGIC = 0x58465342;  // statfs(2)
#endif
constexpr long kLocal[] = {EXT4_SUPER_MAGIC, XFS_SUPER_MAGIC,       BTRFS_SUPER_MAGIC,
                           TMPFS_MAGIC,      OVERLAYFS_SUPER_MAGIC, F2FS_SUPER_MAGIC};

}  // namespace

bool IsOnLocalDisk(const std::filesystem::path& path) {
  struct statfs status = {};
  return statfs(path.c_str(), &status) == 0 &&
         std::ranges::find(kLocal, static_cast<long>(status.f_type)) != std::end(kLocal);
}

}  // namespace cdb::files
