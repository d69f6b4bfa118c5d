#include "library/objects/parts.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "compiler/schema/parametrised_words.h"
#include "library/objects/solid.h"
#include "library/scene_error.h"

namespace cdb::objects {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct PartSolid {
  std::vector<std::vector<Vector3d>> hulls;
  double volume = 0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d moments = Matrix3d::Zero();  ///< mean of x x^T about the centre
};

Vector3d VectorOr(const schema::Call& call, const char* argument, const Vector3d& otherwise) {
  const Vector3d* vector = schema::AsVector(schema::ArgumentOf(call, argument));
  return vector != nullptr ? *vector : otherwise;
}

/// Rings of corners on the surface, from below to above, where the shape is `reach` wide.
void AddRings(Shape shape, const Vector3d& sides, std::vector<Vector3d>& points) {
  const Solid solid{shape, sides};
  const int corners =
      shape == Shape::kEllipsoid || shape == Shape::kCapsule ? kBallCorners : kPartCorners;
  const auto add = [&](double slope) {
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners;
      // Quarter turns are exact, so that the sides are.
      const double c = i % (corners / 4) != 0 ? std::cos(angle) : std::round(std::cos(angle));
      const double s = i % (corners / 4) != 0 ? std::sin(angle) : std::round(std::sin(angle));
      // Normals of the ellipse at angles that are even on the surface.
      points.push_back(
          solid.Support(Vector3d(std::cos(slope) * c / sides.x(), std::sin(slope) / sides.y(),
                                 std::cos(slope) * s / sides.z())));
    }
  };
  if (shape == Shape::kCylinder || shape == Shape::kCone) {
    for (const double slope : {-0.7, 0.7}) add(slope);
  } else {
    const int bands = kBallCorners / 2;
    for (int band = 1; band < bands; ++band)
      add(std::numbers::pi * (static_cast<double>(band) / bands - 0.5));
    if (shape == Shape::kCapsule)
      for (const double slope : {-1e-9, 1e-9}) add(slope);
  }
  for (const double up : {-1.0, 1.0})
    if (shape != Shape::kCylinder) points.push_back(solid.Support(Vector3d(0, up, 0)));
}

PartSolid ClosedPart(std::string_view type, const Vector3d* sides) {
  if (sides == nullptr || !(sides->minCoeff() > 0))
    throw library::SceneError(fmt::format("a part of type {} has no sides", type),
                              fmt::format("write part({}, (1, 2, 3)), for example", type));
  const Shape shape = ShapeOf(type);
  PartSolid part;
  std::vector<Vector3d>& points = part.hulls.emplace_back();
  Visit(shape, [&](auto form) {
    part.volume = form.Volume(*sides);
    part.moments = Vector3d(form.SecondMoments(*sides)).asDiagonal();
    if constexpr (requires { form.Faces(); }) {
      for (const auto& face : form.Faces())
        for (const Vector3d& corner : face) points.push_back(corner.cwiseProduct(*sides));
    } else {
      AddRings(shape, *sides, points);
    }
  });
  return part;
}

PartSolid MeshPart(const ConvexDecomposition& form, const Vector3d* sides) {
  if (sides != nullptr)
    throw library::SceneError(fmt::format("{} has sides of its own", form.name),
                              "write scale: (2, 2, 2) for a mesh twice as large");
  const Vector3d native = form.native_side * form.unit * form.proportions;
  // The point of the file's origin is that of the part.
  const auto in_file = [&](const Vector3d& in_cube) -> Vector3d {
    return (in_cube - form.file_origin).cwiseProduct(native);
  };
  PartSolid part;
  part.volume = form.volume * native.prod();
  part.centre = in_file(form.centre);
  part.moments = form.second_moments.cwiseProduct(native * native.transpose());
  for (const ConvexPiece& piece : form.pieces) {
    std::vector<Vector3d>& points = part.hulls.emplace_back();
    for (const Vector3d& vertex : piece.vertices) points.push_back(in_file(piece.centre + vertex));
  }
  return part;
}

