#include "compiler/names/kind_name.h"

#include <fmt/format.h>

namespace cdb::names {
namespace {

struct NameOf {
  std::string operator()(bool on) const { return on ? "'on'" : "'off'"; }
  std::string operator()(const schema::Number& number) const {
    return fmt::format("the number {}", number.Text());
  }
  std::string operator()(const schema::Word& word) const { return fmt::format("'{}'", word.text); }
  std::string operator()(const schema::Text&) const { return "a text"; }
  std::string operator()(const Eigen::Vector3d&) const { return "a vector"; }
  std::string operator()(const schema::Ratio&) const { return "a ratio"; }
  std::string operator()(const schema::WordList&) const { return "a list"; }
  std::string operator()(const schema::Call& call) const { return fmt::format("{}( )", call.name); }
  std::string operator()(const schema::Formula&) const { return "a value of each object"; }
  std::string operator()(const schema::Distribution& drawn) const {
    return fmt::format("the distribution {}( )", schema::DistributionName(drawn.kind));
  }
};

}  // namespace

std::string KindName(const schema::Value& value) {
  return std::visit(NameOf{}, static_cast<const schema::Value::variant&>(value));
}

}  // namespace cdb::names
