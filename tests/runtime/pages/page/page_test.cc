#include "runtime/pages/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace cdb::tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Page, HoldsTheDocumentAndLetsNoTextOutOfItsElement) {
  const page::Template page{"<title>", "</title><script>", "</script>"};
  EXPECT_EQ(page::Assemble(page, "a < b & c", R"({"title": "</script><script>alert(1)<!--"})"),
            "<title>a &lt; b &amp; c</title><script>"
            R"({"title": "\u003c/script>\u003cscript>alert(1)\u003c!--"})"
            "</script>");
}

TEST(Page, SaysWhatIsMissingInABuildWithoutPages) {
  try {
    page::Assemble({}, "title", "{}");
    FAIL();
  } catch (const page::PageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("built without pages"));
  }
}

TEST(Page, LoadsNothingAndNamesItsLicences) {
  for (const page::Template* page :
       {&page::ReportTemplate(), &page::ViewTemplate(), &page::EditTemplate()}) {
    if (page->before_title.empty()) GTEST_SKIP() << "built without npm";
    const std::string text = page::Assemble(*page, "title", "{}");
    EXPECT_THAT(text, HasSubstr("default-src 'none'; script-src 'sha256-"));
    EXPECT_THAT(text, HasSubstr("Licences of the libraries in this page"));
    for (const char* loads : {"<script src", "<link", "@import"})
      EXPECT_THAT(text, Not(HasSubstr(loads)));
  }
}

}  // namespace
}  // namespace cdb::tests
