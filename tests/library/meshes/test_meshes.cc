#include "tests/library/meshes/test_meshes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

template <typename Word>
void Put(Word word, bool big_endian, std::string& bytes) {
  for (std::size_t i = 0; i < sizeof word; ++i)
    bytes += static_cast<char>(word >> 8 * (big_endian ? sizeof word - 1 - i : i) & 0xff);
}

}  // namespace

meshes::Mesh BoxMesh(const Vector3d& low, const Vector3d& high) {
  meshes::Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                               i & 4 ? high.z() : low.z());
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

meshes::Mesh SphereMesh(double radius, int halvings) {
  meshes::Mesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < halvings; ++i) {
    meshes::Mesh next{mesh.vertices, {}};
    for (const auto& [a, b, c] : mesh.triangles) {
      const auto middle = [&](std::uint32_t from, std::uint32_t to) {
        // The lower index first, so that both triangles of an edge round the same way.
        const Vector3d sum = mesh.vertices[std::min(from, to)] + mesh.vertices[std::max(from, to)];
        next.vertices.push_back(sum.normalized());
        return static_cast<std::uint32_t>(next.vertices.size() - 1);
      };
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      next.triangles.insert(next.triangles.end(),
                            {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh = meshes::MergeEqualVertices(next);
  }
  for (Vector3d& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

meshes::Mesh AngleMesh() {
  // A hexagon of area 3, counter-clockwise about z, and a copy of it one unit above.
  const double corners[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  meshes::Mesh mesh;
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : corners) mesh.vertices.emplace_back(x, y, z);
  for (std::uint32_t i = 1; i < 5; ++i) {
    mesh.triangles.push_back({6, i + 6, i + 7});
    mesh.triangles.push_back({0, i + 1, i});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t k = (i + 1) % 6;
    mesh.triangles.push_back({i, k, k + 6});
    mesh.triangles.push_back({i, k + 6, i + 6});
  }
  return mesh;
}

meshes::Mesh Joined(const meshes::Mesh& a, const meshes::Mesh& b) {
  meshes::Mesh joined = a;
  joined.vertices.insert(joined.vertices.end(), b.vertices.begin(), b.vertices.end());
  const auto base = static_cast<std::uint32_t>(a.vertices.size());
  for (const meshes::Triangle& t : b.triangles)
    joined.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  return joined;
}

meshes::Mesh InsideOut(meshes::Mesh mesh) {
  for (meshes::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

meshes::Mesh Moved(meshes::Mesh mesh, const Eigen::Matrix3d& matrix, const Vector3d& by) {
  for (Vector3d& vertex : mesh.vertices) vertex = matrix * vertex + by;
  return mesh;
}

std::string ToOff(const meshes::Mesh& mesh) {
  std::string text = fmt::format("OFF # a comment\n\n{} {} 0\n# another\n", mesh.vertices.size(),
                                 mesh.triangles.size());
  for (const Vector3d& v : mesh.vertices) text += fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& [a, b, c] : mesh.triangles)
    text += fmt::format("3 {} {} {} 0.5 0.5 0.5\n", a, b, c);
  return text;
}

std::string ToObj(const meshes::Mesh& mesh) {
  std::string text = "# a comment\nmtllib some.mtl\no thing\nvt 0 0\nvn 0 0 1\n";
  for (const Vector3d& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& [a, b, c] : mesh.triangles)
    text += fmt::format("f {}/1/1 {}//1 {}/1\n", a + 1, b + 1, c + 1);
  return text;
}

std::string ToPly(const meshes::Mesh& mesh) {
  std::string text = fmt::format(
      "ply\r\nformat ascii 1.0\r\ncomment c\r\nelement vertex {}\r\nproperty double x\r\n"
      "property double y\r\nproperty double z\r\nproperty uchar red\r\nelement face {}\r\n"
      "property list uchar int vertex_index\r\nend_header\r\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Vector3d& v : mesh.vertices)
    text += fmt::format("{} {} {} 255\r\n", v.x(), v.y(), v.z());
  for (const auto& [a, b, c] : mesh.triangles) text += fmt::format("3 {} {} {}\r\n", a, b, c);
  return text;
}

std::string ToBinaryPly(const meshes::Mesh& mesh, bool big_endian) {
  std::string bytes = fmt::format(
      "ply\nformat binary_{}_endian 1.0\nelement edge 1\nproperty list ushort short ends\n"
      "element vertex {}\nproperty double z\nproperty float quality\nproperty double x\n"
      "property double y\nelement face {}\nproperty list uint uint vertex_indices\n"
      "property int8 flags\nend_header\n",
      big_endian ? "big" : "little", mesh.vertices.size(), mesh.triangles.size());
  Put(std::uint16_t{2}, big_endian, bytes);
  Put(std::uint16_t{7}, big_endian, bytes);
  Put(std::uint16_t{9}, big_endian, bytes);
  for (const Vector3d& v : mesh.vertices) {
    Put(std::bit_cast<std::uint64_t>(v.z()), big_endian, bytes);
    Put(std::bit_cast<std::uint32_t>(1.0f), big_endian, bytes);
    Put(std::bit_cast<std::uint64_t>(v.x()), big_endian, bytes);
    Put(std::bit_cast<std::uint64_t>(v.y()), big_endian, bytes);
  }
  for (const meshes::Triangle& t : mesh.triangles) {
    Put(std::uint32_t{3}, big_endian, bytes);
    for (const std::uint32_t vertex : t) Put(vertex, big_endian, bytes);
    bytes += '\xff';
  }
  return bytes;
}

std::string ToStl(const meshes::Mesh& mesh) {
  std::string text = "solid some thing\n";
  for (const meshes::Triangle& t : mesh.triangles) {
    text += "facet normal nan 0 0\n outer loop\n";
    for (const Vector3d& v : meshes::CornersOf(mesh, t))
      text += fmt::format("  vertex {} {} {}\n", v.x(), v.y(), v.z());
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid\n";
}

std::string ToBinaryStl(const meshes::Mesh& mesh) {
  std::string bytes = "solid, as some exporters begin binary files too";
  bytes.resize(80);
  Put(static_cast<std::uint32_t>(mesh.triangles.size()), false, bytes);
  for (const meshes::Triangle& t : mesh.triangles) {
    bytes.append(12, '\0');
    for (const Vector3d& v : meshes::CornersOf(mesh, t))
      for (const double x : v)
        Put(std::bit_cast<std::uint32_t>(static_cast<float>(x)), false, bytes);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace cdb::tests
