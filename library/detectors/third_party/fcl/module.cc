// The detectors of the shared library cdb-detectors-fcl.so.
#include "library/detectors/detector.h"
#include "library/detectors/third_party/fcl/managers.h"
#include "library/detectors/third_party/fcl/narrow.h"

namespace cdb::third_party {
namespace {

constexpr DetectorEntry kEntries[] = {
    {"fcl_dyntree", "a dynamic tree of boxes", kBroad, 0, MakeFclTree},
    {"fcl_dyntree_array", "a dynamic tree of boxes in an array", kBroad, 0, MakeFclTreeArray},
    {"fcl_ssap", "sorted anew every cycle along the best axis", kBroad, 0, MakeFclSsap},
    {"fcl_spatialhash", "a hashed grid", kBroad, 0, MakeFclSpatialHash},
    {"fcl_intervaltree", "an interval tree for each axis", kBroad, 0, MakeFclIntervalTree},
    {"fcl_gjk", "closed forms, else GJK and an expanding polytope", kNarrow, 0, MakeFclGjk},
    {"fcl_aabb", "trees of boxes on triangles", kNarrow, 0, MakeFclAabb},
    {"fcl_obb", "trees of oriented boxes on triangles", kNarrow, 0, MakeFclObb},
    {"fcl_rss", "trees of rectangle-swept spheres on triangles", kNarrow, 0, MakeFclRss},
    {"fcl_kdop", "trees of 18-DOPs on triangles", kNarrow, 0, MakeFclKdop},
};

}  // namespace
}  // namespace cdb::third_party

CDB_DETECTORS(cdb::third_party::kEntries)
