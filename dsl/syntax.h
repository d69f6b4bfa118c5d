// The syntax tree of a `.cdb` file, without the meaning of any name.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "dsl/text/source.h"

namespace cdb::dsl {

struct Expr;
using ExprPtr = std::unique_ptr<Expr>;
struct Condition;
using ConditionPtr = std::unique_ptr<Condition>;

/// A name or a dotted path with its location.
struct Name {
  std::string text;  ///< `objects.quantity`
  text::Span span;
};

/// One argument of a call: `x`, `sd: 3`, or a weighted word `sphere 3`.
struct Argument {
  std::optional<Name> name;  ///< `sd` of `sd: 3`
  ExprPtr value;
  ExprPtr weight;  ///< the `3` of `sphere 3`; null if absent
};

enum class ExprKind {
  kNumber,    ///< text: the literal as written (`1_000`, `0xAA`, `1e6`), without its sign
  kText,      ///< text: the contents with escapes resolved
  kPath,      ///< text: the name or the path, also words such as `sphere` and `on`
  kVector,    ///< items: x, y, z
  kRatio,     ///< items: the three parts of `1 : y : z`
  kCall,      ///< text: the function; arguments; axis from `as`; items: the two limits of `in`
  kNegate,    ///< items: the operand
  kBinary,    ///< op; items: left, right
  kRange,     ///< items: first, last, and the step or the count if given; range, is_log
  kQuantity,  ///< items: the value; text: its unit, `m/s^2`; text_span
  kError,     ///< could not be parsed, which was reported: an unknown value
};

/// The form of a range: `a .. b`, `step d`, `count n`, `sobol n`, `latin n`.
enum class RangeKind { kByOne, kStep, kCount, kSobol, kLatin };

/// `let a, b = zip(sweep(…), sweep(…)) as name "title"`: sweeps that vary together. Each is the
/// value of a separate let.
struct Zip {
  text::Span span;  ///< of the call
  std::vector<Name> names;
  std::vector<const Expr*> sweeps;  ///< one for each name
  std::optional<Name> axis;         ///< `as name`
  std::string axis_title;           ///< `as "title"`; may be empty
};

struct Expr {
  ExprKind kind = ExprKind::kNumber;
  int height = 1;   ///< nodes on the longest path down; with its ancestors at most `kMaxDepth`
  text::Span span;  ///< including the brackets around it
  std::string text;
  char op = 0;  ///< one of + - * / ^
  RangeKind range = RangeKind::kByOne;
  bool is_log = false;   ///< of a kRange: `log`
  text::Span text_span;  ///< of the unit of a kQuantity
  std::vector<ExprPtr> items;
  std::vector<Argument> arguments;
  std::optional<Name> axis;        ///< `as name` after a call
  std::string axis_title;          ///< `as "title"` or `as name "title"` after a call; may be empty
  bool bare = false;               ///< a call without brackets: `ring radius: 20`
  std::shared_ptr<const Zip> zip;  ///< the zip that this sweep belongs to, or null
  /// Of a `find( )`: the condition after `until:`, or null.
  std::shared_ptr<const Condition> until;
  text::Span until_span;  ///< of that word
};

/// `and` binds closer than `or`; `not` negates everything after it within its brackets.
enum class ConditionKind { kCompare, kIn, kAnd, kOr, kNot };

struct Condition {
  ConditionKind kind = ConditionKind::kCompare;
  int height = 1;   ///< as in Expr
  text::Span span;  ///< including the brackets around it
  std::string op;   ///< kCompare: == != < <= > >=
  ExprPtr left, right;
  std::vector<ConditionPtr> items;  ///< kAnd, kOr: two; kNot: one
  std::vector<ExprPtr> values;      ///< kIn: one or more; `left` must equal one of them
};

struct Statement;
struct Block {
  text::Span span;  ///< including its braces
  std::vector<Statement> statements;
};

struct Let {
  Name name;
  ExprPtr value;
};
struct Case {
  Name name;
  std::string title;
  Block block;
};
struct Cases {
  std::optional<Name> name;
  text::Span keyword;
  std::vector<Case> cases;
};
struct Skip {
  ConditionPtr when;     ///< null if it could not be parsed, which was reported
  bool is_only = false;  ///< `only when`: keeps the points that meet the condition
};
/// `require p99(step) < 4 ms`: a comparison of a figure of the results with a value.
struct Require {
  ConditionPtr what;  ///< null if it could not be parsed, which was reported
};
struct Group {
  Name kind;                  ///< `objects`
  std::optional<Name> label;  ///< `pebbles`
  Block block;
};
struct Setting {
  Name path;
  std::vector<ExprPtr> values;  ///< one or more
};

struct Statement {
  text::Span span;
  std::variant<Let, Cases, Skip, Require, Group, Setting> what;
};

struct Use {
  text::Span span;
  bool detector = false;
  std::string path;
  text::Span path_span;
};

/// The damage that errors did to a file or a benchmark. A value that cannot be parsed is a kError
/// and does not count as damage.
enum class Damage {
  kNone,
  kLost,       ///< statements are missing: any name may have been defined in one of them
  kMisnested,  ///< its braces do not match: statements may be in the wrong block
};

struct Benchmark {
  Damage damage = Damage::kNone;
  text::Span span;
  Name name;
  std::optional<Name> from;
  std::string title;
  Block block;
};

/// One file. `items` keeps the order of the text. Owns the source that its spans point into.
struct File {
  std::shared_ptr<const text::Source> source;
  Damage damage = Damage::kNone;  ///< outside the benchmarks
  std::vector<std::variant<Use, Let, Benchmark>> items;
};

}  // namespace cdb::dsl
