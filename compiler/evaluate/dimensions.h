// Whether the units that are written fit: `size 5 kg` does not.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/evaluate/evaluate.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/units.h"

namespace cdb::evaluate {

/// `a length`, `a mass`, `a stiffness`; in SI units where it has no name: `kg m/s`.
std::string DimensionName(const text::Unit& unit);

/// Derives the dimension of expressions from the units written in them, without their values. A
/// number without a unit is in the SI unit of its parameter; beside a number with a unit, in a sum,
/// a vector, a range or a distribution, it is refused. Names of parameters are plain numbers, but
/// for those that are drawn for each object.
class Dimensions {
 public:
  Dimensions(const scenario::Layers& layers, Evaluator& evaluator)
      : layers_(layers), evaluator_(evaluator) {}

  /// Reports the faults of all settings, lets and conditions of the layers; gives the settings that
  /// have one.
  std::set<scenario::ParameterKey> CheckAll();
  void CheckLet(const dsl::Let& let, const scenario::Scope& scope);
  /// False, with a report, if the parts of `expr` do not go together.
  bool Check(const dsl::Expr& expr, const scenario::Scope& scope);

 private:
  enum class Kind {
    kZero,     ///< goes with every unit
    kPure,     ///< numbers without a unit
    kUnit,     ///< a unit is written
    kDrawn,    ///< a setting that is drawn for each object: its unit counts beside a written one
    kUnknown,  ///< a parameter, a word, or faulty
  };
  struct Dimension {
    Kind kind = Kind::kUnknown;
    text::Unit unit = {};
  };
  struct Part {
    Dimension dimension;
    text::Span span;
  };
  using Parts = std::vector<Part>;

  static Dimension Pure() { return {Kind::kPure, {}}; }
  static Dimension Of(const text::Unit& unit) {
    return unit.IsPure() ? Pure() : Dimension{Kind::kUnit, unit};
  }

  Dimension Find(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension FindPath(const dsl::Expr& expr, const scenario::Scope& scope);
  /// The expression is, or names, what is drawn for each object.
  bool IsDrawn(const dsl::Expr& expr, const scenario::Scope& scope);
  bool IsDrawn(const scenario::ParameterKey& key);
  bool NamesDrawn(const dsl::Expr& path, const scenario::Scope& scope);
  Dimension FindBinary(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension FindPower(const dsl::Expr& expr, const Dimension& base, const Dimension& exponent);
  Dimension FindQuantity(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension FindRange(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension FindCall(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension FindFunction(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension FindDrawn(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension FindNormal(const dsl::Expr& expr, const scenario::Scope& scope);
  /// The arguments of a word, each checked by itself.
  void CheckWord(const dsl::Expr& call, const schema::ParametrisedWord& info,
                 const scenario::Scope& scope);
  Parts ArgumentsOf(const dsl::Expr& call, const scenario::Scope& scope);
  Parts ItemsOf(const dsl::Expr& expr, const scenario::Scope& scope, std::size_t count);
  /// What the parts have in common.
  Dimension Join(const Parts& parts);
  static Dimension JoinWithoutUnit(const Parts& parts);
  void RequirePure(const Part& part, const char* what);
  void CheckFor(const schema::Parameter& parameter, std::string_view unit, const dsl::Expr& expr,
                const scenario::Scope& scope);
  void Check(const dsl::Condition& condition, const scenario::Scope& scope);
  /// The unit of one side of a comparison; nullopt if it goes with every number.
  std::optional<text::Unit> SideOf(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension Report(const text::Span& span, std::string message, std::string help = {});

  const scenario::Layers& layers_;
  Evaluator& evaluator_;
  std::map<const dsl::Let*, Dimension> lets_;
  std::map<const void*, bool> drawn_;  ///< lets and settings
  int depth_ = 0;                      ///< of names that lead to one another
  bool is_faulty_ = false;
};

}  // namespace cdb::evaluate
