#include "tests/dsl/invariants.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <variant>

#include "dsl/diagnostics.h"
#include "dsl/format.h"
#include "dsl/parser.h"
#include "tests/dsl/dump.h"

namespace cdb::tests {
namespace {

// Checks the heights that the tree stores, and that every span lies in the source.
class Walker {
 public:
  explicit Walker(const text::Source& source) : source_(source) {}

  const std::string& problem() const { return problem_; }

  void Visit(const dsl::File& file) {
    for (const auto& item : file.items) std::visit([this](const auto& what) { Visit(what); }, item);
  }

 private:
  void Check(const text::Span& span) {
    if (span.source != &source_ || span.begin > span.end || span.end > source_.text().size())
      problem_ = "a span of the tree lies outside the text";
  }
  int Height(const dsl::Expr& expr) {
    Check(expr.span);
    int below = 0;
    for (const dsl::ExprPtr& item : expr.items) below = std::max(below, Height(*item));
    for (const dsl::Argument& argument : expr.arguments) {
      below = std::max(below, Height(*argument.value));
      if (argument.weight) below = std::max(below, Height(*argument.weight));
    }
    if (expr.until) below = std::max(below, Height(*expr.until));
    if (expr.height != below + 1 || expr.height > dsl::kMaxDepth)
      problem_ = "an expression is not as high as it says";
    return below + 1;
  }
  int Height(const dsl::Condition& condition) {
    Check(condition.span);
    int below = 0;
    if (condition.left) below = Height(*condition.left);
    if (condition.right) below = std::max(below, Height(*condition.right));
    for (const dsl::ExprPtr& value : condition.values) below = std::max(below, Height(*value));
    for (const dsl::ConditionPtr& item : condition.items) below = std::max(below, Height(*item));
    if (condition.height != below + 1 || condition.height > dsl::kMaxDepth)
      problem_ = "a condition is not as high as it says";
    return below + 1;
  }
  void Visit(const dsl::Use& use) { Check(use.span); }
  void Visit(const dsl::Let& let) {
    Check(let.name.span);
    Height(*let.value);
  }
  void Visit(const dsl::Benchmark& benchmark) {
    Check(benchmark.span);
    Visit(benchmark.block);
  }
  void Visit(const dsl::Block& block) {
    Check(block.span);
    for (const dsl::Statement& statement : block.statements) {
      Check(statement.span);
      std::visit([this](const auto& what) { Visit(what); }, statement.what);
    }
  }
  void Visit(const dsl::Cases& cases) {
    Check(cases.keyword);
    for (const dsl::Case& one : cases.cases) Visit(one.block);
  }
  void Visit(const dsl::Skip& skip) {
    if (skip.when) Height(*skip.when);
  }
  void Visit(const dsl::Require& require) {
    if (require.what) Height(*require.what);
  }
  void Visit(const dsl::Group& group) {
    Check(group.kind.span);
    Visit(group.block);
  }
  void Visit(const dsl::Setting& setting) {
    Check(setting.path.span);
    if (setting.values.empty()) problem_ = "a setting has no value";
    for (const dsl::ExprPtr& value : setting.values) Height(*value);
  }

  const text::Source& source_;
  std::string problem_;
};

std::string BrokenDiagnostic(const text::Source& source, const dsl::Diagnostics& diagnostics) {
  const auto inside = [&](const text::Span& span) {
    return span.source == &source && span.begin <= span.end && span.end <= source.text().size();
  };
  std::set<std::pair<const dsl::DiagnosticKind*, std::pair<std::uint32_t, std::uint32_t>>> places;
  for (const dsl::Diagnostic& diagnostic : diagnostics.all()) {
    if (diagnostic.kind == nullptr || diagnostic.message.empty()) return "an error has no words";
    if (diagnostic.message.back() == '.') return "a message ends with a full stop";
    if (!inside(diagnostic.span)) return "an error lies outside the text";
    for (const dsl::Note& note : diagnostic.notes)
      if (!inside(note.span) || note.text.empty()) return "a note lies outside the text";
    const std::pair place{diagnostic.span.begin, diagnostic.span.end};
    if (!places.insert({diagnostic.kind, place}).second)
      return "one error is told twice: " + diagnostic.message;
  }
  return {};
}

}  // namespace

std::string BrokenInvariant(const std::string& text) {
  const auto source = std::make_shared<const text::Source>("test.cdb", text);
  dsl::Diagnostics diagnostics;
  const dsl::File file = dsl::Parse(source, diagnostics);
  if (std::string problem = BrokenDiagnostic(*source, diagnostics); !problem.empty())
    return problem;
  const std::string rendered = dsl::Render(diagnostics, {.color = true});
  if (rendered.empty() != diagnostics.all().empty()) return "an error is not shown";
  Walker walker(*source);
  walker.Visit(file);
  if (!walker.problem().empty()) return walker.problem();
  if (diagnostics.has_errors()) return {};

  const auto formatted = std::make_shared<const text::Source>("test.cdb", dsl::Format(*source));
  dsl::Diagnostics again;
  const dsl::File same = dsl::Parse(formatted, again);
  if (again.has_errors()) return "the formatted text does not parse:\n" + dsl::Render(again);
  if (Dump(same) != Dump(file)) return "formatting changed the tree";
  if (dsl::Format(*formatted) != formatted->text()) return "formatting twice gives another text";
  return {};
}

}  // namespace cdb::tests
