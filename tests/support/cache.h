// An empty cache for a test, so that decompositions are computed, not found.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/files.h"

namespace cdb::tests {

/// An empty folder that CDB_CACHE names while this lives. Only one at a time.
class TemporaryCache {
 public:
  TemporaryCache() {
    if (const char* before = std::getenv("CDB_CACHE")) before_ = before;
    setenv("CDB_CACHE", folder_.path().c_str(), 1);
  }
  ~TemporaryCache() {
    if (before_.empty()) {
      unsetenv("CDB_CACHE");
    } else {
      setenv("CDB_CACHE", before_.c_str(), 1);
    }
  }
  TemporaryCache(const TemporaryCache&) = delete;
  TemporaryCache& operator=(const TemporaryCache&) = delete;

  const std::filesystem::path& folder() const { return folder_.path(); }
  /// The files in it.
  std::vector<std::filesystem::path> Entries() const {
    std::vector<std::filesystem::path> entries;
    for (const std::string& name : FilesIn(folder())) entries.push_back(folder() / name);
    return entries;
  }

 private:
  TemporaryFolder folder_;
  std::string before_;
};

}  // namespace cdb::tests
