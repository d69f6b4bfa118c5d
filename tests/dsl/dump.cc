#include "tests/dsl/dump.h"

#include <variant>

namespace cdb::tests {
namespace {

std::string Quoted(const std::string& text) {
  std::string quoted(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else if (c == '\t')
      quoted += "\\t";
    else
      quoted += c;
  }
  quoted += '"';
  return quoted;
}

class Dumper {
 public:
  std::string Take() { return std::move(out_); }

  void Add(const dsl::File& file) {
    for (const auto& item : file.items) std::visit([this](const auto& what) { Line(what); }, item);
  }

 private:
  void Start() { out_.append(2 * level_, ' '); }

  void Line(const dsl::Use& use) {
    Start();
    out_ += use.detector ? "use detector " : "use ";
    out_ += Quoted(use.path);
    out_ += '\n';
  }
  void Line(const dsl::Let& let) {
    Start();
    out_ += "let ";
    out_ += let.name.text;
    out_ += ' ';
    out_ += Dump(*let.value);
    out_ += '\n';
  }
  void Line(const dsl::Benchmark& benchmark) {
    Start();
    out_ += "benchmark ";
    out_ += benchmark.name.text;
    if (benchmark.from) {
      out_ += " from ";
      out_ += benchmark.from->text;
    }
    Title(benchmark.title);
    Inside(benchmark.block);
  }
  void Line(const dsl::Cases& cases) {
    Start();
    out_ += "cases";
    if (cases.name) {
      out_ += ' ';
      out_ += cases.name->text;
    }
    out_ += '\n';
    ++level_;
    for (const dsl::Case& one : cases.cases) {
      Start();
      out_ += "case ";
      out_ += one.name.text;
      Title(one.title);
      Inside(one.block);
    }
    --level_;
  }
  void Line(const dsl::Skip& skip) {
    Start();
    out_ += skip.is_only ? "only " : "skip ";
    out_ += skip.when ? Dump(*skip.when) : "(error)";
    out_ += '\n';
  }
  void Line(const dsl::Require& require) {
    Start();
    out_ += "require ";
    out_ += require.what ? Dump(*require.what) : "(error)";
    out_ += '\n';
  }
  void Line(const dsl::Group& group) {
    Start();
    out_ += "group ";
    out_ += group.kind.text;
    if (group.label) {
      out_ += ' ';
      out_ += group.label->text;
    }
    Inside(group.block);
  }
  void Line(const dsl::Setting& setting) {
    Start();
    out_ += "set ";
    out_ += setting.path.text;
    for (const dsl::ExprPtr& value : setting.values) {
      out_ += ' ';
      out_ += Dump(*value);
    }
    out_ += '\n';
  }
  void Title(const std::string& title) {
    if (title.empty()) return;
    out_ += ' ';
    out_ += Quoted(title);
  }
  void Inside(const dsl::Block& block) {
    out_ += '\n';
    ++level_;
    for (const dsl::Statement& statement : block.statements)
      std::visit([this](const auto& what) { Line(what); }, statement.what);
    --level_;
  }

  std::string out_;
  std::size_t level_ = 0;
};

std::string List(std::string head, const std::vector<dsl::ExprPtr>& items) {
  std::string out(1, '(');
  out += head;
  for (const dsl::ExprPtr& item : items) {
    out += ' ';
    out += Dump(*item);
  }
  return out;
}

}  // namespace

std::string Dump(const dsl::File& file) {
  Dumper dumper;
  dumper.Add(file);
  return dumper.Take();
}

std::string Dump(const dsl::Expr& expr) {
  std::string out;
  switch (expr.kind) {
    case dsl::ExprKind::kNumber:
    case dsl::ExprKind::kPath:
      return expr.text;
    case dsl::ExprKind::kText:
      return Quoted(expr.text);
    case dsl::ExprKind::kVector:
      return List("vector", expr.items) + ')';
    case dsl::ExprKind::kRatio:
      return List("ratio", expr.items) + ')';
    case dsl::ExprKind::kNegate:
      return List("neg", expr.items) + ')';
    case dsl::ExprKind::kBinary:
      return List(std::string(1, expr.op), expr.items) + ')';
    case dsl::ExprKind::kQuantity:
      return List("unit", expr.items) + ' ' + expr.text + ')';
    case dsl::ExprKind::kError:
      return "(error)";
    case dsl::ExprKind::kRange: {
      const char* words[] = {"range", "range-step", "range-count", "range-sobol", "range-latin"};
      return List(words[static_cast<int>(expr.range)] + std::string(expr.is_log ? "-log" : ""),
                  expr.items) +
             ')';
    }
    case dsl::ExprKind::kCall:
      break;
  }
  out = "(call ";
  out += expr.text;
  for (const dsl::Argument& argument : expr.arguments) {
    out += ' ';
    if (argument.name) {
      out += argument.name->text;
      out += ':';
    }
    if (argument.weight) out += "(weigh ";
    out += Dump(*argument.value);
    if (argument.weight) {
      out += ' ';
      out += Dump(*argument.weight);
      out += ')';
    }
  }
  if (expr.until) out += " until " + Dump(*expr.until);
  if (expr.zip) out += " zipped";
  if (expr.zip && expr.zip->axis) out += " as " + expr.zip->axis->text;
  if (expr.zip && !expr.zip->axis_title.empty()) out += " titled " + Quoted(expr.zip->axis_title);
  if (expr.axis) {
    out += " as ";
    out += expr.axis->text;
  }
  if (!expr.axis_title.empty()) {
    out += " titled ";
    out += Quoted(expr.axis_title);
  }
  for (const dsl::ExprPtr& limit : expr.items) {
    out += &limit == &expr.items[0] ? " in " : " ";
    out += Dump(*limit);
  }
  out += ')';
  return out;
}

std::string Dump(const dsl::Condition& condition) {
  std::string out(1, '(');
  switch (condition.kind) {
    case dsl::ConditionKind::kCompare:
      out += condition.op;
      out += ' ';
      out += Dump(*condition.left);
      out += ' ';
      out += Dump(*condition.right);
      break;
    case dsl::ConditionKind::kIn:
      out += "in " + Dump(*condition.left);
      for (const dsl::ExprPtr& value : condition.values) out += ' ' + Dump(*value);
      break;
    case dsl::ConditionKind::kAnd:
      out += "and";
      break;
    case dsl::ConditionKind::kOr:
      out += "or";
      break;
    case dsl::ConditionKind::kNot:
      out += "not";
      break;
  }
  for (const dsl::ConditionPtr& item : condition.items) {
    out += ' ';
    out += Dump(*item);
  }
  out += ')';
  return out;
}

}  // namespace cdb::tests
