// Of an MJCF file: the settings of its <compiler>, the default values of its classes, and what the
// attributes of an element are by them. Source:
// https://mujoco.readthedocs.io/en/stable/XMLreference.html
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "library/robots/xml.h"

namespace cdb::robots {

/// An element with the values of its class.
class MjcfElement {
 public:
  using Values = std::map<std::string, std::string, std::less<>>;
  MjcfElement(const XmlFile& file, const pugi::xml_node& node, const Values* defaults)
      : file_(&file), node_(node), defaults_(defaults) {}

  const pugi::xml_node& node() const { return node_; }
  /// Empty without one.
  std::string_view Text(const char* name) const;
  bool Has(const char* name) const { return !Text(name).empty(); }
  double Number(const char* name, double otherwise) const;
  Eigen::Vector3d Vector(const char* name, const Eigen::Vector3d& otherwise) const;
  std::vector<double> Numbers(const char* name, std::size_t least, std::size_t most) const;
  [[noreturn]] void Fail(const std::string& cause, const std::string& remedy) const {
    file_->Fail(node_, cause, remedy);
  }

 private:
  const XmlFile* file_;
  pugi::xml_node node_;
  const Values* defaults_;
};

struct MjcfCompiler {
  double angle = 0;  ///< rad for each unit of angles
  bool has_auto_limits = true;
  std::string mesh_folder;
  bool strips_paths = false;
  std::string euler = "xyz";
  /// From the shapes: without <inertial>, always, never.
  enum class FromShapes { kAuto, kAlways, kNever } from_shapes = FromShapes::kAuto;
  int first_group = 0, last_group = 5;  ///< of the shapes that have a mass
  double least_mass = 0, least_moment = 0;
  double total_mass = -1;  ///< of all bodies; that of the file if it is not above 0
  bool balances = false;   ///< makes inertias that no body has those of balls
};

class MjcfValues {
 public:
  /// Reads the settings and classes; throws library::SceneError.
  explicit MjcfValues(const XmlFile& file);

  const MjcfCompiler& compiler() const { return compiler_; }
  /// `kind`: the element of defaults. `of_body`: the class of the body around it; may be empty.
  MjcfElement Element(const pugi::xml_node& node, const std::string& kind,
                      const std::string& of_body) const;
  /// The orientation of an element: quat, axisangle, xyaxes, zaxis or euler.
  Eigen::Matrix3d TurnOf(const MjcfElement& element) const;
  Eigen::Isometry3d PoseOf(const MjcfElement& element) const;
  /// Of the z axis along `way`, which is not 0, by the shortest turn.
  static Eigen::Matrix3d TurnOfZ(const Eigen::Vector3d& way);

 private:
  using Class = std::map<std::string, MjcfElement::Values>;
  void ReadCompiler(const pugi::xml_node& node);
  void ReadDefaults(const pugi::xml_node& node, const std::string& parent, bool is_root);
  const Class& ClassOf(const std::string& name, const pugi::xml_node& by) const;

  const XmlFile& file_;
  MjcfCompiler compiler_;
  std::map<std::string, Class> classes_;
};

}  // namespace cdb::robots
