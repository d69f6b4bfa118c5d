#include "compiler/schema/catalogue.h"

#include <algorithm>

namespace cdb::schema {
namespace {

constexpr ObjectType kObjectTypes[] = {
    {"sphere", "a ball; unequal sides make an ellipsoid"},
    {"cuboid", "a box"},
    {"cylinder", "stands along y; its base is as wide as the x and z sides"},
    {"cone", "stands along y, the tip up; its base is as wide as the x and z sides"},
    {"capsule", "stands along y, its ends round; a ball where it is no higher than wide"},
    {"tetrahedron", "on every other corner of its box; regular where the sides are equal"},
    {"torus", "lies flat, its hole along y and twice as wide as the tube; 16 convex hulls"},
    {"bunny", "the Stanford Bunny; convex hulls"},
    {"armadillo", "the Stanford Armadillo; convex hulls"},
    {"teapot", "the Utah teapot; convex hulls"},
};

// What holds of all of FCL's trees.
#define FCL_TREES "surfaces, those of round shapes with 24 sides: no contact wholly inside another"

constexpr DetectorInfo kDetectors[] = {
    {"simple", "every pair of boxes is tested (btSimpleBroadphase)", "Bullet", "broad",
     "all pairs"},
    {"sap", "sweep and prune on boxes rounded to 16 bits (btAxisSweep3)", "Bullet", "broad",
     "sweep and prune", 16384},
    {"sap32", "sweep and prune on boxes rounded to 32 bits (bt32BitAxisSweep3)", "Bullet", "broad",
     "sweep and prune"},
    {"dbvt", "two dynamic bounding-volume trees (btDbvtBroadphase)", "Bullet", "broad",
     "AABB trees"},
    {"bullet",
     "each pair of shapes has its algorithm: GJK with EPA and closed forms; swept with `ccd`",
     "Bullet", "narrow", "GJK, continuous"},
    {"auto", "skin, grid or sweep, whichever suits the scene as it moves", "cdb", "broad",
     "Verlet list, uniform grid, sweep and prune"},
    {"skin", "a list of the pairs of fattened boxes that lasts for several cycles", "cdb", "broad",
     "Verlet list"},
    {"grid", "a uniform grid built every cycle, rows tested eight boxes at once", "cdb", "broad",
     "uniform grid", 0,
     "slow where boxes crowd in a few cells: several dense clusters far apart, slanted lines, many "
     "of very unequal size"},
    {"hierarchical_grid", "a uniform grid for each size of box, built every cycle", "cdb", "broad",
     "hierarchical grid"},
    {"sweep", "sweep and prune along one axis, eight boxes tested at once", "cdb", "broad",
     "sweep and prune"},
    {"octree", "a loose octree, made anew in each cycle", "cdb", "broad", "octrees"},
    {"kd_tree", "a k-d tree of boxes, made anew in each cycle", "cdb", "broad", "k-d trees"},
    {"fcl_dyntree", "a dynamic tree of boxes (DynamicAABBTreeCollisionManager)", "FCL", "broad",
     "AABB trees", 0, "slower as cycles go by: its tree is refitted, hardly rebalanced", "fcl"},
    {"fcl_dyntree_array", "a dynamic tree of boxes in an array", "FCL", "broad", "AABB trees", 0,
     "slower as cycles go by: its tree is refitted, hardly rebalanced", "fcl"},
    {"fcl_ssap", "sorted anew every cycle, swept along the best axis (SSaPCollisionManager)", "FCL",
     "broad", "sweep and prune", 0, "", "fcl"},
    {"fcl_spatialhash", "a hashed grid (SpatialHashingCollisionManager)", "FCL", "broad",
     "spatial hashing", 0,
     "lists all that share a cell, most of them phantoms; may miss pairs that only touch, and "
     "boxes without extent",
     "fcl"},
    {"fcl_intervaltree", "an interval tree for each axis, filled anew every cycle", "FCL", "broad",
     "interval trees", 0,
     "may miss pairs, and list phantoms, where many sides are at equal coordinates", "fcl"},
    {"ode_hash", "hashed cells of several sizes (dHashSpace)", "ODE", "broad",
     "hierarchical spatial hashing", 0, "", "ode"},
    {"ode_sap", "sorted along x, pruned along y and z (dSweepAndPruneSpace)", "ODE", "broad",
     "sweep and prune", 0, "", "ode"},
    {"ode_quadtree", "a quadtree over x and y (dQuadTreeSpace)", "ODE", "broad", "quadtrees", 0,
     "the first cycle takes a second with 20,000 bodies", "ode"},
    {"cgal", "streamed segment trees, built anew every cycle (box_self_intersection_d)", "CGAL",
     "broad", "segment trees", 0, "its code is under the GPL: so is what is given away with it",
     "cgal"},
    {"embree", "a tree of boxes, built anew every cycle (rtcCollide)", "Embree", "broad",
     "AABB trees", 0, "counts in float: what it finds is tested again in double", "embree"},
    {"rtree", "an R-tree, packed anew every cycle", "Boost.Geometry", "broad", "R-trees", 0, "",
     "boost"},
    {"fcl_gjk", "balls and boxes in closed form; else GJK for how far, MPR for how deep", "FCL",
     "narrow", "GJK", 0,
     "refuses elliptic cylinders, cones and capsules; depth and normal of hulls are those of a way "
     "out, not of the shortest",
     "fcl"},
    {"fcl_aabb", "the triangles that cross, by trees of boxes", "FCL", "narrow", "AABB trees", 0,
     FCL_TREES "; no contact before an overlap; copies both trees for each pair", "fcl"},
    {"fcl_obb", "the triangles that cross, by trees of oriented boxes", "FCL", "narrow",
     "OBB trees", 0, FCL_TREES "; no contact before an overlap", "fcl"},
    {"fcl_rss", "the triangles that cross or are nearest, by trees of rectangle-swept spheres",
     "FCL", "narrow", "RSS trees", 0, FCL_TREES "; a tenth of a millisecond for two balls", "fcl"},
    {"fcl_kdop", "the triangles that cross, by trees of 18-DOPs", "FCL", "narrow", "k-DOP trees", 0,
     FCL_TREES "; no contact before an overlap; copies both trees for each pair", "fcl"},
    {"ccd_gjk", "GJK and an expanding polytope (ccdGJKPenetration)", "libccd", "narrow", "GJK", 0,
     "normals of round shapes are off by a hundredth; up to 2 of 100 shallow overlaps of balls are "
     "taken for none",
     "ccd"},
    {"ccd_mpr", "Minkowski portal refinement (ccdMPRPenetration)", "libccd", "narrow", "MPR", 0,
     "depth and normal are those of a way out, not of the shortest", "ccd"},
    {"null", "finds nothing: what the harness itself costs", "cdb", "broad", "none"},
};

// What was there when this was built.
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
    {"uniform grid", "the cells of equal size that section 2 begins with"},
    {"hierarchical grid", "one uniform grid for each range of sizes"},
    {"spatial hashing", "Teschner et al. 2003"},
    {"hierarchical spatial hashing", "Mirtich 1998a"},
    {"octrees", "a cube cut in eight, again and again"},
    {"k-d trees", "Bentley 1975; Friedman et al. 1977"},
    {"AABB trees", "van den Bergen 1997"},
    {"sphere trees", "Quinlan 1994",
     "Debian has no library with them. fcl_rss is next to them: its volumes are spheres swept over "
     "a "
     "rectangle"},
    {"OBB trees", "Gottschalk et al. 1996"},
    {"k-DOP trees", "Klosowski et al. 1998"},
    {"GJK", "Gilbert et al. 1988; Gilbert and Foo 1990"},
    {"Lin-Canny", "Lin and Canny 1991",
     "Debian has no library with it. It tracks the closest features of two convex polyhedra, which "
     "spheres, cylinders and cones are not, and can go round in circles where they overlap, as "
     "bodies in contact do; GJK that starts from its last answer takes its place"},
    {"V-Clip", "Mirtich 1998b",
     "Debian has no library with it. It mends Lin-Canny's circles; polyhedra it still needs"},
    {"continuous", "Redon et al. 2002"},
};

constexpr LayoutInfo kLayouts[] = {
    {"uniform", "each coordinate uniform between the walls"},
    {"normal", "each coordinate normal about 0 with a third of the wall's coordinate as deviation"},
};

constexpr ClosedFormInfo kClosedForms[] = {
    {"flight", "objects under constant acceleration that touch nothing until the end"},
    {"bounce", "a ball between walls along one axis, its acceleration along it or 0"},
    {"slide", "a cuboid on the floor, its acceleration tilted more than friction holds"},
    {"stick", "a cuboid on the floor, its acceleration tilted less than friction holds"},
    {"spin", "one object that turns freely, without acceleration"},
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
