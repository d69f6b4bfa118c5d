// A few facts about each run of a plan in YAML, without parsing all of it: for reports on results,
// whose plans are long.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::yaml {

struct BriefRun {
  std::string id;
  std::vector<std::size_t> at;
  std::string detector;
  std::uint64_t objects = 0;  ///< of all groups
};

/// The runs of `yaml`, a plan written by ToYaml; nullopt for a plan of another version and for any
/// other text (FromYaml gives the reason). Nothing is checked: ids may not match their runs.
std::optional<std::vector<BriefRun>> FindBriefRuns(std::string_view yaml);

}  // namespace cdb::yaml
