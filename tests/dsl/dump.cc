#include "tests/dsl/dump.h"

#include <variant>

namespace cdb::dsl::testing {
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

  void Add(const File& file) {
    for (const auto& item : file.items) std::visit([this](const auto& what) { Line(what); }, item);
  }

 private:
  void Start() { out_.append(2 * level_, ' '); }

  void Line(const Use& use) {
    Start();
    out_ += use.detector ? "use detector " : "use ";
    out_ += Quoted(use.path);
    out_ += '\n';
  }
  void Line(const Let& let) {
    Start();
    out_ += "let ";
    out_ += let.name.text;
    out_ += ' ';
    out_ += Dump(*let.value);
    out_ += '\n';
  }
  void Line(const Benchmark& benchmark) {
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
  void Line(const Cases& cases) {
    Start();
    out_ += "cases";
    if (cases.name) {
      out_ += ' ';
      out_ += cases.name->text;
    }
    out_ += '\n';
    ++level_;
    for (const Case& one : cases.cases) {
      Start();
      out_ += "case ";
      out_ += one.name.text;
      Title(one.title);
      Inside(one.block);
    }
    --level_;
  }
  void Line(const Skip& skip) {
    Start();
    out_ += "skip ";
    out_ += Dump(*skip.when);
    out_ += '\n';
  }
  void Line(const Group& group) {
    Start();
    out_ += "group ";
    out_ += group.kind.text;
    if (group.label) {
      out_ += ' ';
      out_ += group.label->text;
    }
    Inside(group.block);
  }
  void Line(const Setting& setting) {
    Start();
    out_ += "set ";
    out_ += setting.path.text;
    for (const ExprPtr& value : setting.values) {
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
  void Inside(const Block& block) {
    out_ += '\n';
    ++level_;
    for (const Statement& statement : block.statements)
      std::visit([this](const auto& what) { Line(what); }, statement.what);
    --level_;
  }

  std::string out_;
  std::size_t level_ = 0;
};

std::string List(std::string head, const std::vector<ExprPtr>& items) {
  std::string out(1, '(');
  out += head;
  for (const ExprPtr& item : items) {
    out += ' ';
    out += Dump(*item);
  }
  return out;
}

}  // namespace

std::string Dump(const File& file) {
  Dumper dumper;
  dumper.Add(file);
  return dumper.Take();
}

std::string Dump(const Expr& expr) {
  std::string out;
  switch (expr.kind) {
    case ExprKind::kNumber:
    case ExprKind::kPath:
      return expr.text;
    case ExprKind::kText:
      return Quoted(expr.text);
    case ExprKind::kVector:
      return List("vector", expr.items) + ')';
    case ExprKind::kRatio:
      return List("ratio", expr.items) + ')';
    case ExprKind::kNegate:
      return List("neg", expr.items) + ')';
    case ExprKind::kBinary:
      return List(std::string(1, expr.op), expr.items) + ')';
    case ExprKind::kRange: {
      const char* words[] = {"range", "range-step", "range-count", "range-log"};
      return List(words[static_cast<int>(expr.range)], expr.items) + ')';
    }
    case ExprKind::kCall:
      break;
  }
  out = "(call ";
  out += expr.text;
  for (const Argument& argument : expr.arguments) {
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
  if (expr.axis) {
    out += " as ";
    out += expr.axis->text;
  }
  out += ')';
  return out;
}

std::string Dump(const Condition& condition) {
  std::string out(1, '(');
  switch (condition.kind) {
    case ConditionKind::kCompare:
      out += condition.op;
      out += ' ';
      out += Dump(*condition.left);
      out += ' ';
      out += Dump(*condition.right);
      break;
    case ConditionKind::kAnd:
      out += "and";
      break;
    case ConditionKind::kOr:
      out += "or";
      break;
    case ConditionKind::kNot:
      out += "not";
      break;
  }
  for (const ConditionPtr& item : condition.items) {
    out += ' ';
    out += Dump(*item);
  }
  out += ')';
  return out;
}

}  // namespace cdb::dsl::testing
