// Changes one setting in the text of a scenario, and leaves the rest unchanged.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cdb::serve {

/// The text cannot be edited: it does not parse, or has no such place.
struct EditError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Whether the text has no syntax errors.
bool Parses(const std::string& text);

/// The location of a setting: the world or a group of objects.
struct Place {
  std::string group;  ///< empty: the world; `objects` for a group without a name
  std::string name;   ///< without the group: `size`, `world.side`
};

/// The groups in a benchmark's own block, in order. Throws EditError.
std::vector<std::string> GroupsIn(const std::string& text, const std::string& benchmark);

/// The value as written in the benchmark's own block; nullopt if it is not set there. Throws
/// EditError.
std::optional<std::string> WrittenValue(const std::string& text, const std::string& benchmark,
                                        const Place& place);

/// Puts `value` in place of the written one, or adds a setting at the end of the block. Throws
/// EditError for a text with syntax errors, an unknown benchmark or group, and a value that is
/// empty or has several lines.
std::string WithValue(const std::string& text, const std::string& benchmark, const Place& place,
                      const std::string& value);

}  // namespace cdb::serve
