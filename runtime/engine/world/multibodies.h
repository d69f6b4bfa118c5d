// Jointed objects in reduced coordinates: Bullet's articulated bodies (btMultiBody), which have the
// positions and velocities of the joints as their state, so that joints cannot open.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "runtime/engine/world/axis_drive.h"
#include "runtime/engine/world/gears.h"

class btMultiBody;
class btMultiBodyConstraint;
class btMultiBodyLinkCollider;

namespace cdb::world {

enum class JointKind { kBall, kHinge, kFixed, kSlider, kUniversal };

/// A joint of two bodies at their initial poses. Bodies that do not move stand for the ground.
struct JointFrame {
  JointKind kind;
  btRigidBody *first, *second;
  /// In the world; the axes are unit vectors, of a hinge, a slider or a universal joint. The second
  /// body turns about its own axis: of a universal joint, the other one.
  btVector3 pivot, axis, axis_of_second;
  AxisDrive* drive;   ///< null without damping, motor and limits
  btScalar armature;  ///< kg m^2, or kg of a slider
};

/// The trees of a scene's joints. Objects remain rigid bodies of the world for detection; their
/// poses and velocities are those of the links, set after each step. In the solver, the links take
/// their place. Joints that close a loop are constraints, as are drives and gears. All contacts are
/// solved as one island.
///
/// Source: R. Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 7 (the articulated-body
/// algorithm), as in Bullet. The armature of a joint adds to the diagonal of the inertia of the
/// joints, which the algorithm has no place for: what follows from its inverse, accelerations and
/// the rows of the solver, is corrected by the formula of Sherman, Morrison and Woodbury, which is
/// exact. Differences from rigid bodies: no split impulse, explicit gyroscopic
/// torques, two directions of friction, contacts without warm starting. Not thread-safe.
class Multibodies {
 public:
  /// Joins the objects of user index 0 to `objects` - 1, and gives them the velocities, nearest in
  /// the sense of kinetic energy, that the joints permit. Bodies, drives and gears must outlive it.
  Multibodies(std::span<const JointFrame> joints, std::span<Gear* const> gears,
              std::size_t objects);
  ~Multibodies();
  Multibodies(const Multibodies&) = delete;
  Multibodies& operator=(const Multibodies&) = delete;

  /// Weight, contacts, drives and loops to velocities. `bodies`: the moving ones of the world;
  /// `in_order`: contacts are solved in the order of their bodies, not as the dispatcher lists
  /// them.
  void Solve(const btAlignedObjectArray<btRigidBody*>& bodies, btDispatcher& dispatcher,
             const btVector3& acceleration, bool in_order, const btContactSolverInfo& info);
  /// Moves the links, and the rigid bodies of their objects.
  void Integrate(btScalar timestep);
  /// In the next step, a force at the centre of mass and a torque act on the object, a link.
  void Push(std::size_t object, const btVector3& force, const btVector3& torque) {
    pushes_.push_back({object, force, torque});
  }
  /// From now on, drives get the impulses of their rows.
  void WatchDrives() { watches_drives_ = true; }
  /// By the object's index.
  bool IsLink(std::size_t object) const { return links_[object] != nullptr; }

 private:
  struct Tree;

  void Grow(std::span<const JointFrame> joints);
  /// Its drive, and, if it closes a loop, the joint itself.
  void AddRows(const JointFrame& joint, bool is_in_tree);
  void AddGear(Gear& gear);
  void StartMoving(Tree& tree);
  void Mirror(Tree& tree);
  btMultiBodyLinkCollider* LinkOf(const btCollisionObject& body) const;
  bool IsGround(const btRigidBody& body) const { return body.isStaticOrKinematicObject(); }

  std::unique_ptr<btMultiBody> ground_;  ///< the other side of drives and of loops' ends
  std::vector<std::unique_ptr<Tree>> trees_;
  bool watches_drives_ = false;
  std::vector<btMultiBodyLinkCollider*> links_;  ///< by user index; null without joints
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;  ///< drives, loops, gears
  /// The impulses of its rows can be read. Its rows know the armatures of joints: Bullet makes them
  /// for bodies without.
  struct Solver : btMultiBodyConstraintSolver {
    btScalar ImpulseOf(int row) const {
      return m_multiBodyNonContactConstraints[row].m_appliedImpulse;
    }
    bool has_armatures = false;

   protected:
    btScalar solveGroupCacheFriendlySetup(btCollisionObject** bodies, int body_count,
                                          btPersistentManifold** manifolds, int manifold_count,
                                          btTypedConstraint** constraints, int constraint_count,
                                          const btContactSolverInfo& info,
                                          btIDebugDraw* draw) override;

   private:
    void AddArmatures(btMultiBodyConstraintArray& rows);
    /// The velocity that a unit impulse gives.
    btScalar MobilityOf(const btMultiBodySolverConstraint& row) const;
    std::vector<char> is_done_;  ///< by the index of a row's velocities
  };
  Solver solver_;
  struct ObjectPush {
    std::size_t object;
    btVector3 force, torque;
  };
  std::vector<ObjectPush> pushes_;  ///< of the next step
  // Kept from step to step, so as not to be allocated again.
  std::vector<btCollisionObject*> free_;
  std::vector<btPersistentManifold*> manifolds_;
  std::vector<std::pair<const btCollisionObject*, const btCollisionObject*>> replaced_;
  std::vector<btMultiBodyConstraint*> rows_;
};

}  // namespace cdb::world
