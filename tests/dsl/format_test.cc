#include "dsl/format.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "dsl/parser.h"
#include "tests/dsl/dump.h"
#include "tests/dsl/invariants.h"
#include "tests/dsl/random_text.h"

namespace cdb::tests {
namespace {

std::string Formatted(const std::string& text) { return dsl::Format(text::Source("t.cdb", text)); }

TEST(Format, TheExampleOfTheReferenceIsLaidOutAlready) {
  const std::string text = R"(# Does a long, thin shape slow the broad phase down?
benchmark aspect "Woulfe & Manzke 2009, figure 4" {
  objects {
    quantity  sweep(1000 .. 5000 step 1000)
    type      any(sphere, cuboid, cylinder, cone, bunny, armadillo)
    aspect    1 : 1 : sweep(1 .. 5)
  }
  detector    sweep(simple, sap, dbvt)
}
)";
  EXPECT_EQ(Formatted(text), text);
}

TEST(Format, SpacesAndColumns) {
  EXPECT_EQ(Formatted("benchmark b{size   - 5;mass normal( 1,sd :sweep(10,75) )#hi  \n"
                      "record timing,\ncounts\n\n\n\n"
                      "objects pebbles{quantity 5;size 10}\n"
                      "objects{ aspect y:1:1\n# trailing\n}\n"
                      "let x=-5*(-3+2)^ - 2\n"
                      "skip when not(a>3)and b==c\n"
                      "acceleration(0,-9.8,0)\n\n}"),
            R"(benchmark b {
  size    -5; mass normal(1, sd: sweep(10, 75))  #hi
  record  timing,
    counts

  objects pebbles { quantity 5; size 10 }
  objects {
    aspect      y : 1 : 1
    # trailing
  }
  let x = -5 * (-3 + 2) ^ -2
  skip when not (a > 3) and b == c
  acceleration  (0, -9.8, 0)
}
)");
}

TEST(Format, Zip) {
  EXPECT_EQ(Formatted("let a ,b=zip( sweep(1,- 2),sweep( 3 .. 4))as c\n"),
            "let a, b = zip(sweep(1, -2), sweep(3 .. 4)) as c\n");
}

TEST(Format, Conditions) {
  EXPECT_EQ(Formatted("benchmark b{only when a in(1,- 2 ,b)\nskip when a not in( c )}"),
            R"(benchmark b {
  only when a in (1, -2, b)
  skip when a not in (c)
}
)");
}

TEST(Format, ArgumentsGetTheirBrackets) {
  EXPECT_EQ(Formatted("let n = pair distance :0.5 # near\n"
                      "let m = any(hull file:\"a.obj\" 2,(ring radius:(n+1)*-2))\n"
                      "let v = at x: (1,\n2, 3)\n"),
            R"(let n = pair(distance: 0.5)  # near
let m = any(hull(file: "a.obj") 2, (ring(radius: (n + 1) * -2)))
let v = at(x: (1,
    2, 3))
)");
}

TEST(Format, UnitsAreOneWord) {
  EXPECT_EQ(Formatted("benchmark b { size 5   cm; g (0,-981,0) cm / s ^ 2\nc 3 N  s/m; t 1/60 s }"),
            "benchmark b {\n  size  5 cm; g (0, -981, 0) cm/s^2\n  c     3 N s/m; t 1 / 60 s\n}\n");
}

TEST(Format, ListsKeepTheirLines) {
  EXPECT_EQ(Formatted("let n = any(\na, # first\n\nuniform(1,\n2),\nb\n)\n"),
            R"(let n = any(
  a,  # first

  uniform(1,
    2),
  b
)
)");
}

TEST(Format, LongBlocksStandOnLinesOfTheirOwn) {
  EXPECT_EQ(Formatted("benchmark b { objects { size 5\nmass 3 } cycles 10; warmup 1 }\n"),
            R"(benchmark b {
  objects {
    size  5
    mass  3
  }
  cycles  10; warmup 1
}
)");
}

TEST(Format, BlankLinesEndAColumn) {
  EXPECT_EQ(
      Formatted("benchmark b {\n\n\nsize 1\nmass 2\n\n\nsolver.iterations 3\n# c\nseed 4\n\n}"),
      R"(benchmark b {
  size  1
  mass  2

  solver.iterations  3
  # c
  seed               4
}
)");
}

TEST(Format, EmptyAndComments) {
  EXPECT_EQ(Formatted(""), "");
  EXPECT_EQ(Formatted("\n\n"), "");
  EXPECT_EQ(Formatted("\n\n# a  \n\n\n\n# b"), "# a\n\n# b\n");
  EXPECT_EQ(Formatted("\xEF\xBB\xBFlet a=1\r\n# b\r\n"), "let a = 1\n# b\n");
}

TEST(FormatProperty, RandomTreesStayTheSame) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const RandomText::Sample sample = RandomText(seed).File();
    const auto formatted = std::make_shared<const text::Source>("t.cdb", Formatted(sample.text));
    dsl::Diagnostics diagnostics;
    const dsl::File file = dsl::Parse(formatted, diagnostics);
    ASSERT_FALSE(diagnostics.has_errors()) << "seed " << seed << "\n" << formatted->text();
    ASSERT_TRUE(Dump(file) == sample.dump) << "seed " << seed << "\n" << sample.text;
    ASSERT_TRUE(dsl::Format(*formatted) == formatted->text()) << "seed " << seed << "\n"
                                                              << sample.text;
  }
}

// Formatting keeps every comment, in order.
TEST(FormatProperty, CommentsAreKept) {
  const auto comments = [](std::string_view text) {
    std::string all;
    for (std::size_t at = text.find('#'); at != std::string_view::npos; at = text.find('#', at)) {
      const std::size_t end = text.find_first_of("\r\n", at);
      all += text.substr(at, end - at);
      all += '\n';
      at = end;
    }
    return all;
  };
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const std::string text = RandomText(seed).File().text;
    if (text.find("a # b") != std::string::npos) continue;  // a string, not a comment
    ASSERT_TRUE(comments(Formatted(text)) == comments(text)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace cdb::tests
