#include "runtime/report/wrap.h"

#include <algorithm>

#include "runtime/report/console.h"

namespace cdb::report {
namespace {

constexpr std::size_t kWidestText = 100;

std::size_t ColumnsOfText(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

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

}  // namespace cdb::report
