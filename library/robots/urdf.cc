#include "library/robots/urdf.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <system_error>

#include "compiler/plan/input_file.h"
#include "library/robots/outline.h"
#include "library/scene_error.h"

namespace cdb::robots {
namespace {

using analysis::Robot;
using analysis::RobotFault;
using analysis::RobotInertia;
using analysis::RobotJoint;
using analysis::RobotLink;
using analysis::RobotOptions;
using analysis::RobotShape;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace fs = std::filesystem;

/// Larger lengths, masses and moments are errors of units.
constexpr double kLargest = 1e9;
/// By which a moment of inertia may exceed the sum of the others: files have rounded numbers.
constexpr double kRoundedInertia = 1.01;

bool IsFinite(const urdf::Vector3& v) {
  return std::abs(v.x) <= kLargest && std::abs(v.y) <= kLargest && std::abs(v.z) <= kLargest;
}
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
const std::map<std::string_view, std::set<std::string_view>> kTaken = {
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
    const auto fail = [&](const std::string& cause, const char* remedy) {
      throw library::SceneError(
          fmt::format("{}:{}: {}", path, elements_.empty() ? 1 : elements_[0].line, cause), remedy);
    };
    if (elements_.empty()) fail("has no elements", "a URDF file begins with <robot name=\"…\">");
    if (elements_[0].name != "robot")
      fail(fmt::format("begins with <{}>, not with <robot>", elements_[0].name),
           elements_[0].name == "sdf"      ? "this is SDF; export the robot as URDF"
           : elements_[0].name == "mujoco" ? "this is MJCF; export the robot as URDF"
                                           : "name a URDF file");
    for (const Element& element : elements_)
      if (element.name.starts_with("xacro:"))
        throw library::SceneError(
            fmt::format("{}:{}: <{}> is a macro of xacro", path, element.line, element.name),
            "expand it first: `xacro robot.urdf.xacro > robot.urdf`");
    Reduce();
  }

  const std::vector<Element>& elements() const { return elements_; }
  const std::string& reduced() const { return text_; }
  std::vector<std::string> LeftOut() const {
    std::vector<std::string> texts;
    for (const auto& [name, count] : left_out_)
      texts.push_back(count == 1 ? name : fmt::format("{} {}", count, name));
    return texts;
  }
  /// The line of a link or a joint; that of the root if there is none.
  std::size_t LineOf(std::string_view kind, std::string_view name) const {
    for (const Element& element : elements_)
      if (element.parent == 0 && element.name == kind && element.Attribute("name") == name)
        return element.line;
    return elements_[0].line;
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
  /// Overwrites what is not taken with blanks, so that lines remain.
  void Reduce() {
    std::vector<char> is_out(elements_.size(), 0);
    for (std::size_t i = 1; i < elements_.size(); ++i) {
      const Element& element = elements_[i];
      const Element& parent = elements_[element.parent];
      is_out[i] = is_out[element.parent];
      if (is_out[i] != 0) continue;
      const auto taken = kTaken.find(parent.name);
      if (taken == kTaken.end() || taken->second.contains(element.name)) continue;
      if (parent.name == "geometry")
        throw library::SceneError(
            fmt::format("{}:{}: a collision shape is a <{}>, which URDF does not have", path_,
                        element.line, element.name),
            "write a box, a cylinder, a sphere or a mesh");
      is_out[i] = 1;
      ++left_out_[element.name];
      for (std::size_t at = element.begin; at < element.end; ++at)
        if (text_[at] != '\n') text_[at] = ' ';
    }
  }

  const std::string& path_;
  std::string text_;
  std::vector<Element> elements_;
  std::map<std::string, int> left_out_;
};

/// The mesh file that a robot names. `package://NAME/REST` (and `model://`) is REST in the folder
/// NAME, which is searched for in `packages` and in each folder above the robot's file, or REST in
/// `packages` itself. Other names are relative to the folder of the robot's file. A path that does
/// not exist is the first one where the file should be. Source: http://wiki.ros.org/Packages.
std::string MeshPath(std::string_view written, const std::string& robot_file,
                     const std::string& packages) {
  const fs::path folder = fs::path(robot_file).parent_path();
  std::vector<fs::path> candidates;
  const std::size_t scheme = written.find("://");
  if (scheme == written.npos) {
    candidates.push_back(folder / written);
  } else if (written.starts_with("file://")) {
    candidates.push_back(folder / written.substr(scheme + 3));
  } else {
    const fs::path in_package(written.substr(scheme + 3));
    const fs::path rest = in_package.lexically_relative(*in_package.begin());
    if (!packages.empty()) {
      candidates.push_back(fs::path(packages) / in_package);
      candidates.push_back(fs::path(packages) / rest);
    }
    std::error_code error;
    fs::path above = fs::absolute(folder, error).lexically_normal(), way = folder;
    for (; !above.empty() && above != above.parent_path(); above = above.parent_path()) {
      candidates.push_back(way / in_package);
      if (above.filename() == *in_package.begin()) candidates.push_back(way / rest);
      way /= "..";
    }
  }
  std::error_code error;
  for (const fs::path& candidate : candidates)
    if (fs::is_regular_file(candidate, error)) return candidate.lexically_normal().string();
  return candidates.empty() ? std::string(written) : candidates[0].lexically_normal().string();
}

/// Makes a robot of urdfdom's model, and finds its faults.
class Builder {
 public:
  Builder(const Document& document, const std::string& path, const RobotOptions& options,
          std::vector<RobotFault>& faults)
      : document_(document), path_(path), options_(options), faults_(faults) {}

