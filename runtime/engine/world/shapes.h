// Converts the library's solids to Bullet shapes.
#pragma once

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "library/exact/signed_distance.h"
#include "library/layouts/initial_state.h"
#include "library/objects/solid.h"

namespace cdb::world {

/// Any solid by its support function, for Bullet's general convex algorithm (GJK and EPA). Used for
/// solids for which Bullet has no shape: ellipsoids, cylinders, cones and capsules on an ellipse,
/// tetrahedra, superellipsoids. Also used for every cone, as Bullet's has its origin at half the
/// height and adds its margin outside. The core is the solid with `margin` taken off each half
/// extent, so that core and margin together have the solid's extents.
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

/// The half space behind a wall that is a plane; nullopt if it is a box, whose solid is
/// BoxWallSolid.
std::optional<exact::HalfSpace> PlaneOf(const btCollisionObject& wall);
objects::Solid BoxWallSolid(const btCollisionObject& wall);

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
  using Key = std::tuple<objects::Shape, const objects::Compound*, double, double, double, double,
                         double, double, bool>;
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

/// The body of an object with its mass, coefficients, pose and velocities at the start. A kinematic
/// one never sleeps. The shape must outlive it.
std::unique_ptr<btRigidBody> MakeBody(const layouts::ObjectState& object, btCollisionShape* shape);

}  // namespace cdb::world
