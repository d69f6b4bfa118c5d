// SDF: one model of links and joints. Frames are resolved, and what is not taken over is listed.
// Source: http://sdformat.org/spec
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "library/robots/builder.h"
#include "library/robots/mesh_mass.h"
#include "library/robots/reader.h"
#include "library/robots/xml.h"
#include "library/scene_error.h"

namespace cdb::robots {
namespace {

using analysis::Robot;
using analysis::RobotFault;
using analysis::RobotInertia;
using analysis::RobotJoint;
using analysis::RobotLink;
using analysis::RobotShape;
using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using pugi::xml_node;

constexpr const char *kModelFrame = "__model__", *kWorld = "world";
/// Limits at or above are none; the default of SDF.
constexpr double kNoLimit = 1e16;

const Taken kSdfTaken = {{"sdf", {"model"}},
                         {"model", {"static", "link", "joint", "frame", "pose"}},
                         {"link", {"pose", "inertial", "collision"}},
                         {"inertial", {"pose", "mass", "inertia", "density"}},
                         {"collision", {"pose", "geometry", "density"}},
                         {"mesh", {"uri", "scale"}},
                         {"joint", {"parent", "child", "pose", "axis", "axis2"}},
                         {"axis", {"xyz", "limit", "dynamics", "mimic", "use_parent_model_frame"}},
                         {"axis2", {"xyz", "limit", "dynamics", "use_parent_model_frame"}},
                         {"limit", {"lower", "upper", "effort", "velocity"}},
                         {"dynamics", {"damping", "friction"}}};

class SdfReader {
 public:
  SdfReader(const XmlFile& file, RobotBuilder& builder) : file_(file), builder_(builder) {}

  std::optional<Robot> Read() {
    FindModel();
    LeaveOthers(file_.root(), kSdfTaken, builder_);
    for (const xml_node& node : model_.children()) AddFrame(node);
    if (links_.empty()) file_.Fail(model_, "the model has no links", "write <link name=\"…\">");
    if (model_.child("pose")) builder_.Leave("pose of the model, as `location` places it");
    for (const xml_node& link : links_) AddLink(link);
    const bool is_static = FlagOf(model_, "static", false);
    if (!is_static)
      for (const xml_node& joint : model_.children("joint")) AddJoint(joint);
    HoldRoots(is_static);
    return builder_.Finish(model_.attribute("name").value());
  }

 private:
  struct Frame {
    xml_node node;
    std::string relative_to;         ///< a frame
    std::string attached_to;         ///< a frame; empty: it is a link
    std::optional<Isometry3d> pose;  ///< in the frame of the model, if resolved
  };

  void FindModel() {
    const xml_node root = file_.root();
    for (const char* kind : {"world", "include"})
      if (const xml_node node = root.child(kind))
        file_.Fail(node, fmt::format("<{}> is no model of one robot", kind),
                   "name the file of a model, and write what is around it as objects");
    model_ = root.child("model");
    if (!model_) file_.Fail(root, "there is no <model>", "name the file of a model");
    if (const xml_node second = model_.next_sibling("model"))
      file_.Fail(second, "there is a second <model>", "write a file for each");
    for (const char* kind : {"model", "include"})
      if (const xml_node node = model_.child(kind))
        file_.Fail(node, fmt::format("the model contains a <{}>", kind),
                   "write its links and joints into this model: nested models are not read");
  }

  // Frames.

  void AddFrame(const xml_node& node) {
    const std::string_view kind = node.name();
    if (kind != "link" && kind != "joint" && kind != "frame") return;
    const std::string name = node.attribute("name").value();
    if (name.empty() || name == kWorld || name.starts_with("__"))
      file_.Fail(node, fmt::format("the {} has the name '{}'", kind, name), "give it another");
    Frame frame;
    frame.node = node;
    frame.relative_to = kModelFrame;
    if (kind == "link") links_.push_back(node);
    if (kind == "joint") frame.relative_to = frame.attached_to = TextOf(node, "child");
    if (kind == "frame") {
      frame.attached_to = node.attribute("attached_to").as_string(kModelFrame);
      frame.relative_to = frame.attached_to;
    }
    const std::string given = node.child("pose").attribute("relative_to").value();
    if (!given.empty()) frame.relative_to = given;
    if (!frames_.emplace(name, std::move(frame)).second)
      file_.Fail(node, fmt::format("there is another link, joint or frame '{}'", name),
                 "names are unique in a model");
  }

