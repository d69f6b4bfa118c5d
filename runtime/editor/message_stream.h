// Messages of the protocol in a stream of bytes: a head with Content-Length, then JSON.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace cdb::editor {

/// Extracts messages from a stream of bytes. A head with a missing or malformed length is skipped.
/// A message of more than kLongestMessage bytes breaks the stream, because its end cannot be waited
/// for.
class MessageReader {
 public:
  static constexpr std::size_t kLongestMessage = std::size_t{64} << 20;

  void Add(std::string_view bytes) { buffer_ += bytes; }
  /// The next complete message; nullopt until more bytes arrive.
  std::optional<std::string> Next();
  /// The stream is broken: later bytes cannot be interpreted.
  bool is_broken() const { return is_broken_; }

 private:
  std::string buffer_;
  bool is_broken_ = false;
};

/// A message with its head.
std::string Framed(std::string_view message);

}  // namespace cdb::editor
