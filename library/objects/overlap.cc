#include "library/objects/overlap.h"

#include "library/objects/solid_pair.h"

namespace cdb::objects {

bool Overlap(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b) {
  return SolidPair(a, pose_a.orientation, b, pose_b.orientation)
      .Overlap(pose_b.position - pose_a.position);
}

}  // namespace cdb::objects
