// Joins strings, for messages.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace cdb::text {

inline std::string Concat(std::initializer_list<std::string_view> pieces) {
  std::string joined;
  for (const std::string_view piece : pieces) joined += piece;
  return joined;
}

}  // namespace cdb::text
