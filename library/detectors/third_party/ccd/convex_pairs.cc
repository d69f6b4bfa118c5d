// libccd's two algorithms for the penetration depth of two convex pieces: GJK with an expanding
// polytope, and MPR (Minkowski portal refinement).
//
// libccd reports nothing for separate pieces, so they get a thin skin, which is subtracted from the
// result. A skin adds its thickness to the depth and keeps the normal.
// Source: D. Fiser, libccd 2.1; G. Snethen, XenoCollide, 2008.
#include <ccd/ccd.h>

#include <algorithm>
#include <vector>

#include "library/detectors/catalogue_entry.h"
#include "library/detectors/third_party/convex.h"
#include "library/detectors/third_party/piece_pairs.h"

namespace cdb::third_party {
namespace {

using Eigen::Vector3d;

/// libccd's tests against 0 are absolute. With balls 1 m wide its GJK is right; 20 m wide, it
/// reports every third shallow overlap as a mere touch; 10 cm wide, it does not return. So lengths
/// are in units of the width of the smaller piece, relative to its position.
struct Frame {
  Vector3d origin;
  double unit;  ///< m
  mutable int questions = 0;

  Vector3d In(const Vector3d& point) const { return (point - origin) / unit; }
  Vector3d Out(const Vector3d& point) const { return origin + unit * point; }
};

struct Skinned {
  PlacedPiece piece;
  double skin;  ///< m
  const Frame* frame;
};

Vector3d FromCcd(const ccd_vec3_t& v) { return {v.v[0], v.v[1], v.v[2]}; }
void ToCcd(const Vector3d& from, ccd_vec3_t* to) { ccdVec3Set(to, from.x(), from.y(), from.z()); }

/// The polytope grows without bound if rounding hides convergence. Beyond this number of calls, no
/// point is farther than another, which ends the search with the best result so far.
constexpr int kMostQuestions = 2000;

void Support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* farthest) {
  const auto& [piece, skin, frame] = *static_cast<const Skinned*>(object);
  if (++frame->questions > kMostQuestions) return ccdVec3Set(farthest, 0, 0, 0);
  const Vector3d towards = FromCcd(*direction);
  ToCcd(frame->In(piece.Support(towards) + skin * towards.stableNormalized()), farthest);
}

void Centre(const void* object, ccd_vec3_t* centre) {
  const auto* skinned = static_cast<const Skinned*>(object);
  ToCcd(skinned->frame->In(skinned->piece.Centre()), centre);
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
    ccd_.epa_tolerance = 1e-9;  // compares squares
    ccd_.mpr_tolerance = ccd_.dist_tolerance = 1e-6;
  }

 private:
  /// The support point suffices.
  bool Takes(const Shape& shape) const override {
    return shape.kind == ShapeKind::kSuperellipsoid || PiecePairs::Takes(shape);
  }

  void Touch(const Scene& scene, const Place& a, const Place& b,
             std::vector<Contact>& contacts) override {
    const bool is_a_less = BallOf(a).radius < BallOf(b).radius;
    const double size = BallOf(is_a_less ? a : b).radius;
    const double skin = std::min(kNear / 2, size / 10);
    const PlacedPiece of_a(scene, a.body, a.piece), of_b(scene, b.body, b.piece);
    const Frame frame = {.origin = (is_a_less ? of_a : of_b).Centre(), .unit = 2 * size};
    const Skinned first = {of_a, skin, &frame}, second = {of_b, skin, &frame};
    ccd_real_t depth = 0;
    ccd_vec3_t out, at;  // `out`: the direction in which the second has to move
    if (penetration_(&first, &second, &ccd_, &depth, &out, &at) != 0) return;
    const Vector3d normal = -FromCcd(out);
    const double distance = 2 * skin - depth * frame.unit;
    if (penetration_ == ccdMPRPenetration) {
      Add(a, b, frame.Out(FromCcd(at)), normal,
          AreApart(of_a, of_b, frame) ? std::max(distance, 0.0) : distance, contacts);
    } else {
      // The position that GJK reports is a mean of the corners of its polytope.
      Add(a, b, MeetingPoint(of_a, of_b, normal), normal, distance, contacts);
    }
  }

  /// Without the skin. The depth of MPR is not minimal, and may exceed that of the skin.
  bool AreApart(const PlacedPiece& a, const PlacedPiece& b, const Frame& frame) const {
    frame.questions = 0;
    const Skinned first = {a, 0, &frame}, second = {b, 0, &frame};
    return ccdMPRIntersect(&first, &second, &ccd_) == 0;
  }

  Penetration penetration_;
  ccd_t ccd_;
};

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("ccd_gjk",
                   [](const Options&) -> Detector* { return new ConvexPairs(ccdGJKPenetration); }),
    CatalogueEntry("ccd_mpr",
                   [](const Options&) -> Detector* { return new ConvexPairs(ccdMPRPenetration); }),
};

}  // namespace
}  // namespace cdb::third_party

CDB_DETECTORS(cdb::third_party::kEntries)
