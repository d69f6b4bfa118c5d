// A library that is rejected for the reason defined by its build.
#include <signal.h>
#include <unistd.h>

#include "library/detectors/detector.h"

namespace {

#if defined(CRASHES)
const int at_loading = raise(SIGSEGV);
#elif defined(HANGS)
const int at_loading = [] {
  for (;;) pause();
  return 0;
}();
#endif

#if defined(BAD_NAME)
constexpr const char* kName = "half-open";
#elif defined(TAKEN_NAME)
constexpr const char* kName = "dbvt";
#else
constexpr const char* kName = "lonely";
#endif

[[maybe_unused]] cdb::Detector* Make(const cdb::Options&) { return new cdb::Detector; }
[[maybe_unused]] constexpr cdb::DetectorEntry kEntries[] = {{kName, "", cdb::kBroad, 0, Make}};

}  // namespace

#if defined(OTHER_ABI)
extern "C" __attribute__((used, section(CDB_MANIFEST_SECTION))) constexpr char kOther[] =
    "1000000\tlibstdc++\nlonely\tbroad\t0\n";
#elif defined(OTHER_BUILD)
static_assert(cdb::kDetectorAbi == 5, "the number in the list below");
extern "C" __attribute__((used, section(CDB_MANIFEST_SECTION))) constexpr char kOther[] =
    "5\tanother library\nlonely\tbroad\t0\n";
#elif !defined(NO_SYMBOL)
CDB_DETECTORS(kEntries)
#endif
