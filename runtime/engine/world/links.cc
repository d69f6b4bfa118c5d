#include "runtime/engine/world/links.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "compiler/analysis/joints.h"
#include "dsl/text/check.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/joints/universal_joint.h"
#include "runtime/engine/world/pushes.h"

namespace cdb::world {
namespace {

using Eigen::Vector3d;

/// Bullet's own spring limits the stiffness, aims at a velocity that ignores other forces, and
/// drops the spring where the damper is stronger. Here its first row, the axis x, is the force
/// itself.
class PlainSpring : public btGeneric6DofSpring2Constraint {
 public:
  PlainSpring(btRigidBody& a, btRigidBody& b, const btTransform& in_a, const btTransform& in_b,
              btScalar stiffness, btScalar damping)
      : btGeneric6DofSpring2Constraint(a, b, in_a, in_b), stiffness_(stiffness), damping_(damping) {
    setLimit(0, 1, -1);  // free
    enableSpring(0, true);
    calculateTransforms();
    length_ = getRelativePivotPosition(0);
  }

  void getInfo2(btConstraintInfo2* info) override {
    btGeneric6DofSpring2Constraint::getInfo2(info);
    const btVector3 line(info->m_J1linearAxis[0], info->m_J1linearAxis[1], info->m_J1linearAxis[2]);
    const btScalar stretch = getRelativePivotPosition(0) - length_;
    const btScalar rate =
        line.dot(getRigidBodyB().getLinearVelocity() - getRigidBodyA().getLinearVelocity());
    info->m_constraintError[0] = 0;
    info->m_lowerLimit[0] = info->m_upperLimit[0] =
        (stiffness_ * stretch + damping_ * rate) / info->fps;
  }

 private:
  const btScalar stiffness_, damping_;
  btScalar length_;
};

btVector3 InBody(const btRigidBody& body, const btVector3& point) {
  return body.getWorldTransform().invXform(point);
}

/// What a motor may do, each a number or a table of them.
constexpr std::array<schema::GroupParameter, 4> kGoals = {
    "joints.motor.velocity", "joints.motor.position", "joints.motor.torque", "joints.motor.force"};

AxisDrive::Settings DriveOf(const plan::GroupSettings& settings) {
  AxisDrive::Settings drive;
  const auto number = [&](schema::GroupParameter parameter, double otherwise) {
    const schema::Number* given = schema::AsNumber(settings.Get(parameter));
    return given != nullptr ? given->AsReal() : otherwise;
  };
  drive.damping = settings.Real("joints.damping");
  drive.friction = settings.Real("joints.friction");
  drive.velocity = number("joints.motor.velocity", 0);
  drive.effort = number("joints.motor.effort", 0);
  // The drive counts from the initial poses.
  const double start = settings.Real("joints.start");
  const auto has = [&](schema::GroupParameter parameter) {
    const schema::Value& value = settings.Get(parameter);
    return schema::AsNumber(value) != nullptr || analysis::TimeTableOf(value) != nullptr;
  };
  if (has("joints.motor.position")) drive.target = number("joints.motor.position", start) - start;
  for (const schema::GroupParameter torque : {schema::GroupParameter("joints.motor.torque"),
                                              schema::GroupParameter("joints.motor.force")})
    if (has(torque)) drive.torque = number(torque, 0);
  drive.lower = number("joints.limits.lower", drive.lower + start) - start;
  drive.upper = number("joints.limits.upper", drive.upper + start) - start;
  return drive;
}

double RateOf(const std::array<JointAxis::Share, 2>& shares) {
  return static_cast<double>(shares[0].Rate() + shares[1].Rate());
}

/// The equations of joints for the velocities of their bodies: rows over the bodies' velocities and
/// spins, and their residuals.
class JointEquations {
 public:
  /// The bodies' points at `pivot` move alike along `direction`.
  void AddPoint(const btRigidBody& first, const btRigidBody& second, const Vector3d& pivot,
                const Vector3d& direction) {
    const auto arm = [&](const btRigidBody& body) -> Vector3d {
      return (pivot - ToEigen(body.getWorldTransform().getOrigin())).cross(direction);
    };
    residuals_.push_back(0);
    Add(first, direction, arm(first));
    Add(second, -direction, -arm(second));
  }
  /// The bodies turn alike about `axis`.
  void AddTurn(const btRigidBody& first, const btRigidBody& second, const Vector3d& axis) {
    residuals_.push_back(0);
    Add(first, Vector3d::Zero(), axis);
    Add(second, Vector3d::Zero(), -axis);
  }

