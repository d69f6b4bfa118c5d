// The browsers of the machine: one that shows a page, and one that draws the figures of a page
// without a window.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace cdb::options {

/// `file:///home/a%20b/c.html`
std::string AddressOf(const std::filesystem::path& page);

/// Opens a page in the first program of $BROWSER (`firefox:chromium --new-window %s`), else by
/// xdg-open if there is a display, and does not wait for it. Returns the program, or an empty text
/// if there is none.
std::string OpenInBrowser(const std::filesystem::path& page);

/// How the figures of a report are drawn.
struct FigureChoices {
  std::string size = "screen";  ///< or `column` or `page`, of print
  std::string view;             ///< what the address of the page has after #; empty: on opening it
};

/// The figures of a report: the name of a file, and SVG. Scripts draw them, and need the fonts and
/// the layout of a browser. Throws CommandError, with the remedy, if a choice is unknown, PATH has
/// no browser of the family of Chromium, or it fails.
std::vector<std::pair<std::string, std::string>> DrawFigures(const std::filesystem::path& page,
                                                             const FigureChoices& choices);

}  // namespace cdb::options
