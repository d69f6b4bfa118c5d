// Any bytes, read as a mesh of each format: the result is an error that names the file, or a mesh.
// A mesh gives an error, or a solid whose volume, centre and hull are finite.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsl/text/check.h"
#include "library/meshes/convex_hull.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/mesh.h"
#include "library/meshes/topology.h"
#include "library/scene_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string name : {"fuzz.obj", "fuzz.off", "fuzz.ply", "fuzz.stl"}) try {
      const meshes::Mesh mesh = meshes::ParseMesh(bytes, name);
      CDB_CHECK(!mesh.vertices.empty());
      for (const Eigen::Vector3d& vertex : mesh.vertices) CDB_CHECK(vertex.allFinite());
      for (const meshes::Triangle& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle) CDB_CHECK(vertex < mesh.vertices.size());
      // Closing holes must not damage a closed mesh, and must fail only with an error.
      try {
        meshes::CloseHoles(mesh, name);
      } catch (const library::SceneError&) {
      }
      const meshes::Mesh solid = meshes::Watertight(mesh, name);
      CDB_CHECK(meshes::Watertight(solid, name) == solid);
      const meshes::MassProperties mass = meshes::MassPropertiesOf(solid);
      CDB_CHECK(mass.volume > 0 && mass.centre.allFinite() && mass.inertia.allFinite());
      if (const auto hull = meshes::TryConvexHull(solid.vertices))
        CDB_CHECK(meshes::SignedVolume(meshes::Watertight(meshes::SurfaceOf(*hull), name)) > 0);
    } catch (const library::SceneError& error) {
      CDB_CHECK(std::string_view(error.what()).starts_with(name) ||
                std::string_view(error.what()).starts_with("Qhull"));
    }
  return 0;
}
