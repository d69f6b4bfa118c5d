#include "runtime/engine/worker/confinement.h"

#include <cstdlib>

#include "runtime/engine/worker/landlock.h"
#include "runtime/engine/worker/system_call_filter.h"

#include <sys/prctl.h>

namespace cdb::worker {

void Confine() {
  const char* unconfined = std::getenv(kUnconfined);
  if (unconfined != nullptr && *unconfined != '\0') return;
  // Without it, the kernel allows only root to confine a process.
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  RestrictByLandlock();
  FilterSystemCalls();
}

}  // namespace cdb::worker
