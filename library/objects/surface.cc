#include "library/objects/surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <utility>

#include "library/scene_error.h"

namespace cdb::objects {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

Vector3d AreaOf(const Corners& corners) {
  return (corners[1] - corners[0]).cross(corners[2] - corners[0]);
}

/// The side of the triangle's plane; the plane itself counts as above.
bool IsAbove(const Corners& corners, const Vector3d& normal, const Vector3d& point) {
  return normal.dot(point - corners[0]) >= 0;
}

/// True if the line passes through the triangle, including its edges.
bool GoesThrough(const Corners& corners, const Vector3d& from, const Vector3d& way) {
  int positive = 0, negative = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double side = way.dot((corners[i] - from).cross(corners[(i + 1) % 3] - from));
    positive += side > 0;
    negative += side < 0;
  }
  return positive == 0 || negative == 0;
}

/// A flat mesh has no extent along one axis, so that any scale along it will do.
Vector3d SidesOf(const AlignedBox3d& box) {
  return (box.sizes().array() > 0).select(box.sizes(), box.sizes().maxCoeff());
}

/// A form without triangles, with the frame of this box.
ConvexDecomposition FormIn(const AlignedBox3d& box, std::string name) {
  const double longest = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  ConvexDecomposition form;
  form.name = std::move(name);
  const Vector3d sides = SidesOf(box);
  form.proportions = sides / longest;
  form.native_side = longest;
  form.file_origin = -box.center().cwiseQuotient(sides);
  return form;
}

}  // namespace

ConvexDecomposition MakeSurface(std::string name, const meshes::Mesh& mesh) {
  constexpr double kNoArea = 1e-12;  // as a fraction of the square of the longest side
  AlignedBox3d box;
  for (const meshes::Triangle& triangle : mesh.triangles)
    for (const Vector3d& corner : meshes::CornersOf(mesh, triangle)) box.extend(corner);
  const double longest = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  ConvexDecomposition form = FormIn(box, std::move(name));
  const Vector3d sides = SidesOf(box);
  std::vector<AlignedBox3d> boxes;
  for (const meshes::Triangle& triangle : mesh.triangles) {
    const Corners corners = meshes::CornersOf(mesh, triangle);
    if (!(AreaOf(corners).norm() > kNoArea * longest * longest)) continue;
    AlignedBox3d around;
    ConvexPiece piece;
    for (const Vector3d& corner : corners) {
      piece.vertices.push_back((corner - box.center()).cwiseQuotient(sides));
      around.extend(piece.vertices.back());
    }
    piece.centre = around.center();
    piece.half = around.sizes() / 2;
    for (Vector3d& vertex : piece.vertices) vertex -= piece.centre;
    piece.faces.push_back({0, 1, 2});
    form.pieces.push_back(std::move(piece));
    boxes.push_back(around);
  }
  if (form.pieces.empty())
    throw library::SceneError(
        fmt::format("{}: {}", form.name,
                    mesh.triangles.empty() ? "has no faces" : "its triangles have no area"),
        mesh.triangles.empty() ? "hull takes its vertices" : "name another model");
  if (form.pieces.size() > kMaxSurfaceTriangles)
    throw library::SceneError(fmt::format("{}: it has {} triangles; the limit is {}", form.name,
                                          form.pieces.size(), kMaxSurfaceTriangles),
                              "simplify the model first");
  form.tree = std::make_shared<const BoxTree>(std::move(boxes));
  return form;
}

ConvexDecomposition MakeSurface(std::string name, std::shared_ptr<const terrain::HeightGrid> grid) {
  auto heights = std::make_shared<const HeightSurface>(std::move(grid));
  ConvexDecomposition form = FormIn(heights->box(), std::move(name));
  form.heights = std::move(heights);
  return form;
}

bool Crosses(const Compound& surface, const Vector3d& from, const Vector3d& to) {
  AlignedBox3d path(from.cwiseMin(to), from.cwiseMax(to));
  return surface.AnyPieceIn(path, [&](std::size_t piece) {
    const Corners corners = {surface.Corner(piece, 0), surface.Corner(piece, 1),
                             surface.Corner(piece, 2)};
    const Vector3d normal = AreaOf(corners);
    return IsAbove(corners, normal, from) != IsAbove(corners, normal, to) &&
           GoesThrough(corners, from, to - from);
  });
}

}  // namespace cdb::objects
