// MJCF: the bodies, joints and shapes of MuJoCo's models, as far as cdb has them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "library/robots/builder.h"
#include "library/robots/mjcf_shapes.h"
#include "library/robots/mjcf_values.h"
#include "library/robots/reader.h"

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
using JointType = RobotJoint::Type;

constexpr const char* kWorldBody = "world";
const std::set<std::string_view> kOfBody = {"inertial", "joint", "freejoint",
                                            "geom",     "body",  "frame"};
/// `compiler` and `default` are read apart, and parts of `equality` and `actuator` are listed by
/// name; what is in the sections of the second table, by section.
const Taken kMjcfTaken = {{"mujoco",
                           {"compiler", "default", "asset", "worldbody", "contact", "equality",
                            "actuator", "sensor", "tendon", "keyframe", "custom"}},
                          {"asset", {"mesh"}},
                          {"contact", {"exclude"}},
                          {"worldbody", kOfBody},
                          {"body", kOfBody},
                          {"frame", kOfBody}};
constexpr const char* kSections[] = {"sensor", "tendon", "keyframe", "custom"};
const std::set<std::string_view> kMacros = {"include", "composite", "flexcomp", "replicate",
                                            "attach"};
constexpr const char* kOfShapes[] = {"friction", "solref", "solimp", "condim", "margin", "gap"};
constexpr const char* kOfJoints[] = {"armature", "stiffness"};

/// A body, as far as collisions need it.
struct Body {
  std::string name;
  std::size_t whole;                                 ///< the body that it is fixed to, or itself
  std::vector<std::pair<unsigned, unsigned>> masks;  ///< contype and conaffinity of its shapes
};

class MjcfReader {
 public:
  MjcfReader(const XmlFile& file, RobotBuilder& builder)
      : file_(file), builder_(builder), values_(file) {}

  std::optional<Robot> Read() {
    const xml_node root = file_.root();
    RefuseMacros(root);
    LeaveOthers(root, kMjcfTaken, builder_);
    for (const char* section : kSections)
      for (const xml_node& node : root.children(section))
        for (const xml_node& child : node.children())
          if (child.type() == pugi::node_element) builder_.Leave(section);
    for (const xml_node& node : root.children("asset"))
      for (const xml_node& mesh : node.children("mesh")) shapes_.AddMesh(mesh);
    for (const xml_node& node : root.children("actuator"))
      for (const xml_node& actuator : node.children()) AddActuator(actuator);
    bodies_.push_back({kWorldBody, 0, {}});
    Parts world;
    world.link.name = kWorldBody;
    world.link.line = file_.LineOf(root);
    for (const xml_node& node : root.children("worldbody"))
      ReadParts(node, Isometry3d::Identity(), "", 0, world);
    AddBodies(std::move(world));
    for (const xml_node& node : root.children("equality"))
      for (const xml_node& equality : node.children()) AddEquality(equality);
    DisableContacts(root);
    for (NamedJoint& joint : joints_) builder_.AddJoint(std::move(joint));
    if (const double mass = values_.compiler().total_mass; mass > 0) builder_.SetTotalMass(mass);
    return builder_.Finish(root.attribute("model").as_string("MuJoCo Model"));
  }

 private:
  struct Part {
    MjcfElement element;
    Isometry3d pose;  ///< of the frames around it, in the body
    std::string of_body;
  };
  /// What is in a body.
  struct Parts {
    RobotLink link;
    xml_node inertial;
    std::vector<Part> joints, bodies;
    std::vector<std::pair<RobotShape, MjcfElement>> masses;
  };

  void RefuseMacros(const xml_node& node) const {
    for (const xml_node& child : node.children()) {
      if (kMacros.contains(child.name()))
        file_.Fail(child, fmt::format("<{}> stands for other elements", child.name()),
                   "let MuJoCo write the model without it, by mj_saveLastXML");
      RefuseMacros(child);
    }
  }

  std::string NameOf(const xml_node& node, const char* kind) {
    const std::string name = node.attribute("name").value();
    return name.empty() ? fmt::format("{}_{}", kind, ++unnamed_[kind]) : name;
  }

