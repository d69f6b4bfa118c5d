// The pages of the manual: the Markdown files of this folder, embedded.
#pragma once

#include <span>
#include <string_view>

namespace cdb::manual {

struct Page {
  std::string_view name, markdown;
};

/// By name. README lists the others.
std::span<const Page> Pages();

/// The Markdown of a page; empty if there is none of this name.
inline std::string_view PageNamed(std::string_view name) {
  for (const Page& page : Pages())
    if (page.name == name) return page.markdown;
  return {};
}

}  // namespace cdb::manual
