// SHA-256 (FIPS 180-4), to identify plans and runs by their contents.
#pragma once

#include <string>
#include <string_view>

namespace cdb::plan {

/// 64 hex digits.
std::string Sha256Hex(std::string_view data);
/// The same without special processor instructions.
std::string PortableSha256Hex(std::string_view data);

}  // namespace cdb::plan
