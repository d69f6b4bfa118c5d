// Messages of the protocol in a stream of bytes: a head with Content-Length, then JSON.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace cdb::lsp {

/// Cuts messages out of what arrives. A head without a length, or with one that is no number, is
/// skipped; a message of more than kLongestMessage bytes ends the stream, as its end cannot be
/// waited for.
class MessageReader {
 public:
  static constexpr std::size_t kLongestMessage = std::size_t{64} << 20;

  void Add(std::string_view bytes) { buffer_ += bytes; }
  /// The next whole message; nullopt until more bytes arrive.
  std::optional<std::string> Next();
  /// Nothing that arrives now can be understood.
  bool is_broken() const { return is_broken_; }

 private:
  std::string buffer_;
  bool is_broken_ = false;
};

/// A message with its head.
std::string Framed(std::string_view message);

}  // namespace cdb::lsp
