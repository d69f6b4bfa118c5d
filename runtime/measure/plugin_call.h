// Records which function of a plug-in a worker is executing, to report where it crashed or hung.
#pragma once

#include <cstdint>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::measure {

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

/// A call into the plug-in `index` of a scene, in a number; 0 for none.
std::uint32_t PluginCallCode(PluginCall call, std::size_t index);

/// FindPairs of detector `mine` (libmine.so); empty for none, and for what a crash left there.
std::string PluginCallText(std::uint32_t code, const plan::Scene& scene);

}  // namespace cdb::measure
