#include "compiler/scenario/robot_blocks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/scenario/scenario.h"
#include "compiler/scenario/syntax_maker.h"
#include "dsl/text/utf8.h"

namespace cdb::scenario {
namespace {

using analysis::Robot;
using analysis::RobotJoint;
using analysis::RobotLink;
using analysis::RobotShape;
using dsl::Expr;
using dsl::ExprKind;
using dsl::ExprPtr;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr RobotSetting kSettings[] = {
    {"file", "a text in quotes", "the URDF, SDF or MJCF file, relative to the .cdb file"},
    {"packages", "a text in quotes", "the folder with the packages of `package://` names"},
    {"srdf", "a text in quotes", "an SRDF file, whose disabled pairs of links do not collide"},
    {"base", "free or fixed",
     "fixed holds the root link to the world; the default is free, or "
     "fixed if the root link is called world"},
    {"up", "z or y",
     "the vertical axis of the file; z turns its coordinates (x, y, z) to (x, z, -y)"},
    {"positions", "a block",
     "the positions of joints at the start; others start at 0, or in the "
     "middle of their limits if these exclude 0"},
    {"hold", "on or off", "motors with the effort of the file hold the joints where they start"},
    {"armature", "on or off",
     "the armatures of the file, which need coordinates reduced; off by default"},
    {"self_collision", "on or off", "whether links that no joint joins collide; off by default"},
    {"fixed_joints", "merge or keep",
     "keep makes a body of each link that has mass or shapes, and "
     "joints of type fixed; by default fixed joints make one body"},
    {"dummy_links", "on or off",
     "links of 0.1 % of the mass of a body stand between its joints, if it has several in MJCF; "
     "off by default"},
    {"density", "a number", "kg/m^3, of links that have shapes, but no <inertial>"},
    {"inertia", "possible or any", "any takes inertias that no body has"},
    {"prefix", "a text in quotes", "begins the names of links and joints"},
};

/// Settings of objects that the file determines.
constexpr std::string_view kOfFile[] = {"type",          "size",    "aspect",          "mass",
                                        "collides_with", "overlap", "angular_velocity"};
constexpr std::string_view kOfBase[] = {"quantity", "location", "orientation", "region"};

/// Of a link that has mass, but no shape or no extent, m.
constexpr double kMarker = 0.01;

Vector3d TurnOf(const Matrix3d& turn) {
  const Eigen::AngleAxisd about(turn);
  return about.angle() * about.axis();
}

/// (x, y, z) to (x, z, -y).
Matrix3d ZToY() {
  Matrix3d turn;
  turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return turn;
}

class Expansion {
 public:
  Expansion(const Scenario& scenario, const dsl::Group& block,
            const std::vector<std::string>& others,
            const std::function<bool(const std::string&)>& is_word, dsl::Diagnostics& diagnostics)
      : scenario_(scenario),
        block_(block),
        others_(others),
        is_word_(is_word),
        diagnostics_(diagnostics),
        at_(block.label ? block.label->span : block.kind.span),
        syntax_(at_) {}

  std::optional<RobotBlocks> Run() {
    for (const dsl::Statement& statement : block_.block.statements) Take(statement);
    const dsl::Expr* file = Find("file");
    if (good_ && file == nullptr)
      Refuse(kBadArguments, at_, "the robot has no file", "write file \"robot.urdf\"");
    if (const dsl::Expr* srdf = Find("srdf");
        srdf != nullptr && Word("self_collision", "off") == "off")
      Refuse(kContradiction, srdf->span,
             "an SRDF file names pairs of links that do not collide, but none do",
             "write self_collision on, or remove it");
    if (!good_ || !ReadFile(*file)) return std::nullopt;
    if (Word("up", "z") == "z") turn_ = ZToY();
    is_fixed_ = Word("base", IsOnWorld() ? "fixed" : "free") == "fixed";
    NameAll();
    for (std::size_t i = 0; i < robot_->links.size(); ++i) AddLink(i);
    RefuseMassless();
    for (const RobotJoint& joint : robot_->joints) AddJoint(joint);
    if (!good_) return std::nullopt;
    NameWithoutEffort();
    PlaceGiven();
    if (!good_) return std::nullopt;
    return std::move(result_);
  }

