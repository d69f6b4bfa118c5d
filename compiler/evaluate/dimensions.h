// Checks units: `size 5 kg` is an error.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/value.h"
#include "dsl/text/units.h"

namespace cdb::evaluate {

/// `a length`, `a mass`, `a stiffness`; a dimension without a name in SI units: `kg m/s`.
std::string DimensionName(const text::Unit& unit);

/// Derives the dimensions of expressions from the units written in them, without their values. A
/// number without a unit is in the SI unit of its parameter; beside a number with a unit, in a sum,
/// a vector, a range or a distribution, it is an error. Names of parameters are plain numbers,
/// except those of settings drawn for each object.
class Dimensions {
 public:
  Dimensions(const scenario::Layers& layers, Evaluator& evaluator)
      : layers_(layers), evaluator_(evaluator) {}

  /// Reports the errors of all settings, lets and conditions of the layers. Returns the settings
  /// with errors.
  std::set<scenario::ParameterKey> CheckAll();
  void CheckLet(const dsl::Let& let, const scenario::Scope& scope);
  /// False, with a report, if the units of the parts of `expr` do not match.
  bool Check(const dsl::Expr& expr, const scenario::Scope& scope);
  /// The same, and if `expr` is not of the dimension of `unit`, which `name` has.
  bool CheckFor(std::string_view name, std::string_view unit, const dsl::Expr& expr,
                const scenario::Scope& scope);

 private:
  enum class Kind {
    kZero,     ///< matches every unit
    kPure,     ///< numbers without a unit
    kUnit,     ///< has a written unit
    kDrawn,    ///< a setting drawn for each object: its unit counts beside a written one
    kUnknown,  ///< a parameter, a word, or an error
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
  /// True if the expression is, or names, a value drawn for each object.
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
  /// Checks each argument of a word separately.
  void CheckWord(const dsl::Expr& call, const schema::ParametrisedWord& info,
                 const scenario::Scope& scope);
  Parts ArgumentsOf(const dsl::Expr& call, const scenario::Scope& scope);
  Parts ItemsOf(const dsl::Expr& expr, const scenario::Scope& scope, std::size_t count);
  /// The common dimension of the parts.
  Dimension Join(const Parts& parts);
  static Dimension JoinWithoutUnit(const Parts& parts);
  void RequirePure(const Part& part, const char* what);
  void CheckFor(const schema::Parameter& parameter, std::string_view unit, const dsl::Expr& expr,
                const scenario::Scope& scope);
  /// Reports a written unit that is not of the dimension of `unit`.
  void Require(std::string_view name, std::string_view unit, const Dimension& found,
               const dsl::Expr& expr);
  void Check(const dsl::Condition& condition, const scenario::Scope& scope);
  /// The unit of one side of a comparison; nullopt if it matches every number.
  std::optional<text::Unit> SideOf(const dsl::Expr& expr, const scenario::Scope& scope);
  Dimension Report(const text::Span& span, std::string message, std::string help = {});

  const scenario::Layers& layers_;
  Evaluator& evaluator_;
  std::map<const dsl::Let*, Dimension> lets_;
  std::map<const void*, bool> drawn_;  ///< lets and settings
  int depth_ = 0;                      ///< of names that refer to one another
  bool is_faulty_ = false;
};

// Values with units: `10 ms` is the number 0.01.

class Evaluator;

/// The number in SI units. The shortest decimal text of `number` is scaled exactly and rounded
/// once, so that `10 ms` is the same double as 0.01. A factor of pi or a divisor (km/h) adds one
/// rounding, and an angle in degrees is within an ulp. Not finite if it does not fit.
schema::Number InSi(const schema::Number& number, const text::Unit& unit);

/// `5 cm`, `(1, 2, 3) cm`, `uniform(1, 5) cm`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateQuantity(const dsl::Expr& expr, const scenario::Scope& scope,
                                              Evaluator& evaluator);

}  // namespace cdb::evaluate
