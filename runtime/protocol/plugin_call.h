// Records the function of a plug-in that a worker is executing, to report the place of a crash or
// hang.
#pragma once

#include <cstdint>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::protocol {

enum class PluginCall : std::uint32_t {
  kNone,
  kLoad,
  kMake,
  kPrepare,
  kFindPairs,
  kHandles,
  kFindContacts,
  kDestroy
};

/// Encodes a call into the plug-in `index` of a scene; 0 for none.
std::uint32_t PluginCallCode(PluginCall call, std::size_t index);

/// `FindPairs of detector `mine` (libmine.so)`; empty for none, and for a code damaged by a crash.
std::string PluginCallText(std::uint32_t code, const plan::Scene& scene);

}  // namespace cdb::protocol