 private:
  void Refuse(const dsl::DiagnosticKind& kind, const text::Span& span, std::string message,
              std::string help = {}) {
    diagnostics_.Report(kind, span, std::move(message), std::move(help));
    good_ = false;
  }

  // What the block says.

  void Take(const dsl::Statement& statement) {
    if (const auto* setting = std::get_if<dsl::Setting>(&statement.what)) return Take(*setting);
    if (const auto* group = std::get_if<dsl::Group>(&statement.what);
        group != nullptr && group->kind.text == "positions")
      return TakePositions(*group);
    Refuse(kWrongPlace, statement.span, "only settings and positions { … } are in a robot",
           "write it outside this block");
  }

  void TakePositions(const dsl::Group& group) {
    for (const dsl::Statement& statement : group.block.statements)
      if (const auto* setting = std::get_if<dsl::Setting>(&statement.what))
        positions_.push_back(setting);
      else
        Refuse(kWrongPlace, statement.span, "positions are written `JOINT VALUE`");
  }

  void Take(const dsl::Setting& setting) {
    const std::string& name = setting.path.text;
    const auto* row = std::ranges::find(kSettings, name, &RobotSetting::name);
    if (row != std::end(kSettings)) {
      if (!own_.emplace(name, &setting).second)
        Refuse(kSetTwice, setting.path.span, fmt::format("'{}' is set twice", name),
               "keep one of them");
      return;
    }
    const schema::Parameter* parameter = schema::FindParameter(name, true);
    if (std::ranges::find(kOfFile, name) != std::end(kOfFile))
      return Refuse(kContradiction, setting.path.span,
                    fmt::format("the file of a robot determines '{}'", name),
                    fmt::format("to change one link, write {}.{} outside the block", "LINK", name));
    if (parameter == nullptr || !parameter->NamedBlock().empty() || name.starts_with("links.")) {
      std::vector<std::string_view> names;
      for (const RobotSetting& known : kSettings) names.push_back(known.name);
      names.insert(names.end(), std::begin(kOfBase), std::end(kOfBase));
      names.push_back("friction");
      const std::string_view near = dsl::DidYouMean(name, names);
      return Refuse(
          kUnknownName, setting.path.span,
          fmt::format("no parameter of a robot is called '{}'", name),
          near.empty() ? "`cdb doc robots` lists them" : fmt::format("did you mean '{}'?", near));
    }
    of_objects_.emplace_back(&setting, parameter);
  }

  const Expr* Find(std::string_view name) const {
    const auto found = own_.find(name);
    return found == own_.end() || found->second->values.empty() ? nullptr
                                                                : found->second->values[0].get();
  }

  /// The word of a setting, one of those that it takes.
  std::string Word(std::string_view name, std::string_view otherwise) {
    const Expr* value = Find(name);
    if (value == nullptr) return std::string(otherwise);
    const auto* row = std::ranges::find(kSettings, name, &RobotSetting::name);
    const std::string takes = fmt::format(" {} ", row->takes);
    if (value->kind == ExprKind::kPath && value->text != "or" &&
        takes.find(fmt::format(" {} ", value->text)) != takes.npos)
      return value->text;
    Refuse(kWrongKind, value->span, fmt::format("'{}' takes {}", name, row->takes));
    return std::string(otherwise);
  }

  std::string Text(std::string_view name) {
    const Expr* value = Find(name);
    if (value == nullptr) return {};
    if (value->kind == ExprKind::kText) return value->text;
    Refuse(kWrongKind, value->span, fmt::format("'{}' takes a text in quotes", name),
           fmt::format("such as {} \"robot\"", name));
    return {};
  }

  /// A path that is relative to the file of the scenario.
  std::string Path(std::string_view name) {
    const std::string text = Text(name);
    if (text.empty()) return text;
    return (Folder() / text).lexically_normal().string();
  }

