// The table of the detectors included in cdb. The catalogue and the entries in library/detectors
// read it.
#pragma once

#include "compiler/schema/catalogue.h"

namespace cdb::schema {

// Limits shared by all trees of FCL.
#define FCL_TREES \
  "tests surfaces, with 24 sides for round shapes: no contact if one body is inside the other"

inline constexpr DetectorInfo kDetectorTable[] = {
    {"simple", "tests every pair of boxes (btSimpleBroadphase)", "Bullet", "broad", "all pairs"},
    {"sap", "sweep and prune on boxes rounded to 16 bits (btAxisSweep3)", "Bullet", "broad",
     "sweep and prune", 16384},
    {"sap32", "sweep and prune on boxes rounded to 32 bits (bt32BitAxisSweep3)", "Bullet", "broad",
     "sweep and prune"},
    {"dbvt", "two dynamic bounding-volume trees (btDbvtBroadphase)", "Bullet", "broad",
     "AABB trees"},
    {"bullet",
     "an algorithm for each pair of shapes: GJK with EPA, or closed forms; swept with `ccd`",
     "Bullet", "narrow", "GJK, continuous"},
    {"auto", "skin, grid or sweep, chosen as the scene moves", "cdb", "broad",
     "Verlet list, uniform grid, sweep and prune"},
    {"skin", "a list of the pairs of enlarged boxes, kept for several cycles", "cdb", "broad",
     "Verlet list"},
    {"grid", "a uniform grid, rebuilt every cycle; tests eight boxes at once", "cdb", "broad",
     "uniform grid", 0,
     "slow if boxes differ a lot in size: the largest boxes are tested against all others"},
    {"hierarchical_grid", "a uniform grid for each size of box, rebuilt every cycle", "cdb",
     "broad", "hierarchical grid"},
    {"sweep", "sweep and prune along one axis; tests eight boxes at once", "cdb", "broad",
     "sweep and prune", 0,
     "if bodies fill a plane or a space, its time grows faster than their number N, as more of "
     "them overlap along the axis: as N^1.5 or N^1.67"},
    {"octree", "a loose octree, rebuilt every cycle", "cdb", "broad", "octrees"},
    {"kd_tree", "a k-d tree of boxes, rebuilt every cycle", "cdb", "broad", "k-d trees"},
    {"fcl_dyntree", "a dynamic tree of boxes (DynamicAABBTreeCollisionManager)", "FCL", "broad",
     "AABB trees", 0, "slows down over time: its tree is refitted, but rarely rebalanced", "fcl"},
    {"fcl_dyntree_array", "a dynamic tree of boxes in an array", "FCL", "broad", "AABB trees", 0,
     "slows down over time: its tree is refitted, but rarely rebalanced", "fcl"},
    {"fcl_ssap", "sorted every cycle, swept along the best axis (SSaPCollisionManager)", "FCL",
     "broad", "sweep and prune", 0, "", "fcl"},
    {"fcl_spatialhash", "a hashed grid (SpatialHashingCollisionManager)", "FCL", "broad",
     "spatial hashing", 0,
     "lists all pairs that share a cell, most of them false positives (phantom_pairs); may miss "
     "pairs that only touch, and boxes without extent",
     "fcl", KnownErrors::kMissesPairs | KnownErrors::kFalsePositives},
    {"fcl_intervaltree", "an interval tree for each axis, refilled every cycle", "FCL", "broad",
     "interval trees", 0,
     "may miss pairs, and list false positives (phantom_pairs), if many box sides have equal "
     "coordinates",
     "fcl", KnownErrors::kMissesPairs | KnownErrors::kFalsePositives},
    {"ode_hash", "hashed cells of several sizes (dHashSpace)", "ODE", "broad",
     "hierarchical spatial hashing", 0, "", "ode"},
    {"ode_sap", "sorted along x, pruned along y and z (dSweepAndPruneSpace)", "ODE", "broad",
     "sweep and prune", 0, "", "ode"},
    {"ode_quadtree", "a quadtree over x and y (dQuadTreeSpace)", "ODE", "broad", "quadtrees", 0,
     "the first cycle takes a second with 20,000 bodies", "ode"},
    {"cgal", "streamed segment trees, rebuilt every cycle (box_self_intersection_d)", "CGAL",
     "broad", "segment trees", 0, "GPL: programs distributed with it are subject to the GPL too",
     "cgal"},
    {"embree", "a tree of boxes, rebuilt every cycle (rtcCollide)", "Embree", "broad", "AABB trees",
     0, "computes in single precision; its pairs are tested again in double", "embree"},
    {"rtree", "an R-tree, packed every cycle", "Boost.Geometry", "broad", "R-trees", 0, "",
     "boost"},
    {"fcl_gjk", "closed forms for balls and boxes; otherwise GJK for distances, MPR for depths",
     "FCL", "narrow", "GJK", 0,
     "refuses elliptic cylinders, cones and capsules; depth and normal of hulls separate them, but "
     "are not minimal",
     "fcl"},
    {"fcl_aabb", "intersecting triangles, by trees of boxes", "FCL", "narrow", "AABB trees", 0,
     FCL_TREES "; no contact before bodies overlap; copies both trees for each pair", "fcl",
     KnownErrors::kNoNearContacts},
    {"fcl_obb", "intersecting triangles, by trees of oriented boxes", "FCL", "narrow", "OBB trees",
     0, FCL_TREES "; no contact before bodies overlap", "fcl", KnownErrors::kNoNearContacts},
    {"fcl_rss", "intersecting or nearest triangles, by trees of rectangle-swept spheres", "FCL",
     "narrow", "RSS trees", 0, FCL_TREES "; takes a tenth of a millisecond for two balls", "fcl"},
    {"fcl_kdop", "intersecting triangles, by trees of 18-DOPs", "FCL", "narrow", "k-DOP trees", 0,
     FCL_TREES "; no contact before bodies overlap; copies both trees for each pair", "fcl",
     KnownErrors::kNoNearContacts},
    {"ccd_gjk", "GJK and an expanding polytope (ccdGJKPenetration)", "libccd", "narrow", "GJK", 0,
     "normals of round shapes are off by a hundredth; misses up to 2 of 100 shallow overlaps of "
     "balls",
     "ccd"},
    {"ccd_mpr", "Minkowski portal refinement (ccdMPRPenetration)", "libccd", "narrow", "MPR", 0,
     "depth and normal separate the bodies, but are not minimal", "ccd"},
    {"null", "finds nothing; measures the overhead of calling a detector", "cdb", "broad", "none"},
};

#undef FCL_TREES

}  // namespace cdb::schema
