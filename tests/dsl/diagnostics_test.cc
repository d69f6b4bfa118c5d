#include "dsl/diagnostics.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "dsl/text/utf8.h"

namespace cdb::tests {
using namespace dsl;

namespace {

constexpr dsl::DiagnosticKind kError{"E0001", "some-error"};
constexpr dsl::DiagnosticKind kWarning{"W0001", "some-warning"};

TEST(Printable, LeavesNoControlsAndNoMarksOfDirection) {
  const std::string text = "a\x1b[31m\x7f\u0085\u202e\u2066\u061c\u00e9\xff\n";
  EXPECT_EQ(text::Printable(text), "a?[31m???????????\u00e9?\n");
  EXPECT_EQ(text::PrintableJson("\"a\\u001b\x7f\u0085\u202e\u2066\u061c\u00e9\"\n"),
            "\"a\\u001b\\u007f\\u0085\\u202e\\u2066\\u061c\u00e9\"\n");
}

TEST(DidYouMean, SlipsOfTheHand) {
  const std::vector<std::string_view> types{"sphere", "cuboid", "cylinder", "cone", "bunny"};
  EXPECT_EQ(dsl::DidYouMean("cuboyd", types), "cuboid");
  EXPECT_EQ(dsl::DidYouMean("cuobid", types), "cuboid");
  EXPECT_EQ(dsl::DidYouMean("Sphere", types), "sphere");
  EXPECT_EQ(dsl::DidYouMean("sphre", types), "sphere");
  EXPECT_EQ(dsl::DidYouMean("cylindr", types), "cylinder");
  EXPECT_EQ(dsl::DidYouMean("con", types), "cone");
  EXPECT_EQ(dsl::DidYouMean("linearvelocity", {"linear_velocity"}), "linear_velocity");
}

TEST(DidYouMean, SaysNothingWhereNothingIsNear) {
  EXPECT_EQ(dsl::DidYouMean("torus", {"sphere", "cone"}), "");
  EXPECT_EQ(dsl::DidYouMean("x", {"y", "xy"}), "");
  EXPECT_EQ(dsl::DidYouMean("ab", {"cd"}), "");
  EXPECT_EQ(dsl::DidYouMean("", {"a"}), "");
  EXPECT_EQ(dsl::DidYouMean("cone", {"cone"}), "");
  EXPECT_EQ(dsl::DidYouMean(std::string(1000, 'a'), {"a"}), "");
  EXPECT_EQ(dsl::DidYouMean("a", {}), "");
}

TEST(DidYouMean, TakesTheNearest) {
  EXPECT_EQ(dsl::DidYouMean("quantitty", {"quality", "quantity"}), "quantity");
}

TEST(Diagnostics, TheSameIsKeptOnce) {
  const text::Source source("t", "abc");
  dsl::Diagnostics diagnostics;
  diagnostics.Report(kError, {&source, 0, 1}, "wrong");
  diagnostics.Report(kError, {&source, 0, 1}, "wrong");
  diagnostics.Report(kError, {&source, 1, 2}, "wrong");
  diagnostics.Report(kWarning, {&source, 1, 2}, "doubtful");
  EXPECT_EQ(diagnostics.error_count(), 2);
  EXPECT_EQ(diagnostics.warning_count(), 1);
  EXPECT_TRUE(diagnostics.has_errors());
  EXPECT_EQ(diagnostics.all().size(), 3u);
}

TEST(Diagnostics, ErrorsDoNotOverlap) {
  const text::Source source("t", "abcdefgh"), other("u", "abcdefgh");
  dsl::Diagnostics diagnostics;
  diagnostics.Report(kError, {&source, 2, 4}, "first");
  diagnostics.Report(kError, {&source, 3, 5}, "touches its end");
  diagnostics.Report(kError, {&source, 0, 8}, "holds it");
  diagnostics.Report(kError, {&source, 2, 2}, "at its begin");
  diagnostics.Report(kError, {&source, 1, 3}, "touches its begin");
  EXPECT_EQ(diagnostics.error_count(), 1);
  diagnostics.Report(kError, {&source, 4, 4}, "behind it");
  diagnostics.Report(kError, {&source, 0, 2}, "before it");
  diagnostics.Report(kError, {&other, 2, 4}, "elsewhere");
  diagnostics.Report(kError, {}, "nowhere");
  diagnostics.Report(kError, {}, "nowhere either");
  diagnostics.Report(kWarning, {&source, 2, 4}, "a warning");
  EXPECT_EQ(diagnostics.error_count(), 6);
  EXPECT_EQ(diagnostics.warning_count(), 1);
}

TEST(Render, AsTheHeaderShows) {
  const text::Source source("examples/first.cdb", "a\nb\nc\n  type      cuboyd\n");
  dsl::Diagnostics diagnostics;
  diagnostics.Report(kError, {&source, 18, 24}, "no object type is called 'cuboyd'",
                     "did you mean 'cuboid'?", {{{&source, 2, 3}, "it was set here before"}});
  EXPECT_EQ(dsl::Render(diagnostics),
            "examples/first.cdb:4:13: error: no object type is called 'cuboyd' [E0001 some-error]\n"
            "  4 |   type      cuboyd\n"
            "    |             ^^^^^^ did you mean 'cuboid'?\n"
            "examples/first.cdb:2:1: note: it was set here before\n"
            "  2 | b\n"
            "    | ^\n");
}

TEST(Render, ByFileAndPlace) {
  const text::Source one("one", "abc\ndef\n"), two("two", "abc\n");
  dsl::Diagnostics diagnostics;
  diagnostics.Report(kError, {&one, 4, 5}, "third");
  diagnostics.Report(kError, {&two, 0, 1}, "fourth");
  diagnostics.Report(kWarning, {&one, 0, 1}, "second");
  diagnostics.Report(kError, {}, "first", "and help");
  EXPECT_EQ(dsl::Render(diagnostics),
            "error: first [E0001 some-error]\n"
            "  and help\n"
            "one:1:1: warning: second [W0001 some-warning]\n"
            "  1 | abc\n"
            "    | ^\n"
            "one:2:1: error: third [E0001 some-error]\n"
            "  2 | def\n"
            "    | ^\n"
            "two:1:1: error: fourth [E0001 some-error]\n"
            "  1 | abc\n"
            "    | ^\n");
  EXPECT_EQ(dsl::Render(dsl::Diagnostics()), "");
}

std::string RenderOne(const text::Source& source, std::uint32_t begin, std::uint32_t end) {
  dsl::Diagnostics diagnostics;
  diagnostics.Report(kError, {&source, begin, end}, "m");
  const std::string text = dsl::Render(diagnostics);
  return text.substr(text.find('\n') + 1);
}

TEST(Render, SeveralLinesShowTheFirst) {
  const text::Source source("t", "ab {  \n  c\n}\n");
  EXPECT_EQ(RenderOne(source, 3, 12), "  1 | ab {  \n    |    ^\n");
}

TEST(Render, TabsStayInStepAndPlacesPastTheEndAreShown) {
  const text::Source source("t", "\ta\tb");
  EXPECT_EQ(RenderOne(source, 3, 4), "  1 | \ta\tb\n    | \t \t^\n");
  EXPECT_EQ(RenderOne(source, 4, 4), "  1 | \ta\tb\n    | \t \t ^\n");
  EXPECT_EQ(RenderOne(source, 100, 100), "  1 | \ta\tb\n    | \t \t ^\n");
}

TEST(Render, WideAndCombiningCharacters) {
  const text::Source source("t", "\u7530e\u0301x");
  EXPECT_EQ(RenderOne(source, 6, 7), "  1 | \u7530e\u0301x\n    |    ^\n");
  EXPECT_EQ(RenderOne(source, 0, 3), "  1 | \u7530e\u0301x\n    | ^^\n");
}

TEST(Render, NothingReachesTheTerminalThatItWouldObey) {
  const text::Source source("t\x1b[2J", "a\x1b[31m\u202eb\x07");
  dsl::Diagnostics diagnostics;
  diagnostics.Report(kError, {&source, 0, 1}, "m \x1b", "h \x1b");
  EXPECT_EQ(dsl::Render(diagnostics).find('\x1b'), std::string::npos);
  EXPECT_EQ(dsl::Render(diagnostics).find("\u202e"), std::string::npos);
  EXPECT_NE(dsl::Render(diagnostics, {.color = true}).find("\x1b["), std::string::npos);
}

TEST(Render, SaysHowManyMoreThereAre) {
  const text::Source source("t", "abcd");
  dsl::Diagnostics diagnostics;
  for (std::uint32_t i = 0; i < 4; ++i) diagnostics.Report(kError, {&source, i, i + 1}, "wrong");
  const std::string all = dsl::Render(diagnostics);
  EXPECT_EQ(dsl::Render(diagnostics, {.color = false, .most = 4}), all);
  const std::string two = dsl::Render(diagnostics, {.color = false, .most = 2});
  EXPECT_EQ(two, all.substr(0, all.find("t:1:3:")) + "… and 2 more errors\n");
  EXPECT_TRUE(
      dsl::Render(diagnostics, {.color = false, .most = 3}).ends_with("… and 1 more error\n"));
}

TEST(Render, LongLinesAreCutAroundTheFault) {
  const text::Source source("t", std::string(500, 'a') + "XYZ" + std::string(500, 'b'));
  const std::string text = RenderOne(source, 500, 503);
  const std::string line = text.substr(0, text.find('\n'));
  EXPECT_LT(line.size(), 120u);
  EXPECT_TRUE(line.starts_with("  1 | …")) << line;
  EXPECT_TRUE(line.ends_with("…")) << line;
  // The carets are under the fault: the ellipsis is three bytes, but one column.
  const std::string carets = text.substr(text.find('\n') + 1);
  EXPECT_EQ(carets.find('^') + 2, line.find("XYZ"));
  EXPECT_NE(carets.find("^^^\n"), std::string::npos);
}

TEST(Render, AVeryWideFaultIsCutToo) {
  const text::Source source("t", std::string(5000, 'a'));
  EXPECT_LT(RenderOne(source, 0, 5000).size(), 250u);
  EXPECT_LT(RenderOne(source, 2000, 5000).size(), 250u);
}

}  // namespace
}  // namespace cdb::tests
