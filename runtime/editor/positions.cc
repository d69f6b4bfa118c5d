#include "runtime/editor/positions.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "dsl/text/utf8.h"

namespace cdb::editor {
namespace {

constexpr std::string_view kFileScheme = "file://";

struct CharacterSize {
  std::uint32_t bytes;
  int units;
};

CharacterSize SizeAt(std::string_view text, std::size_t at) {
  const text::CodePoint point = text::DecodeUtf8(text, at);
  if (point.bytes == 0) return {1, 1};
  return {static_cast<std::uint32_t>(point.bytes), point.value > 0xFFFF ? 2 : 1};
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

Position PositionOf(const text::Source& source, std::uint32_t offset) {
  offset = std::min(offset, static_cast<std::uint32_t>(source.text().size()));
  const int line = source.PositionAt(offset).line;
  Position position{line - 1, 0};
  for (std::uint32_t at = source.LineStart(line); at < offset;) {
    const CharacterSize size = SizeAt(source.text(), at);
    if (at + size.bytes > offset) break;
    at += size.bytes;
    position.character += size.units;
  }
  return position;
}

std::uint32_t OffsetOf(const text::Source& source, const Position& position) {
  if (position.line < 0) return 0;
  if (position.line >= source.LineCount()) return static_cast<std::uint32_t>(source.text().size());
  const int line = static_cast<int>(position.line) + 1;
  const std::uint32_t begin = source.LineStart(line);
  const auto end = begin + static_cast<std::uint32_t>(source.Line(line).size());
  std::uint32_t at = begin;
  for (std::int64_t units = 0; at < end;) {
    const CharacterSize size = SizeAt(source.text(), at);
    if (units + size.units > position.character) break;
    units += size.units;
    at += size.bytes;
  }
  return std::min(at, end);
}

std::string PathOf(const std::string& uri) {
  if (!uri.starts_with(kFileScheme)) return uri;
  std::string path;
  for (std::size_t i = uri.find('/', kFileScheme.size()); i < uri.size(); ++i) {
    const int high = i + 2 < uri.size() ? HexDigit(uri[i + 1]) : -1;
    const int low = i + 2 < uri.size() ? HexDigit(uri[i + 2]) : -1;
    if (uri[i] == '%' && high >= 0 && low >= 0) {
      path += static_cast<char>(high * 16 + low);
      i += 2;
    } else {
      path += uri[i];
    }
  }
  return path;
}

std::string UriOf(const std::string& path) {
  if (!path.starts_with('/')) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::absolute(path, error);
    return error || path.find(':') != path.npos ? path : UriOf(whole.lexically_normal().string());
  }
  std::string uri(kFileScheme);
  for (const char c : path) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') ||
                          std::string_view("/-._~").find(c) != std::string_view::npos;
    uri += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

}  // namespace cdb::editor