  void AddShape(const Part& part, std::size_t body, Parts& parts) {
    const MjcfElement& geom = part.element;
    auto shape = shapes_.ShapeOf(geom);
    if (!shape) return;
    shape->pose = part.pose * shape->pose;
    const auto group = static_cast<int>(geom.Number("group", 0));
    if (group >= values_.compiler().first_group && group <= values_.compiler().last_group)
      parts.masses.emplace_back(*shape, geom);
    const auto mask = [&](const char* name) {
      const double number = geom.Number(name, 1);
      if (!(std::abs(number) < 2147483648.0)) geom.Fail(fmt::format("{} is no mask", name), "");
      return static_cast<unsigned>(static_cast<int>(number));
    };
    const unsigned own = mask("contype"), others = mask("conaffinity");
    if (own == 0 && others == 0) return builder_.Leave("geom that touches nothing");
    for (const char* name : kOfShapes)
      if (geom.Has(name)) builder_.Leave(name);
    bodies_[body].masks.emplace_back(own, others);
    builder_.AddShape(parts.link, *std::move(shape));
  }

  // Bodies.

  void ReadParts(const xml_node& node, const Isometry3d& pose, const std::string& of_body,
                 std::size_t body, Parts& parts) {
    for (const xml_node& child : node.children()) {
      const std::string kind = child.name();
      if (kind == "frame") {
        const std::string given = child.attribute("childclass").value();
        const Isometry3d own = values_.PoseOf(MjcfElement(file_, child, nullptr));
        ReadParts(child, pose * own, given.empty() ? of_body : given, body, parts);
      } else if (kind == "geom") {
        AddShape({values_.Element(child, kind, of_body), pose, of_body}, body, parts);
      } else if (kind == "joint" || kind == "freejoint") {
        // <freejoint> has no defaults.
        const MjcfElement element = kind == "joint" ? values_.Element(child, kind, of_body)
                                                    : MjcfElement(file_, child, nullptr);
        parts.joints.push_back({element, pose, of_body});
      } else if (kind == "body") {
        parts.bodies.push_back({MjcfElement(file_, child, nullptr), pose, of_body});
      } else if (kind == "inertial") {
        parts.inertial = child;
      }
    }
  }

  static bool IsFree(const Part& joint) {
    return joint.element.node().name() == std::string_view("freejoint") ||
           joint.element.Text("type") == "free";
  }

  /// The world is a link if it has shapes, if a body is fixed to it, or if several are free.
  void AddBodies(Parts world) {
    struct Top {
      std::size_t body;
      Isometry3d pose;
    };
    std::vector<Top> free;
    const std::size_t before = joints_.size();
    for (const Part& part : world.bodies) {
      const std::size_t index = bodies_.size();
      const auto pose = AddBody(part, 0);
      if (pose) free.push_back({index, *pose});
    }
    if (!world.joints.empty())
      world.joints[0].element.Fail("a joint is of the world", "write it in a <body>");
    const bool is_held =
        std::any_of(joints_.begin() + static_cast<std::ptrdiff_t>(before), joints_.end(),
                    [](const NamedJoint& joint) { return joint.parent == kWorldBody; });
    if (world.link.shapes.empty() && !is_held && free.size() == 1) return;
    if (bodies_.size() == 1) file_.Fail(file_.root(), "there is no <body>", "write one");
    for (const Top& top : free) {
      NamedJoint named = JointTo(world.link, top.pose, kWorldBody, bodies_[top.body].name);
      named.joint.name = "world_to_" + named.child;
      named.joint.type = JointType::kFree;
      joints_.push_back(std::move(named));
    }
    builder_.AddLink(std::move(world.link));
  }

  /// The pose of a body that a free joint lets go.
  std::optional<Isometry3d> AddBody(const Part& part, std::size_t parent) {
    const xml_node node = part.element.node();
    const std::string given = node.attribute("childclass").value();
    const std::size_t index = bodies_.size();
    bodies_.push_back({NameOf(node, "body"), index, {}});
    Parts parts;
    parts.link.name = bodies_[index].name;
    parts.link.line = file_.LineOf(node);
    const std::string of_body = given.empty() ? part.of_body : given;
    ReadParts(node, Isometry3d::Identity(), of_body, index, parts);
    if (node.attribute("mocap").as_bool()) builder_.Leave("mocap");
    parts.link.inertia = InertiaFor(parts);
    const Isometry3d pose = part.pose * values_.PoseOf(part.element);
    const bool is_free = std::ranges::any_of(parts.joints, IsFree);
    if (is_free && (parent != 0 || parts.joints.size() > 1))
      part.element.Fail(fmt::format("body {} has a free joint {}", parts.link.name,
                                    parent != 0 ? "inside of another body" : "and another one"),
                        "write it as the only joint of a body of <worldbody>");
    if (parts.joints.empty()) bodies_[index].whole = bodies_[parent].whole;
    if (!is_free) AddJoints(parts, pose, bodies_[parent].name);
    builder_.AddLink(std::move(parts.link));
    for (const Part& child : parts.bodies) AddBody(child, index);
    return is_free ? std::optional(pose) : std::nullopt;
  }

