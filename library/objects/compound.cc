#include "library/objects/compound.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace cdb::objects {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

AlignedBox3d BoxOf(std::span<const Vector3d> points) {
  AlignedBox3d box;
  for (const Vector3d& point : points) box.extend(point);
  return box;
}

/// The hull in coordinates that map `cube` to the cube of side 1 about the origin.
ConvexPiece PieceOf(const meshes::Hull& hull, const AlignedBox3d& cube) {
  const meshes::Mesh surface = meshes::SurfaceOf(hull);
  ConvexPiece piece;
  piece.faces = surface.triangles;
  for (const Vector3d& vertex : surface.vertices)
    piece.vertices.push_back((vertex - cube.center()).cwiseQuotient(cube.sizes()));
  const AlignedBox3d box = BoxOf(piece.vertices);
  piece.centre = box.center();
  piece.half = box.sizes() / 2;
  for (Vector3d& vertex : piece.vertices) vertex -= piece.centre;
  return piece;
}

}  // namespace

ConvexDecomposition MakeDecomposition(std::string name, const meshes::Mesh& mesh,
                                      const meshes::MassProperties& properties,
                                      const meshes::Decomposition& pieces) {
  ConvexDecomposition form;
  form.name = std::move(name);
  const AlignedBox3d box = BoxOf(mesh.vertices);
  const Vector3d sides = box.sizes();
  form.proportions = sides / sides.maxCoeff();
  form.native_side = sides.maxCoeff();
  form.file_origin = -box.center().cwiseQuotient(sides);
  form.volume = properties.volume / sides.prod();
  form.centre = (properties.centre - box.center()).cwiseQuotient(sides);
  form.origin = form.centre;
  const Matrix3d& inertia = properties.inertia;
  const Matrix3d moments = inertia.trace() / 2 * Matrix3d::Identity() - inertia;
  form.second_moments = moments.cwiseQuotient(sides * sides.transpose());
  AlignedBox3d cube;
  for (const meshes::Hull& hull : pieces.hulls) cube.extend(BoxOf(hull.vertices));
  for (const meshes::Hull& hull : pieces.hulls) form.pieces.push_back(PieceOf(hull, cube));
  form.volume_error = pieces.volume_error;
  form.iou = pieces.iou;
  form.overlap = pieces.overlap;
  form.hull_overlap = pieces.hull_overlap;
  return form;
}

bool Compound::PieceContains(std::size_t piece, const Vector3d& point) const {
  if (form_->heights) return false;  // its triangles have no inside
  const ConvexPiece& hull = form_->pieces[piece];
  // In the form and relative to the centre of the piece; scaling keeps it on its side of a plane.
  const Vector3d in_form = (from_mesh_.transpose() * point).cwiseQuotient(sides_) + form_->centre;
  const Vector3d relative = in_form - hull.centre;
  if ((relative.cwiseAbs().array() > hull.half.array()).any()) return false;
  return std::ranges::all_of(hull.faces, [&](const meshes::Triangle& face) {
    const Vector3d &a = hull.vertices[face[0]], &b = hull.vertices[face[1]],
                   &c = hull.vertices[face[2]];
    return (b - a).cross(c - a).dot(relative - a) <= 0;
  });
}

bool Compound::IsInCells(const Vector3d& point) const {
  if (form_->voxels == nullptr) return false;
  const Vector3d in_form = (from_mesh_.transpose() * point).cwiseQuotient(sides_) + form_->centre;
  return form_->voxels->Contains(
      (in_form - form_->file_origin).cwiseProduct(form_->native_side * form_->proportions));
}

Compound::Compound(std::shared_ptr<const ConvexDecomposition> form, const Vector3d& sides)
    : form_(std::move(form)), sides_(sides) {
  if (form_->IsSurface()) {
    MeasureSurface();
    return;
  }
  volume_ = form_->volume * sides.prod();
  const Matrix3d moments = form_->second_moments.cwiseProduct(sides * sides.transpose());
  const meshes::PrincipalAxes axes =
      meshes::PrincipalAxesOf(moments.trace() * Matrix3d::Identity() - moments);
  inertia_ = axes.moments;
  from_mesh_ = axes.rotation.transpose();
  least_half_extent_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < form_->pieces.size(); ++i) {
    const ConvexPiece& piece = form_->pieces[i];
    inner_radius_ = std::max(inner_radius_, InnerRadiusOf(piece));
    least_half_extent_ = std::min(least_half_extent_, PieceHalfExtent(i));
    for (const Vector3d& vertex : piece.vertices)
      outer_radius_ = std::max(outer_radius_, ToBody(piece.centre + vertex).norm());
  }
}

