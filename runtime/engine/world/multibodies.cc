#include "runtime/engine/world/multibodies.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>

#include "library/scene_error.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::world {
namespace {

constexpr int kBase = -1;
constexpr btScalar kNoLimit = std::numeric_limits<btScalar>::max();

btMultiBodySolverConstraint& NewRow(btMultiBodyConstraintArray& rows) {
  btMultiBodySolverConstraint& row = rows.expandNonInitializing();
  row = btMultiBodySolverConstraint();
  row.m_orgConstraint = nullptr;
  return row;
}

/// A constraint of two multibodies that is in no island. Bullet's own kind for one multibody reads
/// out of bounds in a world without fixed bodies: the ground must be a multibody, too.
class Rows : public btMultiBodyConstraint {
 public:
  Rows(btMultiBody* first, int link_of_first, btMultiBody* second, int link_of_second)
      : btMultiBodyConstraint(first, second, link_of_first, link_of_second, 0, false,
                              MAX_MULTIBODY_CONSTRAINT_TYPE) {}
  void finalizeMultiDof() override {}
  int getIslandIdA() const override { return 0; }
  int getIslandIdB() const override { return 0; }
  void debugDraw(btIDebugDraw*) override {}
};

/// A place on a link.
struct Side {
  btMultiBody* body;
  int link;
  btTransform frame;  ///< in the link: the pivot, and x along the axis

  btTransform Pose() const {
    return (link == kBase ? body->getBaseWorldTransform()
                          : body->getLink(link).m_cachedWorldTransform) *
           frame;
  }
};

/// The rows of an AxisDrive.
class JointDrive final : public Rows {
 public:
  JointDrive(JointKind kind, const Side& first, const Side& second, AxisDrive& drive)
      : Rows(second.body, second.link, first.body, first.link),
        turns_(kind == JointKind::kHinge),
        first_(first),
        second_(second),
        drive_(drive) {}

  void createConstraintRows(btMultiBodyConstraintArray& rows, btMultiBodyJacobianData& data,
                            const btContactSolverInfo& info) override {
    row_count_ = 0;
    const btVector3 axis = first_.Pose().getBasis().getColumn(0), none(0, 0, 0);
    const btVector3 point = second_.Pose().getOrigin();
    // The rows differ only in the velocity that they seek and in their limits, which depend on what
    // the first is filled with.
    const int at = rows.size();
    const btScalar rate =
        fillMultiBodyConstraint(NewRow(rows), data, nullptr, nullptr, turns_ ? axis : none,
                                turns_ ? none : axis, point, point, 0, info, 0, 0, turns_);
    const btMultiBodySolverConstraint first = rows[at];
    rows.pop_back();
    const btScalar inverse = first.m_jacDiagABInv;
    AxisDrive::RowList list;
    drive_.ListRows({.rate = rate,
                     .mobility = inverse > 0 ? 1 / inverse : btScalar(0),
                     .fps = 1 / info.m_timeStep,
                     .erp = info.m_erp},
                    list);
    first_row_ = at;
    row_count_ = list.count;
    for (int i = 0; i < list.count; ++i) {
      btMultiBodySolverConstraint& row = rows.expandNonInitializing();
      row = first;
      row.m_rhs = (list.rows[i].velocity - rate) * inverse;
      row.m_lowerLimit = list.rows[i].least;
      row.m_upperLimit = list.rows[i].most;
    }
  }

  /// `impulse_of`: of a row of the solver.
  void TakeImpulses(const auto& impulse_of) {
    for (int i = 0; i < row_count_; ++i) drive_.TakeImpulse(i, impulse_of(first_row_ + i));
  }

 private:
  const bool turns_;
  const Side first_, second_;
  AxisDrive& drive_;
  int first_row_ = 0, row_count_ = 0;  ///< in the solver, of the last step
};

/// A joint that closes a loop: the pivots are held together, and those of the axes that the joint
/// fixes.
class LoopJoint final : public Rows {
 public:
  LoopJoint(JointKind kind, const Side& first, const Side& second)
      : Rows(first.body, first.link, second.body, second.link),
        kind_(kind),
        first_(first),
        second_(second) {}

