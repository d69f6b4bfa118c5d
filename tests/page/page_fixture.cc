// Writes a page of a document, for tests that have no results:  page_fixture report|view <
// document.json > page.html
#include <cstdio>
#include <iostream>
#include <iterator>
#include <string>
#include <string_view>

#include "runtime/pages/page/page.h"

int main(int argc, char** argv) {
  const std::string_view name = argc > 1 ? argv[1] : "";
  if (name != "report" && name != "view") {
    std::fputs("page_fixture report|view < document.json > page.html\n", stderr);
    return 2;
  }
  const std::string json(std::istreambuf_iterator<char>(std::cin), {});
  const auto& page = name == "report" ? cdb::page::ReportTemplate() : cdb::page::ViewTemplate();
  std::cout << cdb::page::Assemble(page, "A page for <tests> & more", json);
}
