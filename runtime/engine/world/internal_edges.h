// Contacts at the edges between the triangles of a surface: `edges smooth`.
#pragma once

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <btBulletCollisionCommon.h>

#include "library/objects/compound.h"

namespace cdb::world {

/// Bullet numbers the triangles of a height field by column and row, and mixes up the edges of
/// those more than 1024 columns apart.
class NumberedHeights final : public btHeightfieldTerrainShape {
 public:
  BT_DECLARE_ALIGNED_ALLOCATOR();

  using btHeightfieldTerrainShape::btHeightfieldTerrainShape;

  void processAllTriangles(btTriangleCallback* callback, const btVector3& lower,
                           const btVector3& upper) const override {
    Numbering numbering(*callback, 2 * (m_heightStickWidth - 1));
    btHeightfieldTerrainShape::processAllTriangles(&numbering, lower, upper);
  }

 private:
  struct Numbering final : btTriangleCallback {
    Numbering(btTriangleCallback& to, int count) : callback(to), row(count) {}
    void processTriangle(btVector3* corners, int column, int line) override {
      callback.processTriangle(corners, 0, line * row + column);
    }
    btTriangleCallback& callback;
    const int row;  ///< triangles in a row
  };
};

/// Finds the edges of a surface, for AdjustAtEdges. `shape`, Bullet's shape of it, refers to
/// `edges` from then on.
void FindEdges(const objects::Compound& surface, btBvhTriangleMeshShape& shape,
               btTriangleInfoMap& edges);
void FindEdges(const objects::Compound& surface, btHeightfieldTerrainShape& shape,
               btTriangleInfoMap& edges);

/// Bullet's gContactAddedCallback for `edges smooth`: corrects the normal of a contact with a
/// triangle of a surface whose edges were found; leaves all others alone. Bullet calls it for
/// bodies with CF_CUSTOM_MATERIAL_CALLBACK.
bool AdjustAtEdges(btManifoldPoint& contact, const btCollisionObjectWrapper* a, int part_a,
                   int triangle_a, const btCollisionObjectWrapper* b, int part_b, int triangle_b);

}  // namespace cdb::world
