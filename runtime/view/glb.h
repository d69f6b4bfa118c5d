// A run as binary glTF 2.0, which other programs open: meshes, a material for each object group, a
// node for each body, and its motion as an animation.
// Source: Khronos, glTF 2.0 specification, 2021.
#pragma once

#include <string>

#include "runtime/view/scene_recording.h"

namespace cdb::view {

/// The bytes of a .glb file. Axes and units are those of the scene, which glTF shares: y up, m, s.
/// Time 0 is the first frame; poses are held until the next frame. A body that has no finite pose
/// stays where it last had one. Numbers are float32.
std::string SceneGlb(const SceneRecording& recording);

}  // namespace cdb::view
