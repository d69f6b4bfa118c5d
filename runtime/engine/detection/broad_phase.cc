#include "runtime/engine/detection/broad_phase.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/schema/catalogue.h"
#include "library/scene_error.h"
#include "runtime/engine/detection/detectors.h"

namespace cdb::detection {

std::unique_ptr<btBroadphaseInterface> MakeBroadPhase(const BroadPhaseOptions& options) {
  const schema::DetectorInfo* info = schema::FindDetector(options.detector);
  if (info != nullptr) CheckHolds(options.detector, info->max_bodies, options.bodies);
  // All of them write past their arrays when a body comes too many.
  const auto capacity = static_cast<unsigned>(std::max<std::size_t>(options.bodies, 1));
  if (options.detector == "dbvt") return std::make_unique<btDbvtBroadphase>();
  if (options.detector == "simple")
    return std::make_unique<btSimpleBroadphase>(static_cast<int>(capacity));
  if (options.detector == "sap")
    return std::make_unique<btAxisSweep3>(options.lower, options.upper,
                                          static_cast<unsigned short>(capacity), nullptr,
                                          !options.raycast_tree);
  if (options.detector == "sap32")
    return std::make_unique<bt32BitAxisSweep3>(options.lower, options.upper, capacity, nullptr,
                                               !options.raycast_tree);
  throw library::SceneError(
      fmt::format("detector `{}` does not exist in this version", options.detector));
}

}  // namespace cdb::detection