  Frame& FrameOf(const std::string& name, const xml_node& by) {
    const auto found = frames_.find(name);
    if (found == frames_.end())
      file_.Fail(by, fmt::format("there is no link, joint or frame '{}'", name),
                 "those of nested models are not read");
    return found->second;
  }

  /// In the frame of the model.
  Isometry3d PoseOf(const std::string& name, const xml_node& by) {
    std::vector<Frame*> chain;  // up to one that is resolved
    Isometry3d pose = Isometry3d::Identity();
    for (std::string at = name; at != kModelFrame; at = chain.back()->relative_to) {
      Frame& frame = FrameOf(at, chain.empty() ? by : chain.back()->node);
      if (frame.pose) {
        pose = *frame.pose;
        break;
      }
      chain.push_back(&frame);
      if (chain.size() > frames_.size())
        file_.Fail(frame.node, fmt::format("the pose of '{}' is relative to itself", at),
                   "correct relative_to");
    }
    for (std::size_t i = chain.size(); i-- > 0;) {
      pose = pose * OwnPose(chain[i]->node);
      chain[i]->pose = pose;
    }
    return pose;
  }

  /// The link that a frame moves with; `world` for the world.
  std::string LinkOf(const std::string& name, const xml_node& by) {
    std::string at = name;
    for (std::size_t steps = 0; steps <= frames_.size(); ++steps) {
      if (at == kWorld) return at;
      if (at == kModelFrame) {
        const std::string canonical = model_.attribute("canonical_link").value();
        at = canonical.empty() ? links_[0].attribute("name").value() : canonical;
      }
      const Frame& frame = FrameOf(at, by);
      if (frame.attached_to.empty()) return at;
      at = frame.attached_to;
    }
    file_.Fail(by, fmt::format("'{}' is attached to itself", name), "correct attached_to");
  }

  /// As `<pose>` of the node states it.
  Isometry3d OwnPose(const xml_node& node) const {
    const xml_node pose = node.child("pose");
    Isometry3d result = Isometry3d::Identity();
    if (!pose) return result;
    const std::string_view format = pose.attribute("rotation_format").as_string("euler_rpy");
    const bool is_quaternion = format == "quat_xyzw";
    if (!is_quaternion && format != "euler_rpy")
      file_.Fail(pose, fmt::format("the rotation has the format '{}'", format),
                 "write euler_rpy or quat_xyzw");
    const std::size_t count = is_quaternion ? 7 : 6;
    std::vector<double> numbers = file_.Numbers(pose, pose.text().get(), "a pose", 0, count);
    if (numbers.empty()) return result;
    if (numbers.size() != count)
      file_.Fail(pose, fmt::format("a pose has {} numbers", numbers.size()),
                 fmt::format("it takes {}", count));
    for (const double number : numbers)
      if (!(std::abs(number) <= kLargest))
        file_.Fail(pose, "a pose has numbers above 1e9", "the units are m and rad");
    result.translation() = Vector3d(numbers[0], numbers[1], numbers[2]);
    if (is_quaternion) {
      const Eigen::Quaterniond turn(numbers[6], numbers[3], numbers[4], numbers[5]);
      if (!(turn.norm() > 1e-9)) file_.Fail(pose, "a quaternion is 0", "0 0 0 1 does not turn");
      result.linear() = turn.normalized().toRotationMatrix();
      return result;
    }
    const std::string degrees = pose.attribute("degrees").as_string("false");
    const double unit = file_.Flag(pose, degrees, "degrees") ? std::numbers::pi / 180 : 1;
    result.linear() = (AngleAxisd(unit * numbers[5], Vector3d::UnitZ()) *
                       AngleAxisd(unit * numbers[4], Vector3d::UnitY()) *
                       AngleAxisd(unit * numbers[3], Vector3d::UnitX()))
                          .toRotationMatrix();
    return result;
  }

  // Values.

