#include "runtime/terminal/console.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "dsl/text/utf8.h"

namespace cdb::terminal {
namespace {

int first_error = 0;  // of standard output

void NoteError(bool has_failed) {
  if (has_failed && first_error == 0) first_error = errno;
}

}  // namespace

void Print(std::string_view text) { PrintExact(text::Printable(text)); }

void PrintJson(std::string_view json) { PrintExact(text::PrintableJson(json)); }

void PrintExact(std::string_view text) {
  NoteError(std::fwrite(text.data(), 1, text.size(), stdout) != text.size());
}

void Say(std::string_view text) { SayExact(text::Printable(text)); }

void SayExact(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); }

void Flush() { NoteError(std::fflush(stdout) != 0); }

std::optional<std::string> FinishOutput() {
  Flush();
  // Closing may be the first call that reports a failed write (NFS, quotas). A copy is closed,
  // because the libraries still use the descriptor.
  if (const int copy = dup(STDOUT_FILENO); copy >= 0) NoteError(close(copy) != 0);
  if (first_error == 0 && std::ferror(stdout) != 0) first_error = EIO;
  if (first_error == 0 || first_error == EPIPE) return std::nullopt;
  return std::generic_category().message(first_error);
}

std::size_t TerminalWidth() {
  if (isatty(STDOUT_FILENO) == 0) return 0;
  if (const char* columns = std::getenv("COLUMNS"))
    if (const long width = std::strtol(columns, nullptr, 10); width > 0)
      return static_cast<std::size_t>(width);
  struct winsize size = {};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

std::string ShellWord(std::string_view text) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./+=:,@%").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::ranges::all_of(text, is_plain)) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

}  // namespace cdb::terminal
