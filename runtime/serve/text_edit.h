// Changes one setting in the text of a scenario, and leaves the rest as it was written.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::serve {

/// The text cannot be edited: it is no scenario, or has no such place.
struct EditError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where a setting belongs: of the world, or of a group of objects.
struct Place {
  std::string group;  ///< empty: the world; `objects` where the group has no name
  std::string name;   ///< without the group: `size`, `world.side`
};

/// The groups of a benchmark's own block, in its order. Throws EditError.
std::vector<std::string> GroupsIn(const std::string& text, const std::string& benchmark);

/// As the benchmark's own block writes it; nullopt where it does not set it. Throws EditError.
std::optional<std::string> WrittenValue(const std::string& text, const std::string& benchmark,
                                        const Place& place);

/// With `value` in place of the written one, or a new setting at the end of its block. Throws
/// EditError for text with errors of syntax, a benchmark or a group that is not there, and a value
/// that is empty or has several lines.
std::string WithValue(const std::string& text, const std::string& benchmark, const Place& place,
                      const std::string& value);

}  // namespace cdb::serve
