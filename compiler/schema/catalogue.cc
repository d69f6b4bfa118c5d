#include "compiler/schema/catalogue.h"

#include <algorithm>
#include <cmath>

#include "compiler/schema/catalogue_table.h"

namespace cdb::schema {
namespace {

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
     "Debian has no library for them. fcl_rss is the closest: its volumes are spheres swept over "
     "a rectangle"},
    {"OBB trees", "Gottschalk et al. 1996"},
    {"k-DOP trees", "Klosowski et al. 1998"},
    {"GJK", "Gilbert et al. 1988; Gilbert and Foo 1990"},
    {"Lin-Canny", "Lin and Canny 1991",
     "Debian has no library for it. It tracks the closest features of two convex polyhedra: it "
     "cannot handle spheres, cylinders and cones, and may not terminate if the polyhedra overlap, "
     "as bodies in contact do; GJK with a warm start replaces it"},
    {"V-Clip", "Mirtich 1998b",
     "Debian has no library for it. It terminates where Lin-Canny does not, but also needs "
     "polyhedra"},
    {"continuous", "Redon et al. 2002"},
};

constexpr LayoutInfo kLayouts[] = {
    {"uniform", "each coordinate is uniform between the walls"},
    {"normal",
     "each coordinate is normal with mean 0; the standard deviation is a third of the coordinate "
     "of the wall"},
};

}  // namespace

std::span<const ObjectType> ObjectTypes() { return kObjectTypeTable; }

// Jaklič, Leonardis, Solina, Segmentation and Recovery of Superquadrics, 2000, equation 2.60: Beta
// functions, here with their poles at 0 taken out.
double SuperellipsoidFill(double e1, double e2) {
  const auto gamma = [](double x) { return std::tgamma(x + 1); };
  return gamma(e2 / 2) * gamma(e2 / 2) / gamma(e2) * gamma(e1 / 2) * gamma(e1) / gamma(1.5 * e1);
}

std::span<const DetectorInfo> Detectors() { return kDetectorTable; }
std::span<const DetectorPart> DetectorParts() { return kParts; }
std::span<const FamilyInfo> Families() { return kFamilies; }
std::span<const LayoutInfo> Layouts() { return kLayouts; }
std::span<const ClosedFormInfo> ClosedForms() { return kClosedFormTable; }

const DetectorInfo* FindDetector(std::string_view name) {
  const auto* row = std::ranges::find(kDetectorTable, name, &DetectorInfo::name);
  return row == std::end(kDetectorTable) ? nullptr : row;
}

bool ListsAllPoints(std::string_view narrow_phase) {
  const DetectorInfo* row = FindDetector(narrow_phase);
  return row != nullptr && row->lists_all_points;
}

std::optional<DetectorInfo> FindDetector(std::string_view name,
                                         std::span<const PluginDetector> plugins) {
  if (const DetectorInfo* row = FindDetector(name)) return *row;
  const auto plugin = std::ranges::find(plugins, name, &PluginDetector::name);
  if (plugin == plugins.end()) return std::nullopt;
  DetectorInfo info{};
  info.name = plugin->name;
  info.source = plugin->path;
  info.phases = plugin->phases;
  info.max_bodies = plugin->max_bodies;
  return info;
}

const DetectorPart* FindDetectorPart(std::string_view name) {
  const auto* row = std::ranges::find(kParts, name, &DetectorPart::name);
  return row == std::end(kParts) ? nullptr : row;
}

std::string_view WordFor(std::string_view word) {
  struct Other {
    std::string_view word, ours;
  };
  static constexpr Other kOthers[] = {
      {"cube", "cuboid"},
      {"box", "cuboid"},
      {"brick", "cuboid"},
      {"ball", "sphere"},
      {"ellipsoid", "sphere"},
      {"superquadric", "superellipsoid"},
      {"sdf", "implicit"},
      {"voxel", "voxels"},
      {"point_cloud", "voxels"},
      {"points", "voxels"},
      {"octomap", "voxels"},
      {"pill", "capsule"},
      {"rod", "cylinder"},
      {"donut", "torus"},
      {"bruteforce", "simple"},
      {"brute_force", "simple"},
      {"sweep_and_prune", "sap"},
      {"bvh", "dbvt"},
      {"gauss", "normal"},
      {"gaussian", "normal"},
      {"choice", "any"},
      {"choose", "any"},
      {"random", "uniform"},
      {"rand", "uniform"},
      {"range", "sweep"},
      {"linspace", "sweep"},
      {"logspace", "sweep"},
      {"arange", "sweep"},
      {"geomspace", "sweep"},
      {"float", "single"},
      {"float32", "single"},
      {"f32", "single"},
      {"float64", "double"},
      {"f64", "double"},
      {"static", "fixed"},
      {"infinite", "fixed"},
      {"inf", "fixed"},
      {"immovable", "fixed"},
      {"yes", "on"},
      {"no", "off"},
  };
  for (const Other& other : kOthers)
    if (other.word == word) return other.ours;
  return {};
}

}  // namespace cdb::schema
