#include "library/robots/builder.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ranges>
#include <set>
#include <system_error>
#include <utility>

#include "compiler/plan/input_file.h"
#include "library/objects/solid.h"
#include "library/robots/reader.h"

namespace cdb::robots {

using analysis::Robot;
using analysis::RobotInertia;
using analysis::RobotJoint;
using analysis::RobotLink;
using analysis::RobotShape;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

namespace fs = std::filesystem;

/// By which a moment of inertia may exceed the sum of the others: files have rounded numbers.
constexpr double kRoundedInertia = 1.01;

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
    // Some files write `package:///NAME/REST`.
    const std::size_t name = std::min(written.find_first_not_of('/', scheme + 3), written.size());
    const fs::path in_package(written.substr(name));
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

}  // namespace

bool IsInRange(const Vector3d& v) {
  return std::abs(v.x()) <= kLargest && std::abs(v.y()) <= kLargest && std::abs(v.z()) <= kLargest;
}

void RobotBuilder::Report(std::size_t line, const std::string& cause, const std::string& remedy) {
  faults_.push_back({fmt::format("{}:{}: {}", path_, line, cause), remedy});
}

std::optional<RobotInertia> RobotBuilder::InertiaOf(const RobotLink& link, double mass,
                                                    const Isometry3d& pose,
                                                    const Matrix3d& tensor) {
  const auto refuse = [&](const std::string& cause, const char* remedy) {
    Report(link.line, fmt::format("link {} {}", link.name, cause), remedy);
    return std::nullopt;
  };
  if (!(std::abs(mass) <= kLargest) || !(tensor.cwiseAbs().maxCoeff() <= kLargest) ||
      !IsInRange(pose.translation()))
    return refuse("has a mass or an inertia that is no number below 1e9",
                  "the units are kg, m and kg m^2");
  if (mass < 0) return refuse(fmt::format("has the mass {:.6g} kg", mass), "a mass is more than 0");
  if (mass == 0) {  // as many files write for frames, and for bases that are fixed
    if (!tensor.isZero(0))
      Note(fmt::format("link {} has no mass, so its inertia is ignored", link.name));
    return std::nullopt;
  }
  const Vector3d moments = tensor.selfadjointView<Eigen::Lower>().eigenvalues();
  if (moments[0] < -1e-9 * std::abs(moments[2]))
    return refuse(
        fmt::format("has an inertia that no body has: of the principal moments {:.4g}, "
                    "{:.4g} and {:.4g} kg m^2, one is negative",
                    moments[0], moments[1], moments[2]),
        "correct the inertia: it is about the centre of mass, along the axes of its frame");
  return RobotInertia{mass, pose.translation(), pose.linear() * tensor * pose.linear().transpose()};
}

void RefuseOddInertias(const Robot& robot, const std::string& path,
                       std::vector<analysis::RobotFault>& faults) {
  for (const RobotLink& link : robot.links) {
    if (!link.inertia) continue;
    const Vector3d moments =
        link.inertia->tensor.selfadjointView<Eigen::Lower>().eigenvalues().cwiseMax(0);
    if (moments[2] <= kRoundedInertia * (moments[0] + moments[1])) continue;
    faults.push_back(
        {fmt::format("{}:{}: link {} has an inertia that no body has: of the principal moments "
                     "{:.4g}, {:.4g} and {:.4g} kg m^2, one is more than the sum of the others",
                     path, link.line, link.name, moments[0], moments[1], moments[2]),
         "correct the inertia, or write `inertia any` in the block of the robot: Bullet simulates "
         "such bodies"});
  }
}

RobotShape RobotBuilder::MeshOf(const std::string& written, const Vector3d& scale) const {
  RobotShape shape;
  shape.kind = RobotShape::Kind::kMesh;
  shape.sides = scale;
  shape.written = written;
  shape.file = MeshPath(written, path_, options_.packages);
  shape.is_missing = !plan::WhyNotReadable(shape.file).empty();
  std::string extension = fs::path(shape.file).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (shape.is_missing || extension != ".dae") return shape;
  constexpr std::size_t kHead = 1 << 20;  // the axis is stated in the first element
  std::string why;
  const auto bytes = plan::ReadInputFile(shape.file, why);
  shape.is_turned = bytes && bytes->substr(0, kHead).find("Z_UP") != std::string::npos;
  return shape;
}

