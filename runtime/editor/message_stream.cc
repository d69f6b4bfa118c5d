#include "runtime/editor/message_stream.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace cdb::editor {
namespace {

constexpr std::size_t kLongestHead = 8192;
constexpr std::string_view kLength = "content-length:";

bool StartsWithLength(std::string_view line) {
  if (line.size() < kLength.size()) return false;
  for (std::size_t i = 0; i < kLength.size(); ++i) {
    const char c = line[i];
    if ((c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) != kLength[i]) return false;
  }
  return true;
}

/// The length in the last line that states it.
std::optional<std::size_t> LengthIn(std::string_view head) {
  std::optional<std::size_t> length;
  while (!head.empty()) {
    std::string_view line = head.substr(0, head.find('\n'));
    head.remove_prefix(std::min(head.size(), line.size() + 1));
    if (!StartsWithLength(line)) continue;
    line.remove_prefix(kLength.size());
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    const std::string_view rest(end, static_cast<std::size_t>(line.data() + line.size() - end));
    if (error == std::errc() && (rest.empty() || rest == "\r")) length = value;
  }
  return length;
}

/// The end of the head, and the length of its terminator; npos if the head is incomplete.
std::pair<std::size_t, std::size_t> EndOfHead(std::string_view bytes) {
  const std::size_t crlf = bytes.find("\r\n\r\n"), lf = bytes.find("\n\n");
  return crlf < lf ? std::pair(crlf, std::size_t{4}) : std::pair(lf, std::size_t{2});
}

}  // namespace

std::optional<std::string> MessageReader::Next() {
  while (!is_broken_) {
    const auto [end, ending] = EndOfHead(buffer_);
    if (end == std::string::npos) {
      is_broken_ = buffer_.size() > kLongestHead;
      return std::nullopt;
    }
    const auto length = LengthIn(std::string_view(buffer_).substr(0, end));
    if (!length) {
      buffer_.erase(0, end + ending);
      continue;
    }
    if (*length > kLongestMessage) {
      is_broken_ = true;
      return std::nullopt;
    }
    if (buffer_.size() - end - ending < *length) return std::nullopt;
    std::string message = buffer_.substr(end + ending, *length);
    buffer_.erase(0, end + ending + *length);
    return message;
  }
  return std::nullopt;
}

std::string Framed(std::string_view message) {
  return "Content-Length: " + std::to_string(message.size()) + "\r\n\r\n" + std::string(message);
}

}  // namespace cdb::editor
