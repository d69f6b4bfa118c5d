// Facts about the build and the machine, without which a timing has no meaning.
#pragma once

#include <string>

#include "runtime/results/store.h"

namespace cdb::options {

/// `Release`, or another build type. A build with sanitizers counts as a build type of its own.
std::string BuildType();

/// Version, commit, build, compiler, Bullet, processor with its clocks and frequency governor,
/// memory, kernel, system.
/// Facts that the system does not provide are left out.
results::Provenance CollectProvenance();

}  // namespace cdb::options
