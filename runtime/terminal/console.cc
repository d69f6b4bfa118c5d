#include "runtime/terminal/console.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <deque>
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

namespace {

constexpr std::size_t kWidestText = 100;

std::size_t ColumnsOfText(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::size_t IndentOf(std::string_view line) {
  return std::min(line.find_first_not_of(' '), line.size());
}

/// The column at which the second column of a line begins, or else its text.
std::size_t HangOf(std::string_view line, std::size_t width) {
  const std::size_t indent = IndentOf(line);
  const std::size_t gap = line.find("  ", indent);
  const std::size_t text = gap == std::string_view::npos ? gap : line.find_first_not_of(' ', gap);
  if (text == std::string_view::npos) return indent;
  const std::size_t column = ColumnsOfText(line.substr(0, text));
  return column <= width / 2 ? column : indent;
}

/// The byte at which to break a line: that of the last space that leaves at most `width` columns
/// before it, and some text after `hang`; npos if there is none.
std::size_t BreakOf(std::string_view line, std::size_t hang, std::size_t width) {
  std::size_t best = std::string_view::npos, column = 0;
  for (std::size_t at = 0; at < line.size() && column <= width; ++at) {
    if (line[at] == ' ' && column > hang) best = at;
    if ((line[at] & 0xC0) != 0x80) ++column;
  }
  return best;
}

/// True if the line continues a paragraph, or a column, that hangs at `hang`.
bool GoesOn(std::string_view next, std::size_t hang) {
  return !next.empty() && IndentOf(next) == hang && next.find("  ", hang) == std::string_view::npos;
}

bool IsRule(std::string_view line) {
  return !line.empty() && line.find_first_not_of(" -") == std::string_view::npos;
}

}  // namespace

std::string Fitted(std::string_view text, std::size_t width) {
  if (width == 0) return std::string(text);
  std::deque<std::string> lines;
  for (; !text.empty(); text.remove_prefix(std::min(text.size(), lines.back().size() + 1)))
    lines.emplace_back(text.substr(0, text.find('\n')));
  std::string fitted;
  while (!lines.empty()) {
    std::string line = std::move(lines.front());
    lines.pop_front();
    if (ColumnsOfText(line) > width && IsRule(line)) line.resize(width);
    std::size_t hang = HangOf(line, width);
    const std::size_t at =
        ColumnsOfText(line) > width ? BreakOf(line, hang, width) : std::string::npos;
    // The first line of a paragraph may be indented further.
    if (hang == IndentOf(line) && !lines.empty() && IndentOf(lines.front()) < hang &&
        GoesOn(lines.front(), IndentOf(lines.front())))
      hang = IndentOf(lines.front());
    if (at != std::string::npos) {
      std::string rest = std::string(hang, ' ') + line.substr(at + 1);
      line.resize(line.find_last_not_of(' ', at) + 1);
      if (!lines.empty() && GoesOn(lines.front(), hang)) {
        rest += ' ' + lines.front().substr(hang);
        lines.pop_front();
      }
      lines.push_front(std::move(rest));
    }
    fitted += line + '\n';
  }
  return fitted;
}

std::size_t TextWidth() {
  const std::size_t terminal = TerminalWidth();
  return terminal == 0 ? kWidestText : std::min(terminal, kWidestText);
}

std::string Wrapped(std::string_view text, std::size_t indent, std::size_t width) {
  std::string wrapped;
  std::size_t column = 0;
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(" \n"), text.size()));
    if (text.empty()) break;
    const std::string_view word = text.substr(0, text.find_first_of(" \n"));
    text.remove_prefix(word.size());
    const std::size_t columns = ColumnsOfText(word);
    if (column > 0 && column + 1 + columns <= width) {
      wrapped += ' ';
      ++column;
    } else {
      if (column > 0) wrapped += '\n';
      wrapped.append(indent, ' ');
      column = indent;
    }
    wrapped += word;
    column += columns;
  }
  return wrapped.empty() ? wrapped : wrapped + '\n';
}

}  // namespace cdb::terminal
