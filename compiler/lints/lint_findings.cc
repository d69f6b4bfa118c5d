#include "compiler/lints/lint_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace cdb::lints {

void LintFindings::Add(configure::Configuration& configuration, const plan::Scene& scene,
                       std::size_t runs) {
  const FactReaders read{[&](const schema::Call& path, analysis::PoseFault& why) {
                           return configuration.scenario().PosesAt(path, why);
                         },
                         [&](const schema::Value& type, analysis::ModelFault& why) {
                           return configuration.scenario().ModelAt(type, why);
                         }};
  for (const LintNumber& number : LintScene(scene, read)) {
    if (!number.IsDoubtful()) continue;
    const auto [at, is_first] = findings_.try_emplace(number.lint);
    Finding& finding = at->second;
    finding.runs += runs;
    if (number.IsBad()) finding.bad_runs += runs;
    if (!is_first && !number.IsWorseThan(finding.worst)) continue;
    finding.worst = number;
    finding.span = SpanOf(configuration, scene.groups[number.group].name, number.lint);
  }
}

// The location of the first parameter at fault that the benchmark sets, else of its name.
text::Span LintFindings::SpanOf(configure::Configuration& configuration, const std::string& group,
                                Lint lint) const {
  std::string_view names = InfoOf(lint).about;
  while (!names.empty()) {
    const std::string_view name = names.substr(0, names.find(' '));
    names.remove_prefix(std::min(names.size(), name.size() + 1));
    const schema::Parameter* of_world = schema::FindParameter(name, false);
    const scenario::ParameterKey key =
        of_world != nullptr ? scenario::ParameterKey{"", of_world}
                            : scenario::ParameterKey{group, schema::FindParameter(name, true)};
    if (configuration.IsSet(key)) return configuration.SpanOf(key, {});
  }
  return benchmark_;
}

void LintFindings::Report(std::size_t looked_at, std::size_t runs) const {
  for (const auto& [lint, finding] : findings_) {
    std::string where;
    if (runs > 1) {
      where = "; in " + CountText(finding.runs, looked_at, runs);
      if (finding.bad_runs > 0 && finding.bad_runs < finding.runs)
        where += fmt::format(", beyond the limit in {}", finding.bad_runs);
    }
    diagnostics_.Report(InfoOf(lint).kind, finding.span, LintMessage(finding.worst) + where,
                        LintRemedy(finding.worst));
  }
}

std::string CountText(std::size_t count, std::size_t looked_at, std::size_t runs) {
  return looked_at == runs
             ? fmt::format("{} of {} runs", count, runs)
             : fmt::format("{} of the {} runs that were checked, of {}", count, looked_at, runs);
}

}  // namespace cdb::lints
