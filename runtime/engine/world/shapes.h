// Converts the library's solids to Bullet shapes.
#pragma once

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <btBulletCollisionCommon.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "library/objects/solid.h"

namespace cdb::world {

/// Any solid by its support function, for Bullet's general convex algorithm (GJK and EPA). Used for
/// solids for which Bullet has no shape: ellipsoids, cylinders, cones and capsules on an ellipse,
/// tetrahedra. Also used for every cone, as Bullet's has its origin at half the height and adds its
/// margin outside. The core is the solid with `margin` taken off each half extent, so that core and
/// margin together have the solid's extents.
class SolidShape : public btConvexInternalShape {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  SolidShape(const objects::Solid& solid, btScalar margin);

  btVector3 localGetSupportingVertex(const btVector3& direction) const override;
  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override;
  void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions,
                                                         btVector3* points,
                                                         int count) const override;
  void getAabb(const btTransform& pose, btVector3& lower, btVector3& upper) const override;
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override;
  const char* getName() const override { return "solid"; }

 private:
  /// The least and greatest scalar product of a direction with a point of the core.
  std::pair<btScalar, btScalar> ExtentAlong(const btVector3& direction) const;

  objects::Solid solid_;
  btVector3 core_;   ///< half extents of the core
  btScalar offset_;  ///< objects::OffsetOf
};

/// The outermost point along `direction` of a convex shape, or of a compound of convex shapes, in
/// its own frame, including the margin.
btVector3 FarthestPoint(const btCollisionShape& shape, const btVector3& direction);

/// Makes and owns shapes. Equal solids with equal margins share one, and compounds of one form
/// share its vertices whatever their size. Not thread-safe.
class ShapePool {
 public:
  /// Valid while the pool lives: a convex shape, a btCompoundShape of convex ones, or, for a
  /// surface, a btBvhTriangleMeshShape or a btHeightfieldTerrainShape, which has no margin. A
  /// ball's margin is its radius and a plane has none: `margin` then has no effect. 0.04, the
  /// default, stands for Bullet's own rule: 0.04 m, or a tenth of the least half extent (of any
  /// piece) if that is less. Any other margin is used unchanged. Throws library::SceneError if it
  /// is not less than the least half extent. `smooth_edges`: the shape of a surface has the data
  /// that AdjustAtEdges needs.
  btCollisionShape* Get(const objects::Solid& solid, double margin, bool smooth_edges = false);
  std::size_t size() const { return shapes_.size(); }

 private:
  using Key =
      std::tuple<objects::Shape, const objects::Compound*, double, double, double, double, bool>;
  using Points = std::vector<btVector3>;  ///< of one piece
  /// The data to which the shape of a surface refers.
  struct Triangles {
    std::vector<btVector3> corners;
    std::vector<int> indices;
    btTriangleIndexVertexArray array;
    std::vector<btScalar> heights;  ///< m, for a height field only
    btTriangleInfoMap edges;        ///< with smooth edges only
  };

  std::unique_ptr<btCollisionShape> MakeCompound(const objects::Compound& compound,
                                                 btScalar margin);
  std::unique_ptr<btCollisionShape> MakeSurface(const objects::Compound& surface, btScalar margin,
                                                bool smooth_edges);
  std::unique_ptr<btCollisionShape> MakeHeights(const objects::Compound& surface, btScalar margin,
                                                bool smooth_edges);
  std::vector<Points>& PointsOf(const objects::ConvexDecomposition& form);

  std::map<const objects::ConvexDecomposition*, std::vector<Points>> points_;
  std::vector<std::unique_ptr<Points>> own_points_;        ///< of shapes with one piece
  std::vector<std::unique_ptr<btCollisionShape>> pieces_;  ///< of compounds
  std::vector<std::unique_ptr<Triangles>> triangles_;      ///< of surfaces
  std::map<Key, std::unique_ptr<btCollisionShape>> shapes_;
};

// Joints and springs between the objects of a group.

/// The links of a scene, which are in its world as long as this lives. Each holds an object to the
/// next one of its group. With `links.anchor`, the first object is also held to a point of the
/// world, as if one more object preceded it: as far from it as the second (a single object hangs
/// from half its height above its centre of mass). Two fixed objects are not linked. Linked objects
/// do not collide.
///
///   ball, hinge, fixed  btPoint2PointConstraint, btHingeConstraint about the world's z,
///                       btFixedConstraint; the pivot is in the middle between the centres of mass
///   spring              between the centres of mass, along a line that turns with the first of the
///                       two: the force is k x + c dx/dt with the state at the start of the step,
///                       neither limited nor softened, so that it explodes if w dt exceeds 2; the
///                       other object is held on the line by Bullet's
///                       btGeneric6DofSpring2Constraint and turns freely
/// Not thread-safe.
class Links {
 public:
  /// `objects` are those of `state`, at their initial poses. World and objects must outlive it.
  /// Throws library::SceneError if a spring has no length, and so no line.
  Links(const plan::Scene& scene, const layouts::InitialState& state,
        const std::vector<std::unique_ptr<btRigidBody>>& objects, btDiscreteDynamicsWorld& world);
  ~Links();
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  bool HasJoints() const { return joints_; }
  /// Sets to `mark` the marks of the objects that a link pulls: their motion is not free.
  void MarkHeld(std::vector<char>& marks, char mark) const;
  /// The largest distance between the two pivots of a joint, m; 0 without joints.
  double LargestGap() const;
  /// The energy of all springs, k x^2 / 2, with the integrator's own term dt F.v / 2, J.
  double SpringEnergy(double timestep) const;

 private:
  struct Link {
    std::unique_ptr<btTypedConstraint> constraint;
    const btRigidBody *first, *second;
    btVector3 pivot_in_first, pivot_in_second;  ///< m; for a spring, its ends
    btVector3 line_in_first;                    ///< unit vector of a spring; 0 for a joint
    double length = 0;                          ///< m, at rest
    double stiffness = 0;                       ///< N/m; 0 for a joint
  };

  /// `from`: the position of the first of the two, or where it would be.
  void Add(const plan::GroupSettings& settings, btRigidBody& first, btRigidBody& second,
           const btVector3& from);

  btDiscreteDynamicsWorld& world_;
  std::vector<Link> links_;
  bool joints_ = false;
};

}  // namespace cdb::world
