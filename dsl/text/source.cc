#include "dsl/text/source.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "dsl/text/check.h"

namespace cdb::text {
namespace {

constexpr std::uint32_t kStride = 1024;

// Counts the bytes that begin a code point; a byte that is not UTF-8 counts as one character.
std::uint32_t CountCodePoints(std::string_view text) {
  return static_cast<std::uint32_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

}  // namespace

Source::Source(std::string name, std::string text)
    : name_(std::move(name)), text_(std::move(text)) {
  CDB_CHECK(text_.size() < std::numeric_limits<std::uint32_t>::max());
  if (text_.starts_with("\xEF\xBB\xBF")) byte_order_mark_ = 3;
  text_.erase(0, byte_order_mark_);
  line_starts_.push_back(0);
  for (std::size_t at = text_.find('\n'); at != std::string::npos; at = text_.find('\n', at + 1))
    line_starts_.push_back(static_cast<std::uint32_t>(at + 1));
  std::uint32_t count = 0;
  for (std::size_t at = 0; at <= text_.size(); at += kStride) {
    code_points_.push_back(count);
    count += CountCodePoints(std::string_view(text_).substr(at, kStride));
  }
}

std::uint32_t Source::CodePointsBefore(std::uint32_t offset) const {
  const std::uint32_t block = offset / kStride;
  return code_points_[block] +
         CountCodePoints(std::string_view(text_).substr(block * kStride, offset % kStride));
}

Position Source::PositionAt(std::uint32_t offset) const {
  offset = std::min(offset, static_cast<std::uint32_t>(text_.size()));
  const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
  const auto line = static_cast<int>(next - line_starts_.begin());
  const std::uint32_t before = CodePointsBefore(*(next - 1));
  return {line, static_cast<int>(CodePointsBefore(offset) - before) + 1};
}

std::uint32_t Source::LineStart(int line) const {
  if (line < 1 || line > LineCount()) return static_cast<std::uint32_t>(text_.size());
  return line_starts_[static_cast<std::size_t>(line) - 1];
}

std::string_view Source::Line(int line) const {
  if (line < 1 || line > LineCount()) return {};
  const std::uint32_t begin = LineStart(line);
  std::string_view rest = std::string_view(text_).substr(begin, LineStart(line + 1) - begin);
  if (rest.ends_with('\n')) rest.remove_suffix(1);
  if (rest.ends_with('\r')) rest.remove_suffix(1);
  return rest;
}

Span Join(const Span& first, const Span& last) {
  CDB_CHECK(first.source == last.source);
  return {first.source, std::min(first.begin, last.begin), std::max(first.end, last.end)};
}

}  // namespace cdb::text