  void createConstraintRows(btMultiBodyConstraintArray& rows, btMultiBodyJacobianData& data,
                            const btContactSolverInfo& info) override {
    const btTransform first = first_.Pose(), second = second_.Pose();
    const btVector3 none(0, 0, 0), gap = first.getOrigin() - second.getOrigin();
    const auto add = [&](const btVector3& about, const btVector3& along, btScalar error) {
      fillMultiBodyConstraint(NewRow(rows), data, nullptr, nullptr, about, along, first.getOrigin(),
                              second.getOrigin(), error, info, -kNoLimit, kNoLimit,
                              !about.isZero());
    };
    for (int i = kind_ == JointKind::kSlider ? 1 : 0; i < 3; ++i) {
      const btVector3 axis = first.getBasis().getColumn(i);
      add(none, axis, axis.dot(gap));
    }
    if (kind_ == JointKind::kBall) return;
    if (kind_ == JointKind::kUniversal) {
      const btVector3 a = first.getBasis().getColumn(0), b = second.getBasis().getColumn(0);
      return add(a.cross(b), none, a.dot(b));
    }
    // The small turn of the first from the second, rad.
    btVector3 turn(0, 0, 0);
    for (int i = 0; i < 3; ++i)
      turn += second.getBasis().getColumn(i).cross(first.getBasis().getColumn(i)) / 2;
    if (kind_ == JointKind::kHinge)
      turn = second.getBasis().getColumn(0).cross(first.getBasis().getColumn(0));
    for (int i = kind_ == JointKind::kHinge ? 1 : 0; i < 3; ++i) {
      const btVector3 axis = first.getBasis().getColumn(i);
      add(axis, none, axis.dot(turn));
    }
  }

 private:
  const JointKind kind_;
  const Side first_, second_;
};

/// The row of a Gear. A joint's bodies that move are of one multibody, so that a gear has at most
/// two.
class GearRow final : public Rows {
 public:
  struct End {
    btMultiBody* body;
    std::array<int, 4> links;  ///< by the gear's shares; kOther: of the other end, or the ground
  };
  static constexpr int kOther = kBase - 1;

  GearRow(const End& first, const End& second, Gear& gear)
      : Rows(first.body, kBase, second.body, kBase), ends_{first, second}, gear_(gear) {}

  void createConstraintRows(btMultiBodyConstraintArray& rows, btMultiBodyJacobianData& data,
                            const btContactSolverInfo& info) override {
    const Gear::Shares shares = gear_.ListShares();
    for (int end = 0; end < 2; ++end) {
      const btMultiBody& body = *ends_[end].body;
      const auto size = static_cast<std::size_t>(body.getNumDofs() + 6);
      jacobians_[end].assign(size, 0);
      for (int i = 0; i < shares.count; ++i) {
        const int link = ends_[end].links[static_cast<std::size_t>(i)];
        if (link == kOther) continue;
        const JointAxis::Share& share = shares.of[i];
        of_share_.assign(size, 0);
        body.fillConstraintJacobianMultiDof(link, share.body->getWorldTransform().getOrigin(),
                                            share.angular, share.linear, of_share_.data(),
                                            data.scratch_r, data.scratch_v, data.scratch_m);
        for (std::size_t dof = 0; dof < size; ++dof) jacobians_[end][dof] += of_share_[dof];
      }
    }
    const btScalar velocity = gear_.BeginStep(info.m_erp, 1 / info.m_timeStep);
    const btVector3 none(0, 0, 0);
    const int at = rows.size();
    const btScalar rate =
        fillMultiBodyConstraint(NewRow(rows), data, jacobians_[0].data(), jacobians_[1].data(),
                                none, none, none, none, 0, info, -kNoLimit, kNoLimit);
    rows[at].m_rhs = (velocity - rate) * rows[at].m_jacDiagABInv;
  }

