#include "library/robots/mjcf_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "library/scene_error.h"

namespace cdb::robots {

using analysis::RobotInertia;
using analysis::RobotShape;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using pugi::xml_node;

namespace {

MeshMass MassRuleOf(const MjcfElement& mesh) {
  constexpr std::pair<std::string_view, MeshMass> kRules[] = {{"", MeshMass::kUnsigned},
                                                              {"legacy", MeshMass::kUnsigned},
                                                              {"convex", MeshMass::kHull},
                                                              {"exact", MeshMass::kSolid},
                                                              {"shell", MeshMass::kShell}};
  const std::string_view rule = mesh.Text("inertia");
  const auto* row = std::ranges::find(kRules, rule, [](const auto& each) { return each.first; });
  if (row == std::end(kRules))
    mesh.Fail(fmt::format("the inertia of a mesh is '{}'", rule),
              "write legacy, convex, exact or shell");
  return row->second;
}

}  // namespace

void MjcfShapes::AddMesh(const xml_node& node) {
  const MjcfElement mesh = values_.Element(node, "mesh", "");
  std::filesystem::path file(mesh.Text("file"));
  if (file.empty() || mesh.Has("refpos") || mesh.Has("refquat"))
    mesh.Fail(file.empty() ? "a mesh has no file" : "a mesh is moved by refpos or refquat",
              "write the mesh as it is used into a file");
  const std::string name = mesh.Has("name") ? std::string(mesh.Text("name")) : file.stem().string();
  if (values_.compiler().strips_paths) file = file.filename();
  file = std::filesystem::path(values_.compiler().mesh_folder) / file;
  meshes_[name] = {file.string(), mesh.Vector("scale", Vector3d::Ones()), MassRuleOf(mesh)};
}

const MjcfShapes::Mesh& MjcfShapes::MeshOf(const MjcfElement& geom) const {
  const auto mesh = meshes_.find(std::string(geom.Text("mesh")));
  if (mesh == meshes_.end())
    geom.Fail(fmt::format("there is no mesh '{}'", geom.Text("mesh")),
              "write <mesh name=\"…\" file=\"…\"/> in <asset>");
  return mesh->second;
}

std::optional<RobotShape> MjcfShapes::ShapeOf(const MjcfElement& geom) {
  const std::string_view type = geom.Has("type") ? geom.Text("type") : "sphere";
  RobotShape shape;
  if (type == "plane" || type == "hfield") {
    builder_.Leave(std::string(type));
    return std::nullopt;
  }
  if (type == "mesh") {
    const Mesh& mesh = MeshOf(geom);
    shape = builder_.MeshOf(mesh.file, mesh.scale);
    shape.pose = values_.PoseOf(geom);
    return shape;
  }
  using Kind = RobotShape::Kind;
  constexpr std::pair<std::string_view, Kind> kKinds[] = {{"box", Kind::kBox},
                                                          {"sphere", Kind::kSphere},
                                                          {"cylinder", Kind::kCylinder},
                                                          {"capsule", Kind::kCapsule},
                                                          {"ellipsoid", Kind::kEllipsoid}};
  const auto* kind = std::ranges::find(kKinds, type, [](const auto& row) { return row.first; });
  if (kind == std::end(kKinds) || geom.Has("mesh"))
    geom.Fail(geom.Has("mesh") ? std::string("a shape is fitted to a mesh")
                               : fmt::format("a shape has the type '{}'", type),
              "write a box, a sphere, a cylinder, a capsule, an ellipsoid or a mesh");
  shape.kind = kind->second;
  SetSides(geom, shape);
  return shape;
}

/// MJCF states radii and half lengths.
void MjcfShapes::SetSides(const MjcfElement& geom, RobotShape& shape) const {
  using Kind = RobotShape::Kind;
  std::vector<double> size = geom.Numbers("size", 0, 3);
  const bool is_block = shape.kind == Kind::kBox || shape.kind == Kind::kEllipsoid;
  const bool is_line = geom.Has("fromto") && shape.kind != Kind::kSphere;
  const std::size_t least = is_line || shape.kind == Kind::kSphere ? 1 : is_block ? 3 : 2;
  if (size.size() < least)
    geom.Fail(fmt::format("size has {} numbers", size.size()), fmt::format("it takes {}", least));
  size.resize(3, size[0]);
  shape.pose = is_line ? Isometry3d::Identity() : values_.PoseOf(geom);
  if (is_line) {
    const std::vector<double> n = geom.Numbers("fromto", 6, 6);
    const Vector3d from(n[0], n[1], n[2]), to(n[3], n[4], n[5]);
    const Vector3d way = from - to;
    if (!(way.norm() > 1e-9)) geom.Fail("fromto has one point twice", "write two points");
    shape.pose.translation() = (from + to) / 2;
    shape.pose.linear() = MjcfValues::TurnOfZ(way);
    size = {size[0], size[0], way.norm() / 2};
  } else if (shape.kind == Kind::kSphere) {
    size = {size[0], size[0], size[0]};
  } else if (!is_block) {
    size = {size[0], size[0], size[1]};
  }
  shape.sides = 2 * Vector3d(size[0], size[1], size[2]);
  if (shape.kind == Kind::kCapsule) shape.sides.z() += 2 * size[0];
}

bool MjcfShapes::IsWithoutMass(const MjcfElement& geom) {
  return geom.Number("mass", geom.Number("density", 1)) == 0;
}

std::optional<RobotInertia> MjcfShapes::InertiaOf(const RobotShape& shape,
                                                  const MjcfElement& geom) const {
  constexpr double kWater = 1000;  // the default of MJCF
  const bool is_mesh = shape.kind == RobotShape::Kind::kMesh;
  const double least = (is_mesh ? shape.sides.cwiseAbs() : shape.sides).minCoeff();
  if (shape.is_missing || !(least > 0)) return std::nullopt;
  if (!is_mesh && geom.Has("shellinertia") &&
      file_.Flag(geom.node(), geom.Text("shellinertia"), "shellinertia"))
    geom.Fail("the mass of a shape is that of its surface (shellinertia)", "write <inertial>");
  try {
    RobotInertia own = is_mesh ? InertiaOfMesh(shape, MeshOf(geom).mass)
                               : robots::InertiaOf(shape, VolumeOf(shape));
    const double factor =
        geom.Has("mass") ? geom.Number("mass", 0) / own.mass : geom.Number("density", kWater);
    Scale(own, factor);
    return own;
  } catch (const library::SceneError& error) {
    geom.Fail(error.cause(), error.remedy());
  }
}

}  // namespace cdb::robots
