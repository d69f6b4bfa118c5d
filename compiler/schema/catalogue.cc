#include "compiler/schema/catalogue.h"

#include <algorithm>

namespace cdb::schema {
namespace {

constexpr ObjectType kObjectTypes[] = {
    {"sphere", "a ball, or an ellipsoid if the sides are unequal"},
    {"cuboid", "a box"},
    {"cylinder", "along y; its base has the x and z sides"},
    {"cone", "along y, apex up; its base has the x and z sides"},
    {"capsule", "along y, with round ends; a ball if it is no taller than wide"},
    {"tetrahedron", "on alternate corners of its box; regular if the sides are equal"},
    {"torus", "lies flat; its hole is along y and twice as wide as the tube; 16 convex hulls"},
    {"bunny", "the Stanford Bunny; convex hulls"},
    {"armadillo", "the Stanford Armadillo; convex hulls"},
    {"teapot", "the Utah teapot; convex hulls"},
};

// Limits of all of FCL's trees.
#define FCL_TREES \
  "tests surfaces, with 24 sides for round shapes: no contact if one body is inside the other"

constexpr DetectorInfo kDetectors[] = {
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
     "slow if many boxes share a few cells: dense clusters far apart, slanted lines, boxes of very "
     "unequal size"},
    {"hierarchical_grid", "a uniform grid for each size of box, rebuilt every cycle", "cdb",
     "broad", "hierarchical grid"},
    {"sweep", "sweep and prune along one axis; tests eight boxes at once", "cdb", "broad",
     "sweep and prune"},
    {"octree", "a loose octree, rebuilt every cycle", "cdb", "broad", "octrees"},
    {"kd_tree", "a k-d tree of boxes, rebuilt every cycle", "cdb", "broad", "k-d trees"},
    {"fcl_dyntree", "a dynamic tree of boxes (DynamicAABBTreeCollisionManager)", "FCL", "broad",
     "AABB trees", 0, "slows down over time: its tree is refitted, but hardly rebalanced", "fcl"},
    {"fcl_dyntree_array", "a dynamic tree of boxes in an array", "FCL", "broad", "AABB trees", 0,
     "slows down over time: its tree is refitted, but hardly rebalanced", "fcl"},
    {"fcl_ssap", "sorted every cycle, swept along the best axis (SSaPCollisionManager)", "FCL",
     "broad", "sweep and prune", 0, "", "fcl"},
    {"fcl_spatialhash", "a hashed grid (SpatialHashingCollisionManager)", "FCL", "broad",
     "spatial hashing", 0,
     "lists all pairs that share a cell, mostly false positives (phantom_pairs); may miss pairs "
     "that "
     "only touch, and boxes without extent",
     "fcl"},
    {"fcl_intervaltree", "an interval tree for each axis, refilled every cycle", "FCL", "broad",
     "interval trees", 0,
     "may miss pairs, and list false positives (phantom_pairs), if many sides have equal "
     "coordinates",
     "fcl"},
    {"ode_hash", "hashed cells of several sizes (dHashSpace)", "ODE", "broad",
     "hierarchical spatial hashing", 0, "", "ode"},
    {"ode_sap", "sorted along x, pruned along y and z (dSweepAndPruneSpace)", "ODE", "broad",
     "sweep and prune", 0, "", "ode"},
    {"ode_quadtree", "a quadtree over x and y (dQuadTreeSpace)", "ODE", "broad", "quadtrees", 0,
     "the first cycle takes a second with 20,000 bodies", "ode"},
    {"cgal", "streamed segment trees, rebuilt every cycle (box_self_intersection_d)", "CGAL",
     "broad", "segment trees", 0, "GPL: programs distributed with it fall under the GPL too",
     "cgal"},
    {"embree", "a tree of boxes, rebuilt every cycle (rtcCollide)", "Embree", "broad", "AABB trees",
     0, "computes in float; its pairs are tested again in double", "embree"},
    {"rtree", "an R-tree, packed every cycle", "Boost.Geometry", "broad", "R-trees", 0, "",
     "boost"},
    {"fcl_gjk", "closed forms for balls and boxes; otherwise GJK for distances, MPR for depths",
     "FCL", "narrow", "GJK", 0,
     "refuses elliptic cylinders, cones and capsules; depth and normal of hulls separate them, but "
     "are "
     "not minimal",
     "fcl"},
    {"fcl_aabb", "intersecting triangles, by trees of boxes", "FCL", "narrow", "AABB trees", 0,
     FCL_TREES "; no contact before an overlap; copies both trees for each pair", "fcl"},
    {"fcl_obb", "intersecting triangles, by trees of oriented boxes", "FCL", "narrow", "OBB trees",
     0, FCL_TREES "; no contact before an overlap", "fcl"},
    {"fcl_rss", "intersecting or nearest triangles, by trees of rectangle-swept spheres", "FCL",
     "narrow", "RSS trees", 0, FCL_TREES "; a tenth of a millisecond for two balls", "fcl"},
    {"fcl_kdop", "intersecting triangles, by trees of 18-DOPs", "FCL", "narrow", "k-DOP trees", 0,
     FCL_TREES "; no contact before an overlap; copies both trees for each pair", "fcl"},
    {"ccd_gjk", "GJK and an expanding polytope (ccdGJKPenetration)", "libccd", "narrow", "GJK", 0,
     "normals of round shapes are off by a hundredth; misses up to 2 of 100 shallow overlaps of "
     "balls",
     "ccd"},
    {"ccd_mpr", "Minkowski portal refinement (ccdMPRPenetration)", "libccd", "narrow", "MPR", 0,
     "depth and normal separate the bodies, but are not minimal", "ccd"},
    {"null", "finds nothing; measures the overhead of the harness", "cdb", "broad", "none"},
};

// The optional parts of this build.
#ifndef CDB_BUILT_PARTS
#define CDB_BUILT_PARTS ""
#endif
constexpr bool IsBuilt(std::string_view part) {
  const std::string_view built = " " CDB_BUILT_PARTS " ";
  for (std::size_t at = built.find(part); at != std::string_view::npos;
       at = built.find(part, at + 1))
    if (built[at - 1] == ' ' && built[at + part.size()] == ' ') return true;
  return false;
}

constexpr DetectorPart kParts[] = {
    {"fcl", "libfcl-dev", IsBuilt("fcl")},       {"ode", "libode-dev", IsBuilt("ode")},
    {"cgal", "libcgal-dev", IsBuilt("cgal")},    {"embree", "libembree-dev", IsBuilt("embree")},
    {"boost", "libboost-dev", IsBuilt("boost")}, {"ccd", "libccd-dev", IsBuilt("ccd")},
};

constexpr FamilyInfo kFamilies[] = {
    {"sweep and prune", "Baraff 1992; Cohen et al. 1995"},
    {"uniform grid", "Woulfe & Manzke 2009, section 2: cells of equal size"},
    {"hierarchical grid", "one uniform grid for each range of sizes"},
    {"spatial hashing", "Teschner et al. 2003"},
    {"hierarchical spatial hashing", "Mirtich 1998a"},
    {"octrees", "a cube divided in eight, recursively"},
    {"k-d trees", "Bentley 1975; Friedman et al. 1977"},
    {"AABB trees", "van den Bergen 1997"},
    {"sphere trees", "Quinlan 1994",
     "Debian has no library with them. fcl_rss is the closest: its volumes are spheres swept over "
     "a rectangle"},
    {"OBB trees", "Gottschalk et al. 1996"},
    {"k-DOP trees", "Klosowski et al. 1998"},
    {"GJK", "Gilbert et al. 1988; Gilbert and Foo 1990"},
    {"Lin-Canny", "Lin and Canny 1991",
     "Debian has no library with it. It tracks the closest features of two convex polyhedra, which "
     "spheres, cylinders and cones are not, and may not terminate if they overlap, as bodies in "
     "contact do; GJK with a warm start replaces it"},
    {"V-Clip", "Mirtich 1998b",
     "Debian has no library with it. It terminates where Lin-Canny does not, but also needs "
     "polyhedra"},
    {"continuous", "Redon et al. 2002"},
};

constexpr LayoutInfo kLayouts[] = {
    {"uniform", "each coordinate is uniform between the walls"},
    {"normal",
     "each coordinate is normal with mean 0; the standard deviation is a third of the wall's "
     "coordinate"},
};

constexpr ClosedFormInfo kClosedForms[] = {
    {"flight", "objects under constant acceleration, without contacts"},
    {"bounce", "a ball between walls along one axis, with acceleration 0 or along it"},
    {"slide", "a cuboid on the floor, with acceleration tilted beyond the friction angle"},
    {"stick", "a cuboid on the floor, with acceleration tilted within the friction angle"},
    {"spin", "one object that rotates freely, without acceleration"},
    {"head_on", "two balls that meet along the line of their centres, without acceleration"},
    {"rolling", "a cuboid on equal balls that roll on the floor, under tilted acceleration"},
    {"stack", "one column of cuboids at rest on the floor"},
};

}  // namespace

std::span<const ObjectType> ObjectTypes() { return kObjectTypes; }
std::span<const DetectorInfo> Detectors() { return kDetectors; }
std::span<const DetectorPart> DetectorParts() { return kParts; }
std::span<const FamilyInfo> Families() { return kFamilies; }
std::span<const LayoutInfo> Layouts() { return kLayouts; }
std::span<const ClosedFormInfo> ClosedForms() { return kClosedForms; }

const DetectorInfo* FindDetector(std::string_view name) {
  const auto* row = std::ranges::find(kDetectors, name, &DetectorInfo::name);
  return row == std::end(kDetectors) ? nullptr : row;
}

const DetectorPart* FindDetectorPart(std::string_view name) {
  const auto* row = std::ranges::find(kParts, name, &DetectorPart::name);
  return row == std::end(kParts) ? nullptr : row;
}

}  // namespace cdb::schema
