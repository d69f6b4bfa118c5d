// The well-known models that a scene can name: their files, and how they become solids. They are
// not in the repository; library/meshes/fetch-models downloads them.
//
// Each stands along y, in the unit of its file. The Stanford models: "The Stanford 3D Scanning
// Repository", for research, with credit, not for sale; bunny and armadillo as CGAL ships them,
// watertight. The Utah teapot: Newell 1975, public domain, as npm's `teapot` has it: three open
// sheets (body with handle, spout, lid). CloseHoles caps its five holes; its parts reach into one
// another, so that mass properties count 0.5 % of its volume twice.
// Errors: SceneError that says what to run. Threads: any.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct Model {
  std::string_view name;    ///< what a scene calls it
  std::string_view file;    ///< in the folder of models
  std::string_view credit;  ///< whose it is
  bool has_holes = false;   ///< to be closed with CloseHoles
};
std::span<const Model> Models();
/// Null where there is none.
const Model* FindModel(std::string_view name);

/// Where models are looked for, the first that has it first: `$CDB_MODELS` alone where it is set,
/// else `models` beside the program and `../share/cdb/models` from there.
std::vector<std::filesystem::path> ModelFolders();

/// The model's file in the first of the folders that has it.
std::filesystem::path PathOf(const Model& model, std::span<const std::filesystem::path> folders);

/// Of the file's bytes, the model as Watertight gives it; `name` stands for the file.
Mesh ParseModel(const Model& model, std::string_view bytes, const std::string& name);
/// The same of the file.
Mesh LoadModel(const Model& model, std::span<const std::filesystem::path> folders);

}  // namespace cdb::meshes
