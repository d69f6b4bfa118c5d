#include "library/detectors/bullet/broad_phases.h"
#include "library/detectors/bullet/bullet.h"
#include "library/detectors/bullet/contacts.h"

namespace cdb::bullet {
namespace {

constexpr DetectorEntry kEntries[] = {
    {"simple", "every pair of boxes is tested", kBroad, 0, MakeBulletSimple},
    {"sap", "sweep and prune on boxes rounded to 16 bits", kBroad, 16384, MakeBulletSap},
    {"sap32", "sweep and prune on boxes rounded to 32 bits", kBroad, 0, MakeBulletSap32},
    {"dbvt", "two dynamic bounding-volume trees", kBroad, 0, MakeBulletDbvt},
    {"bullet", "contacts of two balls or two cuboids", kNarrow, 0, MakeBulletContacts},
};

}  // namespace

std::span<const DetectorEntry> BulletDetectors() { return kEntries; }

}  // namespace cdb::bullet
