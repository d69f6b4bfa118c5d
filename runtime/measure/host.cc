#include "runtime/measure/host.h"

#include <sched.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <limits>

namespace cdb::measure {

std::string HostName() {
  std::array<char, 256> name = {};
  if (gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return "localhost";
  return name.data();
}

double LoadAverage() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : std::numeric_limits<double>::quiet_NaN();
}

double ProcessorCount() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set)
                                                     : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace cdb::measure
