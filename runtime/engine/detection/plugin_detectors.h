// Detectors of a plug-in. Each call is recorded, so that the message about a crash or a hang names
// it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "compiler/plan/plan.h"
#include "library/detectors/plugin.h"

namespace cdb::detection {

/// During its lifetime, calls into plug-ins are recorded in `place` (RecordingHeader::plugin_call).
/// Only one may exist at a time.
class NotesPluginCalls {
 public:
  explicit NotesPluginCalls(std::atomic<std::uint32_t>& place);
  ~NotesPluginCalls();
  NotesPluginCalls(const NotesPluginCalls&) = delete;
  NotesPluginCalls& operator=(const NotesPluginCalls&) = delete;
};

/// Loads the library of plug-in `index` of the scene, after checking its hash. Throws
/// library::SceneError if the file does not exist, has changed, or is refused by LoadPlugin.
detectors::LoadedDetector LoadPluginDetector(const plan::Scene& scene, std::size_t index);

/// Makes its detector. Returns null or throws if its function does.
std::unique_ptr<Detector> MakePluginDetector(std::size_t index,
                                             const detectors::LoadedDetector& loaded,
                                             const Options& options);

}  // namespace cdb::detection
