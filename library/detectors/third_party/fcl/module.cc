// The detectors of the shared library cdb-detectors-fcl.so.
#include "library/detectors/catalogue_entry.h"
#include "library/detectors/detector.h"
#include "library/detectors/third_party/fcl/managers.h"
#include "library/detectors/third_party/fcl/narrow.h"

namespace cdb::third_party {
namespace {

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("fcl_dyntree", MakeFclTree),
    CatalogueEntry("fcl_dyntree_array", MakeFclTreeArray),
    CatalogueEntry("fcl_ssap", MakeFclSsap),
    CatalogueEntry("fcl_spatialhash", MakeFclSpatialHash),
    CatalogueEntry("fcl_intervaltree", MakeFclIntervalTree),
    CatalogueEntry("fcl_gjk", MakeFclGjk),
    CatalogueEntry("fcl_aabb", MakeFclAabb),
    CatalogueEntry("fcl_obb", MakeFclObb),
    CatalogueEntry("fcl_rss", MakeFclRss),
    CatalogueEntry("fcl_kdop", MakeFclKdop),
};

}  // namespace
}  // namespace cdb::third_party

CDB_DETECTORS(cdb::third_party::kEntries)
