#include "runtime/manual/markdown.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "runtime/manual/page.h"

namespace cdb::tests {
namespace {

std::string PartOf(std::string_view name) { return name == "table" ? "  a table\n" : ""; }

std::string Body(std::string_view markdown, std::size_t width = 40) {
  return manual::BodyText(markdown, width, PartOf);
}

TEST(Markdown, HeadingsAreInCapitalsButNotTheirCode) {
  EXPECT_EQ(manual::PageText("# The `.cdb` language\n\n## Two: `cdb show`\n\n### Three\n\nText.\n",
                             40, PartOf),
            "THE .cdb LANGUAGE\n\nTWO: cdb show\n\nThree\n\nText.\n");
}

TEST(Markdown, ParagraphsAreWrapped) {
  EXPECT_EQ(Body("one *two*\nthree \\* **four** five\n\nsix `a * b`\n", 20),
            "one two three * four\nfive\n\nsix `a * b`\n");
}

TEST(Markdown, LinksKeepTheirTextAndTheAddressOfOtherSites) {
  EXPECT_EQ(Body("[`cdb doc omit`](omit.md), [Bullet](https://b.org)\n", 60),
            "`cdb doc omit`, Bullet (https://b.org)\n");
}

TEST(Markdown, ItemsThatBeginWithCodeHaveTwoColumns) {
  EXPECT_EQ(Body("- `any(x, y)`: one of\n  the values\n- `pi`, `e`: [numbers](a.md)\n", 24),
            "  any(x, y)\n            one of the\n            values\n  pi, e     numbers\n");
  EXPECT_EQ(Body("- `cdb run FILE [--jobs N]`: runs\n- `cdb fmt FILE [--check]`: formats\n"),
            "  cdb run FILE [--jobs N]\n      runs\n\n  cdb fmt FILE [--check]\n      formats\n");
  EXPECT_EQ(Body("- `on`: a switch\n- `a: b`, ...: more `c: d`\n- `x` is not a term: text\n"),
            "  on         a switch\n  a: b, ...  more `c: d`\n  - `x` is not a term: text\n");
  EXPECT_EQ(Body("- one two three four five six seven eight\n- nine\n", 20),
            "  - one two three\n    four five six\n    seven eight\n  - nine\n");
}

TEST(Markdown, CodeKeepsItsLines) {
  EXPECT_EQ(Body("```sh\n# not a heading\n\n  a  |  b\n```\n"),
            "  # not a heading\n\n    a  |  b\n");
}

TEST(Markdown, TablesHaveAlignedColumns) {
  EXPECT_EQ(Body("| name | n |\n| --- | ---: |\n| `a\\|b` | 1 |\n| c | 20 |\n"),
            "  name   n\n  --------\n  a|b    1\n  c     20\n");
}

TEST(Markdown, AMarkIsReplacedByItsPart) {
  EXPECT_EQ(Body("The table is\nin a file. <!-- table -->\n\nText.\n"), "  a table\n\nText.\n");
  EXPECT_EQ(Body("No table. <!-- tabel -->\n"), "No table. <!-- tabel -->\n");
}

TEST(Pages, HaveATitle) {
  EXPECT_GT(manual::Pages().size(), 20u);
  for (const manual::Page& page : manual::Pages())
    EXPECT_TRUE(page.markdown.starts_with("# ")) << page.name;
  EXPECT_TRUE(manual::PageNamed("frobnicate").empty());
}

}  // namespace
}  // namespace cdb::tests