void RobotBuilder::AddShape(RobotLink& link, RobotShape shape) {
  if (!IsInRange(shape.pose.translation()))
    return Report(
        link.line,
        fmt::format("a collision shape of link {} has no position below 1e9 m", link.name), "");
  const bool is_mesh = shape.kind == RobotShape::Kind::kMesh;
  // A point of contact, which no body of Bullet is.
  if (shape.kind == RobotShape::Kind::kSphere && shape.sides.isZero(0))
    return Leave("sphere of radius 0");
  const double least = is_mesh ? shape.sides.cwiseAbs().minCoeff() : shape.sides.minCoeff();
  if (!(least > 0) || !IsInRange(shape.sides))
    return Report(
        link.line,
        fmt::format("a collision shape of link {} has the {} {:.6g} x {:.6g} x {:.6g}", link.name,
                    is_mesh ? "scale" : "sides", shape.sides.x(), shape.sides.y(), shape.sides.z()),
        is_mesh ? "no factor is 0" : "each is more than 0");
  link.shapes.push_back(std::move(shape));
}

void RobotBuilder::SetTotalMass(double mass) {
  double whole = 0;
  for (const RobotLink& link : links_) whole += link.inertia ? link.inertia->mass : 0;
  if (!(whole > 0)) return;
  for (RobotLink& link : links_)
    if (link.inertia) Scale(*link.inertia, mass / whole);
}

bool RobotBuilder::SetAxis(RobotJoint& joint, Vector3d& axis, const Vector3d& value) {
  const bool is_good = IsInRange(value) && value.norm() > 1e-9;
  if (is_good)
    axis = value.normalized();
  else
    Report(joint.line, fmt::format("joint {} has no axis", joint.name),
           "an axis is a vector, such as 0 0 1");
  return is_good;
}

void RobotBuilder::SetDynamics(RobotJoint& joint, double damping, double friction) {
  joint.damping = damping;
  joint.friction = friction;
  if (!(damping >= 0) || !(friction >= 0) || !(damping + friction <= kLargest))
    Report(joint.line, fmt::format("joint {} has a damping or a friction below 0", joint.name),
           "each is 0 or more");
}

void RobotBuilder::SetLimits(RobotJoint& joint, double lower, double upper) {
  const bool is_above = lower > -kLargest, is_below = upper < kLargest;
  if (!(lower <= upper) || lower > kLargest || upper < -kLargest) {
    Report(joint.line,
           fmt::format("joint {} has the limits {:.6g} and {:.6g}", joint.name, lower, upper),
           "the lower one must not be above the upper one");
  } else if (lower == upper) {
    Note(fmt::format("joint {} is fixed: its limits are equal", joint.name));
    HoldAt(joint, joint.type == RobotJoint::Type::kSlider, lower);
  } else if (is_above && is_below) {
    joint.limits = {lower, upper};
  } else if (is_above || is_below) {
    Leave(fmt::format("the only limit of joint {}", joint.name));
  }
}

void RobotBuilder::SetMimic(RobotJoint& joint, const std::string& followed, double multiplier,
                            double offset) {
  joint.mimic = followed;
  joint.multiplier = multiplier;
  joint.offset = offset;
  if (!(std::abs(multiplier) <= kLargest) || !(std::abs(offset) <= kLargest))
    Report(joint.line,
           fmt::format("joint {} mimics with a multiplier or an offset that is no number below 1e9",
                       joint.name),
           "");
}

std::optional<Robot> RobotBuilder::Finish(std::string name) {
  robot_.name = std::move(name);
  if (faults_.size() > before_ || !Arrange()) return std::nullopt;
  ResolveMimics(robot_, [&](const RobotJoint& joint, const std::string& cause, const char* remedy) {
    Report(joint.line, cause, remedy);
  });
  for (const auto& [what, count] : left_out_)
    robot_.left_out.push_back(count == 1 ? what : fmt::format("{} {}", count, what));
  const auto limits = std::ranges::count_if(
      robot_.joints, [](const RobotJoint& joint) { return joint.velocity > 0; });
  if (limits > 0)
    robot_.left_out.push_back(limits == 1 ? "1 velocity limit"
                                          : fmt::format("{} velocity limits", limits));
  if (faults_.size() > before_) return std::nullopt;
  return std::move(robot_);
}