  std::filesystem::path Folder() const {
    return std::filesystem::path(at_.source->name()).parent_path();
  }

  // The robot.

  bool ReadFile(const Expr& file) {
    analysis::RobotOptions options;
    const std::string path = Path("file");
    options.packages = Path("packages");
    options.srdf = Path("srdf");
    options.merges = Word("fixed_joints", "merge") == "merge";
    options.takes_any_inertia = Word("inertia", "possible") == "any";
    options.has_dummy_links = Word("dummy_links", "off") == "on";
    if (!good_) return false;
    std::vector<analysis::RobotFault> faults;
    robot_ = scenario_.RobotAt(path, options, faults);
    if (!faults.empty()) {
      const analysis::RobotFault& fault = faults[0];
      Refuse(fault.kind == analysis::RobotFault::Kind::kMissing       ? kNoSuchFile
             : fault.kind == analysis::RobotFault::Kind::kUnavailable ? kUnavailable
                                                                      : kOutOfDomain,
             file.span, fault.cause + AndMore(faults.size(), path), fault.remedy);
    }
    if (robot_ == nullptr) return false;
    path_ = path;
    RefuseMissing(file);
    return good_;
  }

  static std::string AndMore(std::size_t count, const std::string& path) {
    if (count < 2) return {};
    return fmt::format(" (and {} more: `cdb check {}` lists them)", count - 1, path);
  }

  void RefuseMissing(const Expr& file) {
    std::size_t count = 0;
    std::string first, remedy;
    for (const RobotLink& link : robot_->links)
      for (const RobotShape& shape : link.shapes) {
        if (!shape.is_missing || count++ > 0) continue;
        first = fmt::format("{}:{}: link {} has the mesh '{}', but there is no file '{}'", path_,
                            link.line, link.name, shape.written, shape.file);
        remedy = shape.written.find("://") != std::string::npos
                     ? "write packages \"FOLDER\", the folder that its package is in"
                     : "its path is relative to the folder of the robot's file";
      }
    if (count > 0) Refuse(kNoSuchFile, file.span, first + AndMore(count, path_), remedy);
  }

  bool IsOnWorld() const {
    const RobotLink& root = robot_->links[0];
    return root.name == "world" || std::ranges::find(root.parts, "world") != root.parts.end();
  }

  /// Names of the language, from those of the file; each once.
  void NameAll() {
    const std::string prefix = Text("prefix");
    std::set<std::string> taken;
    const auto name = [&](const std::string& written, const char* suffix) {
      std::string plain = prefix;
      for (const char c : written) plain += text::IsNameChar(c) ? c : '_';
      if (plain.empty() || text::IsDigit(plain[0])) plain.insert(0, "_");
      if (is_word_(plain) || taken.contains(plain)) plain += suffix;
      while (!taken.insert(plain).second) plain += '_';
      if (std::ranges::find(others_, plain) != others_.end())
        Refuse(kSetTwice, at_, fmt::format("there is another group '{}'", plain),
               "write prefix \"left_\", for example, in the block of the robot");
      return plain;
    };
    std::vector<std::string> renamed;
    const auto tell = [&](const char* what, const std::string& written, const std::string& plain) {
      if (plain != prefix + written)
        renamed.push_back(fmt::format("{} {} is {}", what, written, plain));
    };
    for (const RobotLink& link : robot_->links) {
      result_.groups.push_back(name(link.name, "_link"));
      tell("link", link.name, result_.groups.back());
    }
    for (const RobotJoint& joint : robot_->joints) {
      result_.joints.push_back(name(joint.name, "_joint"));
      tell("joint", joint.name, result_.joints.back());
    }
    if (!renamed.empty())
      scenario_.NoteOnRobot(
          fmt::format("  names that are taken in the scene, or are none of the language: {}",
                      fmt::join(renamed, ", ")));
  }

  // Links.

