// Facts of build and machine that a timing means nothing without.
#pragma once

#include <string>

#include "runtime/store/store.h"

namespace cdb::options {

/// `Release`, or what else this program was built as. Sanitizers count as another build.
std::string BuildType();

/// Version, commit, build, compiler, Bullet, processor, memory, kernel, system, frequency governor;
/// what the system does not tell is left out.
store::Provenance CollectProvenance();

}  // namespace cdb::options