  std::optional<Robot> Build(const urdf::ModelInterface& model) {
    const std::size_t before = faults_.size();
    robot_.name = model.getName();
    FindSecondParents();
    if (faults_.size() > before) return std::nullopt;
    AddLink(*model.getRoot());
    if (robot_.links.size() < model.links_.size()) ReportUnreached(model);
    if (faults_.size() > before) return std::nullopt;
    ResolveMimics(robot_, [&](const RobotJoint& joint, const std::string& cause,
                              const char* remedy) { Report(joint.line, cause, remedy); });
    robot_.left_out = document_.LeftOut();
    const auto limits = std::ranges::count_if(
        robot_.joints, [](const RobotJoint& joint) { return joint.velocity > 0; });
    if (limits > 0)
      robot_.left_out.push_back(limits == 1 ? "1 velocity limit"
                                            : fmt::format("{} velocity limits", limits));
    if (faults_.size() > before) return std::nullopt;
    return std::move(robot_);
  }

 private:
  void Report(std::size_t line, const std::string& cause, const std::string& remedy) {
    faults_.push_back({fmt::format("{}:{}: {}", path_, line, cause), remedy});
  }

  /// urdfdom takes the last joint of a link with several.
  void FindSecondParents() {
    std::map<std::string_view, std::string_view> holders;
    for (const Element& element : document_.elements()) {
      if (element.name != "child" || element.parent == Element::kNone) continue;
      const Element& joint = document_.elements()[element.parent];
      if (joint.name != "joint" || joint.parent != 0) continue;
      const auto [holder, is_new] =
          holders.emplace(element.Attribute("link"), joint.Attribute("name"));
      if (!is_new)
        Report(element.line,
               fmt::format("link {} is the child of two joints, {} and {}", holder->first,
                           holder->second, joint.Attribute("name")),
               "URDF describes trees; close the loop by `joints { … }` in the .cdb file");
    }
  }

  void ReportUnreached(const urdf::ModelInterface& model) {
    for (const auto& [name, link] : model.links_)
      if (std::ranges::find(robot_.links, name, &RobotLink::name) == robot_.links.end())
        return Report(
            document_.LineOf("link", name),
            fmt::format("the joints that hold link {} make a circle", name),
            fmt::format("each link hangs from the root, {}, by one joint", robot_.links[0].name));
  }

  /// Children in the order of their joints in the file.
  void AddLink(const urdf::Link& root) {
    std::vector<std::pair<const urdf::Link*, std::size_t>> open = {{&root, 0}};
    while (!open.empty()) {
      const auto [link, parent] = open.back();
      open.pop_back();
      const std::size_t index = robot_.links.size();
      robot_.links.push_back(LinkOf(*link));
      if (link != &root) robot_.joints.push_back(JointOf(*link->parent_joint, parent, index));
      std::vector<std::pair<std::size_t, const urdf::Link*>> children;
      for (const auto& child : link->child_links)
        children.emplace_back(document_.LineOf("joint", child->parent_joint->name), child.get());
      std::ranges::stable_sort(children, std::ranges::greater(),
                               [](const auto& c) { return c.first; });
      for (const auto& child : children) open.emplace_back(child.second, index);
    }
  }

  RobotLink LinkOf(const urdf::Link& from) {
    RobotLink link;
    link.name = from.name;
    link.line = document_.LineOf("link", from.name);
    if (from.inertial) link.inertia = InertiaOf(link, *from.inertial);
    for (const auto& collision : from.collision_array)
      if (collision && collision->geometry) AddShape(link, *collision);
    return link;
  }

