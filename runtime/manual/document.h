// The text of `cdb doc document`: the results document.
#pragma once

#include <string_view>

namespace cdb::manual {

extern const std::string_view kDocumentReference;

}  // namespace cdb::manual