 private:
  const End ends_[2];
  Gear& gear_;
  // Kept from step to step, so as not to be allocated again.
  std::vector<btScalar> jacobians_[2], of_share_;
};

btVector3 InertiaOf(const btRigidBody& body) {
  const btVector3& inverse = body.getInvInertiaDiagLocal();
  return {1 / inverse.x(), 1 / inverse.y(), 1 / inverse.z()};
}

}  // namespace

/// A multibody, and the rigid bodies of its links; that of the base is null if it is the ground,
/// and that of the cross of a universal joint, which has no mass.
struct Multibodies::Tree {
  struct Branch {
    const JointFrame* joint;
    int parent;  ///< link
  };
  btRigidBody* base = nullptr;
  std::vector<btRigidBody*> bodies;  ///< by link
  std::vector<Branch> branches;      ///< by link
  std::unique_ptr<btMultiBody> body;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
  // Room for Bullet.
  btAlignedObjectArray<btScalar> reals;
  btAlignedObjectArray<btVector3> vectors, origins;
  btAlignedObjectArray<btMatrix3x3> matrices;
  btAlignedObjectArray<btQuaternion> turns;
  std::vector<btVector3> spins, velocities;
  struct Armature {
    int link, place;  ///< place: of the joint's velocity in a vector of the multibody's
    btScalar inertia;
  };
  std::vector<Armature> armatures;
  using Matrix = Eigen::Matrix<btScalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<btScalar, Eigen::Dynamic, 1>;
  Matrix responses;            ///< M^-1 e, of the joint of each armature
  Eigen::LDLT<Matrix> system;  ///< of diag(1 / armature) + E^T M^-1 E
  Vector start;                ///< velocities before an acceleration

  btRigidBody* BodyOf(int link) const {
    return link == kBase ? base : bodies[static_cast<std::size_t>(link)];
  }
  btTransform PoseOf(int link) const {
    return link == kBase ? body->getBaseWorldTransform()
                         : body->getLink(link).m_cachedWorldTransform;
  }
  int Add(btRigidBody& object, const JointFrame& joint, int parent) {
    if (joint.kind == JointKind::kUniversal) {
      bodies.push_back(nullptr);
      branches.push_back({&joint, parent});
      parent = static_cast<int>(bodies.size()) - 1;
    }
    bodies.push_back(&object);
    branches.push_back({&joint, parent});
    return static_cast<int>(bodies.size()) - 1;
  }
  /// Velocities of the joints by the forces that were added, in `seconds`.
  void Accelerate(btScalar seconds) {
    if (!armatures.empty()) start = VelocitiesOf();
    AccelerateWithoutArmatures(seconds);
    if (armatures.empty()) return;
    FindResponses();
    const Vector gained = VelocitiesOf() - start;
    Vector corrected = gained;
    AddArmatures(corrected.data());
    corrected -= gained;
    body->applyDeltaVeeMultiDof(corrected.data(), 1);
  }
  int Size() const { return body->getNumDofs() + 6; }
  Vector VelocitiesOf() const {
    return Eigen::Map<const Vector>(body->getVelocityVector(), Size());
  }
  /// By unit torques of the joints with armatures, in the pose of the last acceleration.
  void FindResponses() {
    const auto count = static_cast<Eigen::Index>(armatures.size());
    responses.resize(Size(), count);
    Matrix square(count, count);
    Vector unit = Vector::Zero(Size());
    for (Eigen::Index i = 0; i < count; ++i) {
      const Armature& armature = armatures[static_cast<std::size_t>(i)];
      unit[armature.place] = 1;
      body->calcAccelerationDeltasMultiDof(unit.data(), responses.col(i).data(), reals, vectors);
      unit[armature.place] = 0;
      for (Eigen::Index j = 0; j < count; ++j)
        square(j, i) = responses(armatures[static_cast<std::size_t>(j)].place, i);
      square(i, i) += 1 / armature.inertia;
    }
    system.compute(square);
  }
  /// To velocities M^-1 J^T: with (M + E a E^T)^-1 = M^-1 - M^-1 E (1/a + E^T M^-1 E)^-1 E^T M^-1.
  void AddArmatures(btScalar* velocity) const {
    Eigen::Map<Vector> all(velocity, Size());
    Vector rates(static_cast<Eigen::Index>(armatures.size()));
    for (std::size_t i = 0; i < armatures.size(); ++i)
      rates[static_cast<Eigen::Index>(i)] = all[armatures[i].place];
    all -= responses * system.solve(rates);
  }
  /// Velocities of the joints by the forces that were added, in `seconds`, of rotors without
  /// inertia.
  void AccelerateWithoutArmatures(btScalar seconds) {
    const int links = static_cast<int>(bodies.size());
    reals.resize(links + 1);
    vectors.resize(links + 1);
    matrices.resize(links + 1);
    body->forwardKinematics(turns, origins);
    body->computeAccelerationsArticulatedBodyAlgorithmMultiDof(seconds, reals, vectors, matrices,
                                                               false, false, false);
    body->clearForcesAndTorques();
  }
  void Make();
  void MakeLink(int link);
  void MakeCross(int link);
};

