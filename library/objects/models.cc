#include "library/objects/models.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "dsl/text/check.h"
#include "library/meshes/topology.h"
#include "library/scene_error.h"

namespace cdb::objects {
namespace {

namespace fs = std::filesystem;

// The files that fetch-models writes.
constexpr Model kModels[] = {
    {"bunny", "bunny.off", "Stanford Computer Graphics Laboratory", false},
    {"armadillo", "armadillo.off", "Stanford Computer Graphics Laboratory", false},
    {"teapot", "teapot.obj", "Martin Newell, University of Utah", true},
};

}  // namespace

std::span<const Model> Models() { return kModels; }

const Model* FindModel(std::string_view name) {
  const auto model = std::find_if(std::begin(kModels), std::end(kModels),
                                  [&](const Model& m) { return m.name == name; });
  return model == std::end(kModels) ? nullptr : model;
}

std::vector<fs::path> ModelFolders() {
  if (const char* folder = std::getenv("CDB_MODELS"); folder != nullptr && *folder != '\0')
    return {folder};
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error)
    throw library::SceneError(fmt::format("models: set CDB_MODELS; /proc: {}", error.message()));
  const fs::path folder = program.parent_path();
  return {folder / "models", folder.parent_path() / "share" / "cdb" / "models"};
}

namespace {

/// An installed copy has the script beside its folder of models.
std::string HowToFetch(std::span<const fs::path> folders) {
  for (const fs::path& folder : folders) {
    const fs::path script = folder.parent_path() / "fetch-models";
    std::error_code error;
    if (fs::exists(script, error))
      return fmt::format("run: '{}' '{}'", script.string(), folder.string());
  }
  return fmt::format("in cdb's source folder run: library/meshes/fetch-models '{}'",
                     folders[0].string());
}

}  // namespace

fs::path PathOf(const Model& model, std::span<const fs::path> folders) {
  CDB_CHECK(!folders.empty());
  std::string looked;
  for (const fs::path& folder : folders) {
    std::error_code error;
    if (fs::exists(folder / model.file, error)) return folder / model.file;
    looked += fmt::format("{}{}", looked.empty() ? "" : " and ", folder.string());
  }
  throw library::SceneError(
      fmt::format("the model `{}` is not on this machine (looked for {} in {}); {} {}", model.name,
                  model.file, looked, HowToFetch(folders), model.name));
}

meshes::Mesh ParseModel(const Model& model, std::string_view bytes, const std::string& name) {
  const meshes::Mesh mesh = meshes::ParseMesh(bytes, name);
  return meshes::Watertight(model.has_holes ? meshes::CloseHoles(mesh, name) : mesh, name);
}

meshes::Mesh LoadModel(const Model& model, std::span<const fs::path> folders) {
  const fs::path file = PathOf(model, folders);
  return ParseModel(model, meshes::ReadMeshFile(file), file.string());
}

}  // namespace cdb::objects
