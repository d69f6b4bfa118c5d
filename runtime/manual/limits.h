// The text of `cdb doc limits`.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kLimitsReference;

}  // namespace cdb::manual
