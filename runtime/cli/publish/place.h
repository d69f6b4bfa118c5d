// A place of published results (publish.h): the folders of many machines, each checked anew, and
// the page of them all.
//
// Results of different versions of the suite are never compared. Those of another version than
// this one cannot be computed again here: their figures are those of their `suite.json`, and the
// page says so.
//
// Threads: one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/cli/publish/signature.h"

namespace cdb::publish {

inline constexpr const char* kPlacePage = "index.html";

/// The claims of an entry, verified by the results of another one, as `cdb suite --against` does.
struct Verification {
  enum class Outcome {
    kAgrees,
    kPartly,       ///< what could be compared agrees, but some scores could not
    kNotCompared,  ///< a scene could not be compared
    kDisagrees,
  };
  std::string by;  ///< name of the other entry
  Outcome outcome = Outcome::kNotCompared;
  /// Scenes that were compared, and those in which every run ended in the same state.
  std::size_t scenes = 0, same_states = 0;
  std::vector<std::string> reasons = {};  ///< `stiff/stack: steps_240: speedup 1.90, here 1.40`
};

struct PlaceEntry {
  std::string name;
  std::optional<int> version = {};  ///< of the suite; nullopt if it cannot be read
  Signature signature = {};
  std::vector<std::string> faults = {};  ///< reasons why its figures are not shown; empty for most
  /// suite.json: computed from the results, or for another version as it is published.
  std::string summary = {};
  std::vector<Verification> verified = {};  ///< by each other entry of this version
};

struct Place {
  std::vector<PlaceEntry> entries;                            ///< in the order of their names
  std::vector<std::pair<std::string, std::string>> left_out;  ///< a folder, and why
};

/// Throws CommandError if the folder cannot be read or has no published results.
Place ReadPlace(const std::filesystem::path& folder);

/// Writes index.html, which depends on nothing but the published folders and this cdb. Throws
/// PageError, StoreError.
void WritePlacePage(const Place& place, const std::filesystem::path& folder);

}  // namespace cdb::publish
