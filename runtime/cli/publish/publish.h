// Published results of the standard suite (`cdb suite --publish PLACE`): a folder in PLACE for each
// set of results, with the results files, `suite.json` and a digest of them all. PLACE is kept by
// its owners, in git for example; the folders are all that a page of many machines is built from
// (place.h).
//
// Threads: one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/cli/plans/suite_plan.h"

namespace cdb::publish {

/// True if the folder claims to be published: it has a digest.
bool IsPublished(const std::filesystem::path& folder);

/// Results of the suite that were checked as `cdb suite --check` does, with every value read, and
/// as published ones if they are.
struct CheckedResults {
  plans::SuiteFolder read;
  std::string summary;  ///< suite.json, computed from the results
  std::vector<std::string> faults, facts;
};
/// Throws StoreError for damaged files, CommandError for a folder without results.
CheckedResults CheckResults(const std::filesystem::path& folder);

/// Throws CommandError if the folder is published and its files are not those of its digest.
void RequireAsPublished(const std::filesystem::path& folder);

/// `intel-xeon-gold-6230-cdb-0.1.0-1f2e3d4c5b6a`: the processor, the version of cdb, and the
/// first digits of a digest of the results files.
std::string NameOf(const plans::SuiteFolder& read);

struct Published {
  enum class Outcome {
    kNew,
    kSigned,     ///< it was there, and has been signed now
    kUnchanged,  ///< it was there
  };
  Outcome outcome = Outcome::kNew;
  std::filesystem::path folder;
  std::size_t files = 0;
  double bytes = 0;
};

/// Copies checked results from `folder` to `place`, which is made if necessary, and signs them with
/// `key` unless that is empty. The new folder has its name only when it is complete; the same
/// results are not published twice. Throws CommandError if a folder of this name has other
/// contents, or a signature by another key.
Published Publish(const CheckedResults& results, const std::filesystem::path& folder,
                  const std::filesystem::path& place, const std::string& key);

}  // namespace cdb::publish