// It has the frame of its parent at the start.
void Multibodies::Tree::MakeCross(int link) {
  const Branch& branch = branches[static_cast<std::size_t>(link)];
  const btRigidBody* other = BodyOf(branch.parent);
  const btTransform parent =
      other != nullptr ? other->getWorldTransform() : btTransform::getIdentity();
  // The tree may grow from either body of the joint.
  const JointFrame& joint = *branch.joint;
  const btRigidBody* own = bodies[static_cast<std::size_t>(link) + 1];
  // The tree may grow from either body of the joint.
  const btVector3& axis = joint.first == own ? joint.axis_of_second : joint.axis;
  body->setupRevolute(link, 0, btVector3(0, 0, 0), branch.parent, btQuaternion::getIdentity(),
                      axis * parent.getBasis(), parent.invXform(branch.joint->pivot),
                      btVector3(0, 0, 0));
}

void Multibodies::Tree::MakeLink(int link) {
  const Branch& branch = branches[static_cast<std::size_t>(link)];
  if (bodies[static_cast<std::size_t>(link)] == nullptr) return MakeCross(link);
  const btRigidBody& own = *bodies[static_cast<std::size_t>(link)];
  const bool is_on_cross = branch.joint->kind == JointKind::kUniversal;
  const btRigidBody* other = BodyOf(
      is_on_cross ? branches[static_cast<std::size_t>(branch.parent)].parent : branch.parent);
  const btTransform pose = own.getWorldTransform();
  const btTransform parent =
      other != nullptr ? other->getWorldTransform() : btTransform::getIdentity();
  const btScalar mass = 1 / own.getInvMass();
  const btVector3 inertia = InertiaOf(own);
  const btQuaternion turn = pose.getRotation().inverse() * parent.getRotation();
  const btVector3 to_pivot = parent.invXform(branch.joint->pivot);
  const btVector3 to_centre = -pose.invXform(branch.joint->pivot);
  const btVector3 axis = branch.joint->axis * pose.getBasis();
  switch (branch.joint->kind) {
    case JointKind::kBall:
      return body->setupSpherical(link, mass, inertia, branch.parent, turn, to_pivot, to_centre);
    case JointKind::kHinge:
      return body->setupRevolute(link, mass, inertia, branch.parent, turn, axis, to_pivot,
                                 to_centre);
    case JointKind::kSlider:
      return body->setupPrismatic(link, mass, inertia, branch.parent, turn, axis, to_pivot,
                                  to_centre, false);
    case JointKind::kUniversal: {
      const JointFrame& joint = *branch.joint;
      const btVector3& about = joint.first == &own ? joint.axis : joint.axis_of_second;
      return body->setupRevolute(link, mass, inertia, branch.parent, turn, about * pose.getBasis(),
                                 btVector3(0, 0, 0), to_centre);
    }
    case JointKind::kFixed:
      return body->setupFixed(link, mass, inertia, branch.parent, turn, to_pivot, to_centre);
  }
}

