// Text within HTML and XML.
#pragma once

#include <string>
#include <string_view>

namespace cdb::text {

/// Printable text (utf8.h), with the characters escaped that mean something in an element or an
/// attribute of HTML or XML.
std::string EscapedMarkup(std::string_view text);

}  // namespace cdb::text
