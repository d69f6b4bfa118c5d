// A source text, and ranges of it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::text {

/// Line and column, both counted from 1; a column is one UTF-8 code point.
struct Position {
  int line = 1;
  int column = 1;
};

/// A named text with an index of its lines. Immutable; every `Span` into it points to it, so it
/// must outlive them (the tree parsed from it owns it). A UTF-8 byte order mark at the start is
/// dropped. Less than 4 GiB; the code that reads a file rejects a larger one.
class Source {
 public:
  Source(std::string name, std::string text);
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  /// The name as the user wrote it; shown in messages, never opened.
  const std::string& name() const { return name_; }
  std::string_view text() const { return text_; }

  /// Offsets past the end give the position after the last character.
  Position PositionAt(std::uint32_t offset) const;
  /// The line without its end (LF or CR LF); empty if there is no such line.
  std::string_view Line(int line) const;
  /// The offset of the start of a line; the length of the text if there is no such line.
  std::uint32_t LineStart(int line) const;
  /// The offset in the file of a byte of the text, which excludes the byte order mark.
  std::uint32_t FileOffset(std::uint32_t offset) const { return offset + byte_order_mark_; }
  int LineCount() const { return static_cast<int>(line_starts_.size()); }

 private:
  std::uint32_t CodePointsBefore(std::uint32_t offset) const;

  std::string name_;
  std::string text_;
  std::uint32_t byte_order_mark_ = 0;  // its length in bytes, 0 if there is none
  std::vector<std::uint32_t> line_starts_;
  // Code points before every kStride-th byte, to find a column quickly even in a very long line.
  std::vector<std::uint32_t> code_points_;
};

/// Bytes [begin, end) of a source. An empty span marks a position between two characters.
struct Span {
  const Source* source = nullptr;
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// The text of a span.
inline std::string_view TextOf(const Span& span) {
  return span.source->text().substr(span.begin, span.end - span.begin);
}

/// The smallest span that contains both, which must be of one source.
Span Join(const Span& first, const Span& last);

}  // namespace cdb::text
