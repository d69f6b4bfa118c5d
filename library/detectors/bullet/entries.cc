#include "library/detectors/bullet/broad_phases.h"
#include "library/detectors/bullet/bullet.h"
#include "library/detectors/bullet/contacts.h"
#include "library/detectors/catalogue_entry.h"

namespace cdb::bullet {
namespace {

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("simple", MakeBulletSimple),   CatalogueEntry("sap", MakeBulletSap),
    CatalogueEntry("sap32", MakeBulletSap32),     CatalogueEntry("dbvt", MakeBulletDbvt),
    CatalogueEntry("bullet", MakeBulletContacts),
};

}  // namespace

std::span<const DetectorEntry> BulletDetectors() { return kEntries; }

}  // namespace cdb::bullet