bool RobotBuilder::HasOneParentEach() {
  std::map<std::string_view, std::string_view> holders;
  std::set<std::string_view> names;
  for (const NamedJoint& named : joints_) {
    if (!names.insert(named.joint.name).second)
      Report(named.joint.line, fmt::format("there are two joints '{}'", named.joint.name),
             "names are unique");
    const auto [holder, is_new] = holders.emplace(named.child, named.joint.name);
    if (!is_new)
      Report(named.child_line,
             fmt::format("link {} is the child of two joints, {} and {}", named.child,
                         holder->second, named.joint.name),
             "robots are trees; close the loop by `joints { … }` in the .cdb file");
  }
  return faults_.size() == before_;
}

bool RobotBuilder::Arrange() {
  if (!HasOneParentEach()) return false;
  std::map<std::string_view, std::size_t> places;  // of links, then in the robot
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (!places.emplace(links_[i].name, i).second) {
      Report(links_[i].line, fmt::format("there are two links '{}'", links_[i].name),
             "names are unique");
      return false;
    }
  std::vector<std::vector<const NamedJoint*>> children(links_.size());
  std::vector<char> is_held(links_.size(), 0), is_reached(links_.size(), 0);
  for (const NamedJoint& named : joints_) {
    const auto parent = places.find(named.parent), child = places.find(named.child);
    if (parent == places.end() || child == places.end()) {
      Report(named.joint.line,
             fmt::format("joint {} joins link {}, which the robot does not have", named.joint.name,
                         parent == places.end() ? named.parent : named.child),
             "");
      return false;
    }
    children[parent->second].push_back(&named);
    is_held[child->second] = 1;
  }
  const auto root = static_cast<std::size_t>(std::ranges::find(is_held, char{0}) - is_held.begin());
  struct Open {
    std::size_t link;
    const NamedJoint* joint;
    std::size_t parent;  ///< in the robot
  };
  std::vector<Open> open;
  if (root < links_.size()) open.push_back({root, nullptr, 0});
  while (!open.empty()) {
    const Open next = open.back();
    open.pop_back();
    const std::size_t index = robot_.links.size();
    is_reached[next.link] = 1;
    for (const NamedJoint* child : children[next.link] | std::views::reverse)
      open.push_back({places.at(child->child), child, index});
    if (next.joint != nullptr) {
      RobotJoint& joint = robot_.joints.emplace_back(next.joint->joint);
      joint.parent = next.parent;
      joint.child = index;
    }
    robot_.links.push_back(links_[next.link]);
  }
  const auto lost =
      static_cast<std::size_t>(std::ranges::find(is_reached, char{0}) - is_reached.begin());
  if (lost == links_.size()) return true;
  Report(links_[lost].line,
         fmt::format("the joints that hold link {} make a circle", links_[lost].name),
         root == links_.size()
             ? std::string("one link, the root, is the child of no joint")
             : fmt::format("each link hangs from the root, {}, by one joint", links_[root].name));
  return false;
}

namespace {

/// Its solid, whose axis is y.
struct AsSolid {
  objects::Shape shape;
  Vector3d sides;
};
AsSolid SolidOf(const RobotShape& shape) {
  using Kind = RobotShape::Kind;
  const Vector3d& s = shape.sides;
  const objects::Shape form = shape.kind == Kind::kBox        ? objects::Shape::kCuboid
                              : shape.kind == Kind::kCylinder ? objects::Shape::kCylinder
                              : shape.kind == Kind::kCapsule  ? objects::Shape::kCapsule
                                                              : objects::Shape::kEllipsoid;
  return {form, {s.x(), s.z(), s.y()}};
}

}  // namespace

void Scale(RobotInertia& inertia, double factor) {
  inertia.mass *= factor;
  inertia.tensor *= factor;
}

double VolumeOf(const RobotShape& shape) {
  const AsSolid solid = SolidOf(shape);
  return objects::Visit(solid.shape, [&](auto form) { return form.Volume(solid.sides); });
}

RobotInertia InertiaOf(const RobotShape& shape, double mass) {
  const AsSolid solid = SolidOf(shape);
  const Vector3d squares = objects::Visit(
      solid.shape, [&](auto form) -> Vector3d { return form.SecondMoments(solid.sides); });
  const Vector3d along(squares.x(), squares.z(), squares.y());
  const Matrix3d tensor = (mass * (Vector3d::Constant(along.sum()) - along)).eval().asDiagonal();
  return {mass, shape.pose.translation(),
          shape.pose.linear() * tensor * shape.pose.linear().transpose()};
}

}  // namespace cdb::robots