  void AddLink(std::size_t index) {
    const RobotLink& link = robot_->links[index];
    dsl::Group group = syntax_.Block("objects", result_.groups[index]);
    std::vector<dsl::Statement>& settings = group.block.statements;
    const auto set = [&](const char* name, ExprPtr value) {
      settings.push_back(syntax_.Setting(name, std::move(value)));
    };
    const bool is_base = index == 0, is_held = is_base && is_fixed_;
    if (!is_held && !HasMass(link)) return;
    set("type", TypeOf(link, is_held));
    set("size", syntax_.Word("native"));
    set("mass", MassOf(link, is_held));
    if (is_base) {
      const auto is_given = [&](std::string_view name) {
        return std::ranges::any_of(of_objects_,
                                   [&](const auto& given) { return given.second->name == name; });
      };
      if (!is_given("location")) {
        auto at = syntax_.Make(ExprKind::kCall, "at");
        for (int i = 0; i < 3; ++i) SyntaxMaker::Add(*at, syntax_.Number(0));
        set("location", std::move(at));
      } else if (!is_given("quantity") && !ListsPlaces()) {
        set("quantity", syntax_.Number(1));
      }
    } else {
      const RobotJoint& joint = robot_->joints[index - 1];
      auto location = syntax_.Make(ExprKind::kCall, "relative_to");
      SyntaxMaker::Add(*location, syntax_.Word(result_.groups[joint.parent]));
      SyntaxMaker::Add(*location, syntax_.Vector(turn_ * joint.origin.translation()));
      set("location", std::move(location));
      const Vector3d orientation = TurnOf(turn_ * joint.origin.linear() * turn_.transpose());
      if (orientation.norm() > 1e-14) set("orientation", syntax_.Vector(orientation));
    }
    set("overlap", syntax_.Word("on"));
    AddCollisions(link, settings);
    result_.block.statements.push_back(syntax_.Statement(std::move(group)));
  }

  bool ListsPlaces() const {
    for (const auto& [setting, parameter] : of_objects_)
      if (parameter->name == "location" && !setting->values.empty())
        return setting->values[0]->kind == ExprKind::kCall &&
               (setting->values[0]->text == "at" || setting->values[0]->text == "poses");
    return false;
  }

  /// Whether the link can move as a body; other ones are refused together.
  bool HasMass(const RobotLink& link) {
    const bool has_density = Find("density") != nullptr;
    if (!link.inertia && !(has_density && !link.shapes.empty())) {
      massless_.push_back(&link);
      return false;
    }
    if (!link.inertia || link.inertia->tensor.trace() > 0) return true;
    Refuse(kOutOfDomain, at_,
           fmt::format("{}:{}: link {} has a mass, but the inertia 0", path_, link.line, link.name),
           "give it an <inertia>: Bullet would not turn it");
    return false;
  }

  void RefuseMassless() {
    if (massless_.empty()) return;
    std::vector<std::string_view> names;
    bool have_shapes = true;
    for (const RobotLink* link : massless_) {
      names.push_back(link->name);
      have_shapes = have_shapes && !link->shapes.empty();
    }
    const bool is_base = massless_[0] == &robot_->links[0];
    Refuse(kOutOfDomain, at_,
           fmt::format("{}:{}: link{} {} can move, but {} no mass", path_, massless_[0]->line,
                       names.size() == 1 ? "" : "s", fmt::join(names, ", "),
                       names.size() == 1 ? "has" : "have"),
           fmt::format("write <inertial> in the file{}{}",
                       have_shapes ? ", or `density 1000` in the block of the robot" : "",
                       is_base ? ", or `base fixed`" : ""));
  }

  ExprPtr MassOf(const RobotLink& link, bool is_held) {
    if (is_held) return syntax_.Word("fixed");
    if (link.inertia) return syntax_.Number(link.inertia->mass);
    auto density = syntax_.Make(ExprKind::kCall, "density");
    const Expr& given = *Find("density");
    if (given.kind != ExprKind::kNumber) {
      Refuse(kWrongKind, given.span, "the density of a robot is a number", "in kg/m^3");
      return syntax_.Number(1);
    }
    SyntaxMaker::Add(*density, syntax_.Make(ExprKind::kNumber, given.text));
    return density;
  }

