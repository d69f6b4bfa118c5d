// The plans of the standard suite.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/figures/compare.h"
#include "runtime/figures/suite.h"
#include "runtime/printers/suite.h"

namespace cdb::plans {

/// The choices for a run of the suite. Cycles, repeats and seeds are fixed.
struct SuiteChoice {
  bool is_long = false;                    ///< kLongRepeats, and the seeds of kLongSeeds
  std::optional<std::uint64_t> seed = {};  ///< a fresh seed in place of the published ones
  /// Detectors in addition to those of the suite, in scenes that sweep detectors. Their contacts
  /// are their own, or Bullet's if they have no narrow phase.
  std::vector<std::string> detectors = {};
  std::vector<std::string> plugins = {};  ///< libraries that contain them
};

inline constexpr std::uint64_t kLongRepeats = 11;
inline constexpr std::uint64_t kLongSeeds[] = {0xAAAAAAAAAA, 1, 2};

/// The plan of a scene of the library of scenarios; files in the current folder are ignored. Throws
/// CommandError, also if the library has no such scene.
plan::Plan StandardPlan(const figures::StandardScene& scene, const SuiteChoice& choice);

// A folder of results of the standard suite: reading, summary and check.

inline constexpr const char* kSuiteSummary = "suite.json";
inline constexpr const char* kSuitePage = "suite.html";

struct SuiteFolder {
  std::vector<std::unique_ptr<figures::ComparedFile>> files;  ///< in the order of the suite
  std::vector<figures::SceneFigures> scenes;                  ///< of each file
  printers::SuiteFacts facts;
};
/// Reads the results that exist. Throws StoreError, and CommandError for a folder without results
/// of the suite.
SuiteFolder ReadSuiteFolder(const std::filesystem::path& folder);

/// Throws CommandError if the summary in the folder names another version of the suite than this
/// one.
void RequireThisVersion(const std::filesystem::path& folder);

/// SHA-256 of the bytes of a file. Throws CommandError if it cannot be read.
std::string FileSha256(const std::filesystem::path& file);

/// The version of the suite that the text of a summary names.
std::optional<int> VersionOf(const std::string& summary);

/// The text of suite.json.
std::string SuiteSummary(const SuiteFolder& read);
/// Writes suite.json and suite.html. Throws StoreError, and, in a build without pages, PageError
/// after suite.json has been written.
void WriteSuiteSummary(const SuiteFolder& read, const std::filesystem::path& folder);

/// Whether the figures and facts of two summaries are equal. Sentences, which may be those of
/// another version of cdb, need not be the same, but one has them where the other does.
bool HasFiguresOf(const std::string& summary, const std::string& other);

/// The reasons why results of the suite are not complete or not comparable; empty if there are
/// none.
struct SuiteFaults {
  std::vector<std::string> faults;
  std::vector<std::string> facts;  ///< about machine, build and noise, to be read by people
};
/// In addition to `cdb check` of each file. Throws StoreError, CommandError.
SuiteFaults CheckSuite(const SuiteFolder& read, const std::filesystem::path& folder);

}  // namespace cdb::plans
