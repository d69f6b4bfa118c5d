// The text of `cdb doc statistics`: the statistics of `cdb show` and `cdb compare`.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kStatisticsReference;

}  // namespace cdb::manual
