// Random pairs of bodies, and how good the contacts are that a narrow phase finds for them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "library/detectors/detector.h"
#include "library/distributions/stream.h"
#include "library/objects/solid.h"
#include "runtime/engine/detection/detector_shapes.h"

namespace cdb::tests {

/// kFlatCapsule: on an ellipse.
enum class Type {
  kBall,
  kCapsule,
  kBox,
  kTetrahedron,
  kHull,
  kCompound,
  kCylinder,
  kCone,
  kEllipsoid,
  kFlatCapsule,
  kPlane
};
inline constexpr const char* kTypeNames[] = {"ball",      "capsule",     "box",      "tetrahedron",
                                             "hull",      "compound",    "cylinder", "cone",
                                             "ellipsoid", "flatcapsule", "plane"};
inline const char* NameOf(Type type) { return kTypeNames[static_cast<int>(type)]; }

/// Two bodies; the second of a plane is the half space y < 0 of its frame.
struct PairCase {
  objects::Solid a, b;
  objects::Pose pose_a, pose_b;
  bool is_plane = false;
};

struct ExactContact {
  double gap;
  Eigen::Vector3d normal;
  bool is_tight;  ///< known to a billionth of the smaller body
};
ExactContact ExactOf(const PairCase& pair);
/// The gap along a normal (unit, from b to a).
double GapAlong(const PairCase& pair, const Eigen::Vector3d& normal);

/// A solid with its longest side about `size` m; `thin`: with a side of a hundredth of the others.
objects::Solid RandomBody(distributions::Stream& stream, Type type, double size, bool thin);

/// A convex polyhedron of points on a ball, with this number of vertices.
objects::Solid RoundHull(std::size_t vertices, double size);

/// Bodies from a tenth of a size deep in each other to just apart: of about 1 m, tiny, huge or
/// different; some are thin; in any orientation, parallel, or nearly so; some have the same centre.
PairCase RandomPair(distributions::Stream& stream, Type a, Type b);

/// Moves the second along the exact normal, so that the gap is about this, m.
void MoveToGap(PairCase& pair, double gap);

/// The pairs as one scene: bodies 2 i and 2 i + 1.
class PairScene {
 public:
  explicit PairScene(const std::vector<PairCase>& pairs);
  PairScene(const PairScene&) = delete;
  PairScene& operator=(const PairScene&) = delete;
  Scene View() const;
  const std::vector<Pair>& pairs() const { return pairs_; }

 private:
  void Add(const objects::Solid& solid, const objects::Pose& pose, bool is_plane);
  detection::DetectorShapes parts_;
  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
  std::vector<Pose> poses_;
  std::vector<Shape> shapes_;
  std::vector<Pair> pairs_;
};

/// Faults of a narrow phase on pairs of two types. Lengths in longest sides of the smaller body.
struct Faults {
  int pairs = 0, overlaps = 0, near = 0, missed = 0, missed_near = 0, phantom = 0, invalid = 0;
  /// Errors: of the deepest point's distance; rad, of the normal where it is unique.
  std::vector<double> depths = {}, normals = {};
  double worst_depth = 0, worst_normal = 0;
  double worst_relative = 0;  ///< of that: as a part of the depth, or of 1e-3 if that is more
  int inexact = 0;            ///< depths off by more than 1e-6
  double worst_excess = 0;    ///< overlap along the normal, less the exact one
  /// Distances of contacts' points from the surface, of a part of the pairs of solids with one
  /// piece.
  std::vector<double> surfaces = {};
  double worst_surface = 0;
  int worst_pair = -1;   ///< that with the worst depth; that is a phantom; that is missed
  int worst_place = -1;  ///< that with the worst distance from the surface

  /// Adds the faults of other pairs, the first of which is number `first`.
  void Add(const Faults& others, int first);
};

/// The value below which this part of them is; 0 if there are none.
double Quantile(std::vector<double> values, double part);

/// Runs the detector on the pairs that it handles, and that `other`, a prepared one, handles too.
/// The surface is judged for each pair of which the index is a multiple of `every`.
Faults Judge(Detector& detector, const std::vector<PairCase>& pairs,
             const std::vector<ExactContact>& exact, const Detector* other = nullptr,
             int every = 20);

}  // namespace cdb::tests
