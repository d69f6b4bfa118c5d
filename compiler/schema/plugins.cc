#include "compiler/schema/plugins.h"

#include <algorithm>

namespace cdb::schema {

std::optional<DetectorInfo> FindDetector(std::string_view name,
                                         std::span<const PluginDetector> plugins) {
  if (const DetectorInfo* row = FindDetector(name)) return *row;
  const auto plugin = std::ranges::find(plugins, name, &PluginDetector::name);
  if (plugin == plugins.end()) return std::nullopt;
  DetectorInfo info{};
  info.name = plugin->name;
  info.source = plugin->path;
  info.phases = plugin->phases;
  info.max_bodies = plugin->max_bodies;
  return info;
}

}  // namespace cdb::schema
