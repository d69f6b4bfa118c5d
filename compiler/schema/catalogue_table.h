// THE tables of the types of objects, the detectors and the closed forms, as constants, so that the
// code of each names its row at compile time. At run time, use catalogue.h.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "compiler/schema/catalogue.h"

namespace cdb::schema {

// A type of objects is a closed form (library/objects/solid.h), a model
// (library/objects/models.cc) or the torus.
// clang-format off
inline constexpr auto kObjectTypeTable = std::to_array<ObjectType>({
    {.name = "sphere", .doc = "a ball, or an ellipsoid if the sides are unequal", .fill = 0.52},
    {.name = "cuboid", .doc = "a box", .fill = 1},
    {.name = "cylinder", .doc = "along y; its base extends over the x and z sides", .fill = 0.79},
    {.name = "cone", .doc = "along y, apex up; its base extends over the x and z sides", .fill = 0.26},
    {.name = "capsule", .doc = "along y, with round ends; a ball if it is no taller than wide", .fill = 0.52},
    {.name = "tetrahedron", .doc = "on alternate corners of its box; regular if the sides are equal", .fill = 0.33},
    {.name = "superellipsoid", .doc = "along y, between a box and an octahedron: the exponents e1 and e2 round it", .fill = 0.52},
    {.name = "torus", .doc = "lies flat; its hole is along y and twice as wide as the tube; 16 convex hulls", .fill = 0.46},
    {.name = "bunny", .doc = "the Stanford Bunny; convex hulls", .fill = 0.5},
    {.name = "armadillo", .doc = "the Stanford Armadillo; convex hulls", .fill = 0.5},
    {.name = "teapot", .doc = "the Utah teapot; convex hulls", .fill = 0.5},
});
// clang-format on

/// Not constexpr: a constant expression that calls it does not compile.
void NoSuchObjectType();

/// A type named in the code. It is a compile error if the table has no such name.
class ObjectTypeRef {
 public:
  consteval ObjectTypeRef(const char* name) {
    while (row_ < kObjectTypeTable.size() && kObjectTypeTable[row_].name != name) ++row_;
    if (row_ == kObjectTypeTable.size()) NoSuchObjectType();
  }
  constexpr std::string_view name() const { return kObjectTypeTable[row_].name; }

