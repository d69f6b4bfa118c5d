// Text of bounded size in memory that another process may have damaged.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

namespace cdb::protocol {

/// Truncates text that does not fit.
template <std::size_t kSize>
class FixedText {
 public:
  static constexpr std::size_t kMaxLength = kSize - 1;

  FixedText& operator=(std::string_view text) {
    const std::size_t length = std::min(text.size(), kMaxLength);
    std::memcpy(text_, text.data(), length);
    text_[length] = '\0';
    return *this;
  }
  /// Ends at the end of the memory if the terminator was overwritten.
  std::string str() const { return std::string(text_, strnlen(text_, kSize)); }

 private:
  char text_[kSize] = {};
};

}  // namespace cdb::protocol
