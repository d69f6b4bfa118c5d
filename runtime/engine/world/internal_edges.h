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
                           const btVector3& upper) const override;
  /// Finds the edges of a triangle, unless they are known.
  void FindEdgesOf(int triangle);

 private:
  /// The triangle whose edges are looked for: the only one that Bullet shall find at first, among
  /// all that it asks for. Negative: none.
  mutable int only_ = -1;
};

/// Above this number of cells, the edges of a height field are found when they are touched: those
/// of all would take 5 us and 80 bytes for each cell.
inline constexpr std::size_t kMostCellsAtOnce = 1'000'000;

/// Finds the edges of a surface, for AdjustAtEdges. `shape`, Bullet's shape of it, refers to
/// `edges` from then on.
void FindEdges(const objects::Compound& surface, btBvhTriangleMeshShape& shape,
               btTriangleInfoMap& edges);
void FindEdges(const objects::Compound& surface, NumberedHeights& shape, btTriangleInfoMap& edges);

/// Bullet's gContactAddedCallback for `edges smooth`: corrects the normal of a contact with a
/// triangle of a surface whose edges were found; leaves all others alone. Bullet calls it for
/// bodies with CF_CUSTOM_MATERIAL_CALLBACK.
bool AdjustAtEdges(btManifoldPoint& contact, const btCollisionObjectWrapper* a, int part_a,
                   int triangle_a, const btCollisionObjectWrapper* b, int part_b, int triangle_b);

}  // namespace cdb::world