  /// The sum of the bodies' shares does not change.
  void AddGear(const Gear::Shares& shares) {
    residuals_.push_back(0);
    for (int i = 0; i < shares.count; ++i)
      Add(*shares.of[i].body, ToEigen(shares.of[i].linear), ToEigen(shares.of[i].angular));
  }

  double JerkEnergy() const {
    const auto rows = static_cast<Eigen::Index>(residuals_.size());
    // Scaled by the roots of the inverse masses, which makes the matrix a square.
    Eigen::SparseMatrix<double> scaled(rows, 6 * static_cast<Eigen::Index>(columns_.size()));
    scaled.setFromTriplets(entries_.begin(), entries_.end());
    Eigen::SparseMatrix<double> square = scaled * scaled.transpose();
    // Between fixed objects, equations may follow from others.
    constexpr double kRegular = 1e-10;
    const double regular = kRegular * square.diagonal().maxCoeff();
    for (Eigen::Index row = 0; row < rows; ++row) square.coeffRef(row, row) += regular;
    const Eigen::Map<const Eigen::VectorXd> residuals(residuals_.data(), rows);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(square);
    return residuals.dot(solver.solve(residuals)) / 2;
  }

 private:
  void Add(const btRigidBody& body, const Vector3d& along, const Vector3d& about) {
    residuals_.back() += along.dot(ToEigen(body.getLinearVelocity())) +
                         about.dot(ToEigen(body.getAngularVelocity()));
    if (body.isStaticOrKinematicObject()) return;
    const auto [found, is_new] = columns_.try_emplace(&body, static_cast<int>(columns_.size()));
    const int row = static_cast<int>(residuals_.size()) - 1;
    // The inverse inertia in world axes is R diag(i) R^T.
    const Eigen::Matrix3d turn = ToEigen(body.getWorldTransform().getBasis());
    const Vector3d linear = std::sqrt(static_cast<double>(body.getInvMass())) * along;
    const Vector3d angular =
        ToEigen(body.getInvInertiaDiagLocal()).cwiseSqrt().cwiseProduct(turn.transpose() * about);
    for (int i = 0; i < 3; ++i) {
      entries_.emplace_back(row, 6 * found->second + i, linear[i]);
      entries_.emplace_back(row, 6 * found->second + 3 + i, angular[i]);
    }
  }