  std::optional<RobotInertia> InertiaOf(const RobotLink& link, const urdf::Inertial& from) {
    const auto refuse = [&](const std::string& cause, const char* remedy) {
      Report(link.line, fmt::format("link {} {}", link.name, cause), remedy);
      return std::nullopt;
    };
    Eigen::Matrix3d tensor;
    tensor << from.ixx, from.ixy, from.ixz, from.ixy, from.iyy, from.iyz, from.ixz, from.iyz,
        from.izz;
    if (!(std::abs(from.mass) <= kLargest) || !(tensor.cwiseAbs().maxCoeff() <= kLargest) ||
        !IsFinite(from.origin.position))
      return refuse("has a mass or an inertia that is no number below 1e9",
                    "the units are kg, m and kg m^2");
    if (from.mass < 0)
      return refuse(fmt::format("has the mass {:.6g} kg", from.mass), "a mass is more than 0");
    if (from.mass == 0) {  // as many files write for frames, and for bases that are fixed
      if (!tensor.isZero(0))
        robot_.notes.push_back(
            fmt::format("link {} has no mass, so its inertia is ignored", link.name));
      return std::nullopt;
    }
    const Vector3d moments = tensor.selfadjointView<Eigen::Lower>().eigenvalues();
    const bool is_negative = moments[0] < -1e-9 * std::abs(moments[2]);
    if (is_negative ||
        (!options_.takes_any_inertia && moments[2] > kRoundedInertia * (moments[0] + moments[1])))
      return refuse(
          fmt::format("has an inertia that no body has: of the principal moments {:.4g}, {:.4g} "
                      "and {:.4g} kg m^2, one is {}",
                      moments[0], moments[1], moments[2],
                      is_negative ? "negative" : "more than the sum of the others"),
          is_negative
              ? "correct <inertia>: it is about the centre of mass, along the axes of its "
                "<origin>"
              : "correct <inertia>, or write `inertia any` in the block of the robot: Bullet "
                "simulates such bodies");
    const Isometry3d pose = ToEigen(from.origin);
    return RobotInertia{from.mass, pose.translation(),
                        pose.linear() * tensor * pose.linear().transpose()};
  }

  void AddShape(RobotLink& link, const urdf::Collision& from) {
    RobotShape shape;
    if (!IsFinite(from.origin.position))
      return Report(
          link.line,
          fmt::format("a collision shape of link {} has no position below 1e9 m", link.name), "");
    shape.pose = ToEigen(from.origin);
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
      case urdf::Geometry::MESH:
        TakeMesh(shape, static_cast<const urdf::Mesh&>(*from.geometry));
        break;
      default:  // of later versions; Document refuses them
        return;
    }
    const bool is_mesh = shape.kind == RobotShape::Kind::kMesh;
    const double least = is_mesh ? shape.sides.cwiseAbs().minCoeff() : shape.sides.minCoeff();
    if (!(least > 0) || !(shape.sides.cwiseAbs().maxCoeff() <= kLargest))
      return Report(link.line,
                    fmt::format("a collision shape of link {} has the {} {:.6g} x {:.6g} x {:.6g}",
                                link.name, is_mesh ? "scale" : "sides", shape.sides.x(),
                                shape.sides.y(), shape.sides.z()),
                    is_mesh ? "no factor is 0" : "each is more than 0");
    link.shapes.push_back(std::move(shape));
  }

  void TakeMesh(RobotShape& shape, const urdf::Mesh& mesh) {
    shape.kind = RobotShape::Kind::kMesh;
    shape.sides = ToEigen(mesh.scale);
    shape.written = mesh.filename;
    shape.file = MeshPath(mesh.filename, path_, options_.packages);
    shape.is_missing = !plan::WhyNotReadable(shape.file).empty();
    std::string extension = std::filesystem::path(shape.file).extension().string();
    for (char& c : extension)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (shape.is_missing || extension != ".dae") return;
    constexpr std::size_t kHead = 1 << 20;  // the axis is stated in the first element
    std::string why;
    const auto bytes = plan::ReadInputFile(shape.file, why);
    shape.is_turned = bytes && bytes->substr(0, kHead).find("Z_UP") != std::string::npos;
  }

