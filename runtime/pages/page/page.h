// Self-contained HTML pages: they open from disk, offline, and load nothing. A page consists of a
// template, which esbuild makes from the JavaScript and the style sheet beside this file, and a
// JSON document, which the script draws. Its Content-Security-Policy allows no other script, and
// the document is escaped, so that its text cannot leave its element.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace cdb::page {

/// HTML up to the title, from there to the document, and from there to the end.
struct Template {
  std::string_view before_title, before_data, after_data;
};

/// Pages of `cdb report`, with figures, of `cdb view`, with bodies in 3-D, and of `cdb view
/// --serve`, which adds an editor.
const Template& ReportTemplate();
const Template& ViewTemplate();
const Template& EditTemplate();

/// This build has no pages, because it was made without npm.
struct PageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The whole page. `title` is plain text; `json` is a document in UTF-8. Throws PageError.
std::string Assemble(const Template& page, std::string_view title, std::string_view json);

}  // namespace cdb::page
