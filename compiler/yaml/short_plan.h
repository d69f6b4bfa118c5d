// The short form of a plan that is too long to be listed: the source texts, and the hash that the
// compiled plan must have.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::yaml {

/// The key of the format version, which identifies a short plan.
inline constexpr std::string_view kShortPlanFormat = "cdb_short_plan";

struct ShortPlan {
  std::string benchmark;
  std::string sha256;                ///< of the whole plan
  std::uint64_t runs = 0;            ///< of the whole plan
  std::string source;                ///< the scenario file, as the user named it
  std::string file;                  ///< the scenario file, as a key of `files`
  std::string library;               ///< folder in which files were searched for; may be empty
  std::vector<std::string> plugins;  ///< shared libraries of the command line
  std::map<std::string, std::string> files;  ///< texts of scenario files by their paths
  bool operator==(const ShortPlan&) const = default;
};

std::string ToYaml(const ShortPlan& plan);

/// Nullopt if the text is something else, such as a plan that lists its runs. Throws PlanError for
/// a short plan of another version or a damaged one; `name` is for messages.
std::optional<ShortPlan> FindShortPlan(const std::string& text, const std::string& name);

/// Throws PlanError if the format of the plan `name`, in either form, is not one from `oldest` to
/// kPlanVersion.
void CheckPlanVersion(std::uint64_t version, int oldest, const std::string& name);

// A few facts about each run of a plan in YAML, without parsing all of it: for reports on results,
// whose plans are long.

struct BriefRun {
  std::string id;
  std::vector<std::size_t> at;
  std::string detector, narrow_phase;
  std::uint64_t objects = 0;  ///< of all groups
  bool is_on_trace = false;
};

/// The runs of `yaml`, a plan written by ToYaml; nullopt for a plan of another version and for any
/// other text (FromYaml gives the reason). Nothing is checked: ids may not match their runs.
std::optional<std::vector<BriefRun>> FindBriefRuns(std::string_view yaml);

}  // namespace cdb::yaml
