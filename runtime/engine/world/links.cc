#include "runtime/engine/world/links.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "library/scene_error.h"
#include "runtime/engine/world/conversions.h"

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

/// A frame at `origin` with x along `line`, a unit vector.
btTransform FrameAlong(const btVector3& line, const btVector3& origin) {
  btVector3 y, z;
  btPlaneSpace1(line, y, z);
  return btTransform(
      btMatrix3x3(line.x(), y.x(), z.x(), line.y(), y.y(), z.y(), line.z(), y.z(), z.z()), origin);
}

btVector3 InBody(const btRigidBody& body, const btVector3& point) {
  return body.getWorldTransform().invXform(point);
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
    : world_(world) {
  std::size_t first = 0;
  for (const plan::Group& group : scene.groups) {
    const std::size_t end = first + group.settings.Count("quantity");
    if (group.HasLinks()) {
      const auto place = [&](std::size_t i) { return objects[i]->getWorldTransform().getOrigin(); };
      if (group.settings.On("links.anchor")) {
        const layouts::ObjectState& object = state.objects[first];
        const double height = objects::Bounds(object.solid, object.pose.orientation).upper.y();
        const btVector3 from = end - first > 1 ? 2 * place(first) - place(first + 1)
                                               : place(first) + ToBullet({0, 2 * height, 0});
        Add(group.settings, btTypedConstraint::getFixedBody(), *objects[first], from);
      }
      for (std::size_t i = first; i + 1 < end; ++i)
        Add(group.settings, *objects[i], *objects[i + 1], place(i));
    }
    first = end;
  }
}

Links::~Links() {
  for (const Link& link : links_) world_.removeConstraint(link.constraint.get());
}

void Links::Add(const plan::GroupSettings& settings, btRigidBody& first, btRigidBody& second,
                const btVector3& from) {
  if (first.isStaticOrKinematicObject() && second.isStaticOrKinematicObject()) return;
  const std::string_view type = settings.WordOr("links.type");
  const btVector3 to = second.getWorldTransform().getOrigin();
  Link link;
  link.first = &first;
  link.second = &second;
  link.line_in_first.setZero();
  const btVector3 pivot = (from + to) / 2;
  link.pivot_in_first = InBody(first, pivot);
  link.pivot_in_second = InBody(second, pivot);
  if (type == "ball") {
    link.constraint = std::make_unique<btPoint2PointConstraint>(first, second, link.pivot_in_first,
                                                                link.pivot_in_second);
  } else if (type == "hinge") {
    const btVector3 axis(0, 0, 1);
    link.constraint = std::make_unique<btHingeConstraint>(
        first, second, link.pivot_in_first, link.pivot_in_second,
        axis * first.getWorldTransform().getBasis(), axis * second.getWorldTransform().getBasis());
  } else if (type == "fixed") {
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
  joints_ = joints_ || link.stiffness == 0;
  const bool continues = !links_.empty() && links_.back().second == &first;
  link.root = continues ? links_.back().root : links_.size();
  link.chain = (continues ? links_.back().chain : 0) + static_cast<double>((to - from).length());
  link.second_in_root = InBody(continues ? *links_[link.root].first : first, to);
  // The body that represents the world is shared and must not keep references to our constraints.
  const bool between_objects = &first != &btTypedConstraint::getFixedBody();
  world_.addConstraint(link.constraint.get(), between_objects);
  links_.push_back(std::move(link));
}

void Links::MarkHeld(std::vector<char>& marks, char mark) const {
  for (const Link& link : links_)
    for (const btRigidBody* body : {link.first, link.second})
      if (body->getUserIndex() >= 0) marks[static_cast<std::size_t>(body->getUserIndex())] = mark;
}

double Links::BendOf(const Link& link) const {
  const btTransform &first = link.first->getWorldTransform(),
                    &second = link.second->getWorldTransform();
  if (link.constraint->getConstraintType() == HINGE_CONSTRAINT_TYPE) {
    const auto& hinge = static_cast<const btHingeConstraint&>(*link.constraint);
    const Vector3d in_first = ToEigen(first.getBasis() * hinge.getAFrame().getBasis().getColumn(2));
    const Vector3d in_second =
        ToEigen(second.getBasis() * hinge.getBFrame().getBasis().getColumn(2));
    return std::atan2(in_first.cross(in_second).norm(), std::abs(in_first.dot(in_second)));
  }
  if (link.constraint->getConstraintType() == POINT2POINT_CONSTRAINT_TYPE) return 0;
  const Link& root = links_[link.root];
  const btTransform& pose = root.first->getWorldTransform();
  const Vector3d held = ToEigen(pose * link.second_in_root);
  const double arm = (held - ToEigen(pose * root.pivot_in_first)).norm();
  return arm > 0 ? (ToEigen(second.getOrigin()) - held).norm() / arm : 0;
}

Links::Gaps Links::MeasureGaps() const {
  Gaps gaps;
  double chain = 0;  // sum of its gaps up to here
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    if (link.stiffness != 0) continue;
    const Vector3d first = ToEigen(link.first->getWorldTransform() * link.pivot_in_first);
    const Vector3d second = ToEigen(link.second->getWorldTransform() * link.pivot_in_second);
    const double gap = (second - first).norm();
    chain = (link.root == i ? 0 : chain) + gap;
    gaps.largest = std::max(gaps.largest, gap);
    gaps.sum += gap;
    gaps.stretch = std::max(gaps.stretch, chain / link.chain);
    gaps.bend = std::max(gaps.bend, BendOf(link));
  }
  return gaps;
}

double Links::JerkEnergy() const {
  if (!joints_) return 0;
  JointEquations equations;
  for (const Link& link : links_) {
    const btTransform& pose = link.first->getWorldTransform();
    const Vector3d pivot = ToEigen(pose * link.pivot_in_first);
    const auto add_point = [&](const Vector3d& at, const Vector3d& direction) {
      equations.AddPoint(*link.first, *link.second, at, direction);
    };
    if (link.stiffness != 0) {
      // Its end stays on a line that turns with the first object.
      btVector3 y, z;
      btPlaneSpace1(pose.getBasis() * link.line_in_first, y, z);
      const Vector3d end = ToEigen(link.second->getWorldTransform().getOrigin());
      add_point(end, ToEigen(y));
      add_point(end, ToEigen(z));
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) add_point(pivot, Vector3d::Unit(axis));
    // A hinge turns about z at the start.
    const auto type = link.constraint->getConstraintType();
    const int turns = type == POINT2POINT_CONSTRAINT_TYPE ? 0
                      : type == HINGE_CONSTRAINT_TYPE     ? 2
                                                          : 3;
    for (int axis = 0; axis < turns; ++axis)
      equations.AddTurn(*link.first, *link.second, Vector3d::Unit(axis));
  }
  return equations.JerkEnergy();
}

double Links::SpringEnergy(double timestep) const {
  double energy = 0;
  for (const Link& link : links_) {
    if (link.stiffness == 0) continue;
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
