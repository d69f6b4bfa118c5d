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
  double mean_depth = 0, worst_depth = 0;  ///< error of the deepest point's distance
  double worst_relative = 0;  ///< of that: as a part of the depth, or of 1e-3 if that is more
  int inexact = 0;            ///< depths off by more than 1e-6
  double mean_excess = 0, worst_excess = 0;  ///< overlap along the normal, less the exact one
  double mean_normal = 0, worst_normal = 0;  ///< rad; where the normal is unique
  int normals = 0;
  double worst_surface = 0;  ///< distance of a contact's points from the surface
  int worst_pair = -1;       ///< that with the worst depth, or that is missed
  void Finish();
};

/// Runs the detector on the pairs that it handles.
Faults Judge(Detector& detector, const std::vector<PairCase>& pairs,
             const std::vector<ExactContact>& exact);

}  // namespace cdb::tests
