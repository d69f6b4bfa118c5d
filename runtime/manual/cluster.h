// Sweeps on many machines, for `cdb doc cluster`.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kClusterReference;

}  // namespace cdb::manual
