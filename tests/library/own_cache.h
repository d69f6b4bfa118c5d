// A cache of its own for a test, so that what is tested is computed and not found.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>

namespace cdb::tests {

/// An empty folder, named by CDB_CACHE while it lives. One at a time.
class OwnCache {
 public:
  OwnCache() {
    std::string name = (std::filesystem::temp_directory_path() / "cdb-cache-XXXXXX").string();
    folder_ = mkdtemp(name.data());
    if (const char* before = std::getenv("CDB_CACHE")) before_ = before;
    setenv("CDB_CACHE", folder_.c_str(), 1);
  }
  ~OwnCache() {
    std::filesystem::remove_all(folder_);
    if (before_.empty()) {
      unsetenv("CDB_CACHE");
    } else {
      setenv("CDB_CACHE", before_.c_str(), 1);
    }
  }
  OwnCache(const OwnCache&) = delete;
  OwnCache& operator=(const OwnCache&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::string before_;
};

}  // namespace cdb::tests
