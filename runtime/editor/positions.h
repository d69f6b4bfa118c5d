// Positions in a text as the protocol counts them: lines and UTF-16 code units, both from 0.
#pragma once

#include <cstdint>
#include <string>

#include "dsl/text/source.h"

namespace cdb::editor {

struct Position {
  std::int64_t line = 0;
  std::int64_t character = 0;
};

/// The position of a byte; within a character, that of its first byte. A byte that is not UTF-8
/// counts as one unit.
Position PositionOf(const text::Source& source, std::uint32_t offset);

/// The byte at a position. Beyond the end of a line, the end of that line; beyond the last line,
/// the end of the text; before the first line, its begin.
std::uint32_t OffsetOf(const text::Source& source, const Position& position);

/// `file:///tmp/a%20b.cdb` as a path. Other URIs, such as those of unsaved texts, are unchanged.
std::string PathOf(const std::string& uri);
std::string UriOf(const std::string& path);

}  // namespace cdb::editor
