// A comparison as sections of lines and tables, for a terminal or in Markdown.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace cdb::compare {

struct DocumentTable {
  std::vector<std::pair<std::string, bool>> columns;  ///< head; aligned to the right
  std::vector<std::vector<std::string>> rows;
};

/// Lines, then a table if it has rows, then notes.
struct DocumentSection {
  std::string title;
  std::vector<std::string> lines = {};
  DocumentTable table = {};
  std::vector<std::string> notes = {};
};
using Document = std::vector<DocumentSection>;

/// Lines of more than 100 columns are wrapped.
std::string TerminalText(const Document& document);
/// In GitHub's dialect of Markdown, which has tables.
std::string MarkdownText(const Document& document);

/// `1.052`: four significant digits, and all digits of a whole number; `-` for NaN.
std::string FourDigits(double value);
/// `+5.2 %` of a ratio of 1.052.
std::string PercentText(double ratio);
/// `+4.6 .. +5.8 %`.
std::string PercentRange(double low, double high);
/// `25.12 us`, in the unit that suits `like_ns`.
std::string TimeText(double ns, double like_ns);

}  // namespace cdb::compare
