// The map of a stability suite: the limits of sound simulation for each configuration.
#pragma once

#include <string>

#include "runtime/store/store.h"

namespace cdb::printers {

/// The part of one benchmark: the verdicts along its graded axis, the last one of numbers, in a
/// line for each combination of the other axes, with equal neighbours joined: `single  stable 1 ..
/// 5 | penetrating 10 | collapsed 20 .. 1000` The worst verdict of the repeats counts. Throws
/// StoreError.
std::string StabilityMap(const store::ResultFile& file);

}  // namespace cdb::printers
