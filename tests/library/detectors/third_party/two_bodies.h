// A scene of two bodies, for tests of narrow phases.
#pragma once

#include <vector>

#include "library/detectors/detector.h"
#include "library/objects/solid.h"

namespace cdb::tests {

/// The shape as which a cuboid is passed to a detector.
enum class CuboidAs { kBox, kHull };

class TwoBodies {
 public:
  /// Balls and cuboids.
  TwoBodies(const objects::Solid& a, const objects::Pose& pose_a, const objects::Solid& b,
            const objects::Pose& pose_b, CuboidAs cuboids = CuboidAs::kBox);
  TwoBodies(const TwoBodies&) = delete;
  TwoBodies& operator=(const TwoBodies&) = delete;
  Scene View() const;

 private:
  void Place(const objects::Solid& solid, const objects::Pose& pose, CuboidAs cuboids);

  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
  std::vector<Pose> poses_;
  std::vector<Shape> shapes_;
  std::vector<Vec3> corners_[2];
  Hull hulls_[2];
};

/// The contacts that a narrow phase finds, if it accepts the pair of shapes.
std::vector<Contact> ContactsOf(Detector& detector, const TwoBodies& bodies);

}  // namespace cdb::tests
