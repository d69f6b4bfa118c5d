#include "dsl/text/check.h"

#include <cstdio>
#include <cstdlib>

namespace cdb::text {

void CheckFailed(const char* condition, const char* file, int line) {
  std::fprintf(
      stderr,
      "cdb: internal error at %s:%d: '%s' does not hold. This is a bug in cdb, not in your "
      "scenario; please report it.\n",
      file, line, condition);
  std::fflush(stderr);
  std::abort();
}

}  // namespace cdb::text