void Multibodies::Tree::Make() {
  const int links = static_cast<int>(bodies.size());
  const bool is_fixed = base == nullptr;
  body = std::make_unique<btMultiBody>(links, is_fixed ? btScalar(0) : 1 / base->getInvMass(),
                                       is_fixed ? btVector3(0, 0, 0) : InertiaOf(*base), is_fixed,
                                       false);
  if (!is_fixed) body->setBaseWorldTransform(base->getWorldTransform());
  for (int link = 0; link < links; ++link) MakeLink(link);
  body->finalizeMultiDof();
  for (int link = 0; link < links; ++link)
    if (const btScalar inertia = branches[static_cast<std::size_t>(link)].joint->armature;
        inertia > 0)
      armatures.push_back({link, 6 + body->getLink(link).m_dofOffset, inertia});
  body->setUserPointer(this);
  body->setLinearDamping(0);
  body->setAngularDamping(0);
  body->setMaxCoordinateVelocity(kNoLimit);
  body->forwardKinematics(turns, origins);
  spins.resize(static_cast<std::size_t>(links) + 1);
  velocities.resize(static_cast<std::size_t>(links) + 1);
  for (int link = is_fixed ? 0 : kBase; link < links; ++link) {
    if (BodyOf(link) == nullptr) continue;
    auto collider = std::make_unique<btMultiBodyLinkCollider>(body.get(), link);
    collider->setWorldTransform(PoseOf(link));
    if (link == kBase)
      body->setBaseCollider(collider.get());
    else
      body->getLink(link).m_collider = collider.get();
    colliders.push_back(std::move(collider));
  }
}

Multibodies::Multibodies(std::span<const JointFrame> joints, std::span<Gear* const> gears,
                         std::size_t objects)
    : ground_(std::make_unique<btMultiBody>(0, btScalar(0), btVector3(0, 0, 0), true, false)),
      links_(objects, nullptr) {
  ground_->finalizeMultiDof();
  Grow(joints);
  for (Gear* gear : gears) AddGear(*gear);
  for (const auto& constraint : constraints_) rows_.push_back(constraint.get());
}

Multibodies::~Multibodies() = default;

btMultiBodyLinkCollider* Multibodies::LinkOf(const btCollisionObject& body) const {
  const int index = body.getUserIndex();
  return index >= 0 && static_cast<std::size_t>(index) < links_.size()
             ? links_[static_cast<std::size_t>(index)]
             : nullptr;
}

void Multibodies::Grow(std::span<const JointFrame> joints) {
  std::map<btRigidBody*, std::vector<std::size_t>> joints_of;
  std::vector<btRigidBody*> order;  // of the bodies, as joints name them
  for (std::size_t i = 0; i < joints.size(); ++i)
    for (btRigidBody* body : {joints[i].first, joints[i].second})
      if (!IsGround(*body)) {
        if (!joints_of.contains(body)) order.push_back(body);
        joints_of[body].push_back(i);
      }
  std::vector<bool> is_used(joints.size(), false);
  std::map<btRigidBody*, Tree*> placed;
  // Breadth first, so that chains are as short as they can be.
  const auto grow = [&](Tree& tree) {
    std::vector<std::pair<btRigidBody*, int>> front;
    if (tree.base != nullptr) front.emplace_back(tree.base, kBase);
    for (std::size_t link = 0; link < tree.bodies.size(); ++link)
      if (tree.bodies[link] != nullptr)
        front.emplace_back(tree.bodies[link], static_cast<int>(link));
    for (std::size_t next = 0; next < front.size(); ++next) {
      const auto [body, link] = front[next];
      placed[body] = &tree;
      for (const std::size_t i : joints_of[body]) {
        btRigidBody* other = joints[i].first == body ? joints[i].second : joints[i].first;
        if (is_used[i] || IsGround(*other) || placed.contains(other)) continue;
        is_used[i] = true;
        placed[other] = &tree;
        front.emplace_back(other, tree.Add(*other, joints[i], link));
      }
    }
  };
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const bool on_first = IsGround(*joints[i].first), on_second = IsGround(*joints[i].second);
    btRigidBody* held = on_first ? joints[i].second : joints[i].first;
    if ((!on_first && !on_second) || placed.contains(held)) continue;
    is_used[i] = true;
    trees_.push_back(std::make_unique<Tree>());
    trees_.back()->Add(*held, joints[i], kBase);
    grow(*trees_.back());
  }
  for (btRigidBody* body : order) {
    if (placed.contains(body)) continue;
    trees_.push_back(std::make_unique<Tree>());
    trees_.back()->base = body;
    grow(*trees_.back());
  }
  for (const auto& tree : trees_) {
    tree->Make();
    for (const auto& collider : tree->colliders)
      links_[static_cast<std::size_t>(tree->BodyOf(collider->m_link)->getUserIndex())] =
          collider.get();
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].armature > 0 && !is_used[i])
      throw library::SceneError("a joint that closes a loop of joints has an armature",
                                "give it to another joint of the loop, written before this one");
    AddRows(joints[i], is_used[i]);
  }
  solver_.has_armatures =
      std::ranges::any_of(trees_, [](const auto& tree) { return !tree->armatures.empty(); });
  for (const auto& tree : trees_) {
    StartMoving(*tree);
    Mirror(*tree);
  }
}

