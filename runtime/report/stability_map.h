// The map of a stability suite: where each configuration stops being sound.
#pragma once

#include <string>

#include "runtime/store/store.h"

namespace cdb::report {

/// One benchmark's part: along its own axis, the last one of numbers, the verdicts of every
/// combination of the other axes, a line each, equal neighbours drawn together:
/// `single  stable 1 .. 5 | penetrating 10 | collapsed 20 .. 1000`. The worst of repeats counts.
/// Throws StoreError.
std::string StabilityMap(const store::ResultFile& file);

}  // namespace cdb::report
