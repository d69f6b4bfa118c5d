// A parameter named in the code: `WorldParameter("timestep")`, `GroupParameter("size")`. It is a
// compile error if the table has no such name, or if the parameter cannot have the requested kind
// of value.
#pragma once

#include <cstddef>
#include <string_view>

#include "compiler/schema/parameter_table.h"

namespace cdb::schema {

/// How a parameter's value is read.
enum class ValueKind {
  kAny,
  kReal,   ///< numbers and counts
  kCount,  ///< integers
  kSwitch,
  kWord,   ///< one word, also if it stands for a number: `mass fixed`
  kWords,  ///< a list
  kVector,
  kDrawn,  ///< constants and distributions
  /// A number or a switch drawn for each object. The size and the mass are not: they go with the
  /// solid, which has three sizes and whose volume may give the mass.
  kDrawnNumber,
};

constexpr bool MayBe(const Parameter& parameter, ValueKind kind) {
  switch (kind) {
    case ValueKind::kAny:
      return true;
    case ValueKind::kReal:
      return parameter.type == ParameterType::kReal || parameter.type == ParameterType::kCount;
    case ValueKind::kCount:
      return parameter.type == ParameterType::kCount;
    case ValueKind::kSwitch:
      return parameter.type == ParameterType::kSwitch;
    case ValueKind::kWord:
      return parameter.type == ParameterType::kWord ||
             (parameter.type != ParameterType::kWords && !parameter.words.empty());
    case ValueKind::kWords:
      return parameter.type == ParameterType::kWords;
    case ValueKind::kVector:
      return parameter.type == ParameterType::kVector;
    case ValueKind::kDrawn:
      return parameter.distribution;
    case ValueKind::kDrawnNumber:
      return parameter.grouped && parameter.NamedBlock().empty() && parameter.distribution &&
             parameter.calls.empty() &&
             (parameter.type == ParameterType::kReal || parameter.type == ParameterType::kSwitch);
  }
  return false;
}

/// Not constexpr: a constant expression that calls one of these does not compile, and the error
/// message shows its name.
void NoSuchParameter();
void ParameterHasAnotherKind();

/// A row of the table, of the world or, if `kGrouped`, of a group.
template <bool kGrouped, ValueKind kKind = ValueKind::kAny>
class ParameterRef {
 public:
  /// Implicit, so that `settings.Real("timestep")` can be written.
  consteval ParameterRef(const char* name) {
    while (row_ < kParameters.size() &&
           !(kParameters[row_].grouped == kGrouped && kParameters[row_].name == name))
      ++row_;
    if (row_ == kParameters.size()) NoSuchParameter();
    if (!MayBe(kParameters[row_], kKind)) ParameterHasAnotherKind();
  }
  template <ValueKind kOther>
  requires(kKind == ValueKind::kAny &&
           kOther != ValueKind::kAny) constexpr ParameterRef(ParameterRef<kGrouped, kOther> other)
      : row_(other.row_) {}

  constexpr const Parameter* get() const { return &kParameters[row_]; }
  constexpr const Parameter& operator*() const { return kParameters[row_]; }
  constexpr std::string_view name() const { return kParameters[row_].name; }
  constexpr std::size_t row() const { return row_; }

 private:
  template <bool, ValueKind>
  friend class ParameterRef;

  std::size_t row_ = 0;  // not a pointer: GCC's UBSan refuses to compare those in constants
};

using WorldParameter = ParameterRef<false>;
using GroupParameter = ParameterRef<true>;

}  // namespace cdb::schema