  ExprPtr TypeOf(const RobotLink& link, bool is_held) {
    auto type = syntax_.Make(ExprKind::kCall, "compound");
    for (const RobotShape& shape : link.shapes) SyntaxMaker::Add(*type, PartOf(shape));
    if (link.shapes.empty()) AddMarker(link, *type);
    if (!link.inertia || is_held) return type;
    const analysis::RobotInertia& inertia = *link.inertia;
    const Matrix3d tensor = turn_ * inertia.tensor * turn_.transpose() / inertia.mass;
    SyntaxMaker::Add(*type, syntax_.Vector(turn_ * inertia.centre), "centre");
    SyntaxMaker::Add(*type, syntax_.Vector(tensor.diagonal()), "inertia");
    const Vector3d products(tensor(0, 1), tensor(0, 2), tensor(1, 2));
    if (products.cwiseAbs().maxCoeff() > 1e-12 * tensor.trace())
      SyntaxMaker::Add(*type, syntax_.Vector(products), "products");
    return type;
  }

  ExprPtr PartOf(const RobotShape& shape) {
    auto part = syntax_.Make(ExprKind::kCall, "part");
    const bool is_mesh = shape.kind == RobotShape::Kind::kMesh;
    // Its own y is what z is in the file.
    const bool is_turned = !is_mesh || shape.is_turned;
    const Vector3d& s = shape.sides;
    const Vector3d sides = is_turned ? Vector3d(s.x(), s.z(), s.y()) : s;
    if (is_mesh) {
      auto hull = syntax_.Make(ExprKind::kCall, "hull");
      const std::filesystem::path file(shape.file), folder = Folder();
      const std::string relative = folder.empty() || file.is_absolute() != folder.is_absolute()
                                       ? file.string()
                                       : file.lexically_relative(folder).string();
      SyntaxMaker::Add(*hull, syntax_.Text(relative));
      SyntaxMaker::Add(*part, std::move(hull));
      if (sides != Vector3d::Ones()) SyntaxMaker::Add(*part, syntax_.Vector(sides), "scale");
    } else {
      constexpr const char* kTypes[] = {"cuboid", "sphere", "cylinder", "capsule", "sphere"};
      SyntaxMaker::Add(*part, syntax_.Word(kTypes[static_cast<int>(shape.kind)]));
      SyntaxMaker::Add(*part, syntax_.Vector(sides));
    }
    const Vector3d at = turn_ * shape.pose.translation();
    if (at.norm() > 1e-14) SyntaxMaker::Add(*part, syntax_.Vector(at), "at");
    Matrix3d turn = turn_ * shape.pose.linear();
    if (is_turned) turn = turn * ZToY().transpose();
    const Vector3d about = TurnOf(turn);
    if (about.norm() > 1e-14 && shape.kind != RobotShape::Kind::kSphere)
      SyntaxMaker::Add(*part, syntax_.Vector(about), "turn");
    return part;
  }

  /// A box with the inertia of the link.
  void AddMarker(const RobotLink& link, Expr& type) {
    Vector3d sides = Vector3d::Constant(kMarker);
    Vector3d at = Vector3d::Zero(), about = Vector3d::Zero();
    if (link.inertia) {
      const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(turn_ * link.inertia->tensor *
                                                           turn_.transpose());
      const Vector3d moments = solver.eigenvalues() / link.inertia->mass;
      Matrix3d axes = solver.eigenvectors();
      if (axes.determinant() < 0) axes.col(0) *= -1;
      for (int i = 0; i < 3; ++i)
        sides[i] = std::sqrt(std::max(6 * (moments.sum() - 2 * moments[i]), kMarker * kMarker));
      at = turn_ * link.inertia->centre;
      about = TurnOf(axes);
    }
    auto part = syntax_.Make(ExprKind::kCall, "part");
    SyntaxMaker::Add(*part, syntax_.Word("cuboid"));
    SyntaxMaker::Add(*part, syntax_.Vector(sides));
    SyntaxMaker::Add(*part, syntax_.Vector(at), "at");
    SyntaxMaker::Add(*part, syntax_.Vector(about), "turn");
    SyntaxMaker::Add(type, std::move(part));
  }

