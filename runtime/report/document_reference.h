// The results document, for `cdb doc document`.
#pragma once

#include <string_view>

namespace cdb::report {

extern const std::string_view kDocumentReference;

}  // namespace cdb::report
