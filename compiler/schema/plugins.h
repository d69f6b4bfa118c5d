// Detectors of a user's shared library, as named in scenarios and plans.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/catalogue.h"

namespace cdb::schema {

struct PluginDetector {
  std::string name;
  std::string phases;            ///< as in the catalogue: `broad`, `narrow`, `broad narrow`
  std::uint64_t max_bodies = 0;  ///< walls included; 0 means no limit
  std::string path;              ///< of the library, as reached from its scenario file
  std::string sha256;            ///< of the library: another file is another detector
  bool operator==(const PluginDetector&) const = default;
};

/// The possible phases of a detector in a library.
inline constexpr std::string_view kPluginPhases[] = {"broad", "narrow", "broad narrow"};

/// The row of the catalogue, or the entry in `plugins`; nullopt if neither has the name. Its texts
/// live as long as `plugins`.
std::optional<DetectorInfo> FindDetector(std::string_view name,
                                         std::span<const PluginDetector> plugins);

}  // namespace cdb::schema
