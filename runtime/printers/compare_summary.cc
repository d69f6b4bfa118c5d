#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "runtime/figures/points.h"
#include "runtime/figures/times.h"
#include "runtime/printers/compare.h"

namespace cdb::printers {
namespace {

using figures::Found;

/// `slower by more than 5 %: sap step; less stable: verdicts`, of the findings that fail, or of the
/// others.
std::string FindingsText(const std::vector<Found>& all, const figures::Gate& gate, bool fails) {
  std::string text;
  for (const Found& found : all)
    if (gate.Fails(found.finding) == fails)
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", gate.TextOf(found.finding),
                          PlacesText(found.what));
  return text;
}

/// `FAIL: slower, memory`, `pass`, `pass (physics)`.
std::string GateCell(const std::vector<Found>& all, const figures::Gate& gate) {
  std::vector<std::string_view> fails, others;
  for (const Found& found : all)
    (gate.Fails(found.finding) ? fails : others).push_back(figures::InfoOf(found.finding).word);
  if (!fails.empty()) return fmt::format("FAIL: {}", fmt::join(fails, ", "));
  return others.empty() ? "pass" : fmt::format("pass ({})", fmt::join(others, ", "));
}

/// The group that changed the most; null if there is none.
std::pair<const figures::TimedGroup*, const figures::TimeChange*> LargestChange(
    const figures::FileComparison& of, const figures::CompareOptions& options) {
  std::pair<const figures::TimedGroup*, const figures::TimeChange*> largest = {nullptr, nullptr};
  double most = -1;
  for (const figures::TimedGroup& group : of.times.groups)
    for (const figures::TimeChange& change : group.phases) {
      const double size = std::fabs(std::log(JudgementOf(change, options).tested.ratio));
      if (change.phase != of.times.common_phase || !(size > most)) continue;
      most = size;
      largest = {&group, &change};
    }
  return largest;
}

std::string StateCell(const figures::StateComparison& states) {
  if (!states.other.empty()) return "DIFFERS";
  if (!states.unsettled.empty()) return "not repeatable";
  return states.same > 0 ? "same" : "-";
}

/// `exploded` of `exploded from cycle 3 on`.
std::string WordOf(const std::string& ending) { return ending.substr(0, ending.find(' ')); }

/// The largest change of the facts of a kind: `stable -> exploded`.
std::string FactCell(const figures::FileComparison& of, figures::FactComparison::Kind kind) {
  bool has_any = false;
  const figures::FactChange* most = nullptr;
  std::string name;
  for (const figures::FactComparison& fact : of.facts) {
    if (fact.kind != kind) continue;
    has_any = true;
    for (const figures::FactChange& change : fact.changes) {
      if (change.direction == figures::Direction::kOther) continue;
      const bool is_worse = change.direction == figures::Direction::kWorse;
      if (most != nullptr && (most->direction == figures::Direction::kWorse || !is_worse)) continue;
      most = &change;
      name = kind == figures::FactComparison::Kind::kMemory
                 ? fact.name.substr(0, fact.name.find(' ')) + " "
                 : "";
    }
  }
  if (most == nullptr) return has_any ? "same" : "-";
  return std::isfinite(most->RelativeChange())
             ? fmt::format("{}{:+.3g} %", name, 100 * most->RelativeChange())
             : fmt::format("{}{} -> {}", name, WordOf(most->text_a), WordOf(most->text_b));
}

std::vector<std::string> SummaryRow(const figures::BenchmarkHistory& benchmark,
                                    const figures::CompareOptions& options) {
  const figures::FileComparison& of = benchmark.Whole();
  std::vector<std::string> row = {benchmark.files[0]->file.benchmark()};
  if (const auto [group, change] = LargestChange(of, options); change != nullptr) {
    const figures::JudgedChange& judged = JudgementOf(*change, options);
    row.push_back(fmt::format("{}{}", of.times.groups.size() > 1 ? group->name + " " : "",
                              PercentText(judged.tested.ratio)));
    row.push_back(PercentRange(judged.tested.interval.low, judged.tested.interval.high));
    row.push_back(VerdictText(judged));
  } else {
    row.insert(row.end(), 3, "-");
  }
  row.push_back(StateCell(of.states));
  row.push_back(FactCell(of, figures::FactComparison::Kind::kVerdict));
  row.push_back(FactCell(of, figures::FactComparison::Kind::kMemory));
  row.push_back(GateCell(figures::FindingsOf(of, options), options.gate));
  return row;
}

/// A row for each benchmark.
Section Summary(const figures::Comparisons& comparisons, const figures::CompareOptions& options) {
  Section summary = {"Summary", {Headline(comparisons, options)}};
  const std::string phase =
      comparisons.benchmarks.empty()
          ? "step"
          : figures::PhaseName(comparisons.benchmarks[0].Whole().times.common_phase);
  for (const std::string& head :
       {std::string("benchmark"), phase, std::string("95 % interval"), std::string("time"),
        std::string("last state"), std::string("verdicts"), std::string("memory"),
        std::string("gate")})
    summary.table.AddColumn(head, false);
  for (const figures::BenchmarkHistory& benchmark : comparisons.benchmarks)
    summary.table.rows.push_back(SummaryRow(benchmark, options));
  const auto add = [&](const std::string& name, const std::string& gate) {
    summary.table.rows.push_back({name, "-", "-", "-", "-", "-", "-", gate});
  };
  for (const figures::UnlikeBenchmark& of : comparisons.unlike)
    add(of.name, fmt::format("FAIL: {}", figures::InfoOf(figures::Finding::kScenes).word));
  const Found missing = {figures::Finding::kMissing, {}};
  for (const std::string& file : comparisons.unmatched)
    add(file, std::ranges::count(comparisons.missing, file) > 0 ? GateCell({missing}, options.gate)
                                                                : "pass (new)");
  return summary;
}

/// What was not compared.
Document Uncompared(const figures::Comparisons& comparisons) {
  Document document;
  if (!comparisons.unmatched.empty())
    document.push_back(
        {.title = "Not compared, because not in all folders", .lines = comparisons.unmatched});
  if (comparisons.unlike.empty()) return document;
  Section scenes = {"Not compared, because of other scenes"};
  scenes.table.columns = {{"benchmark", false}, {"parameter", false}};
  scenes.table.keys = 2;
  for (const std::string& name : comparisons.names) scenes.table.AddColumn(name, false);
  for (const figures::UnlikeBenchmark& of : comparisons.unlike) {
    if (of.differences.empty()) scenes.lines.push_back(of.name + ": " + of.why);
    for (const figures::SetupDifference& difference : of.differences)
      scenes.table.rows.push_back({of.name, difference.name, difference.a, difference.b});
  }
  if (comparisons.IsHistory()) {
    // The differences are between two of the files, which the sentence names.
    scenes.table.rows.clear();
    scenes.lines.clear();
    for (const figures::UnlikeBenchmark& of : comparisons.unlike)
      scenes.lines.push_back(of.name + ": " + of.why);
  }
  scenes.notes = {
      "A change could be due to the scenes. Run the same scenario for both; --allow "
      "scenes compares them nevertheless."};
  document.push_back(std::move(scenes));
  return document;
}

std::string InHtml(std::string_view text) {
  std::string escaped;
  for (const char c : text)
    escaped += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return escaped;
}

std::string Folded(const std::string& summary, const Document& document) {
  return fmt::format("\n<details>\n<summary>{}</summary>\n\n{}\n</details>\n", InHtml(summary),
                     TextOf(document, Format::kMarkdown));
}

}  // namespace

