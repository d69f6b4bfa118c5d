// URDF, by urdfdom, which reads links, joints, masses and collision shapes. What it does not need
// is removed before it reads the text, which is well-formed (outline.h). One robot at a time.
// Source: https://wiki.ros.org/urdf/XML
#include <console_bridge/console.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>

#include "library/robots/builder.h"
#include "library/robots/outline.h"
#include "library/scene_error.h"

namespace cdb::robots {
namespace {

using analysis::Robot;
using analysis::RobotFault;
using analysis::RobotJoint;
using analysis::RobotLink;
using analysis::RobotShape;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d ToEigen(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Isometry3d ToEigen(const urdf::Pose& pose) {
  Isometry3d result = Isometry3d::Identity();
  result.translation() = ToEigen(pose.position);
  const urdf::Rotation& turn = pose.rotation;
  result.linear() =
      Eigen::Quaterniond(turn.w, turn.x, turn.y, turn.z).normalized().toRotationMatrix();
  return result;
}

/// Collects what urdfdom would print.
class Log : public console_bridge::OutputHandler {
 public:
  Log() { console_bridge::useOutputHandler(this); }
  ~Log() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) errors_.push_back(text);
  }
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  std::vector<std::string> errors_;
};

/// The elements that urdfdom gets; those of others are listed.
const std::map<std::string_view, std::set<std::string_view>> kUrdfTaken = {
    {"robot", {"link", "joint"}},
    {"link", {"inertial", "collision"}},
    {"inertial", {"mass", "origin", "inertia"}},
    {"collision", {"origin", "geometry"}},
    {"geometry", {"box", "sphere", "cylinder", "mesh"}},
    {"joint", {"parent", "child", "origin", "axis", "limit", "dynamics", "mimic"}}};

/// The file, before urdfdom reads it.
class Document {
 public:
  Document(const std::string& text, const std::string& path) : path_(path), text_(text) {
    elements_ = ReadOutline(text_, path);
    for (const Element& element : elements_)
      if (element.name.starts_with("xacro:"))
        throw library::SceneError(
            fmt::format("{}:{}: <{}> is a macro of xacro", path, element.line, element.name),
            "expand it first: `xacro robot.urdf.xacro > robot.urdf`");
    Reduce();
  }

  const std::vector<Element>& elements() const { return elements_; }
  const std::string& reduced() const { return text_; }
  void LeaveOut(RobotBuilder& builder) const {
    for (const std::string& name : left_out_) builder.Leave(name);
  }
  /// The line of a link or a joint; that of the root if there is none.
  std::size_t LineOf(std::string_view kind, std::string_view name) const {
    for (const Element& element : elements_)
      if (element.parent == 0 && element.name == kind && element.Attribute("name") == name)
        return element.line;
    return elements_[0].line;
  }
  /// The line of `<child>` of a joint.
  std::size_t LineOfChild(std::string_view joint) const {
    for (const Element& element : elements_)
      if (element.name == "child" && element.parent != Element::kNone &&
          elements_[element.parent].parent == 0 &&
          elements_[element.parent].Attribute("name") == joint)
        return element.line;
    return LineOf("joint", joint);
  }
  /// The names of the links or joints, in order.
  std::vector<std::string> NamesOf(std::string_view kind) const {
    std::vector<std::string> names;
    for (const Element& element : elements_)
      if (element.parent == 0 && element.name == kind)
        names.emplace_back(element.Attribute("name"));
    return names;
  }

 private:
  bool HasShape(std::size_t geometry) const {
    const auto& shapes = kUrdfTaken.at("geometry");
    return std::ranges::any_of(elements_, [&](const Element& element) {
      return element.parent == geometry && shapes.contains(element.name);
    });
  }

