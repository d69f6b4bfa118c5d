// The text of `cdb doc cluster`: sweeps on many machines.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kClusterReference;

}  // namespace cdb::manual