void Multibodies::AddRows(const JointFrame& joint, bool is_in_tree) {
  const auto side = [&](const btRigidBody& body, const btVector3& axis) -> Side {
    const btTransform frame = FrameAlong(axis, joint.pivot);
    const btMultiBodyLinkCollider* link = IsGround(body) ? nullptr : LinkOf(body);
    if (link == nullptr) return {ground_.get(), kBase, frame};
    return {link->m_multiBody, link->m_link, body.getWorldTransform().inverse() * frame};
  };
  const Side first = side(*joint.first, joint.axis),
             second = side(*joint.second, joint.axis_of_second);
  if (joint.drive != nullptr)
    constraints_.push_back(std::make_unique<JointDrive>(joint.kind, first, second, *joint.drive));
  if (!is_in_tree) constraints_.push_back(std::make_unique<LoopJoint>(joint.kind, first, second));
}

void Multibodies::AddGear(Gear& gear) {
  GearRow::End ends[2] = {{ground_.get(), {}}, {ground_.get(), {}}};
  for (GearRow::End& end : ends) end.links.fill(GearRow::kOther);
  const Gear::Shares shares = gear.ListShares();
  for (int i = 0; i < shares.count; ++i) {
    const btRigidBody& body = *shares.of[i].body;
    const btMultiBodyLinkCollider* link = IsGround(body) ? nullptr : LinkOf(body);
    if (link == nullptr) continue;
    GearRow::End& end =
        ends[ends[0].body == ground_.get() || ends[0].body == link->m_multiBody ? 0 : 1];
    end.body = link->m_multiBody;
    end.links[static_cast<std::size_t>(i)] = link->m_link;
  }
  constraints_.push_back(std::make_unique<GearRow>(ends[0], ends[1], gear));
}

// The momenta of the bodies, as forces on the tree at rest in one second, give H^-1 J^T M v: the
// velocities of the joints for which the kinetic energy of the difference is least.
void Multibodies::StartMoving(Tree& tree) {
  const auto momenta = [](const btRigidBody& body) {
    const btMatrix3x3& turn = body.getWorldTransform().getBasis();
    return std::pair(body.getLinearVelocity() / body.getInvMass(),
                     turn * (InertiaOf(body) * (body.getAngularVelocity() * turn)));
  };
  if (tree.base != nullptr) {
    const auto [force, torque] = momenta(*tree.base);
    tree.body->addBaseForce(force);
    tree.body->addBaseTorque(torque);
  }
  for (std::size_t link = 0; link < tree.bodies.size(); ++link) {
    if (tree.bodies[link] == nullptr) continue;
    const auto [force, torque] = momenta(*tree.bodies[link]);
    tree.body->addLinkForce(static_cast<int>(link), force);
    tree.body->addLinkTorque(static_cast<int>(link), torque);
  }
  // The velocities of the links are given, and so are those of the joints: rotors turn with them.
  tree.AccelerateWithoutArmatures(1);
}

