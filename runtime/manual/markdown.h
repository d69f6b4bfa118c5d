// The pages of the manual, from Markdown to text for a terminal.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::manual {

/// A heading, and the Markdown up to the next one.
struct Section {
  int level;
  /// In capitals, but for its code, if the level is 1 or 2.
  std::string heading;
  std::string body;
};

std::vector<Section> Sections(std::string_view markdown);

/// The generated text in place of a paragraph that ends with `<!-- NAME -->`; empty for an unknown
/// name, which leaves the paragraph as it is.
using PartOf = std::function<std::string(std::string_view name)>;

/// The blocks of a section in lines of at most `width` columns: paragraphs, lists, tables and code;
/// neither lists in lists nor numbered ones. Items that begin with code and a colon, "`term`:
/// text", become two columns. Code keeps its lines.
std::string BodyText(std::string_view body, std::size_t width, const PartOf& part);

/// All sections of a page.
std::string PageText(std::string_view markdown, std::size_t width, const PartOf& part);

}  // namespace cdb::manual