  RobotJoint JointOf(const urdf::Joint& from, std::size_t parent, std::size_t child) {
    RobotJoint joint;
    joint.name = from.name;
    joint.line = document_.LineOf("joint", from.name);
    joint.parent = parent;
    joint.child = child;
    const auto refuse = [&](const std::string& cause, const char* remedy) {
      Report(joint.line, fmt::format("joint {} {}", joint.name, cause), remedy);
    };
    if (!IsFinite(from.parent_to_joint_origin_transform.position))
      refuse("has an origin that is no number below 1e9", "the unit is m");
    joint.origin = ToEigen(from.parent_to_joint_origin_transform);
    if (from.mimic && (from.type == urdf::Joint::FIXED || from.type == urdf::Joint::FLOATING))
      robot_.notes.push_back(
          fmt::format("mimic of joint {} is ignored: its type has no position", joint.name));
    using Type = RobotJoint::Type;
    switch (from.type) {
      case urdf::Joint::FIXED:
        return joint;
      case urdf::Joint::FLOATING:
        joint.type = Type::kFree;
        return joint;
      case urdf::Joint::REVOLUTE:
      case urdf::Joint::CONTINUOUS:
        joint.type = Type::kHinge;
        break;
      case urdf::Joint::PRISMATIC:
        joint.type = Type::kSlider;
        break;
      default:
        refuse("is planar, which cdb cannot simulate",
               "two prismatic joints and a continuous one, with links of some mass between them, "
               "move alike");
        return joint;
    }
    if (!IsFinite(from.axis) || !(ToEigen(from.axis).norm() > 1e-9)) {
      refuse("has no axis", "write <axis xyz=\"0 0 1\"/>, for example");
      return joint;
    }
    joint.axis = ToEigen(from.axis).normalized();
    if (from.mimic) {
      joint.mimic = from.mimic->joint_name;
      joint.multiplier = from.mimic->multiplier;
      joint.offset = from.mimic->offset;
      if (!(std::abs(joint.multiplier) <= kLargest) || !(std::abs(joint.offset) <= kLargest))
        refuse("mimics with a multiplier or an offset that is no number below 1e9", "");
    }
    TakeLimits(from, joint);
    return joint;
  }

  void TakeLimits(const urdf::Joint& from, RobotJoint& joint) {
    const auto refuse = [&](const std::string& cause, const char* remedy) {
      Report(joint.line, fmt::format("joint {} {}", joint.name, cause), remedy);
    };
    if (from.dynamics) {
      joint.damping = from.dynamics->damping;
      joint.friction = from.dynamics->friction;
      if (!(joint.damping >= 0) || !(joint.friction >= 0) ||
          !(joint.damping + joint.friction <= kLargest))
        refuse("has a damping or a friction below 0", "each is 0 or more");
    }
    if (!from.limits) return;
    joint.effort = std::max(from.limits->effort, 0.0);
    joint.velocity = std::max(from.limits->velocity, 0.0);
    if (from.type == urdf::Joint::CONTINUOUS) return;
    const double lower = from.limits->lower, upper = from.limits->upper;
    if (!(lower <= upper)) {
      refuse(fmt::format("has the limits {:.6g} and {:.6g}", lower, upper),
             "the lower one must not be above the upper one");
    } else if (lower == upper) {
      robot_.notes.push_back(fmt::format("joint {} is fixed: its limits are equal", joint.name));
      HoldAt(joint, from.type == urdf::Joint::PRISMATIC, lower);
    } else if (lower > -kLargest && upper < kLargest) {
      joint.limits = {lower, upper};
    }
  }

  const Document& document_;
  const std::string& path_;
  const RobotOptions& options_;
  std::vector<RobotFault>& faults_;
  Robot robot_;
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

/// `disable_collisions` of an SRDF file.
void ReadSrdf(const std::string& path, Robot& robot) {
  std::string why;
  const auto text = plan::ReadInputFile(path, why, kMaxRobotBytes);
  if (!text)
    throw library::SceneError(fmt::format("cannot read '{}': {}", path, why),
                              "its path is relative to the folder of the .cdb file");
  for (const Element& element : ReadOutline(*text, path)) {
    if (element.name != "disable_collisions") continue;
    std::pair<std::string, std::string> links(element.Attribute("link1"),
                                              element.Attribute("link2"));
    for (const std::string& link : {links.first, links.second})
      if (std::ranges::find(robot.links, link, &RobotLink::name) == robot.links.end())
        throw library::SceneError(
            fmt::format("{}:{}: there is no link {}", path, element.line, link),
            "the SRDF file belongs to another robot");
    robot.disabled.push_back(std::move(links));
  }
}

std::optional<Robot> Parse(const std::string& text, const std::string& path,
                           const RobotOptions& options, std::vector<RobotFault>& faults) {
  static std::mutex one_at_a_time;
  const std::lock_guard guard(one_at_a_time);
  const Document document(text, path);
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
    faults.push_back(FaultOf(errors, document, path));
    return std::nullopt;
  }
  auto robot = Builder(document, path, options, faults).Build(*model);
  if (robot && !options.srdf.empty()) ReadSrdf(options.srdf, *robot);
  return robot;
}

}  // namespace

bool HasReader() { return true; }

std::optional<Robot> ParseUrdf(const std::string& text, const std::string& path,
                               const RobotOptions& options, std::vector<RobotFault>& faults) {
  try {
    auto robot = Parse(text, path, options, faults);
    if (robot) *robot = MergeFixed(*robot, !options.merges);
    return robot;
  } catch (const library::SceneError& error) {
    faults.push_back({error.cause(), error.remedy()});
  } catch (const std::exception& error) {
    faults.push_back({fmt::format("{}: {}", path, error.what()), ""});
  }
  return std::nullopt;
}

}  // namespace cdb::robots
