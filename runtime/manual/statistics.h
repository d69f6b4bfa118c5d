// How `cdb show` and `cdb compare` make their figures, for `cdb doc statistics`.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kStatisticsReference;

}  // namespace cdb::manual
