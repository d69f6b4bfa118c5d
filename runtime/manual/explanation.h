// Every kind of diagnostic with a wrong and a right example: the output of `cdb explain CODE`.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/model.h"
#include "dsl/diagnostics.h"

namespace cdb::manual {

/// A row of the tables. Both examples are whole files: the wrong one has diagnostics of this kind
/// only, the right one has none.
struct Explanation {
  const dsl::DiagnosticKind* kind;
  std::string_view text;
  std::string_view wrong, right;
};

// In the order of their codes. Any thread.
std::span<const Explanation> SyntaxExplanations();
std::span<const Explanation> ScenarioExplanations();
/// The text of a lint is made from its row in compiler/lints/lints.h.
std::span<const Explanation> LintExplanations();
std::vector<const Explanation*> AllExplanations();

/// The text of a file that an example names; nullopt if none does.
std::optional<std::string> ExampleFile(std::string_view path);
/// Replaces the reading of models in the examples.
std::optional<analysis::ModelFacts> ExampleModel(const schema::Value& type,
                                                 analysis::ModelFault& why);

/// By code, in upper or lower case, or by name; several kinds may share a name. Empty if there is
/// none.
std::vector<const Explanation*> FindExplanations(std::string_view wanted);

/// The text `E0201 unknown-name: …`, the reason why it is an error, and both examples. `rendered`:
/// the diagnostics of the wrong example, as `cdb check` prints them.
std::string ExplanationText(const Explanation& explanation, std::string_view rendered);
/// The criterion, the usual causes and the remedies of a verdict, or of `noisy`; empty for other
/// names.
std::string RemedyText(std::string_view name);
std::vector<std::string> RemedyNames();

/// A table of every code.
std::string ExplanationList();

}  // namespace cdb::manual
