#include "library/robots/mjcf_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace cdb::robots {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using pugi::xml_node;

namespace {

constexpr const char* kMain = "main";
/// They have one set of defaults, of <general>.
constexpr std::string_view kActuators[] = {"general",  "motor",       "position",
                                           "velocity", "intvelocity", "damper",
                                           "cylinder", "muscle",      "adhesion"};

}  // namespace

std::string_view MjcfElement::Text(const char* name) const {
  const pugi::xml_attribute attribute = node_.attribute(name);
  if (attribute) return attribute.value();
  if (defaults_ == nullptr) return {};
  const auto found = defaults_->find(std::string_view(name));
  return found == defaults_->end() ? std::string_view() : std::string_view(found->second);
}

double MjcfElement::Number(const char* name, double otherwise) const {
  const std::string_view text = Text(name);
  return text.empty() ? otherwise : file_->Number(node_, text, name);
}

Vector3d MjcfElement::Vector(const char* name, const Vector3d& otherwise) const {
  const std::string_view text = Text(name);
  return text.empty() ? otherwise : file_->Vector(node_, text, name);
}

std::vector<double> MjcfElement::Numbers(const char* name, std::size_t least,
                                         std::size_t most) const {
  std::vector<double> numbers = file_->Numbers(node_, Text(name), name, least, most);
  for (const double number : numbers)
    if (!(std::abs(number) <= kLargest))
      Fail(fmt::format("{} has numbers above 1e9", name), "the units are SI");
  return numbers;
}

MjcfValues::MjcfValues(const XmlFile& file) : file_(file) {
  compiler_.angle = std::numbers::pi / 180;
  classes_[kMain];
  for (const xml_node& node : file.root().children()) {
    const std::string_view name = node.name();
    if (name == "compiler") ReadCompiler(node);
    if (name == "default") ReadDefaults(node, kMain, true);
  }
}

void MjcfValues::ReadCompiler(const xml_node& node) {
  const MjcfElement element(file_, node, nullptr);
  const auto flag = [&](const char* name, bool otherwise) {
    return element.Has(name) ? file_.Flag(node, element.Text(name), name) : otherwise;
  };
  if (const std::string_view angle = element.Text("angle"); !angle.empty()) {
    if (angle != "radian" && angle != "degree")
      element.Fail(fmt::format("angle is '{}'", angle), "write radian or degree");
    compiler_.angle = angle == "radian" ? 1 : std::numbers::pi / 180;
  }
  if (element.Text("coordinate") == "global")
    element.Fail("coordinates are global, as in old files", "write the file again by MuJoCo 2.3");
  compiler_.total_mass = element.Number("settotalmass", compiler_.total_mass);
  compiler_.has_auto_limits = flag("autolimits", compiler_.has_auto_limits);
  compiler_.strips_paths = flag("strippath", compiler_.strips_paths);
  compiler_.balances = flag("balanceinertia", compiler_.balances);
  for (const char* name : {"assetdir", "meshdir"})
    if (element.Has(name)) compiler_.mesh_folder = element.Text(name);
  if (element.Has("eulerseq")) compiler_.euler = element.Text("eulerseq");
  if (compiler_.euler.size() != 3 ||
      compiler_.euler.find_first_not_of("xyzXYZ") != std::string::npos)
    element.Fail(fmt::format("eulerseq is '{}'", compiler_.euler), "write xyz, for example");
  if (const std::string_view from = element.Text("inertiafromgeom"); !from.empty())
    compiler_.from_shapes = from == "auto" ? MjcfCompiler::FromShapes::kAuto
                            : file_.Flag(node, from, "inertiafromgeom")
                                ? MjcfCompiler::FromShapes::kAlways
                                : MjcfCompiler::FromShapes::kNever;
  if (element.Has("inertiagrouprange")) {
    const std::vector<double> range = element.Numbers("inertiagrouprange", 2, 2);
    compiler_.first_group = static_cast<int>(range[0]);
    compiler_.last_group = static_cast<int>(range[1]);
  }
  compiler_.least_mass = element.Number("boundmass", compiler_.least_mass);
  compiler_.least_moment = element.Number("boundinertia", compiler_.least_moment);
}