std::string LimitText(const figures::CompareOptions& options) {
  std::string text = fmt::format("{:g} %", 100 * options.gate.LimitOf(figures::Finding::kSlower));
  for (const figures::FindingInfo& info : figures::Findings())
    if (const double limit = options.gate.LimitOf(info.finding);
        info.has_limit && limit != options.gate.LimitOf(figures::Finding::kSlower))
      text += fmt::format(" ({}: {:g} %)", info.word, 100 * limit);
  return text;
}

std::vector<std::string> GateLines(const figures::FileComparison& comparison,
                                   const figures::CompareOptions& options) {
  const std::vector<Found> all = figures::FindingsOf(comparison, options);
  std::vector<std::string> lines;
  if (const std::string fails = FindingsText(all, options.gate, true); !fails.empty())
    lines.push_back("FAIL (exit status 4): " + fails);
  else
    lines.push_back(
        fmt::format("PASS: nothing is significantly worse by more than {}", LimitText(options)));
  for (const Found& found : all)
    if (const figures::FindingInfo& info = figures::InfoOf(found.finding);
        !options.gate.Fails(found.finding))
      lines.push_back(fmt::format("Does not fail ({} {}): {}: {}",
                                  info.fails ? "--allow" : "unless --fail-if", info.word,
                                  options.gate.TextOf(found.finding), PlacesText(found.what)));
  return lines;
}

