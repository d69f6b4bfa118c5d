#include "dsl/parser.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "dsl/diagnostics.h"
#include "tests/dsl/dump.h"
#include "tests/dsl/invariants.h"
#include "tests/dsl/random_text.h"

namespace cdb::tests {
using namespace dsl;

namespace {

struct Parsed {
  explicit Parsed(std::string text)
      : source(std::make_shared<const text::Source>("t.cdb", std::move(text))),
        file(dsl::Parse(source, diagnostics)) {}
  std::shared_ptr<const text::Source> source;
  dsl::Diagnostics diagnostics;
  dsl::File file;
};

// The dump of a text that must parse.
std::string Tree(const std::string& text) {
  const Parsed parsed(text);
  EXPECT_FALSE(parsed.diagnostics.has_errors()) << dsl::Render(parsed.diagnostics);
  return Dump(parsed.file);
}

// The dump of one value.
std::string Value(const std::string& text) {
  const std::string tree = Tree("let v = " + text + "\n");
  EXPECT_TRUE(tree.starts_with("let v ")) << tree;
  return tree.substr(6, tree.size() - 7);
}

std::string When(const std::string& text) {
  const std::string tree = Tree("benchmark b { skip when " + text + " }");
  const std::string head = "benchmark b\n  skip ";
  EXPECT_TRUE(tree.starts_with(head)) << tree;
  return tree.substr(head.size(), tree.size() - head.size() - 1);
}

// The ids of all errors, in order.
std::string Errors(const std::string& text) {
  std::string ids;
  const Parsed parsed(text);
  for (const dsl::Diagnostic& diagnostic : parsed.diagnostics.all()) {
    if (!ids.empty()) ids += ' ';
    ids += diagnostic.kind->id;
  }
  return ids;
}

TEST(Parser, TheExampleOfTheReference) {
  EXPECT_EQ(Tree(R"(# Does a long, thin shape slow the broad phase down?
benchmark aspect "Woulfe & Manzke 2009, figure 4" {
  objects {
    quantity  sweep(1000 .. 5000 step 1000)
    type      any(sphere, cuboid, cylinder, cone, bunny, armadillo)
    aspect    1 : 1 : sweep(1 .. 5)
  }
  detector    sweep(simple, sap, dbvt)
}
)"),
            R"(benchmark aspect "Woulfe & Manzke 2009, figure 4"
  group objects
    set quantity (call sweep (range-step 1000 5000 1000))
    set type (call any sphere cuboid cylinder cone bunny armadillo)
    set aspect (ratio 1 1 (call sweep (range 1 5)))
  set detector (call sweep simple sap dbvt)
)");
}

TEST(Parser, EveryStatement) {
  EXPECT_EQ(Tree(R"(use "base.cdb"
use detector "mine.so"
let n = sweep(10, 100)
benchmark b { }
benchmark c from b "title" {
  let m = 2 * n
  objects pebbles { quantity n; size 5 }
  world.side 20 * n
  accuracy { reference { timestep 1/3840; precision double } metrics position, energy }
  cases load { calm "still" { } storm { objects.size 3 } }
  cases { a { } }
  skip when n > 3
  record timing, counts,
         poses
  acceleration (0, -9.8, 0)
}
)"),
            R"(use "base.cdb"
use detector "mine.so"
let n (call sweep 10 100)
benchmark b
benchmark c from b "title"
  let m (* 2 n)
  group objects pebbles
    set quantity n
    set size 5
  set world.side (* 20 n)
  group accuracy
    group reference
      set timestep (/ 1 3840)
      set precision double
    set metrics position energy
  cases load
    case calm "still"
    case storm
      set objects.size 3
  cases
    case a
  skip (> n 3)
  set record timing counts poses
  set acceleration (vector 0 (neg 9.8) 0)
)");
}

TEST(Parser, EmptyFilesAndStatements) {
  EXPECT_EQ(Tree(""), "");
  EXPECT_EQ(Tree("# nothing\n"), "");
  EXPECT_EQ(Tree("\n;;\r\n; let a = 1;;\n;"), "let a 1\n");
  EXPECT_EQ(Tree("benchmark b {;;}"), "benchmark b\n");
}

TEST(Parser, Precedence) {
  EXPECT_EQ(Value("1 + 2 * 3"), "(+ 1 (* 2 3))");
  EXPECT_EQ(Value("(1 + 2) * 3"), "(* (+ 1 2) 3)");
  EXPECT_EQ(Value("1 - 2 - 3"), "(- (- 1 2) 3)");
  EXPECT_EQ(Value("8 / 4 * 2"), "(* (/ 8 4) 2)");
  EXPECT_EQ(Value("2 ^ 3 ^ 4"), "(^ 2 (^ 3 4))");
  EXPECT_EQ(Value("2 * 3 ^ 4"), "(* 2 (^ 3 4))");
  EXPECT_EQ(Value("-2 ^ 2"), "(^ (neg 2) 2)");  // by the grammar: power = unary ^ power
  EXPECT_EQ(Value("2 ^ -1"), "(^ 2 (neg 1))");
  EXPECT_EQ(Value("a--b"), "(- a (neg b))");
  EXPECT_EQ(Value("-(-5)"), "(neg (neg 5))");
}

TEST(Parser, RangesAndRatios) {
  EXPECT_EQ(Value("1..5"), "(range 1 5)");
  EXPECT_EQ(Value("a .. b step -2"), "(range-step a b (neg 2))");
  EXPECT_EQ(Value("1 .. 2 * n count k + 1 log"), "(range-count-log 1 (* 2 n) (+ k 1))");
  EXPECT_EQ(Value("1 .. 2 sobol 8"), "(range-sobol 1 2 8)");
  EXPECT_EQ(Value("1 .. 2 latin 8 log"), "(range-latin-log 1 2 8)");
  EXPECT_EQ(Value("1 .. 5 count 3"), "(range-count 1 5 3)");
  EXPECT_EQ(Value("step .. count step log"), "(range-step step count log)");
  EXPECT_EQ(Value("1:y:z"), "(ratio 1 y z)");
  EXPECT_EQ(Value("1 : 1 : sweep(1 .. 5) as z"), "(ratio 1 1 (call sweep (range 1 5) as z))");
}

TEST(Parser, Searches) {
  EXPECT_EQ(Value("find(1 .. 9 log, until: verdict != stable)"),
            "(call find (range-log 1 9) until (!= verdict stable))");
  EXPECT_EQ(Value("find(1 .. 9, until: p99(step) > 4 ms, tolerance: 5 %) as n"),
            "(call find (range 1 9) tolerance:(unit 5 %) until (> (call p99 step) (unit 4 "
            "ms)) as n)");
  // Elsewhere `until` is a name like any other.
  EXPECT_EQ(Value("gap(until: 3)"), "(call gap until:3)");
  EXPECT_EQ(Value("2 * find(1, 2, until: (a == b or c < d))"),
            "(* 2 (call find 1 2 until (or (== a b) (< c d))))");
}

TEST(Parser, Arguments) {
  EXPECT_EQ(Value("f()"), "(call f)");
  EXPECT_EQ(Value("normal(1, sd: 3)"), "(call normal 1 sd:3)");
  EXPECT_EQ(Value("sweep(y : 1 : 1)"), "(call sweep (ratio y 1 1))");
  EXPECT_EQ(Value("f(y : 1 : 1 : 2)"), "(call f y:(ratio 1 1 2))");
  EXPECT_EQ(Value("f(y: 1 .. 5 step 2)"), "(call f y:(range-step 1 5 2))");
  EXPECT_EQ(Value("f(y: \"t\", \"u\")"), "(call f y:\"t\" \"u\")");
  EXPECT_EQ(Value("f(y + 1 : 1 : 1)"), "(call f (ratio (+ y 1) 1 1))");
  EXPECT_EQ(Value("any(sphere 3, cone 1.5)"), "(call any (weigh sphere 3) (weigh cone 1.5))");
  EXPECT_EQ(Value("any(t: sphere 3)"), "(call any t:(weigh sphere 3))");
  EXPECT_EQ(Value("any(\n  a,  # first\n\n  b\n)"), "(call any a b)");
  EXPECT_EQ(Value("uniform((1, 2, 3), (4, 5, 6))"), "(call uniform (vector 1 2 3) (vector 4 5 6))");
}

TEST(Parser, CallsWithoutBrackets) {
  EXPECT_EQ(Value("at (0, 5, 0)"), "(call at 0 5 0)");
  EXPECT_EQ(Value("pair distance: 0.5"), "(call pair distance:0.5)");
  EXPECT_EQ(Value("ring radius: let_name * 2"), "(call ring radius:(* let_name 2))");
  EXPECT_EQ(Value("hull file: \"a.obj\""), "(call hull file:\"a.obj\")");
  EXPECT_EQ(Value("ring radius: sweep(1, 2) as r"), "(call ring radius:(call sweep 1 2 as r))");
  EXPECT_EQ(Value("sweep(grid, ring radius: 1, pair distance: 2)"),
            "(call sweep grid (call ring radius:1) (call pair distance:2))");
  EXPECT_EQ(Value("any(hull file: \"a.obj\" 3, mesh(\"b.obj\") 2, sphere 3)"),
            "(call any (weigh (call hull file:\"a.obj\") 3) (weigh (call mesh \"b.obj\") 2) "
            "(weigh sphere 3))");
  // Weights of plain words and ordinary calls are parsed as before.
  EXPECT_EQ(Value("any(sphere 3)"), "(call any (weigh sphere 3))");
  EXPECT_EQ(Value("1 : y : z"), "(ratio 1 y z)");
  EXPECT_EQ(Value("f(y : 1 : 1)"), "(call f (ratio y 1 1))");
}

TEST(Parser, SlipsInCallsWithoutBrackets) {
  EXPECT_EQ(Errors("benchmark b { location stack height: 5, gap: 1 }"), "missing-brackets");
  EXPECT_EQ(Errors("benchmark b { location stack height: n gap: 1 }"), "missing-brackets");
  EXPECT_EQ(Errors("benchmark b { location pair distance: }"), "missing-value");
  EXPECT_EQ(Errors("benchmark b { location ring radius 3 }"), "missing-semicolon");
  EXPECT_EQ(Errors("benchmark b { location at 0, 5, 0 }"), "missing-comma");
  EXPECT_EQ(Errors("benchmark b { location ring radius: 1 : 2 }"), "ratio-parts");
  EXPECT_EQ(Errors("benchmark b { location let radius: 3; mass a.b c: 3 }"),
            "reserved-word bad-name");
}

TEST(Parser, Conditions) {
  EXPECT_EQ(When("quantity > 3000 and detector == simple"),
            "(and (> quantity 3000) (== detector simple))");
  EXPECT_EQ(When("a == 1 or b == 2 and c == 3"), "(or (== a 1) (and (== b 2) (== c 3)))");
  EXPECT_EQ(When("(a == 1 or b == 2) and c == 3"), "(and (or (== a 1) (== b 2)) (== c 3))");
  EXPECT_EQ(When("a == 1 and b == 2 and c == 3"), "(and (and (== a 1) (== b 2)) (== c 3))");
  EXPECT_EQ(When("(a + 1) * 2 <= (b)"), "(<= (* (+ a 1) 2) b)");
  EXPECT_EQ(When("((a + 1) * 2 != b)"), "(!= (* (+ a 1) 2) b)");
  EXPECT_EQ(When("not (a == 1) "), "(not (== a 1))");
  EXPECT_EQ(When("a < 1 and not b >= 2"), "(and (< a 1) (not (>= b 2)))");
  // The grammar: "not" condition.
  EXPECT_EQ(When("not a == 1 and b == 2"), "(not (and (== a 1) (== b 2)))");
}

TEST(Parser, ListsInConditions) {
  EXPECT_EQ(When("a in (1, b + 1) and c == 2"), "(and (in a 1 (+ b 1)) (== c 2))");
  EXPECT_EQ(When("(a in (1) or b == 2) and c not in (x, y)"),
            "(and (or (in a 1) (== b 2)) (not (in c x y)))");
  EXPECT_EQ(When("(a + 1) in (2)"), "(in (+ a 1) 2)");
  EXPECT_EQ(Errors("benchmark b { skip when a in }"), "missing-value");
  EXPECT_EQ(Errors("benchmark b { skip when a in 1, 2 }"), "missing-value");
  EXPECT_EQ(Errors("benchmark b { skip when a in () }"), "missing-value");
  EXPECT_EQ(Errors("benchmark b { skip when a in [1, 2] }"), "square-bracket");
  EXPECT_EQ(Errors("benchmark b { skip when a in (1 2) }"), "missing-comma");
}

TEST(Parser, ZipGivesSeveralLets) {
  EXPECT_EQ(Tree("let a, b = zip(sweep(1, 2), sweep(x)) as c\n"),
            "let a (call sweep 1 2 zipped as c)\nlet b (call sweep x zipped as c)\n");
  EXPECT_EQ(Errors("let a, b = zip(sweep(1, 2))"), "one-value");
  EXPECT_EQ(Errors("let a, b = sweep(1, 2)"), "one-value");
  EXPECT_EQ(Errors("let a, b = zip(1, 2)"), "one-value");
  EXPECT_EQ(Errors("let a, b = zip(sweep(1), sweep(2) as c)"), "one-value");
  EXPECT_EQ(Errors("let a, b = "), "missing-value");
  // It is one statement, whether it is valid or not.
  EXPECT_EQ(
      Tree("benchmark b { let a, b = zip(sweep(1), sweep(2)); size a }"),
      "benchmark b\n  let a (call sweep 1 zipped)\n  let b (call sweep 2 zipped)\n  set size a\n");
}

TEST(Parser, OnlyIsTheOppositeOfSkip) {
  EXPECT_EQ(Tree("benchmark b { only when a > 1 }"), "benchmark b\n  only (> a 1)\n");
  EXPECT_EQ(Errors("benchmark b { only if a > 1 }"), "missing-when");
  EXPECT_EQ(Errors("benchmark b { only }"), "missing-when");
  // `only` is a keyword of statements, and can be used as a name.
  EXPECT_EQ(Errors("let only = 1\nbenchmark b { size only }"), "");
}

TEST(Parser, RequirementsAreComparisons) {
  EXPECT_EQ(Tree("benchmark b { require p99(step) < 4 ms and verdict == stable }"),
            "benchmark b\n  require (and (< (call p99 step) (unit 4 ms)) (== verdict stable))\n");
  EXPECT_EQ(Errors("benchmark b { require }"), "missing-comparison");
  EXPECT_EQ(Errors("benchmark b { require p99(step) }"), "missing-comparison");
  EXPECT_EQ(Errors("let require = 1\nbenchmark b { size require }"), "");
}

TEST(Parser, SpansHoldWhatWasWritten) {
  const Parsed parsed("let v = ( a + f(1) as z ) * 2 # c\n");
  ASSERT_FALSE(parsed.diagnostics.has_errors());
  const auto& let = std::get<dsl::Let>(parsed.file.items[0]);
  const auto text = [&](const text::Span& span) {
    return std::string(parsed.source->text().substr(span.begin, span.end - span.begin));
  };
  EXPECT_EQ(text(let.value->span), "( a + f(1) as z ) * 2");
  EXPECT_EQ(text(let.value->items[0]->span), "( a + f(1) as z )");
  EXPECT_EQ(text(let.value->items[0]->items[1]->span), "f(1) as z");
  EXPECT_EQ(text(let.value->items[0]->items[1]->axis->span), "z");

  const Parsed bare("let v = pair distance: (a + 1) # c\n");
  const dsl::Expr& call = *std::get<dsl::Let>(bare.file.items[0]).value;
  const auto bare_text = [&](const text::Span& span) {
    return std::string(bare.source->text().substr(span.begin, span.end - span.begin));
  };
  EXPECT_EQ(bare_text(call.span), "pair distance: (a + 1)");
  EXPECT_EQ(bare_text(call.arguments[0].name->span), "distance");
  EXPECT_EQ(bare_text(call.arguments[0].value->span), "(a + 1)");
}

TEST(Parser, EveryErrorIsReportedAndNoneTwice) {
  EXPECT_EQ(Errors("benchmark b { size = 5; mass (1; type any(a b); aspect 1:2 }"),
            "equals-in-setting unclosed-bracket missing-comma ratio-parts");
  EXPECT_EQ(Errors("let a = 1 +\nlet b = * 2\nlet c = )\nlet d 4\n"),
            "missing-value missing-value missing-value missing-equals");
  EXPECT_EQ(Errors("benchmark b { f(, 1__0, 2 3 4, (1, 2), x y) }"),
            "bad-number missing-value missing-comma vector-parts");
}

TEST(Parser, NoErrorMakesAnother) {
  EXPECT_EQ(Errors("benchmark b {\n  size @ 5 { = 3 }\n  mass 1\n}\n"),
            "unknown-character "
            "unexpected-token");
  EXPECT_EQ(Errors("benchmark b { type \"abc }\nbenchmark c { }"), "unclosed-text");
  EXPECT_EQ(Errors("benchmark b {\n objects {\n size 5\n\nbenchmark c { }\n"), "unclosed-block");
  EXPECT_EQ(Errors("size 5\nmass 3\ntype x\n"), "misplaced-statement");
  EXPECT_EQ(Errors("benchmark b { size 50 mass 3 cycles 10 }"),
            "missing-semicolon missing-semicolon");
}

TEST(Parser, UnclosedBlockPointsAtItsBrace) {
  const Parsed parsed("benchmark a {\n  objects {\n    size 5\n}\n");
  ASSERT_EQ(parsed.diagnostics.error_count(), 1);
  const dsl::Diagnostic& diagnostic = parsed.diagnostics.all()[0];
  EXPECT_EQ(diagnostic.kind, &kUnclosedBlock);
  // The indentation determines which of the two braces is unclosed.
  EXPECT_EQ(parsed.source->PositionAt(diagnostic.span.begin).line, 2);
  ASSERT_EQ(diagnostic.notes.size(), 1u);
  EXPECT_EQ(diagnostic.notes[0].span.begin, parsed.source->text().size());
}

std::string Repeat(const std::string& what, int times) {
  std::string text;
  for (int i = 0; i < times; ++i) text += what;
  return text;
}

// Every kind of nesting, far beyond the limit: one error, and no stack overflow.
TEST(Parser, DepthIsBounded) {
  constexpr int kMany = 100000;
  const std::string texts[] = {
      "let v = " + Repeat("(", kMany) + "1" + Repeat(")", kMany),
      "let v = " + Repeat("f(", kMany) + "1" + Repeat(")", kMany),
      "let v = " + Repeat("f(a: ", kMany) + "1" + Repeat(")", kMany),
      "let v = " + Repeat("(1, 1, ", kMany) + "1" + Repeat(")", kMany),
      "let v = " + Repeat("-(", kMany) + "1" + Repeat(")", kMany),
      "let v = 1" + Repeat(" + 1", kMany),
      "let v = 1" + Repeat(" - 1", kMany),
      "let v = 1" + Repeat(" * 1", kMany),
      "let v = 1" + Repeat(" ^ 1", kMany),
      "let v = 1" + Repeat(" ^ -1", kMany),
      "benchmark b { " + Repeat("a { ", kMany) + Repeat("} ", kMany) + "}",
      "benchmark b { " + Repeat("cases { a { ", kMany) + Repeat("} } ", kMany) + "}",
      "benchmark b { skip when a == 1" + Repeat(" and a == 1", kMany) + " }",
      "benchmark b { skip when a == 1" + Repeat(" or a == 1", kMany) + " }",
      "benchmark b { skip when " + Repeat("not ", kMany) + "a == 1 }",
      "benchmark b { skip when " + Repeat("(", kMany) + "a == 1" + Repeat(")", kMany) + " }",
  };
  for (const std::string& text : texts) EXPECT_EQ(Errors(text), "too-deep") << text.substr(0, 60);
}

TEST(Parser, UnclosedNestingIsBoundedToo) {
  constexpr int kMany = 100000;
  for (const std::string open :
       {"(", "[", "f(", "{", "a {", "benchmark b {", "cases {", "-", "not ", "a 1 b", "skip when (",
        "= ", "} ", "\"x\" ", "let a = ("}) {
    for (const std::string head : {"", "let v = ", "benchmark b { ", "benchmark b { skip when "})
      EXPECT_EQ(BrokenInvariant(head + Repeat(open, kMany / 10)), "") << head << open;
  }
}

TEST(Parser, LimitItself) {
  const auto sum = [](int terms) { return "let v = 1" + Repeat(" + 1", terms - 1); };
  EXPECT_EQ(Errors(sum(dsl::kMaxDepth)), "");
  EXPECT_EQ(Errors(sum(dsl::kMaxDepth + 1)), "too-deep");
  const auto blocks = [](int count) {
    return "benchmark b {" + Repeat("a {", count - 1) + Repeat("}", count);
  };
  EXPECT_EQ(Errors(blocks(dsl::kMaxDepth)), "");
  EXPECT_EQ(Errors(blocks(dsl::kMaxDepth + 1)), "too-deep");
}

TEST(ParserProperty, RandomTreesAreReadBack) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const RandomText::Sample sample = RandomText(seed).File();
    const Parsed parsed(sample.text);
    ASSERT_FALSE(parsed.diagnostics.has_errors()) << "seed " << seed << "\n"
                                                  << sample.text << dsl::Render(parsed.diagnostics);
    ASSERT_TRUE(Dump(parsed.file) == sample.dump) << "seed " << seed << "\n" << sample.text;
  }
}

TEST(ParserProperty, TokenSoup) {
  for (std::uint64_t seed = 0; seed < 10000; ++seed) {
    const std::string text = RandomText(seed).Soup();
    ASSERT_EQ(BrokenInvariant(text), "") << "seed " << seed << "\n" << text;
  }
}

TEST(ParserProperty, MutatedFiles) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    RandomText random(seed);
    const std::string text = random.Mutate(random.File().text);
    ASSERT_EQ(BrokenInvariant(text), "") << "seed " << seed << "\n" << text;
  }
}

// Every prefix of a file that has everything in it: the texts that an editor sees during typing.
TEST(ParserProperty, Prefixes) {
  const std::string text = RandomText(7).File().text + R"(
benchmark b from a "t" { objects p { size normal(1, sd: 2), 1 : 2 : 3 }; skip when not (a == 1)
cases c { d { e sweep(1 .. 5 count 3 log) as f } } g (1, -2, 3 ^ 4) })";
  for (std::size_t length = 0; length <= text.size(); ++length)
    ASSERT_EQ(BrokenInvariant(text.substr(0, length)), "") << text.substr(0, length);
}

}  // namespace
}  // namespace cdb::tests