void Compound::MeasureSurface() {
  inertia_.setZero();
  from_mesh_.setIdentity();
  least_half_extent_ = sides_.maxCoeff() / 2;
  if (form_->heights) outer_radius_ = form_->heights->OuterRadius(sides_);
  for (std::size_t piece = 0; piece < form_->pieces.size(); ++piece)
    for (std::size_t vertex = 0; vertex < form_->pieces[piece].vertices.size(); ++vertex)
      outer_radius_ = std::max(outer_radius_, Corner(piece, vertex).norm());
}

double Compound::InnerRadiusOf(const ConvexPiece& piece) const {
  double radius = std::numeric_limits<double>::infinity();
  for (const meshes::Triangle& face : piece.faces) {
    const auto corner = [&](int i) {
      return ToBody(piece.centre + piece.vertices[face[static_cast<std::size_t>(i)]]);
    };
    const Vector3d a = corner(0);
    const Vector3d normal = (corner(1) - a).cross(corner(2) - a);
    // The normal of a sliver is only rounding.
    if (normal.norm() <= 1e-12 * sides_.squaredNorm()) continue;
    radius = std::min(radius, normal.normalized().dot(a));
  }
  return std::max(radius, 0.0);
}

Vector3d Compound::PieceCentre(std::size_t piece) const {
  if (form_->heights) {
    const Vector3d corners[] = {Corner(piece, 0), Corner(piece, 1), Corner(piece, 2)};
    return BoxOf(corners).center();
  }
  return ToBody(form_->pieces[piece].centre);
}

Vector3d Compound::Support(std::size_t piece, const Vector3d& direction) const {
  if (form_->heights) {
    const Vector3d corners[] = {Corner(piece, 0), Corner(piece, 1), Corner(piece, 2)};
    return *std::ranges::max_element(corners, {},
                                     [&](const Vector3d& corner) { return direction.dot(corner); });
  }
  const ConvexPiece& it = form_->pieces[piece];
  // In the coordinates of the form, so that the vertices need no conversion.
  const Vector3d along = (from_mesh_.transpose() * direction).cwiseProduct(sides_);
  const Vector3d* farthest = &it.vertices.front();
  double most = -std::numeric_limits<double>::infinity();
  for (const Vector3d& vertex : it.vertices) {
    const double reach = along.dot(vertex);
    if (reach > most) {
      most = reach;
      farthest = &vertex;
    }
  }
  return ToBody(it.centre + *farthest);
}

Vector3d Compound::Support(const Vector3d& direction) const {
  const Vector3d along = (from_mesh_.transpose() * direction).cwiseProduct(sides_);
  if (form_->heights) return ToBody(form_->heights->Support(along));
  const double rounding = 1e-12 * along.lpNorm<1>();
  Vector3d farthest = Support(0, direction);
  for (std::size_t i = 1; i < form_->pieces.size(); ++i) {
    // Most pieces are skipped without looking at their vertices, as not even their boxes reach so
    // far.
    const ConvexPiece& piece = form_->pieces[i];
    const double reach =
        along.dot(piece.centre - form_->centre) + along.cwiseAbs().dot(piece.half) + rounding;
    if (reach < direction.dot(farthest)) continue;
    const Vector3d point = Support(i, direction);
    if (direction.dot(point) > direction.dot(farthest)) farthest = point;
  }
  return farthest;
}

BoxTree::BoxTree(std::vector<Eigen::AlignedBox3d> boxes) : boxes_(std::move(boxes)) {
  order_.resize(boxes_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.reserve(boxes_.size());
  if (!boxes_.empty()) Build(0, static_cast<std::uint32_t>(boxes_.size()));
}

std::uint32_t BoxTree::Build(std::uint32_t first, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, first, end, 0});
  for (std::uint32_t i = first; i < end; ++i) nodes_[index].box.extend(boxes_[order_[i]]);
  if (end - first <= kLeafSize) return index;
  int axis = 0;
  nodes_[index].box.sizes().maxCoeff(&axis);
  const std::uint32_t middle = first + (end - first) / 2;
  // Equal middles are ordered by their index, so that the order is always the same.
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double of_a = boxes_[a].center()[axis], of_b = boxes_[b].center()[axis];
                     return of_a != of_b ? of_a < of_b : a < b;
                   });
  Build(first, middle);
  const std::uint32_t second = Build(middle, end);
  nodes_[index].second = second;
  return index;
}

}  // namespace cdb::objects
