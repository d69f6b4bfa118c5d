// Any bytes, imported as the format that they resemble: whatever becomes of the importer, the
// result is an error that names the file, or a mesh that is valid in itself.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsl/text/check.h"
#include "library/meshes/mesh.h"
#include "library/scene_error.h"

namespace {

std::string_view ExtensionOf(std::string_view bytes) {
  constexpr std::string_view kSigns[][2] = {{"glTF", ".glb"},  {"{", ".gltf"}, {"PK", ".3mf"},
                                            {"; FBX", ".fbx"}, {"xof", ".x"},  {"AC3D", ".ac"},
                                            {"MM", ".3ds"}};
  for (const auto& [start, extension] : kSigns)
    if (bytes.starts_with(start)) return extension;
  if (bytes.find("<amf") != bytes.npos) return ".amf";
  return bytes.find("<X3D") != bytes.npos ? ".x3d" : ".dae";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::string name = "fuzz" + std::string(ExtensionOf(bytes));
  try {
    const meshes::Mesh mesh = meshes::ParseMesh(bytes, name);
    CDB_CHECK(!mesh.vertices.empty());
    for (const Eigen::Vector3d& vertex : mesh.vertices) CDB_CHECK(vertex.allFinite());
    for (const meshes::Triangle& triangle : mesh.triangles)
      for (const std::uint32_t vertex : triangle) CDB_CHECK(vertex < mesh.vertices.size());
  } catch (const library::SceneError& error) {
    CDB_CHECK(std::string_view(error.what()).starts_with(name));
  }
  return 0;
}
