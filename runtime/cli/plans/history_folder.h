// A folder of results files over time (`cdb history`), and the cache in it, so that only new files
// are read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/figures/history/histories.h"

namespace cdb::plans {

/// The cache in the folder: a line with the SHA-256 of the rest, then JSON. A file counts as
/// unchanged if its size and the time of its last change are those in the cache. A cache that is
/// damaged, or of another version of cdb, is made anew.
inline constexpr const char* kHistoryCache = ".history.json";

struct HistoryFolder {
  struct LeftOut {
    std::string file, why;
  };
  std::vector<history::FileFigures> files;  ///< by name
  std::vector<LeftOut> left_out;            ///< damaged, or not readable
  std::size_t read = 0;                     ///< number of files that were not in the cache
  std::string cache_trouble;                ///< why the cache was not written; may be empty
};

/// Reads the results files in the folder and in folders below it, except `.runs` and hidden ones.
/// Throws StoreError if it is not a folder.
HistoryFolder ReadHistoryFolder(const std::filesystem::path& folder);

}  // namespace cdb::plans
