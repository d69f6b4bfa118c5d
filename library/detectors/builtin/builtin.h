// cdb's own detectors, which have no dependencies, by name. Each is a file NAME.cc that needs
// detector.h and the kernels alone.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// Linked into every worker; described in compiler/schema/catalogue_table.h. Threads: any.
std::span<const DetectorEntry> BuiltinDetectors();

/// One of them with these kernels instead of the best, for tests; null if it uses none.
std::unique_ptr<Detector> MakeWithKernels(std::string_view name, const Options& options,
                                          const kernels::Kernels& kernels);

}  // namespace cdb::builtin