  /// Overwrites what is not taken with blanks, so that lines remain.
  void Reduce() {
    std::vector<char> is_out(elements_.size(), 0);
    for (std::size_t i = 1; i < elements_.size(); ++i) {
      const Element& element = elements_[i];
      const Element& parent = elements_[element.parent];
      is_out[i] = is_out[element.parent];
      if (is_out[i] != 0) continue;
      const auto taken = kUrdfTaken.find(parent.name);
      if (taken == kUrdfTaken.end() || taken->second.contains(element.name)) continue;
      if (parent.name == "geometry" && !HasShape(element.parent))
        throw library::SceneError(
            fmt::format("{}:{}: a collision shape is a <{}>, which URDF does not have", path_,
                        element.line, element.name),
            "write a box, a cylinder, a sphere or a mesh");
      is_out[i] = 1;
      left_out_.push_back(element.name);
      for (std::size_t at = element.begin; at < element.end; ++at)
        if (text_[at] != '\n') text_[at] = ' ';
    }
  }

  const std::string& path_;
  std::string text_;
  std::vector<Element> elements_;
  std::vector<std::string> left_out_;
};

/// Makes a robot of urdfdom's model.
class UrdfReader {
 public:
  UrdfReader(const Document& document, RobotBuilder& builder)
      : document_(document), builder_(builder) {}

  std::optional<Robot> Read(const urdf::ModelInterface& model) {
    for (const std::string& name : document_.NamesOf("link"))
      if (const auto link = model.getLink(name)) AddLink(*link);
    for (const std::string& name : document_.NamesOf("joint"))
      if (const auto joint = model.getJoint(name)) AddJoint(*joint);
    document_.LeaveOut(builder_);
    return builder_.Finish(model.getName());
  }

 private:
  void AddLink(const urdf::Link& from) {
    RobotLink link;
    link.name = from.name;
    link.line = document_.LineOf("link", from.name);
    if (from.inertial) {
      const urdf::Inertial& inertial = *from.inertial;
      Matrix3d tensor;
      tensor << inertial.ixx, inertial.ixy, inertial.ixz, inertial.ixy, inertial.iyy, inertial.iyz,
          inertial.ixz, inertial.iyz, inertial.izz;
      link.inertia = builder_.InertiaOf(link, inertial.mass, ToEigen(inertial.origin), tensor);
    }
    for (const auto& collision : from.collision_array)
      if (collision && collision->geometry) AddShape(link, *collision);
    builder_.AddLink(std::move(link));
  }

  void AddShape(RobotLink& link, const urdf::Collision& from) {
    RobotShape shape;
    switch (from.geometry->type) {
      case urdf::Geometry::BOX:
        shape.kind = RobotShape::Kind::kBox;
        shape.sides = ToEigen(static_cast<const urdf::Box&>(*from.geometry).dim);
        break;
      case urdf::Geometry::SPHERE:
        shape.kind = RobotShape::Kind::kSphere;
        shape.sides.setConstant(2 * static_cast<const urdf::Sphere&>(*from.geometry).radius);
        break;
      case urdf::Geometry::CYLINDER: {
        const auto& cylinder = static_cast<const urdf::Cylinder&>(*from.geometry);
        shape.kind = RobotShape::Kind::kCylinder;
        shape.sides = {2 * cylinder.radius, 2 * cylinder.radius, cylinder.length};
        break;
      }
      case urdf::Geometry::MESH: {
        const auto& mesh = static_cast<const urdf::Mesh&>(*from.geometry);
        shape = builder_.MeshOf(mesh.filename, ToEigen(mesh.scale));
        break;
      }
      default:  // of later versions; Document refuses them
        return;
    }
    shape.pose = ToEigen(from.origin);
    builder_.AddShape(link, std::move(shape));
  }

  void AddJoint(const urdf::Joint& from) {
    NamedJoint named;
    named.parent = from.parent_link_name;
    named.child = from.child_link_name;
    RobotJoint& joint = named.joint;
    joint.name = from.name;
    joint.line = document_.LineOf("joint", from.name);
    named.child_line = document_.LineOfChild(from.name);
    SetMotion(from, joint);
    builder_.AddJoint(std::move(named));
  }

