#include "dsl/lexer.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "dsl/diagnostics.h"

namespace cdb::tests {
using namespace dsl;

namespace {

struct Lexed {
  explicit Lexed(const std::string& text) : source("t.cdb", text) {
    list = dsl::Lex(source, diagnostics);
  }
  std::vector<std::string> Words() const {
    std::vector<std::string> words;
    for (const dsl::Token& token : list.tokens)
      words.emplace_back(token.kind == dsl::TokenKind::kNewline
                             ? "\n"
                             : source.text().substr(token.begin, token.end - token.begin));
    return words;
  }
  bool HasOnly(const dsl::DiagnosticKind& kind) const {
    for (const dsl::Diagnostic& diagnostic : diagnostics.all())
      if (diagnostic.kind != &kind) return false;
    return diagnostics.error_count() == 1;
  }
  text::Source source;
  dsl::Diagnostics diagnostics;
  dsl::TokenList list;
};

using Words = std::vector<std::string>;

TEST(Lexer, RangeIsNotPartOfANumber) {
  EXPECT_EQ(Lexed("1..5").Words(), (Words{"1", "..", "5", ""}));
  EXPECT_EQ(Lexed("1.5..2.5").Words(), (Words{"1.5", "..", "2.5", ""}));
  EXPECT_EQ(Lexed("a..b.c").Words(), (Words{"a", "..", "b.c", ""}));
}

TEST(Lexer, SignIsPartOfAnExponentOnly) {
  EXPECT_EQ(Lexed("1e-3-2").Words(), (Words{"1e-3", "-", "2", ""}));
  EXPECT_EQ(Lexed("0xE-1").Words(), (Words{"0xE", "-", "1", ""}));
  EXPECT_EQ(Lexed("1E+2+3").Words(), (Words{"1E+2", "+", "3", ""}));
}

TEST(Lexer, GoodNumbers) {
  for (const char* text : {"0", "007", "50", "9.8", "1e6", "1E6", "1e+6", "1_000_000",
                           "0xAAAAAAAAAA", "0X1f", "0xFFFF_FFFF_FFFF_FFFF", "18446744073709551615",
                           "1.7976931348623157e308", "5e-324", "0e999", "1_0.0_1e1_0"}) {
    const Lexed lexed(text);
    EXPECT_EQ(lexed.diagnostics.error_count(), 0) << text;
    EXPECT_EQ(lexed.Words(), (Words{text, ""}));
  }
}

TEST(Lexer, MalformedNumberIsOneErrorAtTheNumber) {
  for (const char* text :
       {"1__0", "1_",  "1_.5", "1._5",    "1e_5",  "0x", "0x_1", "0xG",  "0x1.8",   "1.2.3", "1e",
        "1e+",  "5ms", "3d",   "12abc34", "0b101", ".5", "5.",   "1.e5", "5\u00b5", "1e5.5"}) {
    const Lexed lexed(text);
    ASSERT_EQ(lexed.diagnostics.error_count(), 1) << text;
    EXPECT_EQ(lexed.diagnostics.all()[0].kind, &kBadNumber) << text;
    EXPECT_EQ(lexed.diagnostics.all()[0].span.begin, 0u) << text;
  }
}

TEST(Lexer, NumberThatDoesNotFit) {
  for (const char* text :
       {"18446744073709551616", "0x1_0000_0000_0000_0000", "1e309", "1e-400", "1.8e308"}) {
    EXPECT_TRUE(Lexed(text).HasOnly(kNumberRange)) << text;
  }
}

TEST(Lexer, TextsAndEscapes) {
  const Lexed lexed(R"("a \"b\" \\ \n\t" "")");
  EXPECT_EQ(lexed.diagnostics.error_count(), 0);
  ASSERT_EQ(lexed.list.tokens.size(), 3u);
  EXPECT_EQ(dsl::TextContents(lexed.Words()[0]), "a \"b\" \\ \n\t");
  EXPECT_EQ(dsl::TextContents(lexed.Words()[1]), "");
  EXPECT_TRUE(Lexed("\"\\x\"").HasOnly(kBadEscape));
  EXPECT_TRUE(Lexed("\"abc\\\"").HasOnly(kUnclosedText));
  EXPECT_TRUE(Lexed("\"abc\n\"").diagnostics.has_errors());
}

TEST(Lexer, UnclosedTextLeavesTheBraceAtTheEndOfTheLine) {
  EXPECT_EQ(Lexed("b \"abc {\n").Words(), (Words{"b", "\"abc", "{", "\n", ""}));
}

TEST(Lexer, LineEndsAreTokensWhereAStatementCanEnd) {
  EXPECT_EQ(Lexed("a\n\n\nb").Words(), (Words{"a", "\n", "b", ""}));
  EXPECT_EQ(Lexed("\n\na").Words(), (Words{"a", ""}));
  EXPECT_EQ(Lexed("(\n1,\n\n2\n)\n").Words(), (Words{"(", "1", ",", "2", ")", "\n", ""}));
  EXPECT_EQ(Lexed("a, # why\n# and\n b").Words(), (Words{"a", ",", "b", ""}));
  EXPECT_EQ(Lexed("a\r\nb # c\r\nd").Words(), (Words{"a", "\n", "b", "\n", "d", ""}));
}

TEST(Lexer, CommentsKeepTheirPlaceWithoutTrailingSpaces) {
  const Lexed lexed("a # one  \r\n#two\nb#three");
  ASSERT_EQ(lexed.list.comments.size(), 3u);
  const auto text = [&](std::size_t i) {
    const text::Span& span = lexed.list.comments[i];
    return std::string(lexed.source.text().substr(span.begin, span.end - span.begin));
  };
  EXPECT_EQ(text(0), "# one");
  EXPECT_EQ(text(1), "#two");
  EXPECT_EQ(text(2), "#three");
}

TEST(Lexer, ByteOrderMarkIsDropped) {
  const Lexed lexed("\xEF\xBB\xBFuse");
  EXPECT_EQ(lexed.Words(), (Words{"use", ""}));
  EXPECT_EQ(lexed.diagnostics.error_count(), 0);
  EXPECT_EQ(lexed.source.PositionAt(0).column, 1);
}

TEST(Lexer, EncodingIsRefusedAtTheByte) {
  const std::pair<std::string, std::uint32_t> cases[] = {
      {"ab\xFF", 2},           {"a\xC0\x80", 1},    {"\xED\xA0\x80", 0}, {"x\xE2\x82", 1},
      {"\xF4\x90\x80\x80", 0}, {"\xE0\x80\x80", 0}, {"# \x80", 2},       {"\xF0\x9F\x98", 0},
  };
  for (const auto& [text, at] : cases) {
    const Lexed lexed(text);
    EXPECT_TRUE(lexed.HasOnly(kNotUtf8)) << text;
    EXPECT_EQ(lexed.diagnostics.all()[0].span.begin, at);
    EXPECT_EQ(lexed.list.tokens.size(), 1u);
  }
  const Lexed nul(std::string("# \0x", 4));
  EXPECT_TRUE(nul.HasOnly(kNulByte));
  EXPECT_EQ(nul.diagnostics.all()[0].span.begin, 2u);
}

TEST(Lexer, ForeignOperatorsStandForOurs) {
  const Lexed lexed("a && b || !c <> d => e =< f ** g");
  EXPECT_EQ(lexed.diagnostics.error_count(), 7);
  std::vector<dsl::TokenKind> kinds;
  for (const dsl::Token& token : lexed.list.tokens)
    if (token.kind != dsl::TokenKind::kPath) kinds.push_back(token.kind);
  EXPECT_EQ(kinds, (std::vector<dsl::TokenKind>{
                       dsl::TokenKind::kAnd, dsl::TokenKind::kOr, dsl::TokenKind::kNot,
                       dsl::TokenKind::kNotEqual, dsl::TokenKind::kGreaterEqual,
                       dsl::TokenKind::kLessEqual, dsl::TokenKind::kCaret, dsl::TokenKind::kEnd}));
}

TEST(Source, PositionsCountCodePoints) {
  const text::Source source("t", "a\r\n\u00e9\u7530b\n");
  EXPECT_EQ(source.LineCount(), 3);
  EXPECT_EQ(source.Line(1), "a");
  EXPECT_EQ(source.Line(2), "\u00e9\u7530b");
  EXPECT_EQ(source.Line(3), "");
  EXPECT_EQ(source.Line(0), "");
  EXPECT_EQ(source.Line(4), "");
  const text::Position b = source.PositionAt(8);
  EXPECT_EQ(b.line, 2);
  EXPECT_EQ(b.column, 3);
  const text::Position past = source.PositionAt(1000);
  EXPECT_EQ(past.line, 3);
  EXPECT_EQ(past.column, 1);
}

TEST(Source, ColumnsOfAVeryLongLine) {
  std::string text = "x\n";
  for (int i = 0; i < 5000; ++i) text += "\u00e9";
  const text::Source source("t", text);
  for (const std::uint32_t i : {0u, 1u, 511u, 512u, 1023u, 2048u, 4999u, 5000u}) {
    const text::Position position = source.PositionAt(2 + 2 * i);
    EXPECT_EQ(position.line, 2);
    EXPECT_EQ(position.column, static_cast<int>(i) + 1);
  }
}

}  // namespace
}  // namespace cdb::tests