  void AddCollisions(const RobotLink& link, std::vector<dsl::Statement>& settings) {
    std::vector<ExprPtr> words;
    if (link.shapes.empty()) {
      words.push_back(syntax_.Word("none"));
    } else if (robot_->links.size() > 1) {
      const bool may_touch = Word("self_collision", "off") == "on";
      if (may_touch && robot_->disabled.empty()) return;
      words.push_back(syntax_.Word("walls"));
      for (const std::string& other : others_) words.push_back(syntax_.Word(other));
      for (std::size_t i = 0; may_touch && i < robot_->links.size(); ++i)
        if (&robot_->links[i] != &link && !IsDisabled(link, robot_->links[i]))
          words.push_back(syntax_.Word(result_.groups[i]));
    } else {
      return;
    }
    settings.push_back(syntax_.Setting("collides_with", std::move(words)));
  }

  bool IsDisabled(const RobotLink& a, const RobotLink& b) const {
    const auto has = [](const RobotLink& link, const std::string& name) {
      return link.name == name || std::ranges::find(link.parts, name) != link.parts.end();
    };
    return std::ranges::any_of(robot_->disabled, [&](const auto& pair) {
      return (has(a, pair.first) && has(b, pair.second)) ||
             (has(b, pair.first) && has(a, pair.second));
    });
  }

  // Joints.

  void AddJoint(const RobotJoint& joint) {
    if (joint.type == RobotJoint::Type::kFree) return;
    const std::string& name = result_.joints[joint.child - 1];
    dsl::Group group = syntax_.Block("joints", name);
    std::vector<dsl::Statement>& settings = group.block.statements;
    const auto set = [&](const char* parameter, ExprPtr value) {
      settings.push_back(syntax_.Setting(parameter, std::move(value)));
    };
    using Type = RobotJoint::Type;
    constexpr const char* kTypes[] = {"fixed", "hinge", "slider", "free", "ball", "universal"};
    set("parent", syntax_.Word(result_.groups[joint.parent]));
    set("child", syntax_.Word(result_.groups[joint.child]));
    set("type", syntax_.Word(kTypes[static_cast<int>(joint.type)]));
    set("at", syntax_.Vector(turn_ * (joint.origin * joint.pivot)));
    const Matrix3d to_parent = turn_ * joint.origin.linear();
    if (joint.type != Type::kFixed && joint.type != Type::kBall)
      set("axis", syntax_.Vector(to_parent * joint.axis));
    if (joint.type == Type::kUniversal) set("axis2", syntax_.Vector(to_parent * joint.axis2));
    if (joint.type == Type::kHinge || joint.type == Type::kSlider) {
      if (joint.limits) {
        const auto [lower, upper] = *joint.limits;
        set("limits.lower", syntax_.Number(lower));
        set("limits.upper", syntax_.Number(upper));
      }
      if (!joint.mimic.empty()) {
        const std::string& followed = NameOf(joint.mimic);
        set("gear.with", syntax_.Word(followed));
        set("gear.ratio", syntax_.Number(joint.multiplier));
        set("gear.offset", syntax_.Number(joint.offset));
        set("start", syntax_.Binary('+',
                                    syntax_.Binary('*', syntax_.Number(joint.multiplier),
                                                   syntax_.Word(followed + ".start")),
                                    syntax_.Number(joint.offset)));
      } else if (joint.start != 0) {
        set("start", syntax_.Number(joint.start));
      }
      if (joint.damping > 0) set("damping", syntax_.Number(joint.damping));
      if (joint.friction > 0) set("friction", syntax_.Number(joint.friction));
      if (joint.armature > 0 && Word("armature", "off") == "on")
        set("armature", syntax_.Number(joint.armature));
      if (joint.mimic.empty() && Word("hold", "off") == "on") {
        if (joint.effort > 0) {
          set("motor.position", syntax_.Word(name + ".start"));
          set("motor.effort", syntax_.Number(joint.effort));
          holds_any_ = true;
        } else {
          without_effort_.push_back(name);
        }
      }
    }
    result_.block.statements.push_back(syntax_.Statement(std::move(group)));
  }