  void SetMotion(const urdf::Joint& from, RobotJoint& joint) {
    const auto refuse = [&](const std::string& cause, const char* remedy) {
      builder_.Report(joint.line, fmt::format("joint {} {}", joint.name, cause), remedy);
    };
    joint.origin = ToEigen(from.parent_to_joint_origin_transform);
    if (!IsInRange(joint.origin.translation()))
      refuse("has an origin that is no number below 1e9", "the unit is m");
    if (from.mimic && (from.type == urdf::Joint::FIXED || from.type == urdf::Joint::FLOATING))
      builder_.Note(
          fmt::format("mimic of joint {} is ignored: its type has no position", joint.name));
    using Type = RobotJoint::Type;
    switch (from.type) {
      case urdf::Joint::FIXED:
        return;
      case urdf::Joint::FLOATING:
        joint.type = Type::kFree;
        return;
      case urdf::Joint::REVOLUTE:
      case urdf::Joint::CONTINUOUS:
        joint.type = Type::kHinge;
        break;
      case urdf::Joint::PRISMATIC:
        joint.type = Type::kSlider;
        break;
      default:
        return refuse(
            "is planar, which cdb cannot simulate",
            "two prismatic joints and a continuous one, with links of some mass between them, "
            "move alike");
    }
    if (!builder_.SetAxis(joint, joint.axis, ToEigen(from.axis))) return;
    if (from.mimic)
      builder_.SetMimic(joint, from.mimic->joint_name, from.mimic->multiplier, from.mimic->offset);
    if (from.dynamics) builder_.SetDynamics(joint, from.dynamics->damping, from.dynamics->friction);
    if (!from.limits) return;
    if (!(from.limits->effort >= 0))
      return refuse(fmt::format("has the effort {:.6g}", from.limits->effort).c_str(),
                    "the largest force or torque of its motor is 0 or more");
    joint.effort = from.limits->effort;
    joint.velocity = std::max(from.limits->velocity, 0.0);
    if (from.type != urdf::Joint::CONTINUOUS)
      builder_.SetLimits(joint, from.limits->lower, from.limits->upper);
  }

  const Document& document_;
  RobotBuilder& builder_;
};

/// urdfdom's own words for a model that it refuses, with the line of what they name.
RobotFault FaultOf(const std::vector<std::string>& errors, const Document& document,
                   const std::string& path) {
  std::string text = "urdfdom refuses it";
  std::size_t line = document.elements()[0].line;
  for (std::size_t i = 0; i < std::min<std::size_t>(errors.size(), 2); ++i)
    text += (i == 0 ? ": " : "; ") + errors[i];
  while (text.ends_with('\n') || text.ends_with('.')) text.pop_back();
  for (const char* kind : {"joint", "link"})
    for (const std::string& name : document.NamesOf(kind))
      for (const std::string& error : errors)
        if (!name.empty() && (error.find("[" + name + "]") != std::string::npos ||
                              error.find("'" + name + "'") != std::string::npos))
          line = document.LineOf(kind, name);
  return {fmt::format("{}:{}: {}", path, line, text), ""};
}

}  // namespace

bool HasUrdf() { return true; }

std::optional<Robot> ReadUrdf(const std::string& text, RobotBuilder& builder,
                              std::vector<RobotFault>& faults) {
  static std::mutex one_at_a_time;
  const std::lock_guard guard(one_at_a_time);
  const Document document(text, builder.path());
  const Log log;
  urdf::ModelInterfaceSharedPtr model;
  std::vector<std::string> errors;
  try {
    model = urdf::parseURDF(document.reduced());
    errors = log.errors();
    if (!errors.empty()) model = nullptr;  // it goes on without what it cannot read
  } catch (const std::exception& error) {
    model = nullptr;
    errors = log.errors();
    errors.emplace_back(error.what());
  }
  if (model == nullptr || model->getRoot() == nullptr) {
    faults.push_back(FaultOf(errors, document, builder.path()));
    return std::nullopt;
  }
  return UrdfReader(document, builder).Read(*model);
}

}  // namespace cdb::robots