  std::string TextOf(const xml_node& node, const char* child) const {
    const std::string_view text = node.child(child).text().get();
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin == text.npos)
      file_.Fail(node, fmt::format("<{}> has no <{}>", node.name(), child), "write it");
    return std::string(text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin));
  }
  double NumberOf(const xml_node& node, const char* child, double otherwise) const {
    const xml_node found = node.child(child);
    return found ? file_.Number(found, found.text().get(), fmt::format("<{}>", child)) : otherwise;
  }
  Vector3d VectorOf(const xml_node& node, const char* child) const {
    return file_.Vector(node, TextOf(node, child), fmt::format("<{}>", child));
  }
  bool FlagOf(const xml_node& node, const char* child, bool otherwise) const {
    const xml_node found = node.child(child);
    return found ? file_.Flag(found, found.text().get(), fmt::format("<{}>", child)) : otherwise;
  }

  // Links.

  void AddLink(const xml_node& node) {
    RobotLink link;
    link.name = node.attribute("name").value();
    link.line = file_.LineOf(node);
    std::vector<double> densities;
    for (const xml_node& collision : node.children("collision")) {
      AddShape(collision, link);
      densities.resize(link.shapes.size(), NumberOf(collision, "density", -1));
    }
    link.inertia = InertiaFor(node, link, densities);
    builder_.AddLink(std::move(link));
  }

  void AddShape(const xml_node& collision, RobotLink& link) {
    const xml_node geometry = collision.child("geometry");
    xml_node node = geometry.first_child();
    while (node && node.type() != pugi::node_element) node = node.next_sibling();
    const std::string_view kind = node.name();
    if (!node || kind == "empty") return;
    RobotShape shape;
    const auto round = [&](RobotShape::Kind as, const char* length, double caps) {
      const double radius = file_.Number(node, TextOf(node, "radius"), "<radius>");
      shape.kind = as;
      shape.sides.setConstant(2 * radius);
      if (length != nullptr)
        shape.sides.z() = file_.Number(node, TextOf(node, length), "<length>") + caps * radius;
    };
    if (kind == "box") {
      shape.sides = VectorOf(node, "size");
    } else if (kind == "sphere") {
      round(RobotShape::Kind::kSphere, nullptr, 0);
    } else if (kind == "cylinder") {
      round(RobotShape::Kind::kCylinder, "length", 0);
    } else if (kind == "capsule") {
      round(RobotShape::Kind::kCapsule, "length", 2);
    } else if (kind == "ellipsoid") {
      shape.kind = RobotShape::Kind::kEllipsoid;
      shape.sides = 2 * VectorOf(node, "radii");
    } else if (kind == "mesh") {
      if (node.child("submesh"))
        file_.Fail(node, fmt::format("link {} has a submesh as a collision shape", link.name),
                   "write it into a file of its own");
      const Vector3d scale = node.child("scale") ? VectorOf(node, "scale") : Vector3d::Ones();
      shape = builder_.MeshOf(TextOf(node, "uri"), scale);
    } else {
      file_.Fail(node,
                 fmt::format("a collision shape of link {} is a <{}>, which cdb does not read",
                             link.name, kind),
                 kind == "plane" || kind == "heightmap"
                     ? "remove it; the scene has its own ground"
                     : "write a box, a sphere, a cylinder, a capsule, an ellipsoid or a mesh");
    }
    shape.pose = PoseIn(link.name, collision);
    builder_.AddShape(link, std::move(shape));
  }

  /// Of a node in a link; in the frame of the link.
  Isometry3d PoseIn(const std::string& link, const xml_node& node) {
    const std::string frame = node.child("pose").attribute("relative_to").value();
    if (frame.empty()) return OwnPose(node);
    return PoseOf(link, node).inverse() * PoseOf(frame, node) * OwnPose(node);
  }

  std::optional<RobotInertia> InertiaFor(const xml_node& node, const RobotLink& link,
                                         const std::vector<double>& densities) {
    const xml_node inertial = node.child("inertial");
    if (!inertial)
      builder_.Note(fmt::format(
          "link {} has no <inertial>, so that it has the defaults of SDF, 1 kg and 1 kg m^2",
          link.name));
    if (file_.Flag(inertial ? inertial : node, inertial.attribute("auto").as_string("false"),
                   "auto"))
      return InertiaOfShapes(inertial, link, densities);
    const xml_node tensor = inertial.child("inertia");
    const double x = NumberOf(tensor, "ixx", 1), y = NumberOf(tensor, "iyy", 1),
                 z = NumberOf(tensor, "izz", 1), xy = NumberOf(tensor, "ixy", 0),
                 xz = NumberOf(tensor, "ixz", 0), yz = NumberOf(tensor, "iyz", 0);
    Matrix3d matrix;
    matrix << x, xy, xz, xy, y, yz, xz, yz, z;
    return builder_.InertiaOf(link, NumberOf(inertial, "mass", 1), PoseIn(link.name, inertial),
                              matrix);
  }

