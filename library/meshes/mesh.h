// Triangle meshes as read from files. topology.h checks whether a mesh bounds a solid.
//
// Lengths in the unit of the file. Faces are counter-clockwise as seen from outside.
// Errors: SceneError, with the file, the line or byte, the cause and the remedy.
// Threads: any; the functions have no state.
// Sources: OBJ, Wavefront's "Advanced Visualizer" appendix B1; PLY, Turk 1994; STL, 3D Systems
// 1989; OFF, Geomview's manual.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::meshes {

using Triangle = std::array<std::uint32_t, 3>;  ///< indices of vertices

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
  std::string left_out = {};  ///< parts of an imported file that are not in the mesh, for messages
  bool operator==(const Mesh&) const = default;
};

/// Reads OBJ, PLY (ASCII and both binary forms), STL (ASCII and binary), OFF, or a format of
/// library/meshes/import.h, selected by the extension of the name. Polygons become triangles
/// (library/meshes/polygon.h). Colours, normals and textures are ignored, and bytes after the end
/// of PLY and STL; unknown content that would change the surface is an error. STL and imported
/// formats have no shared vertices, so equal ones are merged. A file may have vertices alone, for a
/// convex hull.
Mesh ReadMesh(const std::filesystem::path& file);
/// The bytes of such a file, and of the files of data that a .gltf file names
/// (compiler/plan/gltf_buffers.h).
std::string ReadMeshFile(const std::filesystem::path& file);
/// The same from memory; `name` is the name of the file, for messages.
Mesh ParseMesh(std::string_view bytes, std::string_view name);

/// By triangle, the number of its connected part, from 0; triangles are connected by vertices.
std::vector<std::uint32_t> ConnectedParts(const Mesh& mesh);

/// The parts of a file, each as a mesh: the groups of an OBJ file, if it has several, otherwise
/// the connected parts of the mesh. At most `most`.
std::vector<Mesh> ParseParts(std::string_view bytes, std::string_view name, std::size_t most);

/// Merges vertices that are equal to the last bit. Triangles that lose a corner by that are
/// dropped: their two remaining edges are opposite, so that a closed mesh stays closed.
Mesh MergeEqualVertices(const Mesh& mesh);

/// Merges those of the given vertices that are closer than `distance` along each axis, or are
/// connected by such vertices; triangles are dropped as above.
Mesh MergeCloseVertices(const Mesh& mesh, std::span<const std::uint32_t> vertices, double distance);

/// The part of a mesh that has these of its triangles, with their vertices in the same order.
Mesh SubMesh(const Mesh& mesh, std::span<const Triangle> triangles);

/// The corners of a triangle.
inline std::array<Eigen::Vector3d, 3> CornersOf(const Mesh& mesh, const Triangle& triangle) {
  return {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]]};
}

/// Larger files, numbers and meshes are rejected: their volumes and moments would overflow, or
/// their contents are not what they claim.
inline constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;
inline constexpr std::size_t kMaxVertices = 10'000'000;
inline constexpr std::size_t kMaxTriangles = 20'000'000;
inline constexpr double kLargestCoordinate = 1e15;

}  // namespace cdb::meshes
