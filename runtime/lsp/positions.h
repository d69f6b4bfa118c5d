// Places in a text as the protocol counts them: lines from 0, and UTF-16 code units from 0.
#pragma once

#include <cstdint>
#include <string>

#include "dsl/text/source.h"

namespace cdb::lsp {

struct Position {
  std::int64_t line = 0;
  std::int64_t character = 0;
};

/// Of a byte of the text; within a character, that of its begin. A byte that is not UTF-8 counts as
/// one unit.
Position PositionOf(const text::Source& source, std::uint32_t offset);

/// The byte at a position; the end of the line behind it, the end of the text behind the last line,
/// the begin before the first.
std::uint32_t OffsetOf(const text::Source& source, const Position& position);

/// `file:///tmp/a%20b.cdb` as a path; other addresses, such as those of unsaved texts, as they are.
std::string PathOf(const std::string& uri);
std::string UriOf(const std::string& path);

}  // namespace cdb::lsp