  std::optional<RobotInertia> InertiaOfShapes(const xml_node& inertial, const RobotLink& link,
                                              const std::vector<double>& densities) {
    constexpr double kWater = 1000;  // the default of SDF
    std::optional<RobotInertia> whole;
    for (std::size_t i = 0; i < link.shapes.size(); ++i) {
      const RobotShape& shape = link.shapes[i];
      const double density =
          densities[i] > 0 ? densities[i] : NumberOf(inertial, "density", kWater);
      const bool is_mesh = shape.kind == RobotShape::Kind::kMesh;
      if (is_mesh && shape.is_missing) return std::nullopt;
      RobotInertia part =
          is_mesh ? OfMesh(shape, inertial) : robots::InertiaOf(shape, VolumeOf(shape));
      Scale(part, density);
      whole = whole ? Together(*whole, part, Isometry3d::Identity()) : part;
    }
    if (!whole)
      file_.Fail(inertial, fmt::format("link {} has no shapes to have a mass by", link.name),
                 "write <mass> and <inertia>");
    const double mass = NumberOf(inertial, "mass", whole->mass);
    const Matrix3d tensor = mass / whole->mass * whole->tensor;
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = whole->centre;
    return builder_.InertiaOf(link, mass, pose, tensor);
  }

  RobotInertia OfMesh(const RobotShape& shape, const xml_node& inertial) const {
    try {
      return InertiaOfMesh(shape, MeshMass::kSolid);
    } catch (const library::SceneError& error) {
      file_.Fail(inertial, error.cause(), error.remedy());
    }
  }

  // Joints.

  void AddJoint(const xml_node& node) {
    NamedJoint named;
    RobotJoint& joint = named.joint;
    joint.name = node.attribute("name").value();
    joint.line = file_.LineOf(node);
    named.child_line = file_.LineOf(node.child("child"));
    const std::string parent = TextOf(node, "parent"), child = TextOf(node, "child");
    named.parent = LinkOf(parent, node);
    named.child = LinkOf(child, node);
    if (named.child == kWorld)
      file_.Fail(node, fmt::format("the child of joint {} is the world", joint.name),
                 "exchange <parent> and <child>");
    joins_world_ = joins_world_ || named.parent == kWorld;
    held_.insert(named.child);
    const Isometry3d of_child = PoseOf(named.child, node);
    const Isometry3d of_parent =
        named.parent == kWorld ? Isometry3d::Identity() : PoseOf(named.parent, node);
    const Isometry3d in_child = of_child.inverse() * PoseOf(joint.name, node);
    joint.origin = of_parent.inverse() * of_child;
    joint.pivot = in_child.translation();
    SetMotion(node, of_child, in_child, joint);
    builder_.AddJoint(std::move(named));
  }

  void SetMotion(const xml_node& node, const Isometry3d& of_child, const Isometry3d& in_child,
                 RobotJoint& joint) {
    using Type = RobotJoint::Type;
    const std::string_view type = node.attribute("type").value();
    if (type == "fixed") return;
    const bool is_revolute = type == "revolute", is_continuous = type == "continuous";
    joint.type = is_revolute || is_continuous ? Type::kHinge
                 : type == "prismatic"        ? Type::kSlider
                 : type == "ball"             ? Type::kBall
                                              : Type::kUniversal;
    if (joint.type == Type::kBall) return;
    if (joint.type == Type::kUniversal && type != "universal")
      file_.Fail(node, fmt::format("joint {} has the type '{}'", joint.name, type),
                 "cdb has revolute, continuous, prismatic, ball, universal and fixed ones");
    const auto axis_of = [&](const char* which, Vector3d& axis) {
      const xml_node element = node.child(which);
      const xml_node xyz = element.child("xyz");
      const Vector3d value = xyz ? VectorOf(element, "xyz") : Vector3d::UnitZ();
      std::string frame = xyz.attribute("expressed_in").value();
      if (FlagOf(element, "use_parent_model_frame", HasOldAxes())) frame = kModelFrame;
      const Matrix3d turn =
          frame.empty() ? in_child.linear()
                        : Matrix3d(of_child.linear().transpose() * PoseOf(frame, node).linear());
      return builder_.SetAxis(joint, axis, turn * value);
    };
    if (!axis_of("axis", joint.axis)) return;
    if (joint.type == Type::kUniversal) {
      if (axis_of("axis2", joint.axis2)) LeaveMotion(node, joint);
      return;
    }
    const xml_node axis = node.child("axis"), limit = axis.child("limit"),
                   dynamics = axis.child("dynamics");
    builder_.SetDynamics(joint, NumberOf(dynamics, "damping", 0),
                         NumberOf(dynamics, "friction", 0));
    SetMimic(node, axis.child("mimic"), joint);
    const double effort = NumberOf(limit, "effort", -1), velocity = NumberOf(limit, "velocity", -1);
    joint.effort = effort > 0 && effort <= kLargest ? effort : 0;
    joint.velocity = velocity > 0 && velocity <= kLargest ? velocity : 0;
    if (!is_continuous)
      builder_.SetLimits(joint, NumberOf(limit, "lower", -kNoLimit),
                         NumberOf(limit, "upper", kNoLimit));
  }

