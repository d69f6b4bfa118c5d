// Makes syntax that no file contains, all of it at one place of a file that it is reported at.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "compiler/schema/number.h"
#include "dsl/syntax.h"

namespace cdb::scenario {

class SyntaxMaker {
 public:
  explicit SyntaxMaker(const text::Span& span) : span_(span) {}

  dsl::ExprPtr Make(dsl::ExprKind kind, std::string text = {}) const {
    auto expr = std::make_unique<dsl::Expr>();
    expr->kind = kind;
    expr->span = span_;
    expr->text_span = span_;
    expr->text = std::move(text);
    return expr;
  }
  dsl::ExprPtr Number(double value) const {
    if (std::abs(value) < 1e-14) value = 0;  // rounding of turned frames
    auto number = Make(dsl::ExprKind::kNumber, schema::FormatReal(std::abs(value)));
    if (value >= 0) return number;
    auto negated = Make(dsl::ExprKind::kNegate);
    negated->items.push_back(std::move(number));
    negated->height = 2;
    return negated;
  }
  dsl::ExprPtr Vector(const Eigen::Vector3d& value) const {
    auto vector = Make(dsl::ExprKind::kVector);
    for (const double part : value) vector->items.push_back(Number(part));
    vector->height = 3;
    return vector;
  }
  dsl::ExprPtr Binary(char op, dsl::ExprPtr left, dsl::ExprPtr right) const {
    auto binary = Make(dsl::ExprKind::kBinary);
    binary->op = op;
    binary->height = 1 + std::max(left->height, right->height);
    binary->items.push_back(std::move(left));
    binary->items.push_back(std::move(right));
    return binary;
  }
  dsl::ExprPtr Word(std::string word) const { return Make(dsl::ExprKind::kPath, std::move(word)); }
  dsl::ExprPtr Text(std::string text) const { return Make(dsl::ExprKind::kText, std::move(text)); }
  static void Add(dsl::Expr& call, dsl::ExprPtr value, const char* name = nullptr) {
    call.height = std::max(call.height, value->height + 1);
    dsl::Argument argument;
    if (name != nullptr) argument.name = dsl::Name{name, call.span};
    argument.value = std::move(value);
    call.arguments.push_back(std::move(argument));
  }

  dsl::Statement Setting(std::string path, dsl::ExprPtr value) const {
    std::vector<dsl::ExprPtr> values;
    values.push_back(std::move(value));
    return Setting(std::move(path), std::move(values));
  }
  dsl::Statement Setting(std::string path, std::vector<dsl::ExprPtr> values) const {
    return {span_, dsl::Setting{{std::move(path), span_}, std::move(values)}};
  }
  dsl::Group Block(const char* kind, std::string label) const {
    return {{kind, span_}, dsl::Name{std::move(label), span_}, {span_, {}}};
  }
  dsl::Statement Statement(dsl::Group group) const { return {span_, std::move(group)}; }

 private:
  text::Span span_;
};

}  // namespace cdb::scenario
