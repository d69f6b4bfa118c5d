// Detectors of a plug-in. Each call is recorded, so that the message about a crash or a hang names
// it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "compiler/plan/plan.h"
#include "library/detectors/detector.h"

namespace cdb::detection {

/// While it lives, calls into plug-ins are noted in `place` (RecordingHeader::plugin_call), not
/// elsewhere. One at a time.
class NotesPluginCalls {
 public:
  explicit NotesPluginCalls(std::atomic<std::uint32_t>& place);
  ~NotesPluginCalls();
  NotesPluginCalls(const NotesPluginCalls&) = delete;
  NotesPluginCalls& operator=(const NotesPluginCalls&) = delete;
};

/// Loads the library of plug-in `index` of the scene, once it has the hash of the plan. Throws
/// library::SceneError for a file that is not there or was changed, and for one that LoadPlugin
/// refuses.
const DetectorEntry& LoadPluginDetector(const plan::Scene& scene, std::size_t index);

/// Its detector; null, or thrown, is what the entry's function returns or throws.
std::unique_ptr<Detector> MakePluginDetector(std::size_t index, const DetectorEntry& entry,
                                             const Options& options);

}  // namespace cdb::detection