  std::optional<RobotInertia> InertiaFor(const Parts& parts) {
    const MjcfCompiler& compiler = values_.compiler();
    using FromShapes = MjcfCompiler::FromShapes;
    const bool takes_shapes = compiler.from_shapes == FromShapes::kAlways ||
                              (compiler.from_shapes == FromShapes::kAuto && !parts.inertial);
    double mass = 0;
    Isometry3d pose = Isometry3d::Identity();
    Matrix3d tensor = Matrix3d::Zero();
    if (takes_shapes) {
      const auto whole = InertiaOfShapes(parts);
      if (!whole) return std::nullopt;
      mass = whole->mass;
      pose.translation() = whole->centre;
      tensor = whole->tensor;
    } else if (parts.inertial) {
      const MjcfElement inertial(file_, parts.inertial, nullptr);
      mass = inertial.Number("mass", 0);
      pose = values_.PoseOf(inertial);
      if (inertial.Has("fullinertia")) {
        const std::vector<double> n = inertial.Numbers("fullinertia", 6, 6);
        tensor << n[0], n[3], n[4], n[3], n[1], n[5], n[4], n[5], n[2];
      } else {
        tensor = inertial.Vector("diaginertia", Vector3d::Zero()).asDiagonal();
      }
    }
    if (compiler.least_mass > 0 || compiler.least_moment > 0 || compiler.balances) {
      mass = std::max(mass, compiler.least_mass);
      const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(tensor);
      Vector3d moments = solver.eigenvalues().cwiseMax(compiler.least_moment);
      if (compiler.balances && moments.sum() < 2 * moments.maxCoeff())
        moments.setConstant(moments.mean());
      tensor = solver.eigenvectors() * moments.asDiagonal() * solver.eigenvectors().transpose();
    }
    return builder_.InertiaOf(parts.link, mass, pose, tensor);
  }

  /// Zero without shapes. Nullopt where one is refused elsewhere, or its mesh is not here.
  std::optional<RobotInertia> InertiaOfShapes(const Parts& parts) {
    RobotInertia whole;
    for (const auto& [shape, geom] : parts.masses) {
      if (MjcfShapes::IsWithoutMass(geom)) continue;
      if (shape.is_missing && std::ranges::find(parts.link.shapes, shape.file, &RobotShape::file) ==
                                  parts.link.shapes.end())
        geom.Fail(fmt::format("body {} has the mass of the mesh '{}', but there is no file '{}'",
                              parts.link.name, shape.written, shape.file),
                  "its path is relative to the folder of the robot's file");
      const auto own = shapes_.InertiaOf(shape, geom);
      if (!own) return std::nullopt;
      whole = Together(whole, *own, Isometry3d::Identity());
    }
    return whole;
  }

  // Joints.

  /// Of the body to `parent`; several are a universal joint, or have links between them.
  void AddJoints(Parts& parts, const Isometry3d& pose, const std::string& parent) {
    const std::string& child = parts.link.name;
    if (parts.joints.empty()) {
      NamedJoint named = JointTo(parts.link, pose, parent, child);
      named.joint.name = parent + "_to_" + child;
      joints_.push_back(std::move(named));
      return;
    }
    if (parts.joints.size() > 1) {
      const auto why = WhyNotUniversal(parts);
      if (!why) {
        NamedJoint named = JointAt(parts.joints[0], parts.link, pose, parent, child);
        SetUniversal(parts, named.joint);
        joints_.push_back(std::move(named));
        return;
      }
      if (!builder_.options().has_dummy_links)
        parts.joints[0].element.Fail(
            fmt::format("body {} has {} joints{}", child, parts.joints.size(), *why),
            "write `dummy_links on` in the block of the robot, a body with some mass between each "
            "two, or a ball joint");
    }
    AddChain(parts, pose, parent);
  }

