#include "runtime/pages/page/page.h"

#include <fmt/format.h>

#include "dsl/text/markup.h"
#include "dsl/text/utf8.h"

namespace cdb::page {
namespace {

/// In JSON, `<` occurs only in strings; escaped, the document is safe inside a script element.
std::string EscapeJson(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      escaped += "\\u003c";
    else
      escaped += c;
  }
  return escaped;
}

}  // namespace

std::string Assemble(const Template& page, std::string_view title, std::string_view json) {
  if (page.before_title.empty())
    throw PageError(
        "this cdb was built without pages, which need npm and CDB_PAGES=ON: install npm (as root "
        "`apt-get install npm`) and run ./setup again");
  return fmt::format("{}{}{}{}{}", page.before_title, text::EscapedMarkup(title), page.before_data,
                     EscapeJson(text::PrintableJson(json)), page.after_data);
}

}  // namespace cdb::page
