#include "runtime/protocol/plugin_call.h"

#include <iterator>

namespace cdb::protocol {
namespace {

constexpr const char* kNames[] = {
    "",           "loading",         "making",    "Prepare of", "FindPairs of",
    "Handles of", "FindContacts of", "destroying"};
constexpr std::uint32_t kCalls = std::size(kNames);

}  // namespace

std::uint32_t PluginCallCode(PluginCall call, std::size_t index) {
  return static_cast<std::uint32_t>(index) * kCalls + static_cast<std::uint32_t>(call);
}

std::string PluginCallText(std::uint32_t code, const plan::Scene& scene) {
  const std::uint32_t call = code % kCalls, index = code / kCalls;
  if (call == 0 || index >= scene.plugins.size()) return {};
  const schema::PluginDetector& plugin = scene.plugins[index];
  return std::string(kNames[call]) + " detector `" + plugin.name + "` (" + plugin.path + ")";
}

}  // namespace cdb::protocol
