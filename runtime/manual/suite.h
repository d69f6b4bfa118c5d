// The text of `cdb doc suite`.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kSuiteReference;

}  // namespace cdb::manual
