// The figures of the standard suite as JSON, for `suite.json` and the page (`cdb doc suite`).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/suite/figures.h"

namespace cdb::suite {

/// Facts about a folder of results, other than its figures.
struct SuiteFacts {
  bool is_long = false;
  std::optional<std::uint64_t> seed;          ///< a fresh seed in place of the published ones
  std::vector<std::string> missing;           ///< ids of scenes without results
  std::map<std::string, std::string> sha256;  ///< of each results file, by its name
};

/// UTF-8, with a newline. `files`: the results of `scenes`, in the same order. Throws StoreError.
std::string SuiteJson(const std::vector<SceneFigures>& scenes,
                      const std::vector<const store::ResultFile*>& files, const SuiteFacts& facts);

}  // namespace cdb::suite
