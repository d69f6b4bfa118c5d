#include "runtime/manual/lookup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "compiler/schema/language_words.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"
#include "dsl/diagnostics.h"
#include "runtime/manual/page.h"
#include "runtime/terminal/console.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

TEST(Lookup, FindsEveryWordOfTheLanguage) {
  for (const char* word : {"sweep", "any", "let", "skip", "cases", "from", "uniform", "dbvt",
                           "tunnelled", "ring", "side", "world.side", "links", "duration"})
    EXPECT_FALSE(manual::TextAbout(word).empty()) << word;
  for (const std::string& name : manual::KnownNames())
    EXPECT_FALSE(manual::TextAbout(name).empty()) << name;
  EXPECT_TRUE(manual::TextAbout("frobnicate").empty());
}

TEST(Lookup, TellsEveryMeaningOfAWord) {
  const std::string sweep = manual::TextAbout("sweep");
  EXPECT_NE(sweep.find("sweep (function)"), std::string::npos) << sweep;
  EXPECT_NE(sweep.find("sweep (detector)"), std::string::npos) << sweep;
  const std::string uniform = manual::TextAbout("uniform");
  EXPECT_NE(uniform.find("uniform (function)"), std::string::npos);
  EXPECT_NE(uniform.find("uniform (layout)"), std::string::npos);
}

TEST(LanguageWords, HaveExamplesThatCompile) {
  for (const schema::LanguageWord& word : schema::LanguageWords()) {
    // They need another file.
    if (word.name == "use" || word.name == "empirical" || word.name == "robot") continue;
    std::string text(word.example);
    const bool is_item = text.starts_with("benchmark ") || text.starts_with("let ");
    if (text.starts_with("benchmark ") && text.find(" from ") != text.npos)
      text = "benchmark paper_experiment2 { }\n" + text;
    // A race needs repeats.
    if (!is_item) text = "benchmark b {\nrepeats 40\n" + text + "\n}";
    const compiler::Compilation result = CompileText(text + "\nbenchmark last { }\n");
    for (const dsl::Diagnostic& one : result.diagnostics.all())
      EXPECT_TRUE(one.kind->severity() == dsl::Severity::kWarning || one.kind->id == "no-runs")
          << word.name << ": " << dsl::Render(one);
  }
}

// A distribution without a row would be missing in the manual and the syntax files.
TEST(LanguageWords, HaveAllFunctionsThatThePageBeginsAnItemWith) {
  const std::string_view text = manual::PageNamed("language");
  constexpr std::string_view kItem = "\n- `";
  int functions = 0;
  for (std::size_t at = text.find(kItem); at != text.npos; at = text.find(kItem, at + 1)) {
    const std::string_view line = text.substr(at + kItem.size(), 40);
    const std::size_t end = line.find_first_not_of("abcdefghijklmnopqrstuvwxyz_");
    if (end == 0 || end == line.npos || line[end] != '(') continue;
    EXPECT_FALSE(manual::TextAbout(line.substr(0, end)).empty()) << line;
    ++functions;
  }
  EXPECT_GT(functions, 10);
}

TEST(Fitted, GoesOnBelowTheLastColumn) {
  EXPECT_EQ(terminal::Fitted("  nm  one two three\n", 14), "  nm  one two\n      three\n");
  EXPECT_EQ(terminal::Fitted("  name  one two three\n        four\n  next  5\n", 16),
            "  name  one two\n        three\n        four\n  next  5\n");
  EXPECT_EQ(terminal::Fitted("one two three\nfour five\n", 8), "one two\nthree\nfour\nfive\n");
  EXPECT_EQ(terminal::Fitted("-------------\nabcdefghij\n", 5), "-----\nabcdefghij\n");
  EXPECT_EQ(terminal::Fitted("\xC3\xA9\xC3\xA9\xC3\xA9 z\n", 5), "\xC3\xA9\xC3\xA9\xC3\xA9 z\n");
  EXPECT_EQ(terminal::Fitted("a b c\n", 0), "a b c\n");
}

}  // namespace
}  // namespace cdb::tests
