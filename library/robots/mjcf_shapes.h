// The shapes of an MJCF file, and their masses by the rules of MuJoCo. Source:
// https://mujoco.readthedocs.io/en/stable/XMLreference.html, body/geom and asset/mesh
//
// SI units; frames are those of the file. Errors: library::SceneError with file and line.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "compiler/analysis/robot.h"
#include "library/robots/builder.h"
#include "library/robots/mesh_mass.h"
#include "library/robots/mjcf_values.h"

namespace cdb::robots {

class MjcfShapes {
 public:
  MjcfShapes(const XmlFile& file, RobotBuilder& builder, const MjcfValues& values)
      : file_(file), builder_(builder), values_(values) {}

  /// A <mesh> of <asset>.
  void AddMesh(const pugi::xml_node& node);
  /// Its pose is that in the frames around the geom. Nullopt for what is no body, and listed.
  std::optional<analysis::RobotShape> ShapeOf(const MjcfElement& geom);
  static bool IsWithoutMass(const MjcfElement& geom);
  /// By the mass or the density of the geom. Nullopt where the builder refuses the shape, or its
  /// mesh is not here.
  std::optional<analysis::RobotInertia> InertiaOf(const analysis::RobotShape& shape,
                                                  const MjcfElement& geom) const;

 private:
  struct Mesh {
    std::string file;
    Eigen::Vector3d scale;
    MeshMass mass;
  };
  void SetSides(const MjcfElement& geom, analysis::RobotShape& shape) const;
  const Mesh& MeshOf(const MjcfElement& geom) const;

  const XmlFile& file_;
  RobotBuilder& builder_;
  const MjcfValues& values_;
  std::map<std::string, Mesh> meshes_;
};

}  // namespace cdb::robots
