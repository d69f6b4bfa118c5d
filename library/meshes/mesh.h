// Triangle meshes as read from files. topology.h checks whether a mesh bounds a solid.
//
// Lengths in the file's own unit. Faces are counter-clockwise as seen from outside.
// Errors: SceneError, with the file, the line or byte, the cause and the remedy.
// Threads: any; no function here keeps anything.
// Sources: OBJ, Wavefront's "Advanced Visualizer" appendix B1; PLY, Turk 1994; STL, 3D Systems
// 1989; OFF, Geomview's manual.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::meshes {

using Triangle = std::array<std::uint32_t, 3>;  ///< indices of vertices

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
  bool operator==(const Mesh&) const = default;
};

/// Reads OBJ, PLY (ASCII and both binary), STL (ASCII and binary) or OFF, told apart by the name's
/// extension. Polygons become fans about their first corner. Colours, normals and textures are not
/// read; what would change the surface and is not understood is refused. STL knows no shared
/// vertices, so equal ones are merged.
Mesh ReadMesh(const std::filesystem::path& file);
/// The bytes of such a file.
std::string ReadMeshFile(const std::filesystem::path& file);
/// The same from memory; `name` stands for the file.
Mesh ParseMesh(std::string_view bytes, std::string_view name);

/// Makes one of vertices that are equal to the last bit. Triangles that lose a corner by it are
/// dropped: their two remaining edges are opposite, so that what was closed stays closed.
Mesh MergeEqualVertices(const Mesh& mesh);

/// The corners of a triangle.
inline std::array<Eigen::Vector3d, 3> CornersOf(const Mesh& mesh, const Triangle& triangle) {
  return {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]]};
}

/// Larger files, numbers and meshes are refused: their volumes and moments would overflow, or they
/// are not what they say.
inline constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;
inline constexpr std::size_t kMaxVertices = 10'000'000;
inline constexpr std::size_t kMaxTriangles = 20'000'000;
inline constexpr double kLargestCoordinate = 1e15;

}  // namespace cdb::meshes
