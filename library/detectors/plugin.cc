#include "library/detectors/plugin.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>

#include "library/detectors/floating_point.h"

namespace cdb::detectors {

namespace {

bool IsName(std::string_view text) {
  const auto is_word = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !text.empty() && !(text[0] >= '0' && text[0] <= '9') && std::ranges::all_of(text, is_word);
}

}  // namespace

void CheckAbi(std::uint32_t abi, const std::string& path) {
  if (abi != kDetectorAbi)
    throw PluginError(
        fmt::format("'{}' was built for detector interface {}, but this cdb has {}; rebuild it "
                    "with this cdb's cdb/detector.h",
                    path, abi, kDetectorAbi));
}

void CheckName(std::string_view name, const std::string& shown, const std::string& path) {
  if (!IsName(name))
    throw PluginError(
        fmt::format("'{}' calls a detector '{}', which is not a name in .cdb files; a name "
                    "consists of letters, digits and _, and does not begin with a digit",
                    path, shown));
}

void RefuseBuild(const std::string& build, const std::string& path) {
  throw PluginError(
      fmt::format("'{}' was built with {}, but this cdb with {}; build it with the same compiler",
                  path, build, DetectorBuild()));
}

const Plugin& LoadPlugin(const std::string& path) {
  // The initializers of libraries linked with -ffast-math flush denormals to zero.
  const KeepsFloatingPoint keeps;
  // A name without a slash would be searched for in the system's folders.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw PluginError(fmt::format("cannot load '{}': {}", path, dlerror()));
  const auto get = reinterpret_cast<const Plugin* (*)()>(dlsym(handle, "cdb_plugin"));
  if (get == nullptr)
    throw PluginError(
        fmt::format("'{}' has no detectors: it has no function cdb_plugin; write CDB_DETECTORS "
                    "once in it (cdb/detector.h)",
                    path));
  const Plugin* plugin = get();
  if (plugin == nullptr) throw PluginError(fmt::format("'{}': cdb_plugin returns nothing", path));
  CheckAbi(plugin->abi, path);
  if (plugin->build == nullptr || std::string_view(plugin->build) != DetectorBuild())
    RefuseBuild(plugin->build == nullptr ? "nothing named" : plugin->build, path);
  if (plugin->entries == nullptr || plugin->count == 0)
    throw PluginError(fmt::format("'{}' has no detectors: its array is empty", path));
  const std::span entries(plugin->entries, plugin->count);
  for (const DetectorEntry& entry : entries) {
    if (entry.name == nullptr || entry.doc == nullptr || entry.make == nullptr ||
        !HasAny(entry.phases, kBroad | kNarrow))
      throw PluginError(
          fmt::format("'{}' has a detector without name, line, phase or function", path));
    CheckName(entry.name, entry.name, path);
    if (FindEntry(*plugin, entry.name) != &entry)
      throw PluginError(fmt::format("'{}' has two detectors called '{}'", path, entry.name));
  }
  return *plugin;
}

const DetectorEntry* FindEntry(const Plugin& plugin, std::string_view name) {
  for (const DetectorEntry& entry : std::span(plugin.entries, plugin.count))
    if (name == entry.name) return &entry;
  return nullptr;
}

}  // namespace cdb::detectors