btScalar Multibodies::Solver::solveGroupCacheFriendlySetup(
    btCollisionObject** bodies, int body_count, btPersistentManifold** manifolds,
    int manifold_count, btTypedConstraint** constraints, int constraint_count,
    const btContactSolverInfo& info, btIDebugDraw* draw) {
  const btScalar result = btMultiBodyConstraintSolver::solveGroupCacheFriendlySetup(
      bodies, body_count, manifolds, manifold_count, constraints, constraint_count, info, draw);
  if (!has_armatures) return result;
  is_done_.assign(static_cast<std::size_t>(m_data.m_deltaVelocitiesUnitImpulse.size()), 0);
  for (auto* rows :
       {&m_multiBodyNonContactConstraints, &m_multiBodyNormalContactConstraints,
        &m_multiBodyFrictionContactConstraints, &m_multiBodyTorsionalFrictionContactConstraints,
        &m_multiBodySpinningFrictionContactConstraints})
    AddArmatures(*rows);
  return result;
}

// With what one body of a row does to the other, which Bullet leaves out: two links of a tree.
btScalar Multibodies::Solver::MobilityOf(const btMultiBodySolverConstraint& row) const {
  const auto product = [&](const btMultiBody& body, int jacobian, int velocity) {
    btScalar sum = 0;
    for (int dof = 0; dof < body.getNumDofs() + 6; ++dof)
      sum +=
          m_data.m_jacobians[jacobian + dof] * m_data.m_deltaVelocitiesUnitImpulse[velocity + dof];
    return sum;
  };
  const auto of_rigid = [&](int body, const btVector3& linear, const btVector3& about,
                            const btVector3& spin) {
    if (body < 0) return btScalar(0);
    return linear.dot(linear * m_tmpSolverBodyPool[body].internalGetInvMass()) + about.dot(spin);
  };
  const btMultiBody *a = row.m_multiBodyA, *b = row.m_multiBodyB;
  btScalar sum = a != nullptr ? product(*a, row.m_jacAindex, row.m_jacAindex)
                              : of_rigid(row.m_solverBodyIdA, row.m_contactNormal1,
                                         row.m_relpos1CrossNormal, row.m_angularComponentA);
  sum += b != nullptr ? product(*b, row.m_jacBindex, row.m_jacBindex)
                      : of_rigid(row.m_solverBodyIdB, row.m_contactNormal2,
                                 row.m_relpos2CrossNormal, row.m_angularComponentB);
  if (a != nullptr && a == b)
    sum += product(*a, row.m_jacAindex, row.m_jacBindex) +
           product(*a, row.m_jacBindex, row.m_jacAindex);
  return sum;
}

// A row's impulse stays right whatever its step, which only decides how fast it is found.
void Multibodies::Solver::AddArmatures(btMultiBodyConstraintArray& rows) {
  for (int i = 0; i < rows.size(); ++i) {
    btMultiBodySolverConstraint& row = rows[i];
    const auto tree_of = [](const btMultiBody* body) {
      const auto* tree =
          body == nullptr ? nullptr : static_cast<const Tree*>(body->getUserPointer());
      return tree != nullptr && !tree->armatures.empty() ? tree : nullptr;
    };
    const Tree *first = tree_of(row.m_multiBodyA), *second = tree_of(row.m_multiBodyB);
    if (first == nullptr && second == nullptr) continue;
    const auto correct = [&](const Tree* tree, int place) {
      if (tree == nullptr) return;
      // Rows of one drive share their velocities.
      if (std::exchange(is_done_[static_cast<std::size_t>(place)], 1) == 0)
        tree->AddArmatures(&m_data.m_deltaVelocitiesUnitImpulse[place]);
    };
    correct(first, row.m_jacAindex);
    correct(second, row.m_jacBindex);
    if (!(row.m_jacDiagABInv > 0)) continue;
    const btScalar mobility = MobilityOf(row);
    if (!(mobility > 0)) continue;
    const btScalar ratio = 1 / (mobility * row.m_jacDiagABInv);
    row.m_jacDiagABInv *= ratio;
    row.m_rhs *= ratio;
    row.m_cfm *= ratio;
  }
}

