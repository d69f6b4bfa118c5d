// Pages of results for a browser, as `cdb report` and `cdb compare --page` write them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace cdb::cli {

struct PageDocuments {
  std::string title;
  std::string json;           ///< results documents, separated by commas
  std::size_t bad_count = 0;  ///< number of runs that failed or are void
};

/// `baseline`, `only_sound`: as for printers::ResultsDocument. Throws StoreError.
PageDocuments ReadPageDocuments(const std::vector<std::string>& files,
                                const std::string& baseline = {}, bool only_sound = false);

/// Writes the page `name`, whose data are `json`, prints its name, and opens it in a browser if
/// `opens`. Throws PageError, StoreError, and CommandError if `name` is one of `files`, which a
/// page must never replace.
void WriteReportPage(const std::string& name, const std::string& title, const std::string& json,
                     const std::vector<std::string>& files, bool opens = false);

}  // namespace cdb::cli