  std::map<const btRigidBody*, int> columns_;
  std::vector<Eigen::Triplet<double>> entries_;
  std::vector<double> residuals_;  ///< by row
};

}  // namespace

Links::Links(const plan::Scene& scene, const layouts::InitialState& state,
             const std::vector<std::unique_ptr<btRigidBody>>& objects,
             btDiscreteDynamicsWorld& world)
    : world_(world), is_reduced_(scene.world.WordOr("coordinates") == "reduced") {
  std::size_t first = 0;
  for (const plan::Group& group : scene.groups) {
    const std::size_t end = first + group.settings.Count("quantity");
    if (group.HasLinks()) AddLinks(group, state.objects[first], first, end, objects);
    first = end;
  }
  std::map<const plan::Joint*, std::vector<JointAxis*>> axes;
  for (const layouts::JointPair& pair : layouts::JointPairsOf(scene)) {
    const std::size_t before = links_.size();
    AddJoint(pair, state, objects);
    if (links_.size() > before) axes[pair.joint].push_back(links_.back().axis.get());
  }
  for (const plan::Joint& joint : scene.joints)
    if (const auto gear = analysis::GearOf(scene, joint))
      AddGears(axes[&joint], axes[gear->with], gear->ratio);
  if (is_reduced_ && joints_) MakeMultibodies(objects.size());
}

Links::~Links() {
  if (is_reduced_) return;
  for (const GearEntry& entry : gears_) world_.removeConstraint(entry.constraint.get());
  for (const Link& link : links_) {
    if (link.drive) world_.removeConstraint(link.drive.get());
    world_.removeConstraint(link.constraint.get());
  }
}

void Links::AddLinks(const plan::Group& group, const layouts::ObjectState& object,
                     std::size_t first, std::size_t end,
                     const std::vector<std::unique_ptr<btRigidBody>>& objects) {
  const auto place = [&](std::size_t i) { return objects[i]->getWorldTransform().getOrigin(); };
  if (group.settings.On("links.anchor")) {
    const double height = objects::Bounds(object.solid, object.pose.orientation).upper.y();
    const btVector3 from = end - first > 1 ? 2 * place(first) - place(first + 1)
                                           : place(first) + ToBullet({0, 2 * height, 0});
    AddLink(group.settings, btTypedConstraint::getFixedBody(), *objects[first], from);
  }
  for (std::size_t i = first; i + 1 < end; ++i)
    AddLink(group.settings, *objects[i], *objects[i + 1], place(i));
}

void Links::MakeBall(btRigidBody& first, btRigidBody& second, Link& link) {
  link.kind = JointKind::kBall;
  link.constraint = std::make_unique<btPoint2PointConstraint>(first, second, link.pivot_in_first,
                                                              link.pivot_in_second);
}

void Links::AddLink(const plan::GroupSettings& settings, btRigidBody& first, btRigidBody& second,
                    const btVector3& from) {
  if (first.isStaticOrKinematicObject() && second.isStaticOrKinematicObject()) return;
  const std::string_view type = settings.WordOr("links.type");
  const btVector3 to = second.getWorldTransform().getOrigin();
  Link link;
  link.line_in_first.setZero();
  const btVector3 pivot = (from + to) / 2;
  link.pivot_in_first = InBody(first, pivot);
  link.pivot_in_second = InBody(second, pivot);
  if (type == "ball") {
    MakeBall(first, second, link);
  } else if (type == "hinge") {
    link.kind = JointKind::kHinge;
    const btVector3 axis(0, 0, 1);
    link.line_in_first = axis * first.getWorldTransform().getBasis();
    link.constraint = std::make_unique<btHingeConstraint>(
        first, second, link.pivot_in_first, link.pivot_in_second, link.line_in_first,
        axis * second.getWorldTransform().getBasis());
  } else if (type == "fixed") {
    link.kind = JointKind::kFixed;
    const btTransform frame(btMatrix3x3::getIdentity(), pivot);
    link.constraint = std::make_unique<btFixedConstraint>(
        first, second, first.getWorldTransform().inverse() * frame,
        second.getWorldTransform().inverse() * frame);
  } else {
    const btVector3 way = to - from;
    const btVector3 line = way.normalized();
    link.stiffness = settings.Real("links.stiffness");
    link.length = static_cast<double>(way.length());
    link.line_in_first = line * first.getWorldTransform().getBasis();
    link.pivot_in_first = InBody(first, from);
    link.pivot_in_second.setZero();
    link.constraint = std::make_unique<PlainSpring>(
        first, second, first.getWorldTransform().inverse() * FrameAlong(line, from),
        second.getWorldTransform().inverse() * FrameAlong(line, to),
        static_cast<btScalar>(link.stiffness),
        static_cast<btScalar>(settings.Real("links.damping")));
  }
  Add(std::move(link), first, second, static_cast<double>((to - from).length()));
}

void Links::AddJoint(const layouts::JointPair& pair, const layouts::InitialState& state,
                     const std::vector<std::unique_ptr<btRigidBody>>& objects) {
  const bool is_in_world = pair.parent == layouts::JointPair::kWorld;
  btRigidBody& fixed = btTypedConstraint::getFixedBody();
  btRigidBody& first = is_in_world ? fixed : *objects[pair.parent];
  btRigidBody& second = pair.child == layouts::JointPair::kWorld ? fixed : *objects[pair.child];
  if (first.isStaticOrKinematicObject() && second.isStaticOrKinematicObject()) return;
  const plan::GroupSettings& settings = pair.joint->settings;
  objects::Pose frame;
  if (!is_in_world)
    frame = objects::OriginOf(state.objects[pair.parent].solid, state.objects[pair.parent].pose);
  const btVector3 pivot =
      ToBullet(frame.position + frame.orientation * settings.Vector("joints.at"));
  const btVector3 axis =
      ToBullet(frame.orientation * settings.Vector("joints.axis").stableNormalized());
  const btTransform to_first = first.getWorldTransform().inverse(),
                    to_second = second.getWorldTransform().inverse();
  const btTransform along = FrameAlong(axis, pivot);
  Link link;
  link.pivot_in_first = to_first * pivot;
  link.pivot_in_second = to_second * pivot;
  link.line_in_first = to_first.getBasis() * axis;
  const std::string_view type = settings.WordOr("joints.type");
  if (type == "ball") {
    MakeBall(first, second, link);
  } else if (type == "hinge") {
    link.kind = JointKind::kHinge;
    // It turns about z.
    const btMatrix3x3 upright(0, 0, 1, 1, 0, 0, 0, 1, 0);
    const btTransform about(along.getBasis() * upright, pivot);
    link.constraint =
        std::make_unique<btHingeConstraint>(first, second, to_first * about, to_second * about);
  } else if (type == "universal") {
    link.kind = JointKind::kUniversal;
    const btVector3 second_axis =
        ToBullet(frame.orientation * settings.Vector("joints.axis2").stableNormalized());
    link.constraint = std::make_unique<joints::UniversalJoint>(
        first, second, link.pivot_in_first, link.pivot_in_second, link.line_in_first,
        to_second.getBasis() * second_axis);
  } else {
    link.kind = type == "fixed" ? JointKind::kFixed : JointKind::kSlider;
    link.turn =
        first.getWorldTransform().getBasis().transposeTimes(second.getWorldTransform().getBasis());
    auto constraint = std::make_unique<btGeneric6DofSpring2Constraint>(
        first, second, to_first * along, to_second * along);
    for (int i = 0; i < 6; ++i) constraint->setLimit(i, 0, 0);
    if (type != "fixed") constraint->setLimit(0, 1, -1);  // free
    link.constraint = std::move(constraint);
  }
  if (type == "hinge" || type == "slider")
    link.axis = std::make_unique<JointAxis>(first, second, type == "hinge", link.line_in_first,
                                            link.pivot_in_first, link.pivot_in_second);
  const AxisDrive::Settings drive = DriveOf(settings);
  if (!drive.IsIdle()) link.drive = std::make_unique<AxisDrive>(*link.axis, drive);
  if (link.axis) link.armature = settings.Real("joints.armature");
  const auto reach = [&](const btRigidBody& body) {
    return &body == &fixed
               ? 0.
               : static_cast<double>((body.getWorldTransform().getOrigin() - pivot).length());
  };
  Add(std::move(link), first, second, reach(first) + reach(second));
  if (links_.back().drive) AddTimedMotor(settings);
}

void Links::AddTimedMotor(const plan::GroupSettings& settings) {
  TimedMotor motor{.link = links_.size() - 1};
  for (const schema::GroupParameter goal : kGoals)
    if (const schema::Call* call = analysis::TimeTableOf(settings.Get(goal))) {
      motor.table = ReadTable(*call, settings, *goal);
      if (goal.get() == schema::GroupParameter("joints.motor.position").get())
        motor.start = settings.Real("joints.start");
    }
  if (motor.table || links_.back().drive->GivesTorque()) timed_.push_back(std::move(motor));
}

void Links::BeginStep(double time, double timestep) {
  for (TimedMotor& motor : timed_) {
    const Link& link = links_[motor.link];
    const bool gives = link.drive->GivesTorque();
    if (motor.table)
      link.drive->SetGoal(motor.table->At(time + (gives ? timestep / 2 : timestep)) - motor.start);
    motor.shares = link.axis->Shares();
    motor.rate = RateOf(motor.shares);
  }
}

// The work of an impulse on rigid bodies is that in the pose in which it acts.
void Links::EndStep(double timestep) {
  for (const TimedMotor& motor : timed_) {
    const Link& link = links_[motor.link];
    const double rate = RateOf(is_reduced_ ? link.axis->Shares() : motor.shares);
    work_ += link.drive->torque() * timestep * (motor.rate + rate) / 2;
  }
}

double Links::RotorEnergy() const {
  double energy = 0;
  for (const Link& link : links_)
    if (link.armature > 0) energy += link.armature / 2 * std::pow(RateOf(link.axis->Shares()), 2);
  return energy;
}

void Links::Add(Link link, btRigidBody& first, btRigidBody& second, double length) {
  link.first = &first;
  link.second = &second;
  joints_ = joints_ || link.kind;
  const std::size_t index = links_.size();
  const auto holder = holders_.find(&first);
  const bool continues = holder != holders_.end();
  link.before = continues ? holder->second : index;
  link.root =
      continues && links_[link.before].kind == JointKind::kFixed ? links_[link.before].root : index;
  link.chain = (continues ? links_[link.before].chain : 0) + length;
  link.second_in_root = InBody(link.root == index ? first : *links_[link.root].first,
                               second.getWorldTransform().getOrigin());
  // The body that represents the world is shared and must not keep references to our constraints.
  const btRigidBody* world = &btTypedConstraint::getFixedBody();
  const bool between_objects = &first != world && &second != world;
  if (&second != world) holders_.try_emplace(&second, index);
  for (const btRigidBody* body : {&first, &second}) {
    if (body == world) continue;
    const auto object = static_cast<std::size_t>(body->getUserIndex());
    held_.resize(std::max(held_.size(), object + 1));
    held_[object] = true;
  }
  if (is_reduced_) {
    if (between_objects) first.setIgnoreCollisionCheck(&second, true);
    if (between_objects) second.setIgnoreCollisionCheck(&first, true);
  } else {
    world_.addConstraint(link.constraint.get(), between_objects);
    if (link.drive) world_.addConstraint(link.drive.get(), between_objects);
  }
  links_.push_back(std::move(link));
}

void Links::AddGears(const std::vector<JointAxis*>& driven, const std::vector<JointAxis*>& drivers,
                     double ratio) {
  CDB_CHECK(drivers.size() == driven.size() || drivers.size() == 1);
  for (std::size_t i = 0; i < driven.size(); ++i) {
    GearEntry entry;
    entry.gear = std::make_unique<Gear>(*driven[i], *drivers[drivers.size() > 1 ? i : 0], ratio);
    if (!is_reduced_) {
      entry.constraint = std::make_unique<GearConstraint>(*entry.gear);
      world_.addConstraint(entry.constraint.get());
    }
    gears_.push_back(std::move(entry));
  }
}

std::vector<JointFrame> Links::ListFrames() const {
  std::vector<JointFrame> joints;
  for (const Link& link : links_) {
    if (!link.kind) continue;
    const btTransform& pose = link.first->getWorldTransform();
    const btVector3 axis = pose.getBasis() * link.line_in_first;
    joints.push_back(
        {*link.kind, link.first, link.second, pose * link.pivot_in_first, axis,
         link.kind == JointKind::kUniversal
             ? static_cast<const joints::UniversalJoint&>(*link.constraint).AxisOfSecond()
             : axis,
         link.drive.get(), static_cast<btScalar>(link.armature)});
  }
  return joints;
}

std::vector<Gear*> Links::ListGears() const {
  std::vector<Gear*> gears;
  for (const GearEntry& entry : gears_) gears.push_back(entry.gear.get());
  return gears;
}

void Links::MakeMultibodies(std::size_t objects) {
  CDB_CHECK(std::ranges::all_of(links_, [](const Link& link) { return link.kind.has_value(); }));
  multibodies_ = std::make_unique<Multibodies>(ListFrames(), ListGears(), objects);
}

std::unique_ptr<MotorWatch> Links::WatchMotors() const {
  auto watch = std::make_unique<MotorWatch>(ListFrames(), ListGears());
  if (watch->IsEmpty()) return nullptr;
  if (multibodies_ != nullptr)
    multibodies_->WatchDrives();
  else if (auto* solver = dynamic_cast<DriveSolver*>(world_.getConstraintSolver()))
    solver->Watch();
  return watch;
}

double Links::BendOf(const Link& link) const {
  const btTransform &first = link.first->getWorldTransform(),
                    &second = link.second->getWorldTransform();
  if (link.kind == JointKind::kBall) return 0;
  if (link.kind == JointKind::kHinge) {
    const auto& hinge = static_cast<const btHingeConstraint&>(*link.constraint);
    const Vector3d in_first = ToEigen(first.getBasis() * hinge.getAFrame().getBasis().getColumn(2));
    const Vector3d in_second =
        ToEigen(second.getBasis() * hinge.getBFrame().getBasis().getColumn(2));
    const double bend =
        std::atan2(in_first.cross(in_second).norm(), std::abs(in_first.dot(in_second)));
    return std::max(bend, link.drive ? link.drive->Excess() : 0);
  }
  if (link.kind == JointKind::kUniversal) {
    const auto& joint = static_cast<const joints::UniversalJoint&>(*link.constraint);
    return std::asin(
        std::min(1., std::abs(ToEigen(joint.AxisOfFirst()).dot(ToEigen(joint.AxisOfSecond())))));
  }
  double bend = 0;
  if (link.turn)
    bend = Eigen::AngleAxisd(Eigen::Matrix3d(ToEigen(first.getBasis() * *link.turn).transpose() *
                                             ToEigen(second.getBasis())))
               .angle();
  if (link.kind == JointKind::kSlider) return bend;
  const Link& root = links_[link.root];
  const btTransform& pose = root.first->getWorldTransform();
  const Vector3d held = ToEigen(pose * link.second_in_root);
  const double arm = (held - ToEigen(pose * root.pivot_in_first)).norm();
  return std::max(bend, arm > 0 ? (ToEigen(second.getOrigin()) - held).norm() / arm : 0);
}

Vector3d Links::GapOf(const Link& link) const {
  const btTransform& pose = link.first->getWorldTransform();
  const Vector3d first = ToEigen(pose * link.pivot_in_first);
  const Vector3d gap = ToEigen(link.second->getWorldTransform() * link.pivot_in_second) - first;
  if (link.kind != JointKind::kSlider) return gap;
  const Vector3d axis = ToEigen(pose.getBasis() * link.line_in_first);
  return gap - gap.dot(axis) * axis;
}

Links::Gaps Links::MeasureGaps() const {
  Gaps gaps;
  std::vector<double> chains;  // sum of the gaps up to each
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    chains.push_back(link.before == i ? 0 : chains[link.before]);
    if (!link.kind) continue;
    const double gap = GapOf(link).norm();
    chains.back() += gap;
    gaps.largest = std::max(gaps.largest, gap);
    if (link.kind == JointKind::kSlider && link.drive)
      gaps.largest = std::max(gaps.largest, link.drive->Excess());
    gaps.sum += gap;
    if (link.chain > 0) gaps.stretch = std::max(gaps.stretch, chains.back() / link.chain);
    gaps.bend = std::max(gaps.bend, BendOf(link));
  }
  for (const GearEntry& entry : gears_) {
    double& gap = entry.gear->turns() ? gaps.bend : gaps.largest;
    gap = std::max(gap, std::abs(static_cast<double>(entry.gear->Error())));
  }
  return gaps;
}

