// SHA-256 (FIPS 180-4), to name plans and runs by what is in them.
#pragma once

#include <string>
#include <string_view>

namespace cdb::plan {

/// 64 hex digits.
std::string Sha256Hex(std::string_view data);
/// The same without special instructions of the processor.
std::string PortableSha256Hex(std::string_view data);

}  // namespace cdb::plan
