// Explanations of the kinds in dsl/diagnostics.h.
#include "dsl/diagnostics.h"
#include "runtime/manual/explanation.h"

namespace cdb::manual {
namespace {

using namespace std::string_view_literals;  // an example may contain a NUL byte

/// One level of brackets more than the parser accepts.
constexpr std::string_view kDeep =
    "let n = "
    "(((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((("
    "((((("
    "((((((((((1))))))))))"
    "))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))"
    "))))))"
    "\nbenchmark b { cycles n }\n";

constexpr Explanation kSyntaxRows[] = {
    {&dsl::kNotUtf8,
     "Scenario files are UTF-8. The file contains bytes that are not valid UTF-8, often because an "
     "editor saved it in Latin-1. Save it as UTF-8.",
     "benchmark b \"caf\xE9\" { }\n"sv, "benchmark b \"caf\xC3\xA9\" { }\n"},
    {&dsl::kNulByte,
     "A scenario file cannot contain NUL bytes. The file may be UTF-16, or not a text file.",
     "benchmark b { cycles 5\0 }\n"sv, "benchmark b { cycles 5 }\n"},
    {&dsl::kControlCharacter,
     "Control characters other than tab and the end of a line are not allowed, because a terminal "
     "would execute them. A lone carriage return is one of them.",
     "benchmark b { cycles \x1B 5 }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kUnknownCharacter,
     "The character is not part of any word, number or operator of the language. Spaces and quotes "
     "from a word processor are common causes.",
     "benchmark b { cycles @5 }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kForeignOperator,
     "This operator belongs to other languages. The operators are + - * / ^ and, in conditions, "
     "== != < <= > >=, and, or, not.",
     "let n = 2 ** 3\nbenchmark b { cycles n }\n", "let n = 2 ^ 3\nbenchmark b { cycles n }\n"},
    {&dsl::kForeignComment, "A comment begins with # and ends at the end of the line.",
     "// the first\nbenchmark b { }\n", "# the first\nbenchmark b { }\n"},
    {&dsl::kBadNumber,
     "A number is written 50, -9.8, 1e6, 1_000_000 or 0xAA: it begins with a digit, and _ stands "
     "between two digits.",
     "benchmark b { timestep .5 }\n", "benchmark b { timestep 0.01 }\n"},
    {&dsl::kNumberRange,
     "The number is too large: a whole number has to fit into 64 bits, a real number into a "
     "double.",
     "benchmark b { seed 0x1_0000_0000_0000_0000 }\n", "benchmark b { seed 0xFFFF_FFFF }\n"},
    {&dsl::kBadEscape,
     "In a text, a backslash begins one of \\\" \\\\ \\n \\t. Write a backslash itself as \\\\.",
     "benchmark b \"100\\%\" { }\n", "benchmark b \"100 %\" { }\n"},
    {&dsl::kUnclosedText, "A text ends with \" on the line where it begins.",
     "let n = 5\nbenchmark b \"a title {\n  cycles n\n}\n",
     "let n = 5\nbenchmark b \"a title\" {\n  cycles n\n}\n"},
    {&dsl::kSingleQuotes, "Texts are in double quotes; words such as sphere have no quotes.",
     "benchmark b 'a title' { }\n", "benchmark b \"a title\" { }\n"},
    {&dsl::kBadName,
     "A name consists of letters A to Z and a to z, digits and _, and begins with a letter or _. A "
     "hyphen would be a minus.",
     "benchmark my-bench { }\n", "benchmark my_bench { }\n"},
    {&dsl::kMissingName, "benchmark, let, from and as are followed by a name.",
     "benchmark { cycles 5 }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kReservedWord,
     "benchmark, use, let, cases and skip begin statements, and cannot be names.",
     "let use = 3\nbenchmark b { }\n", "let usage = 3\nbenchmark b { cycles usage }\n"},
    {&dsl::kMissingQuotes, "The name of a file must be in double quotes.",
     "use base\nbenchmark b { }\n", "benchmark b { }\n"},
    {&dsl::kUnexpectedToken,
     "The grammar does not allow this token here. A file is a list of use, let and benchmark; a "
     "block is a list of `name value`.",
     "benchmark b { 5 }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kMisplacedStatement,
     "Settings belong inside a benchmark; use and benchmark belong outside of all blocks.",
     "cycles 50\nbenchmark b { }\n", "benchmark b { cycles 50 }\n"},
    {&dsl::kMisplacedFrom,
     "`from` and the base come between the name and the title, and there is only one base.",
     "benchmark a { }\nbenchmark b \"a title\" from a { }\n",
     "benchmark a { }\nbenchmark b from a \"a title\" { }\n"},
    {&dsl::kMissingBlock, "A benchmark, cases, and each case have a block { }, which may be empty.",
     "benchmark b\n", "benchmark b { }\n"},
    {&dsl::kBraceOnOwnLine,
     "A statement ends at the end of its line, so the { of a block must be on the line of its "
     "name.",
     "benchmark b\n{\n  cycles 5\n}\n", "benchmark b {\n  cycles 5\n}\n"},
    {&dsl::kBracesForList,
     "Braces enclose statements. Parentheses ( ) enclose a vector; a list has no brackets.",
     "benchmark b { acceleration {0, -9.8, 0} }\n", "benchmark b { acceleration (0, -9.8, 0) }\n"},
    {&dsl::kUnclosedBlock, "A block that begins with { ends with }.",
     "benchmark b {\n  objects { quantity 5\n}\n", "benchmark b {\n  objects { quantity 5 }\n}\n"},
    {&dsl::kStrayBrace, "There are more } than blocks.", "benchmark b { cycles 5 } }\n",
     "benchmark b { cycles 5 }\n"},
    {&dsl::kEqualsInSetting,
     "A setting is `name value`, with a space between them. Only let has an =.",
     "benchmark b { cycles = 5 }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kMissingEquals, "A let needs an = between its name and its value.",
     "let n 5\nbenchmark b { cycles n }\n", "let n = 5\nbenchmark b { cycles n }\n"},
    {&dsl::kMissingSemicolon,
     "Several statements on a line are separated by ; and several values of one setting by commas.",
     "benchmark b { objects { quantity 5 size 10 } }\n",
     "benchmark b { objects { quantity 5; size 10 } }\n"},
    {&dsl::kMissingWhen, "A skip needs a condition for the points to skip: skip when CONDITION.",
     "benchmark b {\n  objects.quantity sweep(10, 90)\n  detector sweep(sap, dbvt)\n  skip "
     "quantity > 5 and detector == sap\n}\n",
     "benchmark b {\n  objects.quantity sweep(10, 90)\n  detector sweep(sap, dbvt)\n  skip when "
     "quantity > 50 and detector == sap\n}\n"},
    {&dsl::kNoLoops,
     "The language has no loops and no branches. A sweep makes one run for each value; skip and "
     "cases replace branches.",
     "benchmark b { for i in 1 .. 3 { cycles i } }\n", "benchmark b { cycles sweep(1 .. 3) }\n"},
    {&dsl::kNoFunctions, "A let is a value and takes no arguments.",
     "let twice(x) = 2\nbenchmark b { cycles 5 }\n",
     "let n = 5\nlet twice = 2 * n\nbenchmark b { cycles twice }\n"},
    {&dsl::kOneValue,
     "A let holds one value. Several values are a sweep, which makes one run for each.",
     "let n = 10, 100\nbenchmark b { cycles n }\n",
     "let n = sweep(10, 100)\nbenchmark b { cycles n }\n"},
    {&dsl::kMissingValue, "A setting, a let, an operator and a use need a value on the same line.",
     "benchmark b { cycles }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kWrittenUnit,
     "The word after a number is not a known unit, or a unit does not follow a number or a "
     "bracket. `cdb doc NAME` gives the unit of a parameter.",
     "benchmark b { timestep 10 seconds }\n", "benchmark b { timestep 10 ms }\n"},
    {&dsl::kTwoValues,
     "A parameter has one value in a run. A sweep makes one run for each of several values.",
     "benchmark b { cycles 5 6 }\n", "benchmark b { cycles sweep(5, 6) }\n"},
    {&dsl::kMissingComma,
     "Arguments, parts of a vector and values of a list are separated by commas.",
     "benchmark b { detector sweep(simple dbvt sap) }\n",
     "benchmark b { detector sweep(simple, dbvt, sap) }\n"},
    {&dsl::kTrailingComma,
     "A comma must be followed by a value. A list continues after a comma, also on the next line.",
     "benchmark b { detector sweep(simple, sap,) }\n",
     "benchmark b { detector sweep(simple, sap) }\n"},
    {&dsl::kLineBreak,
     "A statement ends at the end of its line. Inside ( ) and in a list, a line may break after a "
     "comma.",
     "benchmark b {\n  cycles 20 *\n    3\n}\n", "benchmark b {\n  cycles 20 * 3\n}\n"},
    {&dsl::kMissingBrackets,
     "A single argument of a word needs no parentheses; several arguments do.",
     "benchmark b { objects { quantity 5; location stack height: 5, gap: 0.1 } }\n",
     "benchmark b { objects { quantity 5; location stack(height: 5, gap: 0) } }\n"},
    {&dsl::kUnclosedBracket,
     "A ( must be closed on its line, or on a later line if each line in between ends with a "
     "comma.",
     "benchmark b {\n  cycles (1 + 2\n}\n", "benchmark b {\n  cycles (1 + 2)\n}\n"},
    {&dsl::kStrayBracket, "There are more closing than opening brackets.",
     "benchmark b { cycles 5) }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kMismatchedBracket, "A ( must be closed by ).",
     "benchmark b { detector sweep(simple, sap] }\n",
     "benchmark b { detector sweep(simple, sap) }\n"},
    {&dsl::kSquareBracket,
     "The language has no square brackets. Parentheses ( ) enclose vectors and arguments; lists "
     "have no brackets.",
     "benchmark b { acceleration [0, -9.8, 0] }\n", "benchmark b { acceleration (0, -9.8, 0) }\n"},
    {&dsl::kRatioParts, "A ratio has three parts: 1 : y : z.",
     "benchmark b { objects.aspect 1 : 2 }\n", "benchmark b { objects.aspect 1 : 2 : 1 }\n"},
    {&dsl::kVectorParts, "A vector has three parts: (x, y, z).",
     "benchmark b { acceleration (0, -9.8) }\n", "benchmark b { acceleration (0, -9.8, 0) }\n"},
    {&dsl::kBadRange,
     "A range is a .. b, a .. b step d, or a .. b count n, optionally followed by log for values "
     "that grow by a factor.",
     "benchmark b { cycles sweep(1 .. 5 by 2) }\n",
     "benchmark b { cycles sweep(1 .. 5 step 2) }\n"},
    {&dsl::kBadSign, "A value has at most one sign, which is a minus.",
     "benchmark b { cycles +5 }\n", "benchmark b { cycles 5 }\n"},
    {&dsl::kTextInSum,
     "A text is a file name or a title, and cannot be part of an expression; words such as dbvt "
     "have no quotes.",
     "benchmark b {\n  detector sweep(sap, dbvt)\n  cycles sweep(1, 2)\n  skip when cycles == 1 "
     "and detector == \"sap\"\n}\n",
     "benchmark b {\n  detector sweep(sap, dbvt)\n  cycles sweep(1, 2)\n  skip when cycles == 1 "
     "and detector == sap\n}\n"},
    {&dsl::kBracketedValue,
     "Plain parentheses enclose arithmetic or a vector. A range, a ratio or a text has none.",
     "benchmark b { cycles (1 .. 5) }\n", "benchmark b { cycles sweep(1 .. 5) }\n"},
    {&dsl::kMisplacedAs, "`as` names an axis, and comes after the ) of its sweep.",
     "benchmark b { cycles sweep(1 .. 5 as n) }\n", "benchmark b { cycles sweep(1 .. 5) as n }\n"},
    {&dsl::kTooDeep,
     "Blocks, brackets, calls and operators can nest at most 100 levels deep. Name parts of the "
     "value with let.",
     kDeep, "let n = 1\nbenchmark b { cycles n }\n"},
    {&dsl::kMissingComparison, "A condition is a comparison: quantity > 3000, detector == simple.",
     "benchmark b {\n  sleeping sweep(on, off)\n  cycles sweep(1, 2)\n  skip when cycles == 1 and "
     "sleeping\n}\n",
     "benchmark b {\n  sleeping sweep(on, off)\n  cycles sweep(1, 2)\n  skip when cycles == 1 and "
     "sleeping == on\n}\n"},
    {&dsl::kSingleEquals, "A comparison is written ==. A single = names a value in a let.",
     "benchmark b {\n  detector sweep(sap, dbvt)\n  cycles sweep(1, 2)\n  skip when cycles == 1 "
     "and detector = sap\n}\n",
     "benchmark b {\n  detector sweep(sap, dbvt)\n  cycles sweep(1, 2)\n  skip when cycles == 1 "
     "and detector == sap\n}\n"},
    {&dsl::kChainedComparison, "Comparisons cannot be chained: join two of them with `and`.",
     "benchmark b {\n  objects.quantity sweep(10, 30, 90)\n  seed sweep(1, 2)\n  skip when seed < "
     "quantity < 50\n}\n",
     "benchmark b {\n  objects.quantity sweep(10, 30, 90)\n  seed sweep(20, 40)\n  skip when seed "
     "< quantity and quantity < 50\n}\n"},
    {&dsl::kNotScope,
     "not negates everything that follows it within its brackets, not only the next comparison. "
     "Add brackets to make the scope explicit.",
     "benchmark b {\n  cycles sweep(10, 20)\n  objects.quantity sweep(10, 90)\n  detector "
     "sweep(sap, dbvt)\n"
     "  skip when cycles == 10 and not quantity > 30 and detector == sap\n}\n",
     "benchmark b {\n  cycles sweep(10, 20)\n  objects.quantity sweep(10, 90)\n  detector "
     "sweep(sap, dbvt)\n"
     "  skip when cycles == 10 and (not quantity > 30) and detector == sap\n}\n"},
};

}  // namespace

std::span<const Explanation> SyntaxExplanations() { return kSyntaxRows; }

}  // namespace cdb::manual
