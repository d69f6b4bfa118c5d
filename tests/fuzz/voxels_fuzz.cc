// Any bytes, read as voxels of each format: the result is an error that names the file, or a grid
// with solid cells and a closed surface.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsl/text/check.h"
#include "library/scene_error.h"
#include "library/terrain/voxel_grid.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  constexpr std::size_t kMostTriangles = 100'000;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string name : {"fuzz.raw", "fuzz.binvox", "fuzz.npy", "fuzz.ply", "fuzz.pcd"}) {
    terrain::VoxelOptions options{.is_z_up = size % 2 == 0, .cell = 0.5};
    if (name == "fuzz.raw") options.counts = {4, 3, size / 12};
    try {
      const terrain::VoxelGrid grid = terrain::ParseVoxels(bytes, name, options);
      const auto [columns, rows, layers] = grid.counts;
      CDB_CHECK(columns >= 1 && rows >= 1 && layers >= 1);
      CDB_CHECK(grid.solid.size() == static_cast<std::size_t>(columns * rows * layers));
      CDB_CHECK(grid.lower.allFinite() && grid.cell == 0.5 && grid.SolidCount() > 0);
      const meshes::Mesh mesh = terrain::SurfaceOf(grid, name, kMostTriangles);
      CDB_CHECK(mesh.triangles.size() >= 12 && mesh.triangles.size() <= kMostTriangles);
      for (const Eigen::Vector3d& vertex : mesh.vertices) CDB_CHECK(vertex.allFinite());
    } catch (const library::SceneError& error) {
      CDB_CHECK(std::string_view(error.what()).starts_with(name));
    }
  }
  return 0;
}
