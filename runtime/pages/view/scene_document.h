// The document that the page of `cdb view` draws: one or two runs as JSON.
//
// Arrays are base64 (packing.h). For each run: `meshes`; `parts` with a row of `place` (scale,
// rotation x y z w, offset along y) for each; `bodies`; `frames`: positions as float32,
// orientations as three words; `contacts` and `boxes`, null where they were not recorded; and the
// series of all cycles. runtime/pages/page/view/recording.js reads it.
#pragma once

#include <span>
#include <string>

#include "runtime/pages/view/scene_recording.h"

namespace cdb::view {

/// Always valid UTF-8, even if names are not.
std::string SceneDocument(const std::string& title, std::span<const SceneRecording> recordings);

}  // namespace cdb::view
