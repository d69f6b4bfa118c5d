// The results document, for `cdb doc document`.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kDocumentReference;

}  // namespace cdb::manual