PartSolid PartOf(const schema::Call& call,
                 const std::function<Form(const schema::Value&)>& form_of) {
  const schema::Value& type = schema::ArgumentOf(call, "type");
  const Vector3d* sides = schema::AsVector(schema::ArgumentOf(call, "sides"));
  const Form form = form_of(type);
  PartSolid part = form != nullptr ? MeshPart(*form, sides)
                                   : ClosedPart(std::get<schema::Word>(type).text, sides);
  const Vector3d scale = VectorOr(call, "scale", Vector3d::Ones());
  if (!(scale.cwiseAbs().minCoeff() > 0))
    throw library::SceneError("the scale of a part is 0 along an axis", "no factor is 0");
  const Vector3d about = VectorOr(call, "turn", Vector3d::Zero());
  const double angle = about.stableNorm();
  const Matrix3d turn = angle > 0 ? Eigen::AngleAxisd(angle, about / angle).toRotationMatrix()
                                  : Matrix3d(Matrix3d::Identity());
  const Vector3d at = VectorOr(call, "at", Vector3d::Zero());
  const Matrix3d map = turn * scale.asDiagonal();
  for (std::vector<Vector3d>& hull : part.hulls)
    for (Vector3d& point : hull) point = map * point + at;
  part.volume *= std::abs(scale.prod());
  part.centre = map * part.centre + at;
  part.moments = map * part.moments * map.transpose();
  return part;
}

}  // namespace

ConvexDecomposition MakeCompoundOfParts(const schema::Call& call,
                                        const std::function<Form(const schema::Value&)>& form_of) {
  std::vector<PartSolid> parts;
  for (const schema::Value& part : schema::PartsOf(call))
    parts.push_back(PartOf(*schema::AsCall(part), form_of));
  meshes::MassProperties whole;
  for (const PartSolid& part : parts) {
    whole.volume += part.volume;
    whole.centre += part.volume * part.centre;
  }
  whole.centre /= whole.volume;
  Matrix3d moments = Matrix3d::Zero();
  for (const PartSolid& part : parts) {
    const Vector3d way = part.centre - whole.centre;
    moments += part.volume / whole.volume * (part.moments + way * way.transpose());
  }
  whole.inertia = moments.trace() * Matrix3d::Identity() - moments;
  whole.centre = VectorOr(call, "centre", whole.centre);
  if (const Vector3d* given = schema::AsVector(schema::ArgumentOf(call, "inertia"))) {
    const Vector3d products = VectorOr(call, "products", Vector3d::Zero());
    whole.inertia << given->x(), products.x(), products.y(), products.x(), given->y(), products.z(),
        products.y(), products.z(), given->z();
    if (!(Vector3d(whole.inertia.selfadjointView<Eigen::Lower>().eigenvalues()).minCoeff() > 0))
      throw library::SceneError(
          "the inertia of a compound has a principal moment that is not "
          "more than 0",
          "inertia: (ixx, iyy, izz), products: (ixy, ixz, iyz), of 1 kg");
  } else if (schema::AsVector(schema::ArgumentOf(call, "products")) != nullptr) {
    throw library::SceneError("a compound has products of inertia, but no moments",
                              "write inertia: (ixx, iyy, izz), too");
  }
  meshes::Decomposition pieces{{}, 0, 1};
  meshes::Mesh box;
  for (const PartSolid& part : parts)
    for (const std::vector<Vector3d>& points : part.hulls) {
      auto hull = meshes::TryConvexHull(points);
      if (!hull) throw library::SceneError("a part of a compound is flat", "give it three sides");
      box.vertices.insert(box.vertices.end(), hull->vertices.begin(), hull->vertices.end());
      pieces.hulls.push_back(*std::move(hull));
    }
  ConvexDecomposition form = MakeDecomposition(
      fmt::format("compound of {} part{}", parts.size(), parts.size() == 1 ? "" : "s"), box, whole,
      pieces);
  form.origin = form.file_origin;
  return form;
}

}  // namespace cdb::objects
