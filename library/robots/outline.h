// The elements of an XML file with their lines, before a library reads it.
//
// XML libraries report no lines, and some end badly on files that are damaged. What passes here is
// well-formed, of limited depth and valid UTF-8. Errors: SceneError with the file, the line, the
// cause and the remedy. Threads: any. Source: Extensible Markup Language 1.0, without DTDs.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cdb::robots {

struct Element {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::size_t parent = kNone;      ///< its index, or kNone
  std::size_t begin = 0, end = 0;  ///< bytes of the text, from `<` to behind the last `>`
  std::size_t line = 0;            ///< from 1

  /// Empty if it has no such attribute.
  std::string_view Attribute(std::string_view attribute) const;
};

/// Larger files, deeper elements and more of them are refused.
inline constexpr std::size_t kMaxRobotBytes = std::size_t{32} << 20;
inline constexpr std::size_t kMaxDepth = 64, kMaxElements = 1'000'000;

/// In the order of their start tags. `file`: for messages.
std::vector<Element> ReadOutline(std::string_view text, const std::string& file);

}  // namespace cdb::robots