double Links::JerkEnergy() const {
  if (!joints_) return 0;
  JointEquations equations;
  for (const Link& link : links_) {
    const btTransform& pose = link.first->getWorldTransform();
    const auto add_point = [&](const Vector3d& at, const Vector3d& direction) {
      equations.AddPoint(*link.first, *link.second, at, direction);
    };
    const auto add_turn = [&](const Vector3d& axis) {
      equations.AddTurn(*link.first, *link.second, axis);
    };
    btVector3 y(0, 0, 0), z(0, 0, 0);
    if (!link.line_in_first.isZero()) btPlaneSpace1(pose.getBasis() * link.line_in_first, y, z);
    // A spring's or a slider's end stays on a line that turns with the first object.
    const bool is_on_line = !link.kind || link.kind == JointKind::kSlider;
    if (is_on_line) {
      const Vector3d end = ToEigen(link.second->getWorldTransform() * link.pivot_in_second);
      add_point(end, ToEigen(y));
      add_point(end, ToEigen(z));
    } else {
      const Vector3d pivot = ToEigen(pose * link.pivot_in_first);
      for (int axis = 0; axis < 3; ++axis) add_point(pivot, Vector3d::Unit(axis));
    }
    if (link.kind == JointKind::kHinge) {
      add_turn(ToEigen(y));
      add_turn(ToEigen(z));
    } else if (link.kind == JointKind::kUniversal) {
      const auto& joint = static_cast<const joints::UniversalJoint&>(*link.constraint);
      add_turn(ToEigen(joint.AxisOfFirst().cross(joint.AxisOfSecond())));
    } else if (link.kind == JointKind::kFixed || link.kind == JointKind::kSlider) {
      for (int axis = 0; axis < 3; ++axis) add_turn(Vector3d::Unit(axis));
    }
  }
  for (const GearEntry& entry : gears_) equations.AddGear(entry.gear->ListShares());
  return equations.JerkEnergy();
}

double Links::SpringEnergy(double timestep) const {
  double energy = 0;
  for (const Link& link : links_) {
    if (link.kind) continue;
    const btTransform& first = link.first->getWorldTransform();
    const Vector3d line = ToEigen(first.getBasis() * link.line_in_first);
    const Vector3d way = ToEigen(link.second->getWorldTransform().getOrigin()) -
                         ToEigen(first * link.pivot_in_first);
    const Vector3d velocity =
        ToEigen(link.second->getLinearVelocity()) - ToEigen(link.first->getLinearVelocity());
    const double stretch = line.dot(way) - link.length;
    // With the force F = -k x, x and v stay on the ellipse k x^2/2 + m v^2/2 - dt k x v/2.
    energy += link.stiffness * stretch * (stretch - timestep * line.dot(velocity)) / 2;
  }
  return energy;
}

}  // namespace cdb::world
