// libccd's two ways to tell how deep two convex pieces are in each other: GJK with an expanding
// polytope, and MPR (Minkowski portal refinement).
//
// libccd is silent about pieces that are apart: they are given a thin skin, which is taken off what
// it answers. A skin adds its thickness to the depth and leaves the normal as it is.
// Source: D. Fiser, libccd 2.1; G. Snethen, XenoCollide, 2008.
#include <ccd/ccd.h>

#include <algorithm>
#include <vector>

#include "library/detectors/convex.h"
#include "library/detectors/piece_pairs.h"

namespace cdb::library {
namespace {

using Eigen::Vector3d;

struct Skinned {
  PlacedPiece piece;
  double skin;  ///< m
};

Vector3d FromCcd(const ccd_vec3_t& v) { return {v.v[0], v.v[1], v.v[2]}; }
void ToCcd(const Vector3d& from, ccd_vec3_t* to) { ccdVec3Set(to, from.x(), from.y(), from.z()); }

void Support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* farthest) {
  const auto& [piece, skin] = *static_cast<const Skinned*>(object);
  const Vector3d towards = FromCcd(*direction);
  ToCcd(piece.Support(towards) + skin * towards.stableNormalized(), farthest);
}

void Centre(const void* object, ccd_vec3_t* centre) {
  ToCcd(static_cast<const Skinned*>(object)->piece.Centre(), centre);
}

using Penetration = int (*)(const void*, const void*, const ccd_t*, ccd_real_t*, ccd_vec3_t*,
                            ccd_vec3_t*);

class ConvexPairs final : public PiecePairs {
 public:
  explicit ConvexPairs(Penetration penetration) : penetration_(penetration) {
    CCD_INIT(&ccd_);
    ccd_.support1 = ccd_.support2 = Support;
    ccd_.center1 = ccd_.center2 = Centre;
    ccd_.max_iterations = 500;
  }

 private:
  void Touch(const Scene& scene, const Place& a, const Place& b,
             std::vector<Contact>& contacts) override {
    const double size = std::min(BallOf(a).radius, BallOf(b).radius);
    const double skin = std::min(kNear / 2, size / 10);
    const Skinned first = {PlacedPiece(scene, a.body, a.piece), skin};
    const Skinned second = {PlacedPiece(scene, b.body, b.piece), skin};
    ccd_.epa_tolerance = 1e-9 * size * size;  // compares squares
    ccd_.mpr_tolerance = ccd_.dist_tolerance = 1e-6 * size;
    ccd_real_t depth = 0;
    ccd_vec3_t out, at;  // `out`: which way the second has to move
    if (penetration_(&first, &second, &ccd_, &depth, &out, &at) != 0) return;
    const Vector3d normal = -FromCcd(out);
    const double distance = 2 * skin - depth;
    if (penetration_ == ccdMPRPenetration) {
      Add(a, b, FromCcd(at), normal, IsApart(first, second) ? std::max(distance, 0.0) : distance,
          contacts);
    } else {
      // Where GJK says that they meet is a mean of its polytope's corners.
      Add(a, b, MeetingPoint(first.piece, second.piece, normal), normal, distance, contacts);
    }
  }

  /// Without the skin. MPR's depth is not the least one, and may be more than the skin's.
  bool IsApart(const Skinned& a, const Skinned& b) const {
    const Skinned first = {a.piece, 0}, second = {b.piece, 0};
    return ccdMPRIntersect(&first, &second, &ccd_) == 0;
  }

  Penetration penetration_;
  ccd_t ccd_;
};

constexpr DetectorEntry kEntries[] = {
    {"ccd_gjk", "GJK and an expanding polytope (ccdGJKPenetration)", kNarrow, 0,
     [](const Options&) -> Detector* { return new ConvexPairs(ccdGJKPenetration); }},
    {"ccd_mpr", "Minkowski portal refinement (ccdMPRPenetration)", kNarrow, 0,
     [](const Options&) -> Detector* { return new ConvexPairs(ccdMPRPenetration); }},
};

}  // namespace
}  // namespace cdb::library

CDB_DETECTORS(cdb::library::kEntries)
