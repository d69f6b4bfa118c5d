// A few facts of each run of a plan that was written as YAML, without reading all of it: for
// reports on results, whose plans are long.
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

/// The runs of `yaml`, a plan as ToYaml writes it; nullopt for one of another version, and for any
/// other text (FromYaml tells why). Nothing is checked: ids may not be those of their runs.
std::optional<std::vector<BriefRun>> FindBriefRuns(std::string_view yaml);

}  // namespace cdb::yaml