  NamedJoint JointTo(const RobotLink& link, const Isometry3d& pose, const std::string& parent,
                     const std::string& child) const {
    NamedJoint named;
    named.joint.line = named.child_line = link.line;
    named.joint.origin = pose;
    named.parent = parent;
    named.child = child;
    return named;
  }

  /// Each joint holds the next of a row of links, the last of which is the body; all have its frame
  /// where the joints are at 0.
  void AddChain(Parts& parts, const Isometry3d& pose, const std::string& parent) {
    constexpr double kShare = 1e-3;  // of the mass and the inertia of the body
    const std::string& body = parts.link.name;
    std::string last = parent;
    for (std::size_t i = 0; i < parts.joints.size(); ++i) {
      const bool is_body = i + 1 == parts.joints.size();
      const std::string child = is_body ? body : fmt::format("{}_{}", body, i + 1);
      NamedJoint named =
          JointAt(parts.joints[i], parts.link, i == 0 ? pose : Isometry3d::Identity(), last, child);
      SetMotion(parts.joints[i], named.joint);
      joints_.push_back(std::move(named));
      if (is_body) break;
      RobotLink link;
      link.name = child;
      link.line = parts.link.line;
      link.inertia = parts.link.inertia;
      if (link.inertia) Scale(*link.inertia, kShare);
      builder_.AddLink(std::move(link));
      last = child;
    }
    const std::size_t between = parts.joints.size() - 1;
    if (between == 0) return;
    if (parts.link.inertia) Scale(*parts.link.inertia, 1 - kShare * static_cast<double>(between));
    builder_.Disable(parent, body);
    builder_.Note(fmt::format(
        "body {} has {} joints, so that {} of {} % of its mass stand{} between them", body,
        parts.joints.size(), between == 1 ? "1 link" : fmt::format("{} links", between),
        100 * kShare, between == 1 ? "s" : ""));
  }

  NamedJoint JointAt(const Part& part, const RobotLink& link, const Isometry3d& pose,
                     const std::string& parent, const std::string& child) {
    NamedJoint named = JointTo(link, pose, parent, child);
    named.joint.name = NameOf(part.element.node(), "joint");
    named.joint.line = file_.LineOf(part.element.node());
    named.joint.pivot = part.pose * part.element.Vector("pos", Vector3d::Zero());
    return named;
  }

  Vector3d AxisOf(const Part& part) const {
    return part.pose.linear() * part.element.Vector("axis", Vector3d::UnitZ());
  }

  /// Nullopt for two hinges about axes that cross at right angles, and that nothing limits or
  /// brakes; otherwise what follows the number of joints in a message.
  std::optional<std::string> WhyNotUniversal(const Parts& parts) const {
    if (parts.joints.size() > 2) return "";
    const Part &first = parts.joints[0], &second = parts.joints[1];
    for (const Part* part : {&first, &second}) {
      const std::string_view type = part->element.Text("type");
      if (!type.empty() && type != "hinge") return fmt::format(", one of the type {}", type);
      for (const char* name : {"range", "damping", "frictionloss", "ref"})
        if (part->element.Has(name) && part->element.Numbers(name, 1, 4) != std::vector{0.0})
          return fmt::format(", one of them with {}", name);
    }
    const Vector3d away = second.pose * second.element.Vector("pos", Vector3d::Zero()) -
                          first.pose * first.element.Vector("pos", Vector3d::Zero());
    const bool is_crossing =
        std::abs(AxisOf(first).normalized().dot(AxisOf(second).normalized())) < 1e-9;
    if (away.norm() > 1e-9 || !is_crossing) return " whose axes do not cross at right angles";
    return std::nullopt;
  }

  void SetUniversal(const Parts& parts, RobotJoint& joint) {
    joint.type = JointType::kUniversal;
    for (const Part& part : parts.joints)
      for (const char* name : kOfJoints) LeaveIfSet(part.element, name);
    builder_.SetAxis(joint, joint.axis, AxisOf(parts.joints[0]));
    builder_.SetAxis(joint, joint.axis2, AxisOf(parts.joints[1]));
  }

  void LeaveIfSet(const MjcfElement& element, const char* name) {
    if (element.Has(name) && element.Numbers(name, 1, 6)[0] != 0) builder_.Leave(name);
  }

  bool IsLimited(const MjcfElement& element, const char* range, const char* limited) const {
    if (!element.Has(range)) return false;
    const std::string_view flag = element.Text(limited);
    return flag.empty() || flag == "auto" ? values_.compiler().has_auto_limits
                                          : file_.Flag(element.node(), flag, limited);
  }

