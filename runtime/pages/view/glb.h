// A run as binary glTF 2.0, for other programs: meshes, a material for each object group, a node
// for each body, and its motion as an animation.
// Source: Khronos, glTF 2.0 specification, 2021.
#pragma once

#include <string>

#include "runtime/pages/view/selection.h"

namespace cdb::view {

/// The bytes of a .glb file. Axes and units are those of the scene, which glTF shares: y up, m, s.
/// Time 0 is the first frame; a pose is held until the next frame. A body without a finite pose
/// stays at its last one. Numbers are float32.
std::string SceneGlb(const SceneRecording& recording);

}  // namespace cdb::view
