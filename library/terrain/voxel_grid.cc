#include "library/terrain/voxel_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "compiler/plan/foreign_model.h"
#include "library/terrain/height_formats.h"
#include "library/terrain/voxel_formats.h"

namespace cdb::terrain {
namespace {

using Eigen::Vector3d;

constexpr double kLargestPlace = 1e9;  ///< m; farther away, single precision has no cells

struct VoxelReader {
  std::string_view extension;
  VoxelGrid (*read)(std::string_view bytes, std::string_view name, const VoxelOptions& options);
};
constexpr VoxelReader kVoxelReaders[] = {{".raw", ReadRaw},
                                         {".binvox", ReadBinvox},
                                         {".npy", ReadNpy},
                                         {".ply", ReadPlyPoints},
                                         {".pcd", ReadPcd}};
static_assert(std::ranges::equal(kVoxelReaders, plan::kVoxelFormats, {}, &VoxelReader::extension));

VoxelGrid ReadVoxels(std::string_view bytes, std::string_view name, const VoxelOptions& options) {
  std::string extension = std::filesystem::path(name).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  try {
    const auto* const format = std::ranges::find(kVoxelReaders, extension, &VoxelReader::extension);
    if (format == std::end(kVoxelReaders))
      RefuseFile(name, "unknown format", "its name ends in .raw, .binvox, .npy, .ply or .pcd");
    const bool has_counts =
        std::ranges::any_of(options.counts, [](const auto& count) { return count.has_value(); });
    if (has_counts && format->read != ReadRaw)
      RefuseFile(name, "columns, rows and layers are for .raw files; this one states its own",
                 "remove them");
    return format->read(bytes, name, options);
  } catch (const library::SceneError&) {
    const auto [kind, remedy] = plan::ForeignVoxelsOf(name, bytes);
    if (kind.empty()) throw;
    RefuseFile(name, fmt::format("is {}", kind), remedy);
  }
}

/// Turns (x, y, z) to (x, z, -y).
VoxelGrid WithYUp(const VoxelGrid& grid) {
  const auto [columns, rows, layers] = grid.counts;
  VoxelGrid turned{{columns, layers, rows}, {}, {}, grid.cell};
  turned.lower = {grid.lower.x(), grid.lower.z(),
                  -(grid.lower.y() + static_cast<double>(rows) * grid.cell)};
  turned.solid.reserve(grid.solid.size());
  for (std::int64_t row = rows - 1; row >= 0; --row)
    for (std::int64_t layer = 0; layer < layers; ++layer)
      for (std::int64_t column = 0; column < columns; ++column)
        turned.solid.push_back(grid.IsSolid({column, row, layer}));
  return turned;
}

/// Calls `visit(cell, axis, is_upper)` for each face of a solid cell beside an empty one, until it
/// returns false.
void ForFaces(const VoxelGrid& grid, auto visit) {
  Cell at;
  for (at[2] = 0; at[2] < grid.counts[2]; ++at[2])
    for (at[1] = 0; at[1] < grid.counts[1]; ++at[1])
      for (at[0] = 0; at[0] < grid.counts[0]; ++at[0]) {
        if (!grid.IsSolid(at)) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (const bool is_upper : {false, true}) {
            Cell beside = at;
            beside[axis] += is_upper ? 1 : -1;
            if (!grid.IsSolid(beside) && !visit(at, axis, is_upper)) return;
          }
      }
}

}  // namespace

bool VoxelGrid::Contains(const Vector3d& point) const {
  Cell at;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double place = std::floor((point[axis] - lower[axis]) / cell);
    if (!(place >= 0 && place < static_cast<double>(counts[i]))) return false;
    at[i] = static_cast<std::int64_t>(place);
  }
  return IsSolid(at);
}

std::size_t VoxelGrid::SolidCount() const {
  return static_cast<std::size_t>(std::ranges::count(solid, true));
}

VoxelGrid ParseVoxels(std::string_view bytes, std::string_view name, const VoxelOptions& options) {
  VoxelGrid grid = ReadVoxels(bytes, name, options);
  const Vector3d upper = grid.lower + grid.cell * Vector3d(static_cast<double>(grid.counts[0]),
                                                           static_cast<double>(grid.counts[1]),
                                                           static_cast<double>(grid.counts[2]));
  if (!(grid.cell > 0 && grid.lower.cwiseAbs().maxCoeff() <= kLargestPlace &&
        upper.cwiseAbs().maxCoeff() <= kLargestPlace))
    RefuseFile(name,
               fmt::format("its cells of {:g} m are not within {:g} m of the origin", grid.cell,
                           kLargestPlace),
               "give another `cell`, or move it to the origin");
  return options.is_z_up ? WithYUp(grid) : grid;
}

meshes::Mesh SurfaceOf(const VoxelGrid& grid, std::string_view name, std::size_t most) {
  std::size_t faces = 0;
  ForFaces(grid, [&](const Cell&, std::size_t, bool) { return 2 * ++faces <= most; });
  if (2 * faces > most)
    RefuseFile(name,
               fmt::format("the surface of its {} solid cells has more than {} triangles",
                           grid.SolidCount(), most),
               "make the cells larger, or take a part of the file");
  meshes::Mesh mesh;
  mesh.vertices.reserve(4 * faces);
  mesh.triangles.reserve(2 * faces);
  ForFaces(grid, [&](const Cell& cell, std::size_t axis, bool is_upper) {
    constexpr std::array<std::array<int, 2>, 4> kAround = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t i = 0; i < 4; ++i) {
      const auto& [right, up] = kAround[is_upper ? i : 3 - i];
      Cell corner = cell;
      corner[axis] += is_upper;
      corner[(axis + 1) % 3] += right;
      corner[(axis + 2) % 3] += up;
      Vector3d vertex;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto along = static_cast<Eigen::Index>(k);
        vertex[along] = grid.lower[along] + static_cast<double>(corner[k]) * grid.cell;
      }
      mesh.vertices.push_back(vertex);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
    return true;
  });
  return mesh;
}

}  // namespace cdb::terrain