  void SetMotion(const Part& part, RobotJoint& joint) {
    const MjcfElement& element = part.element;
    LeaveIfSet(element, "stiffness");
    const std::string_view type = element.Has("type") ? element.Text("type") : "hinge";
    const bool is_limited = IsLimited(element, "range", "limited");
    if (type == "ball") {
      joint.type = JointType::kBall;
      LeaveIfSet(element, "armature");
      if (is_limited) builder_.Leave(fmt::format("range of the ball joint {}", joint.name));
      for (const char* name : {"damping", "frictionloss"})
        if (element.Has(name) && element.Numbers(name, 1, 4)[0] != 0)
          builder_.Leave(fmt::format("{} of the ball joint {}", name, joint.name));
      return;
    }
    if (type != "hinge" && type != "slide")
      element.Fail(fmt::format("a joint has the type '{}'", type),
                   "write hinge, slide, ball or free");
    joint.type = type == "hinge" ? JointType::kHinge : JointType::kSlider;
    const double unit = type == "hinge" ? values_.compiler().angle : 1;
    if (!builder_.SetAxis(joint, joint.axis, AxisOf(part))) return;
    const std::vector<double> damping = element.Numbers("damping", 0, 4);
    if (std::ranges::count(damping, 0.0) + 1 < std::ranges::ssize(damping))
      element.Fail("damping is a polynomial", "write one number");
    joint.armature = element.Number("armature", 0);
    if (!(joint.armature >= 0 && joint.armature <= kLargest))
      element.Fail("the armature is not between 0 and 1e9",
                   "give it the rotor's inertia, or remove it");
    if (joint.armature > 0) builder_.Leave("armature, unless the robot has armature on");
    builder_.SetDynamics(joint, damping.empty() ? 0 : damping[0],
                         element.Number("frictionloss", 0));
    joint.effort = EffortOf(element, joint.name);
    // The body is in the file where the joint is at `ref`.
    const double ref = unit * element.Number("ref", 0);
    if (!(std::abs(ref) <= kLargest)) element.Fail("ref is above 1e9", "the units are SI");
    if (ref != 0) {
      HoldAt(joint, type == "slide", -ref);
      joint.type = type == "hinge" ? JointType::kHinge : JointType::kSlider;
      joint.start = ref;
      refs_[joint.name] = ref;
    }
    if (!is_limited) return;
    const std::vector<double> range = element.Numbers("range", 2, 2);
    builder_.SetLimits(joint, unit * range[0], unit * range[1]);
  }

  // Actuators: their forces serve `hold`.

  void AddActuator(const xml_node& node) {
    if (node.type() != pugi::node_element) return;
    const MjcfElement actuator = values_.Element(node, "general", "");
    const std::string name = NameOf(node, "actuator"), joint(actuator.Text("joint"));
    if (joint.empty()) return builder_.Leave(fmt::format("actuator {} of no joint", name));
    double force = 0;
    const auto take = [&](const char* range, const char* limited) {
      if (force > 0 || !IsLimited(actuator, range, limited)) return;
      const std::vector<double> ends = actuator.Numbers(range, 2, 2);
      force = std::min(std::abs(ends[0]), std::abs(ends[1]));
    };
    take("forcerange", "forcelimited");
    if (node.name() == std::string_view("motor")) take("ctrlrange", "ctrllimited");
    const std::vector<double> gear = actuator.Numbers("gear", 0, 6);
    efforts_[joint] += force * std::abs(gear.empty() ? 1 : gear[0]);
    builder_.Leave(force > 0 ? "control of an actuator" : "actuator without a range of forces");
  }

  double EffortOf(const MjcfElement& element, const std::string& name) const {
    const auto found = efforts_.find(name);
    double effort = found == efforts_.end() ? 0 : found->second;
    if (!IsLimited(element, "actuatorfrcrange", "actuatorfrclimited")) return effort;
    const std::vector<double> ends = element.Numbers("actuatorfrcrange", 2, 2);
    const double least = std::min(std::abs(ends[0]), std::abs(ends[1]));
    return effort > 0 ? std::min(effort, least) : least;
  }

  // Equalities and collisions.