 private:
  std::size_t row_ = 0;
};

// Limits shared by all trees of FCL.
#define FCL_TREES \
  "tests surfaces, with 24 sides for round shapes: no contact if one body is inside the other"

// clang-format off
inline constexpr DetectorInfo kDetectorTable[] = {
    {.name = "simple", .doc = "tests every pair of boxes (btSimpleBroadphase)", .source = "Bullet", .phases = "broad", .family = "all pairs"},
    {.name = "sap", .doc = "sweep and prune on boxes rounded to 16 bits (btAxisSweep3)", .source = "Bullet", .phases = "broad", .family = "sweep and prune", .max_bodies = 16384},
    {.name = "sap32", .doc = "sweep and prune on boxes rounded to 32 bits (bt32BitAxisSweep3)", .source = "Bullet", .phases = "broad", .family = "sweep and prune"},
    {.name = "dbvt", .doc = "two dynamic bounding-volume trees (btDbvtBroadphase)", .source = "Bullet", .phases = "broad", .family = "AABB trees"},
    {.name = "bullet", .doc = "an algorithm for each pair of shapes: GJK with EPA, or closed forms; swept with `ccd`", .source = "Bullet", .phases = "narrow", .family = "GJK, continuous"},
    {.name = "auto", .doc = "skin, grid or sweep, chosen as the scene moves", .source = "cdb", .phases = "broad", .family = "Verlet list, uniform grid, sweep and prune"},
    {.name = "skin", .doc = "a list of the pairs of enlarged boxes, kept for several cycles", .source = "cdb", .phases = "broad", .family = "Verlet list"},
    {.name = "grid", .doc = "a uniform grid, rebuilt every cycle; tests eight boxes at once", .source = "cdb", .phases = "broad", .family = "uniform grid", .limits = "slow if boxes differ a lot in size: the largest boxes are tested against all others"},
    {.name = "hierarchical_grid", .doc = "a uniform grid for each size of box, rebuilt every cycle", .source = "cdb", .phases = "broad", .family = "hierarchical grid"},
    {.name = "sweep", .doc = "sweep and prune along the axis on which the boxes are spread the widest relative to their sides, chosen again every 32 cycles; tests eight boxes at once", .source = "cdb", .phases = "broad", .family = "sweep and prune", .limits = "if bodies fill a plane or a space, its time grows faster than their number N, as more of them overlap along the axis: as N^1.5 or N^1.67"},
    {.name = "octree", .doc = "a loose octree, rebuilt every cycle", .source = "cdb", .phases = "broad", .family = "octrees"},
    {.name = "kd_tree", .doc = "a k-d tree of boxes, rebuilt every cycle", .source = "cdb", .phases = "broad", .family = "k-d trees"},
    {.name = "refit_tree", .doc = "a binary tree of boxes, refitted every cycle, and built again when its nodes have twice the surface", .source = "cdb", .phases = "broad", .family = "AABB trees"},
    {.name = "batch", .doc = "closed forms, separating axes, GJK and an expanding polytope; a whole manifold in each cycle", .source = "cdb", .phases = "narrow", .family = "SAT, GJK", .limits = "all convex shapes and planes, and compounds with these; Bullet handles two compounds, surfaces, height fields and superellipsoids", .lists_all_points = true},
    {.name = "fcl_dyntree", .doc = "a dynamic tree of boxes (DynamicAABBTreeCollisionManager)", .source = "FCL", .phases = "broad", .family = "AABB trees", .limits = "slows down over time: its tree is refitted, but rarely rebalanced", .part = "fcl"},
    {.name = "fcl_dyntree_array", .doc = "a dynamic tree of boxes in an array", .source = "FCL", .phases = "broad", .family = "AABB trees", .limits = "slows down over time: its tree is refitted, but rarely rebalanced", .part = "fcl"},
    {.name = "fcl_ssap", .doc = "sorted every cycle, swept along the best axis (SSaPCollisionManager)", .source = "FCL", .phases = "broad", .family = "sweep and prune", .part = "fcl"},
    {.name = "fcl_spatialhash", .doc = "a hashed grid (SpatialHashingCollisionManager)", .source = "FCL", .phases = "broad", .family = "spatial hashing", .limits = "lists all pairs that share a cell, most of them false positives (phantom_pairs); may miss pairs that only touch, and boxes without extent", .part = "fcl", .known_errors = KnownErrors::kMissesPairs | KnownErrors::kFalsePositives},
    {.name = "fcl_intervaltree", .doc = "an interval tree for each axis, refilled every cycle", .source = "FCL", .phases = "broad", .family = "interval trees", .limits = "may miss pairs, and list false positives (phantom_pairs), if many box sides have equal coordinates", .part = "fcl", .known_errors = KnownErrors::kMissesPairs | KnownErrors::kFalsePositives},
    {.name = "ode_hash", .doc = "hashed cells of several sizes (dHashSpace)", .source = "ODE", .phases = "broad", .family = "hierarchical spatial hashing", .part = "ode"},
    {.name = "ode_sap", .doc = "sorted along x, pruned along y and z (dSweepAndPruneSpace)", .source = "ODE", .phases = "broad", .family = "sweep and prune", .part = "ode"},
    {.name = "ode_quadtree", .doc = "a quadtree over x and y (dQuadTreeSpace)", .source = "ODE", .phases = "broad", .family = "quadtrees", .limits = "the first cycle takes a second with 20,000 bodies", .part = "ode"},
    {.name = "cgal", .doc = "streamed segment trees, rebuilt every cycle (box_self_intersection_d)", .source = "CGAL", .phases = "broad", .family = "segment trees", .limits = "GPL: programs distributed with it are subject to the GPL too", .part = "cgal"},
    {.name = "embree", .doc = "a tree of boxes, rebuilt every cycle (rtcCollide)", .source = "Embree", .phases = "broad", .family = "AABB trees", .limits = "computes in single precision; its pairs are tested again in double", .part = "embree"},
    {.name = "rtree", .doc = "an R-tree, packed every cycle", .source = "Boost.Geometry", .phases = "broad", .family = "R-trees", .part = "boost"},
    {.name = "fcl_gjk", .doc = "closed forms for balls and boxes; otherwise GJK for distances, MPR for depths", .source = "FCL", .phases = "narrow", .family = "GJK", .limits = "refuses elliptic cylinders, cones and capsules; depth and normal of hulls separate them, but are not minimal", .part = "fcl"},
    {.name = "fcl_aabb", .doc = "intersecting triangles, by trees of boxes", .source = "FCL", .phases = "narrow", .family = "AABB trees", .limits = FCL_TREES "; no contact before bodies overlap; copies both trees for each pair", .part = "fcl", .known_errors = KnownErrors::kNoNearContacts},
    {.name = "fcl_obb", .doc = "intersecting triangles, by trees of oriented boxes", .source = "FCL", .phases = "narrow", .family = "OBB trees", .limits = FCL_TREES "; no contact before bodies overlap", .part = "fcl", .known_errors = KnownErrors::kNoNearContacts},
    {.name = "fcl_rss", .doc = "intersecting or nearest triangles, by trees of rectangle-swept spheres", .source = "FCL", .phases = "narrow", .family = "RSS trees", .limits = FCL_TREES "; takes a tenth of a millisecond for two balls", .part = "fcl"},
    {.name = "fcl_kdop", .doc = "intersecting triangles, by trees of 18-DOPs", .source = "FCL", .phases = "narrow", .family = "k-DOP trees", .limits = FCL_TREES "; no contact before bodies overlap; copies both trees for each pair", .part = "fcl", .known_errors = KnownErrors::kNoNearContacts},
    {.name = "ccd_gjk", .doc = "GJK and an expanding polytope (ccdGJKPenetration)", .source = "libccd", .phases = "narrow", .family = "GJK", .limits = "normals of round shapes are off by a hundredth; misses up to 2 of 100 shallow overlaps of balls", .part = "ccd"},
    {.name = "ccd_mpr", .doc = "Minkowski portal refinement (ccdMPRPenetration)", .source = "libccd", .phases = "narrow", .family = "MPR", .limits = "depth and normal separate the bodies, but are not minimal", .part = "ccd"},
    {.name = "null", .doc = "finds nothing; measures the overhead of calling a detector", .source = "cdb", .phases = "broad", .family = "none"},
};
// clang-format on

#undef FCL_TREES

// clang-format off
inline constexpr ClosedFormInfo kClosedFormTable[] = {
    {.name = "flight", .doc = "objects under constant acceleration, without contacts"},
    {.name = "bounce", .doc = "a ball between walls along one axis, with acceleration 0 or along it"},
    {.name = "oblique", .doc = "a ball that meets one wall at an angle, without acceleration"},
    {.name = "head_on", .doc = "two balls that meet along the line of their centres, without acceleration"},
    {.name = "slide", .doc = "a cuboid on the floor, with acceleration tilted beyond the friction angle"},
    {.name = "stick", .doc = "a cuboid on the floor, with acceleration tilted within the friction angle"},
    {.name = "braking", .doc = "a cuboid that slides on the level floor until friction stops it"},
    {.name = "roll", .doc = "a ball at rest on the floor, under tilted acceleration: it rolls, or slips as well"},
    {.name = "bowl", .doc = "a ball that slides on the level floor until it rolls"},
    {.name = "rolling", .doc = "a cuboid on equal balls that roll on the floor, under tilted acceleration"},
    {.name = "stack", .doc = "one column of cuboids at rest on the floor"},
    {.name = "spin", .doc = "one object that rotates freely, without acceleration"},
    {.name = "flip", .doc = "one object that rotates freely about its middle axis and turns over"},
    {.name = "spring", .doc = "one object on an upright spring"},
    {.name = "pendulum", .doc = "one object on a ball joint or hinge, under tilted acceleration"},
};
// clang-format on

}  // namespace cdb::schema