void MjcfValues::ReadDefaults(const xml_node& node, const std::string& parent, bool is_root) {
  const std::string given = node.attribute("class").value();
  if (given.empty() && !is_root)
    file_.Fail(node, "a class of defaults has no name", "write <default class=\"…\">");
  const std::string name = is_root ? kMain : given;
  if (!is_root && classes_.contains(name))
    file_.Fail(node, fmt::format("there is another class '{}'", name), "names are unique");
  Class values = classes_.at(parent);
  for (const xml_node& child : node.children()) {
    const std::string_view kind = child.name();
    if (kind == "default") continue;
    const bool is_actuator = std::ranges::find(kActuators, kind) != std::end(kActuators);
    MjcfElement::Values& of_kind = values[is_actuator ? "general" : std::string(kind)];
    for (const pugi::xml_attribute& attribute : child.attributes())
      of_kind[attribute.name()] = attribute.value();
  }
  classes_[name] = std::move(values);
  if (is_root && !given.empty()) classes_[given] = classes_.at(kMain);
  for (const xml_node& child : node.children("default")) ReadDefaults(child, name, false);
}

const MjcfValues::Class& MjcfValues::ClassOf(const std::string& name, const xml_node& by) const {
  const auto found = classes_.find(name);
  if (found == classes_.end())
    file_.Fail(by, fmt::format("there is no class '{}'", name), "write <default class=\"…\">");
  return found->second;
}

MjcfElement MjcfValues::Element(const xml_node& node, const std::string& kind,
                                const std::string& of_body) const {
  const std::string own = node.attribute("class").value();
  const Class& values = ClassOf(!own.empty() ? own : !of_body.empty() ? of_body : kMain, node);
  const auto found = values.find(kind);
  return {file_, node, found == values.end() ? nullptr : &found->second};
}

Matrix3d MjcfValues::TurnOfZ(const Vector3d& way) {
  const Vector3d axis = Vector3d::UnitZ().cross(way);
  const double sine = axis.norm();
  const Vector3d about = sine < 1e-12 * way.norm() ? Vector3d::UnitX() : Vector3d(axis / sine);
  return AngleAxisd(std::atan2(sine, way.z()), about).toRotationMatrix();
}

Matrix3d MjcfValues::TurnOf(const MjcfElement& element) const {
  const auto needs = [&](bool is_good, const char* name) {
    if (!is_good) element.Fail(fmt::format("{} is no orientation", name), "it has no direction");
  };
  if (element.Has("axisangle")) {
    const std::vector<double> n = element.Numbers("axisangle", 4, 4);
    const Vector3d axis(n[0], n[1], n[2]);
    needs(axis.norm() > 1e-9, "axisangle");
    return AngleAxisd(n[3] * compiler_.angle, axis.normalized()).toRotationMatrix();
  }
  if (element.Has("xyaxes")) {
    const std::vector<double> n = element.Numbers("xyaxes", 6, 6);
    Vector3d x(n[0], n[1], n[2]), y(n[3], n[4], n[5]);
    needs(x.norm() > 1e-9, "xyaxes");
    x.normalize();
    y -= x * x.dot(y);
    needs(y.norm() > 1e-9, "xyaxes");
    y.normalize();
    Matrix3d turn;
    turn << x, y, x.cross(y);
    return turn;
  }
  if (element.Has("zaxis")) {
    const Vector3d way = element.Vector("zaxis", Vector3d::UnitZ());
    needs(way.norm() > 1e-9, "zaxis");
    return TurnOfZ(way);
  }
  if (element.Has("euler")) {
    const Vector3d angles = element.Vector("euler", Vector3d::Zero()) * compiler_.angle;
    Matrix3d turn = Matrix3d::Identity();
    for (int i = 0; i < 3; ++i) {
      const char axis = compiler_.euler[static_cast<std::size_t>(i)];
      const bool moves = axis >= 'x';  // lower case: about axes that turn along
      const Matrix3d by =
          AngleAxisd(angles[i], Vector3d::Unit(moves ? axis - 'x' : axis - 'X')).toRotationMatrix();
      turn = moves ? Matrix3d(turn * by) : Matrix3d(by * turn);
    }
    return turn;
  }
  if (!element.Has("quat")) return Matrix3d::Identity();
  const std::vector<double> n = element.Numbers("quat", 4, 4);
  const Eigen::Quaterniond turn(n[0], n[1], n[2], n[3]);
  needs(turn.norm() > 1e-9, "quat");
  return turn.normalized().toRotationMatrix();
}

Isometry3d MjcfValues::PoseOf(const MjcfElement& element) const {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = element.Vector("pos", Vector3d::Zero());
  pose.linear() = TurnOf(element);
  return pose;
}

}  // namespace cdb::robots
