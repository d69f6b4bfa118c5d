// What the lints say of a scene before its run, and what the verdict says after it.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/lints/lints.h"
#include "compiler/plan/plan.h"
#include "runtime/protocol/verdict.h"

namespace cdb::tests {

/// The prediction of the lints for a scene, by its worst number.
enum Prediction { kSound, kDoubtful, kBad };

struct Foresight {
  std::vector<lints::LintNumber> numbers;
  protocol::Verdict verdict = protocol::Verdict::kUnknown;

  Prediction prediction() const;
  bool is_stable() const { return verdict == protocol::Verdict::kStable; }
  /// The verdict and the numbers that are not negligible, with their parts of the limit.
  std::string Text() const;
};

/// Runs the scene in this process; nullopt, and the reason, if it is rejected when it is placed or
/// built. The scene must record stability and be in the engine's precision.
std::optional<Foresight> Foresee(const plan::Scene& scene, std::string* why = nullptr);

/// Runs by prediction and by whether they were stable.
struct Confusion {
  std::array<std::array<int, 2>, 3> runs = {};
  double Agreement(Prediction prediction, bool stable) const;
};

/// Confusions by a name, such as the theme of a scene, and by lint.
class ConfusionTable {
 public:
  void Add(const std::string& name, const Foresight& foresight);
  const Confusion& all() const { return all_; }
  /// Rows of both.
  std::string Text() const;

 private:
  Confusion all_;
  std::map<std::string, Confusion> names_;
  std::map<lints::Lint, Confusion> lints_;  ///< of runs that the lint warns of
};

}  // namespace cdb::tests
