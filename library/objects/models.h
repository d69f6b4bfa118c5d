// The well-known models that a scene can name, and how they become solids. Their files are not in
// the repository; library/meshes/fetch-models downloads them.
//
// Each stands along y, in the unit of its file. The Stanford models: "The Stanford 3D Scanning
// Repository", for research, with credit, not for sale; bunny and armadillo as distributed by CGAL,
// watertight. The Utah teapot: Newell 1975, public domain, as in npm's `teapot`: three open sheets
// (body with handle, spout, lid). CloseHoles caps its five holes; its parts overlap one another, so
// that mass properties count 0.5 % of its volume twice.
// Errors: SceneError that names the command to run. Threads: any.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::objects {

struct Model {
  std::string_view name;    ///< its name in a scene
  std::string_view file;    ///< its name in the folder of models
  std::string_view credit;  ///< its author and source
  bool has_holes = false;   ///< to be closed with CloseHoles
};
std::span<const Model> Models();
/// Null if there is none with this name.
const Model* FindModel(std::string_view name);

/// The folders in which models are searched for, in order: `$CDB_MODELS` alone if it is set,
/// otherwise `models` beside the program and `../share/cdb/models` relative to it.
std::vector<std::filesystem::path> ModelFolders();

/// The file of the model in the first folder that contains it.
std::filesystem::path PathOf(const Model& model, std::span<const std::filesystem::path> folders);

/// The model from the bytes of its file, as Watertight returns it; `name` is the name of the file.
meshes::Mesh ParseModel(const Model& model, std::string_view bytes, const std::string& name);
/// The same from the file.
meshes::Mesh LoadModel(const Model& model, std::span<const std::filesystem::path> folders);

/// The number of times that this process has read the file of a model, a mesh or a surface for
/// SolidFactory or ReadModel. With plan::KeepFiles, a file is read again only if it has changed.
std::size_t ModelReadings();

}  // namespace cdb::objects