std::string Headline(const figures::Comparisons& comparisons,
                     const figures::CompareOptions& options) {
  std::vector<std::string> fails;
  std::map<figures::Finding, std::vector<std::string>> others;
  for (const figures::UnlikeBenchmark& of : comparisons.unlike)
    fails.push_back(of.name + ": other scenes");
  for (const figures::BenchmarkHistory& benchmark : comparisons.benchmarks) {
    const figures::FileComparison& of = benchmark.Whole();
    const std::string& name = benchmark.files[0]->file.benchmark();
    const std::vector<Found> all = figures::FindingsOf(of, options);
    if (std::string text = FindingsText(all, options.gate, true); !text.empty())
      fails.push_back(name + ": " + std::move(text));
    for (const Found& found : all)
      if (!options.gate.Fails(found.finding))
        others[found.finding].push_back(found.finding == figures::Finding::kUnsure &&
                                                !of.setup.doubt.empty()
                                            ? fmt::format("{} ({})", name, of.setup.doubt)
                                            : name);
  }
  for (const std::string& file : comparisons.missing)
    if (options.gate.Fails(figures::Finding::kMissing))
      fails.push_back("missing: " + file);
    else
      others[figures::Finding::kMissing].push_back(file);
  if (!fails.empty())
    return fmt::format("FAIL (exit status {}): {}", comparisons.unlike.empty() ? 4 : 5,
                       PlacesText(fails));
  std::string text =
      fmt::format("PASS: nothing is significantly worse by more than {}", LimitText(options));
  for (const auto& [finding, names] : others)
    text += fmt::format("; {}: {}", options.gate.TextOf(finding), fmt::join(names, ", "));
  return text;
}

Document SharedSections(const figures::Comparisons& comparisons,
                        const figures::CompareOptions& options) {
  Document document = Uncompared(comparisons);
  if (comparisons.IsHistory())
    std::ranges::move(HistoryDocument(comparisons, options), std::back_inserter(document));
  const std::size_t count =
      comparisons.benchmarks.size() + comparisons.unlike.size() + comparisons.unmatched.size();
  if (count > 1 || comparisons.benchmarks.empty())
    document.push_back(Summary(comparisons, options));
  return document;
}

Document AllDocument(const figures::Comparisons& comparisons,
                     const figures::CompareOptions& options) {
  Document document;
  if (!comparisons.IsHistory())
    for (const figures::BenchmarkHistory& benchmark : comparisons.benchmarks)
      std::ranges::move(CompareDocument(benchmark.steps[0], options), std::back_inserter(document));
  std::ranges::move(SharedSections(comparisons, options), std::back_inserter(document));
  return document;
}

std::string PullRequestText(const figures::Comparisons& comparisons,
                            const figures::CompareOptions& options) {
  Section summary = Summary(comparisons, options);
  summary.title = std::move(summary.lines[0]);
  summary.lines.clear();
  std::string text = TextOf({summary}, Format::kMarkdown);
  Document uncompared = Uncompared(comparisons);
  if (comparisons.IsHistory()) {
    Document history = HistoryDocument(comparisons, options);
    if (!history.empty()) text += Folded("History", history);
  } else {
    for (const figures::BenchmarkHistory& benchmark : comparisons.benchmarks)
      text += Folded(benchmark.files[0]->file.benchmark() + ": all numbers",
                     CompareDocument(benchmark.steps[0], options));
  }
  if (!uncompared.empty()) text += "\n" + TextOf(uncompared, Format::kMarkdown);
  return text;
}

}  // namespace cdb::printers