  void AddEquality(const xml_node& node) {
    if (node.type() != pugi::node_element) return;
    const MjcfElement equality = values_.Element(node, "equality", "");
    if (equality.Text("active") == "false") return;
    const std::string kind = node.name(), name(equality.Text("joint1"));
    const auto find = [&](const char* attribute) {
      const auto found = std::ranges::find(joints_, equality.Text(attribute),
                                           [](const NamedJoint& j) { return j.joint.name; });
      return found == joints_.end() ? nullptr : &found->joint;
    };
    if (kind != "joint") {
      std::vector<std::string_view> ends;
      for (const char* end : {"name", "body1", "body2", "site1", "site2", "tendon1", "tendon2"})
        if (equality.Has(end)) ends.push_back(equality.Text(end));
      return builder_.Leave(fmt::format("equality {} ({})", kind, fmt::join(ends, ", ")));
    }
    RobotJoint* joint = find("joint1");
    if (joint == nullptr) equality.Fail(fmt::format("there is no joint '{}'", name), "");
    std::vector<double> factors = equality.Numbers("polycoef", 0, 5);
    if (factors.empty()) factors = {0, 1};
    factors.resize(5, 0);
    const bool is_linear = factors[2] == 0 && factors[3] == 0 && factors[4] == 0;
    const bool moves = joint->type == JointType::kHinge || joint->type == JointType::kSlider;
    if (!is_linear || !moves)
      return builder_.Leave(
          fmt::format("equality of joint {}{}", name, is_linear ? "" : ", which is not linear"));
    const double own = refs_[name] + factors[0];
    const std::string second(equality.Text("joint2"));
    if (second.empty()) return HoldAt(*joint, joint->type == JointType::kSlider, own);
    if (find("joint2") == nullptr) equality.Fail(fmt::format("there is no joint '{}'", second), "");
    joint->start = 0;
    builder_.SetMimic(*joint, second, factors[1], own - factors[1] * refs_[second]);
  }

  void DisableContacts(const xml_node& root) {
    for (const xml_node& contact : root.children("contact"))
      for (const xml_node& exclude : contact.children("exclude")) {
        const std::string first = exclude.attribute("body1").value(),
                          second = exclude.attribute("body2").value();
        for (const std::string& name : {first, second})
          if (std::ranges::find(bodies_, name, &Body::name) == bodies_.end())
            file_.Fail(exclude, fmt::format("there is no body '{}'", name), "");
        builder_.Disable(first, second);
      }
    // Bodies that are fixed to one another collide as one.
    std::vector<std::vector<const Body*>> wholes(bodies_.size());
    for (const Body& body : bodies_)
      if (!body.masks.empty()) wholes[body.whole].push_back(&body);
    std::size_t partly = 0;
    for (std::size_t i = 0; i < wholes.size(); ++i)
      for (std::size_t j = i + 1; j < wholes.size(); ++j) {
        std::size_t pairs = 0, touching = 0;
        for (const Body* a : wholes[i])
          for (const Body* b : wholes[j]) CountTouching(*a, *b, pairs, touching);
        partly += touching > 0 && touching < pairs ? 1 : 0;
        if (touching > 0) continue;
        for (const Body* a : wholes[i])
          for (const Body* b : wholes[j]) builder_.Disable(a->name, b->name);
      }
    if (partly > 0)
      builder_.Leave(
          fmt::format("masks of single shapes, as {} pairs of bodies collide by some of "
                      "theirs",
                      partly));
  }

  static void CountTouching(const Body& a, const Body& b, std::size_t& pairs,
                            std::size_t& touching) {
    for (const auto& [own, takes] : a.masks)
      for (const auto& [other, other_takes] : b.masks) {
        ++pairs;
        touching += (own & other_takes) != 0 || (other & takes) != 0 ? 1 : 0;
      }
  }

  const XmlFile& file_;
  RobotBuilder& builder_;
  const MjcfValues values_;
  MjcfShapes shapes_{file_, builder_, values_};
  std::map<std::string, int> unnamed_;
  std::map<std::string, double> efforts_, refs_;  ///< by joint
  std::vector<Body> bodies_;                      ///< the first one is the world
  std::vector<NamedJoint> joints_;
};

}  // namespace

std::optional<Robot> ReadMjcf(const std::string& text, RobotBuilder& builder,
                              std::vector<RobotFault>&) {
  const XmlFile file(text, builder.path());
  return MjcfReader(file, builder).Read();
}

}  // namespace cdb::robots