void Multibodies::Mirror(Tree& tree) {
  tree.body->forwardKinematics(tree.turns, tree.origins);
  tree.body->compTreeLinkVelocities(tree.spins.data(), tree.velocities.data());
  for (const auto& collider : tree.colliders) {
    const btTransform pose = tree.PoseOf(collider->m_link);
    const auto at = static_cast<std::size_t>(collider->m_link + 1);
    btRigidBody& body = *tree.BodyOf(collider->m_link);
    collider->setWorldTransform(pose);
    body.setWorldTransform(pose);
    body.setInterpolationWorldTransform(pose);
    body.setLinearVelocity(pose.getBasis() * tree.velocities[at]);
    body.setAngularVelocity(pose.getBasis() * tree.spins[at]);
    body.updateInertiaTensor();
  }
}

void Multibodies::Solve(const btAlignedObjectArray<btRigidBody*>& bodies, btDispatcher& dispatcher,
                        const btVector3& acceleration, bool in_order,
                        const btContactSolverInfo& info) {
  for (const auto& tree : trees_) tree->body->clearConstraintForces();
  for (const ObjectPush& push : pushes_) {
    const btMultiBodyLinkCollider& link = *links_[push.object];
    if (link.m_link == kBase) {
      link.m_multiBody->addBaseForce(push.force);
      link.m_multiBody->addBaseTorque(push.torque);
    } else {
      link.m_multiBody->addLinkForce(link.m_link, push.force);
      link.m_multiBody->addLinkTorque(link.m_link, push.torque);
    }
  }
  pushes_.clear();
  for (const auto& tree : trees_) {
    btMultiBody& body = *tree->body;
    body.addBaseForce(acceleration * body.getBaseMass());
    for (int link = 0; link < body.getNumLinks(); ++link)
      body.addLinkForce(link, acceleration * body.getLinkMass(link));
    tree->Accelerate(info.m_timeStep);
    body.setCompanionId(-1);
  }
  ground_->setCompanionId(-1);
  free_.clear();
  for (int i = 0; i < bodies.size(); ++i)
    if (LinkOf(*bodies[i]) == nullptr) free_.push_back(bodies[i]);
  manifolds_.clear();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
    if (manifold->getNumContacts() > 0 &&
        dispatcher.needsResponse(manifold->getBody0(), manifold->getBody1()))
      manifolds_.push_back(manifold);
  }
  if (in_order) {
    const auto key = [](const btPersistentManifold* manifold) {
      return std::pair(manifold->getBody0()->getUserIndex(), manifold->getBody1()->getUserIndex());
    };
    std::ranges::stable_sort(manifolds_, {}, key);
  }
  // The links take the places of their objects while contacts are solved.
  replaced_.clear();
  for (btPersistentManifold* manifold : manifolds_) {
    const btCollisionObject *first = manifold->getBody0(), *second = manifold->getBody1();
    replaced_.emplace_back(first, second);
    const btCollisionObject* link_of_first = LinkOf(*first);
    const btCollisionObject* link_of_second = LinkOf(*second);
    manifold->setBodies(link_of_first != nullptr ? link_of_first : first,
                        link_of_second != nullptr ? link_of_second : second);
  }
  solver_.solveMultiBodyGroup(free_.data(), static_cast<int>(free_.size()), manifolds_.data(),
                              static_cast<int>(manifolds_.size()), nullptr, 0, rows_.data(),
                              static_cast<int>(rows_.size()), info, nullptr, &dispatcher);
  for (std::size_t i = 0; i < manifolds_.size(); ++i)
    manifolds_[i]->setBodies(replaced_[i].first, replaced_[i].second);
  for (const auto& tree : trees_) tree->body->processDeltaVeeMultiDof2();
  if (!watches_drives_) return;
  for (const auto& constraint : constraints_)
    if (auto* drive = dynamic_cast<JointDrive*>(constraint.get()))
      drive->TakeImpulses([this](int row) { return solver_.ImpulseOf(row); });
}

void Multibodies::Integrate(btScalar timestep) {
  for (const auto& tree : trees_) {
    tree->body->stepPositionsMultiDof(timestep);
    Mirror(*tree);
  }
}

}  // namespace cdb::world