  /// Joints that are meant to be passive have no effort either, so that only a `hold` that holds
  /// nothing is a warning.
  void NameWithoutEffort() {
    if (without_effort_.empty()) return;
    if (holds_any_)
      return scenario_.NoteOnRobot(fmt::format("  not held, as the file has no effort for them: {}",
                                               fmt::join(without_effort_, ", ")));
    diagnostics_.Report(
        kNoEffect, Find("hold")->span,
        fmt::format("{} has no limit of effort for any joint, so that 'hold' gives it no motor",
                    path_),
        fmt::format("write {}.motor {{ position 0; effort 100 }} outside of the block, for example",
                    without_effort_[0]));
  }

  /// Of the block of a joint.
  const std::string& NameOf(const std::string& joint) const {
    const auto found = std::ranges::find(robot_->joints, joint, &RobotJoint::name);
    return result_.joints[static_cast<std::size_t>(found - robot_->joints.begin())];
  }

  /// The settings that the user wrote.
  void PlaceGiven() {
    for (const auto& [setting, parameter] : of_objects_) {
      const bool is_of_base = std::ranges::find(kOfBase, parameter->name) != std::end(kOfBase);
      for (std::size_t i = 0; i < (is_of_base ? 1 : result_.groups.size()); ++i)
        result_.given.push_back({setting, result_.groups[i], parameter});
    }
    const schema::Parameter* position = schema::FindParameter("joints.start", true);
    for (const dsl::Setting* setting : positions_) {
      const std::string& name = setting->path.text;
      std::size_t i = 0;
      while (i < robot_->joints.size() && robot_->joints[i].name != name &&
             result_.joints[i] != name)
        ++i;
      if (i < robot_->joints.size() && (robot_->joints[i].type == RobotJoint::Type::kHinge ||
                                        robot_->joints[i].type == RobotJoint::Type::kSlider)) {
        result_.given.push_back({setting, result_.joints[i], position});
        continue;
      }
      std::vector<std::string_view> names(result_.joints.begin(), result_.joints.end());
      const std::string_view near = dsl::DidYouMean(name, names);
      Refuse(kUnknownName, setting->path.span,
             fmt::format("the robot has no joint '{}' that moves", name),
             near.empty() ? fmt::format("`cdb check {}` lists them", path_)
                          : fmt::format("did you mean '{}'?", near));
    }
  }

  const Scenario& scenario_;
  const dsl::Group& block_;
  const std::vector<std::string>& others_;
  const std::function<bool(const std::string&)>& is_word_;
  dsl::Diagnostics& diagnostics_;
  std::vector<std::string> without_effort_;  ///< joints that `hold` cannot hold
  bool holds_any_ = false;                   ///< `hold` holds another one
  const text::Span at_;
  const SyntaxMaker syntax_;
  bool good_ = true;
  std::map<std::string_view, const dsl::Setting*> own_;
  std::vector<std::pair<const dsl::Setting*, const schema::Parameter*>> of_objects_;
  std::vector<const dsl::Setting*> positions_;
  std::vector<const RobotLink*> massless_;
  std::shared_ptr<const Robot> robot_;
  std::string path_;
  Matrix3d turn_ = Matrix3d::Identity();
  bool is_fixed_ = false;
  RobotBlocks result_;
};

}  // namespace

std::span<const RobotSetting> RobotSettings() { return kSettings; }

std::optional<RobotBlocks> ExpandRobot(const Scenario& scenario, const dsl::Group& robot,
                                       const std::vector<std::string>& others,
                                       const std::function<bool(const std::string&)>& is_word,
                                       dsl::Diagnostics& diagnostics) {
  return Expansion(scenario, robot, others, is_word, diagnostics).Run();
}

}  // namespace cdb::scenario