  /// Before SDF 1.5, axes were those of the model.
  bool HasOldAxes() const {
    const std::string_view version = file_.root().attribute("version").as_string("1.12");
    constexpr std::string_view kOld[] = {"1.0", "1.1", "1.2", "1.3", "1.4"};
    return std::ranges::find(kOld, version) != std::end(kOld);
  }

  void LeaveMotion(const xml_node& node, const RobotJoint& joint) {
    for (const char* which : {"axis", "axis2"}) {
      const xml_node axis = node.child(which), limit = axis.child("limit");
      if (NumberOf(limit, "lower", -kNoLimit) > -kNoLimit ||
          NumberOf(limit, "upper", kNoLimit) < kNoLimit)
        builder_.Leave(fmt::format("limits of the universal joint {}", joint.name));
      const xml_node dynamics = axis.child("dynamics");
      if (NumberOf(dynamics, "damping", 0) != 0 || NumberOf(dynamics, "friction", 0) != 0)
        builder_.Leave(fmt::format("damping of the universal joint {}", joint.name));
    }
  }

  void SetMimic(const xml_node& node, const xml_node& mimic, RobotJoint& joint) {
    if (!mimic) return;
    const std::string followed = mimic.attribute("joint").value();
    if (FrameOf(followed, node).node.name() != std::string_view("joint") ||
        mimic.attribute("axis").as_string("axis") != std::string_view("axis"))
      file_.Fail(mimic, fmt::format("joint {} mimics no joint with one axis", joint.name),
                 "write <mimic joint=\"…\">");
    const double ratio = NumberOf(mimic, "multiplier", 1);
    builder_.SetMimic(joint, followed, ratio,
                      NumberOf(mimic, "offset", 0) - ratio * NumberOf(mimic, "reference", 0));
  }

  /// Joins links that no joint holds to the world, unless one link is the root.
  void HoldRoots(bool is_static) {
    std::vector<std::string> roots;
    for (const xml_node& link : links_)
      if (!held_.contains(link.attribute("name").value()))
        roots.emplace_back(link.attribute("name").value());
    if (!is_static && !joins_world_ && roots.size() <= 1) return;
    RobotLink world;
    world.name = kWorld;
    world.line = file_.LineOf(model_);
    builder_.AddLink(std::move(world));
    for (const std::string& root : roots) {
      NamedJoint named;
      named.joint.name = "world_to_" + root;
      named.joint.line = named.child_line = file_.LineOf(FrameOf(root, model_).node);
      named.joint.type = is_static ? RobotJoint::Type::kFixed : RobotJoint::Type::kFree;
      named.joint.origin = PoseOf(root, model_);
      named.parent = kWorld;
      named.child = root;
      builder_.AddJoint(std::move(named));
    }
  }

  const XmlFile& file_;
  RobotBuilder& builder_;
  xml_node model_;
  std::vector<xml_node> links_;
  std::map<std::string, Frame> frames_;
  std::set<std::string> held_;
  bool joins_world_ = false;
};

}  // namespace

std::optional<Robot> ReadSdf(const std::string& text, RobotBuilder& builder,
                             std::vector<RobotFault>&) {
  const XmlFile file(text, builder.path());
  return SdfReader(file, builder).Read();
}

}  // namespace cdb::robots
