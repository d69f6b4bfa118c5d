#include "runtime/printers/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "runtime/figures/model.h"
#include "runtime/figures/points.h"
#include "runtime/printers/show.h"
#include "runtime/protocol/machine/noise.h"
#include "runtime/protocol/recording.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

/// Breaks a line at spaces; continuation lines are indented by four more.
std::string Wrapped(const std::string& line) {
  const std::string indent = "  ";
  std::string text, current = indent;
  std::istringstream words(line);
  bool is_first = true;
  for (std::string word; words >> word; is_first = false) {
    if (!is_first && current.size() + 1 + word.size() > kLineWidth) {
      text += current + "\n";
      current = indent + "    " + word;
    } else {
      current += (is_first ? "" : " ") + word;
    }
  }
  return text + current + "\n";
}

/// The line without leading spaces; `is_part` if it had some.
std::string_view Stripped(std::string_view line, bool& is_part) {
  is_part = line.starts_with(' ');
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  return line;
}

class TerminalPrinter {
 public:
  explicit TerminalPrinter(bool is_wrapped) : is_wrapped_(is_wrapped) {}

  std::string operator()(const Section& section) const {
    std::string text = section.title.empty() ? "" : section.title + "\n";
    for (const std::string& line : section.lines) text += LineOf(line);
    if (!section.table.rows.empty()) text += TableOf(section.table);
    text += section.plot;
    for (const std::string& note : section.notes) text += LineOf(note);
    return text;
  }

 private:
  std::string LineOf(const std::string& line) const {
    return is_wrapped_ ? Wrapped(line) : "  " + line + "\n";
  }
  static std::string TableOf(const Table& of) {
    terminal::Table table(of.keys);
    for (const Table::Column& column : of.columns)
      table.AddColumn(column.head, column.is_number, column.group);
    for (const auto& row : of.rows) table.AddRow(row);
    return table.Text();
  }

  const bool is_wrapped_;
};

/// Puts `\` before each of `characters`.
std::string Escaped(std::string_view text, std::string_view characters) {
  std::string escaped;
  for (const char c : text) {
    if (characters.find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string InMarkdown(std::string_view text) { return Escaped(text, "|*_`<>[]\\"); }

std::string MarkdownTable(const Table& of) {
  std::string heads = "|", rules = "|", rows;
  for (const Table::Column& column : of.columns) {
    heads +=
        fmt::format(" {} |", InMarkdown(column.group.empty()
                                            ? column.head
                                            : fmt::format("{} ({})", column.head, column.group)));
    rules += column.is_number ? " ---: |" : " --- |";
  }
  for (const auto& row : of.rows) {
    rows += "|";
    for (std::size_t i = 0; i < of.columns.size(); ++i)
      rows += fmt::format(" {} |", i < row.size() ? InMarkdown(row[i]) : "");
    rows += "\n";
  }
  return heads + "\n" + rules + "\n" + rows;
}

std::string MarkdownSection(const Section& section) {
  std::string text;
  const auto add = [&](const std::string& part) {
    if (!part.empty()) text += (text.empty() ? "" : "\n") + part;
  };
  if (!section.title.empty()) add(fmt::format("### {}\n", InMarkdown(section.title)));
  std::string lines;
  bool is_part = false;
  for (const std::string& line : section.lines) {
    const std::string_view stripped = Stripped(line, is_part);
    lines += fmt::format("{}- {}\n", is_part ? "  " : "", InMarkdown(stripped));
  }
  add(lines);
  if (!section.table.rows.empty()) add(MarkdownTable(section.table));
  if (!section.plot.empty()) add("```\n" + section.plot + "```\n");
  for (const std::string& note : section.notes) add(InMarkdown(Stripped(note, is_part)) + "\n");
  return text;
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// The length of the exponent at `at`, as in `1.2e-06`; 0 if there is none.
std::size_t ExponentLength(std::string_view text, std::size_t at) {
  if (at == 0 || text[at] != 'e' || !IsDigit(text[at - 1])) return 0;
  std::size_t end = at + 1;
  if (end < text.size() && (text[end] == '-' || text[end] == '+')) ++end;
  const std::size_t digits = end;
  while (end < text.size() && IsDigit(text[end])) ++end;
  return digits > at + 1 && end > digits ? end - at : 0;
}

std::string InLatex(std::string_view text) {
  std::string escaped;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (const std::size_t length = ExponentLength(text, i); length > 0) {
      const int exponent = std::stoi(std::string(text.substr(i + 1, length - 1)));
      escaped += fmt::format("$\\times10^{{{}}}$", exponent);
      i += length - 1;
    } else if (c == '\\')
      escaped += "\\textbackslash{}";
    else if (c == '~' || c == '^')
      escaped += fmt::format("\\{}{{}}", c);
    else if (c == '<' || c == '>' || c == '|')
      escaped += fmt::format("${}$", c);
    else
      escaped += Escaped(std::string_view(&c, 1), "&%$#_{}");
  }
  // A range.
  for (std::size_t at = 0; (at = escaped.find(" .. ", at)) != escaped.npos;)
    escaped.replace(at, 4, "--");
  return escaped;
}

/// The line above the heads, with a rule below each group; empty if there are no groups.
std::string LatexGroups(const std::vector<Table::Column>& columns) {
  std::string heads, rules;
  for (std::size_t begin = 0, end = 0; begin < columns.size(); begin = end) {
    const std::string& group = columns[begin].group;
    for (end = begin + 1; end < columns.size() && columns[end].group == group;) ++end;
    heads += begin == 0 ? "" : " & ";
    if (group.empty()) {
      heads.append(end - begin - 1, '&');
      continue;
    }
    heads += fmt::format("\\multicolumn{{{}}}{{c}}{{{}}}", end - begin, InLatex(group));
    rules += fmt::format("\\cmidrule(lr){{{}-{}}}\n", begin + 1, end);
  }
  return rules.empty() ? rules : heads + " \\\\\n" + rules;
}

std::string LatexTable(const Table& of) {
  std::string text = "\\begin{tabular}{";
  for (const Table::Column& column : of.columns) text += column.is_number ? 'r' : 'l';
  text += "}\n\\toprule\n" + LatexGroups(of.columns);
  const auto add_row = [&](auto cell_of) {
    for (std::size_t i = 0; i < of.columns.size(); ++i)
      text += (i == 0 ? "" : " & ") + InLatex(cell_of(i));
    text += " \\\\\n";
  };
  add_row([&](std::size_t i) { return of.columns[i].head; });
  text += "\\midrule\n";
  for (const auto& row : of.rows)
    add_row([&](std::size_t i) { return i < row.size() ? row[i] : std::string(); });
  return text + "\\bottomrule\n\\end{tabular}\n";
}

/// Sentences that are not of a table are comments, so that the text can be included anywhere.
std::string LatexSection(const Section& section) {
  std::string text;
  const auto comment = [&](const std::string& line) { text += "% " + line + "\n"; };
  if (!section.title.empty()) comment(section.title);
  for (const std::string& line : section.lines) comment(line);
  if (!section.table.rows.empty()) text += LatexTable(section.table);
  std::istringstream plot(section.plot);
  for (std::string line; std::getline(plot, line);) comment(line);
  for (const std::string& note : section.notes) comment(note);
  return text;
}

template <typename Printer>
std::string Joined(const Document& document, Printer printer) {
  std::string text;
  for (const Section& section : document) text += (text.empty() ? "" : "\n") + printer(section);
  return text;
}

}  // namespace

std::string TextOf(const Document& document, Format format) {
  switch (format) {
    case Format::kMarkdown:
      return Joined(document, MarkdownSection);
    case Format::kLatex:
      return Joined(document, LatexSection);
    case Format::kTerminal:
    case Format::kWrapped:
      break;
  }
  return Joined(document, TerminalPrinter(format == Format::kWrapped));
}

std::string EscapedText(std::string_view text, Format format) {
  return format == Format::kLatex      ? InLatex(text)
         : format == Format::kMarkdown ? InMarkdown(text)
                                       : std::string(text);
}

std::string CsvField(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

std::string CsvOf(const Table& table) {
  std::string text;
  const auto add_line = [&](const auto& cells, auto text_of) {
    for (std::size_t i = 0; i < cells.size(); ++i)
      text += (i == 0 ? "" : ",") + CsvField(text_of(cells[i]));
    text += '\n';
  };
  add_line(table.columns, [](const Table::Column& column) { return column.head; });
  for (const auto& row : table.rows) add_line(row, [](const std::string& cell) { return cell; });
  return text;
}

using figures::Cell;

std::string NoiseNote(const results::ResultFile& file, const std::vector<Cell>& cells) {
  if (!file.Has("noise") || !file.Has("noise_cause") || !file.Has("cpu_time")) return {};
  std::size_t noisy = 0;
  const Cell* worst = nullptr;
  double least_share = std::numeric_limits<double>::infinity();
  for (const Cell& cell : cells) {
    if (!figures::IsNoisy(file, cell)) continue;
    ++noisy;
    const double share = file.ReadReal("cpu_time", cell) / file.ReadReal("cycles_time", cell);
    if (worst != nullptr && !(share < least_share)) continue;
    least_share = share;
    worst = &cell;
  }
  if (worst == nullptr) return {};
  const std::string cause = file.ReadText("noise_cause", *worst);
  if (cells.size() == 1) return fmt::format("The machine was noisy: {} (cdb doc noise).", cause);
  return fmt::format("The machine was noisy in {}; worst in {}: {} (cdb doc noise).",
                     RunsText(noisy, cells.size()), figures::PlaceText(file, *worst), cause);
}

std::string RunsText(std::size_t count, std::size_t of) {
  if (of == 1) return "the only run";
  return count == of ? fmt::format("all {} runs", of) : fmt::format("{} of {} runs", count, of);
}

std::vector<std::string> ProcessorNotes(const results::ResultFile& file,
                                        const std::vector<Cell>& cells) {
  std::map<std::string, std::size_t> runs;
  std::map<figures::Point, std::set<std::string>> kinds;  // keyed by points without their detector
  const auto detector = figures::DetectorAxis(file);
  for (const Cell& cell : cells) {
    if (figures::EndingOf(file, cell).Rank() < 0) continue;
    std::string kind = file.ReadProvenance("cpu", cell);
    if (kind.empty()) kind = "a processor without a name";
    ++runs[kind];
    kinds[detector ? figures::Without(cell.at, *detector) : cell.at].insert(std::move(kind));
  }
  if (runs.size() < 2) return {};
  std::vector<std::string> notes = {
      "Run on different processors, whose times are not comparable (cdb doc cluster):"};
  for (const auto& [kind, count] : runs)
    notes.push_back(fmt::format("  {} run{} on {}", count, count == 1 ? "" : "s", kind));
  const auto mixed = static_cast<std::size_t>(
      std::ranges::count_if(kinds, [](const auto& point) { return point.second.size() > 1; }));
  if (mixed > 0)
    notes.push_back(fmt::format(
        "  At {} of {} points, detectors or repeats ran on several of them.", mixed, kinds.size()));
  return notes;
}

std::string HarnessNote(const figures::Model& model) {
  const auto cost = figures::HarnessCostOf(model);
  if (!cost) return {};
  std::string text =
      fmt::format("Measurement overhead: {} ns per cycle", terminal::ShortNumber(cost->median));
  if (const auto& fastest = cost->fastest)
    text += fmt::format(", {} % of the detection of {}{}",
                        terminal::ShortNumber(100 * cost->median / fastest->time),
                        fastest->detector.empty() ? "the detector" : fastest->detector,
                        fastest->is_only ? "" : ", the fastest");
  return text + "; not subtracted.";
}

std::string BuildNote(const results::ResultFile& file) {
  const std::string build = file.ReadProvenance("build_type");
  if (build == "Release") return {};
  return fmt::format("Timed with a {} build of cdb: do not quote these timings.", build);
}

std::string JobsNote(const results::ResultFile& file) {
  const std::string jobs = file.ReadProvenance("jobs");
  if (jobs.empty() || jobs == "1") return {};
  return fmt::format("Timed with parallel runs (jobs {}), which disturb each other.", jobs);
}

namespace {

/// The fault of a phase, the worst first. Bullet's narrow phase is no detector's fault.
enum class Fault { kMisses, kFails, kBullet, kNone };

std::string ErrorText(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.1e}", value);
}

/// `0` only if something was compared.
std::string MissedText(std::uint64_t missed, std::uint64_t compared) {
  return compared > 0 ? fmt::format("{}", missed) : "-";
}

constexpr const char* kNothing = "nothing compared";

/// A row: a detector's broad phase, or a narrow phase.
struct VerifiedPhase {
  Fault fault = Fault::kNone;
  std::vector<std::string> row;
  std::vector<std::string> below = {};  ///< the first occurrence of each fault, and its command
};

class Verified {
 public:
  explicit Verified(const results::ResultFile& file) : file_(file) {
    for (const figures::DetectorFindings& of : figures::FindingsOf(file)) {
      if (of.AllRuns() == 0) continue;
      phases_.push_back(BroadPhase(of));
      if (of.failed_runs == 0 && of.runs > 0) exact_.insert(of.exact);
      if (of.failed_runs == 0 && of.collisions) collisions_ = std::max(collisions_, of.collisions);
    }
    std::ranges::stable_sort(phases_, {}, &VerifiedPhase::fault);
    std::vector<VerifiedPhase> narrow;
    for (const figures::ContactFindings& of : figures::ContactFindingsOf(file)) {
      narrow.push_back(NarrowPhase(of));
      uncompared_ += of.uncompared;
    }
    std::ranges::stable_sort(narrow, {}, &VerifiedPhase::fault);
    phases_.insert(phases_.end(), narrow.begin(), narrow.end());
  }

  bool IsGood() const {
    return std::ranges::all_of(phases_, [](const VerifiedPhase& of) {
      return of.fault == Fault::kNone || of.fault == Fault::kBullet;
    });
  }

  Document Made(const std::vector<std::string>& left_out) const {
    Section section = {.title = file_.title()}, below;
    Table& table = section.table;
    table.AddColumn("detector", false);
    table.AddColumn("phase", false);
    for (const char* head : {"points", "cycles", "compared", "missed", "phantom", "duplicate",
                             "depth error", "normal error"})
      table.AddColumn(head, true);
    table.AddColumn("verdict", false);
    for (const VerifiedPhase& of : phases_) {
      table.rows.push_back(of.row);
      below.lines.insert(below.lines.end(), of.below.begin(), of.below.end());
    }
    if (std::ranges::count(phases_, Fault::kBullet, &VerifiedPhase::fault) > 0)
      below.lines.emplace_back(
          "bullet: for detectors that only find pairs, Bullet makes the contacts. The contacts "
          "that "
          "it misses do not count against a detector.");
    if (exact_.size() > 1)
      below.lines.emplace_back(
          "The numbers of pairs differ: each detector is judged by the boxes that it was given. "
          "Those of planes are infinite for Bullet's own, unless wall_pairs is omitted, and "
          "half-spaces for the others, and other motion makes other pairs (cdb doc detectors).");
    if (uncompared_ > 0)
      below.lines.push_back(fmt::format(
          "Not compared: {} possible overlaps, whose exact depth is not proven or which were not "
          "among the {} that are drawn in a cycle.",
          uncompared_, protocol::kMostComparedContacts));
    if (collisions_)
      below.lines.push_back(
          fmt::format("Collisions, by exact arithmetic: {} of the pairs.", *collisions_));
    std::vector<std::string>& last = below.lines.empty() ? section.notes : below.lines;
    for (const std::string& line : left_out) last.push_back(fmt::format("Omitted: {}.", line));
    return below.lines.empty() ? Document{section} : Document{section, below};
  }

 private:
  VerifiedPhase BroadPhase(const figures::DetectorFindings& of) const {
    VerifiedPhase phase;
    const auto found = of.exact + of.false_positives + of.duplicate;
    const std::string verdict = [&]() -> std::string {
      phase.fault = of.missed > 0        ? Fault::kMisses
                    : of.failed_runs > 0 ? Fault::kFails
                                         : Fault::kNone;
      if (of.missed > 0) return "wrong: misses pairs";
      if (of.failed_runs > 0) return fmt::format("failed: {} of {}", of.failed_runs, of.AllRuns());
      if (found == 0) return kNothing;
      if (of.duplicate > 0) return "lists pairs twice";
      return of.false_positives > 0 ? "superset" : "exact";
    }();
    // Brute force compares all pairs of a cycle.
    phase.row = {of.detector,
                 "broad",
                 fmt::format("{}", of.AllRuns()),
                 fmt::format("{}", of.cycles),
                 fmt::format("{0} of {0}", of.exact),
                 MissedText(of.missed, of.exact),
                 MissedText(of.false_positives, found),
                 MissedText(of.duplicate, found),
                 "-",
                 "-",
                 verdict};
    AddFirst(of.detector, "misses pairs", of.first_missed, phase);
    if (of.missed_collisions.value_or(0) > 0)
      phase.below.push_back(fmt::format("{} misses {} of {} collisions", of.detector,
                                        *of.missed_collisions, *of.collisions));
    AddFirst(of.detector, "lists pairs twice", of.first_duplicate, phase);
    if (of.first_failed)
      AddBelow(fmt::format("{} {} at {}: {}", of.detector,
                           results::StatusName(file_.ReadStatus(*of.first_failed)),
                           figures::PlaceText(file_, *of.first_failed),
                           file_.ReadText("message", *of.first_failed)),
               *of.first_failed, phase);
    return phase;
  }

  VerifiedPhase NarrowPhase(const figures::ContactFindings& of) const {
    VerifiedPhase phase;
    const bool is_bullet = of.narrow_phase == figures::kBulletPhase;
    if (of.missed > 0) phase.fault = is_bullet ? Fault::kBullet : Fault::kMisses;
    phase.row = {of.narrow_phase.empty() ? "-" : of.narrow_phase,
                 "narrow",
                 fmt::format("{}", of.runs),
                 fmt::format("{}", of.cycles),
                 fmt::format("{} of {}", of.exact, of.All()),
                 MissedText(of.missed, of.exact),
                 "-",
                 "-",
                 ErrorText(of.depth_error),
                 ErrorText(of.normal_error),
                 of.missed > 0   ? is_bullet ? "Bullet misses contacts" : "wrong: misses contacts"
                 : of.exact == 0 ? kNothing
                                 : "misses none"};
    AddFirst(of.narrow_phase, "misses contacts", of.first_missed, phase);
    return phase;
  }

  void AddBelow(std::string line, const figures::Cell& cell, VerifiedPhase& phase) const {
    phase.below.push_back(std::move(line));
    phase.below.push_back("  " + figures::OnlyCommand(file_, cell));
  }
  void AddFirst(const std::string& name, const char* what,
                const std::optional<figures::Place>& first, VerifiedPhase& phase) const {
    if (!first) return;
    // Of a finished run: the first pair that its detector missed.
    const std::string message = file_.ReadText("message", first->cell);
    AddBelow(
        fmt::format("{} {} from cycle {} on, at {}{}{}", name, what, first->cycle,
                    figures::PlaceText(file_, first->cell), message.empty() ? "" : "\n  ", message),
        first->cell, phase);
  }

  const results::ResultFile& file_;
  std::vector<VerifiedPhase> phases_;
  std::set<std::uint64_t> exact_;  ///< the numbers of exact pairs of the detectors
  std::uint64_t uncompared_ = 0;
  std::optional<std::uint64_t> collisions_;  ///< of the pairs of a deforming mesh
};

}  // namespace

namespace {

/// False if cdb's own tree missed a body or found one where there is none: in queries of a type
/// that Bullet does not answer in the same run.
bool AnswersOfTreeAreGood(const results::ResultFile& file) {
  if (!file.Has("missed_hits")) return true;
  const std::optional<plan::Plan> plan = figures::ReadPlan(file);
  if (!plan) return true;
  return std::ranges::none_of(plan->runs, [&](const plan::Run& run) {
    const results::ResultFile::Cell cell{run.at, run.rep};
    if (file.ReadStatus(cell) != results::Status::kDone) return false;
    const auto is_bullets = [&](std::size_t type) {
      return std::ranges::any_of(run.scene.queries, [&](const plan::Queries& queries) {
        return queries.settings.WordOr("queries.type") == schema::kQueryTypes[type] &&
               queries.settings.WordOr("queries.implementation") == "bullet";
      });
    };
    for (std::size_t type = 0; type < protocol::kQueryTypeCount; ++type) {
      if (is_bullets(type)) continue;
      for (const char* series : {"missed_hits", "false_hits"})
        for (const double count :
             file.ReadOfQueries(series, static_cast<schema::QueryType>(type), cell))
          if (count > 0) return true;
    }
    return false;
  });
}

/// False if cdb's lanes missed a hit or found one where there is none.
bool HitsOfLanesAreGood(const results::ResultFile& file, const figures::Model& model) {
  const std::optional<plan::Plan> plan = figures::ReadPlan(file);
  if (!plan) return true;
  std::set<std::vector<std::size_t>> by_lanes;
  for (const plan::Run& run : plan->runs)
    if (run.scene.world.WordOr("configurations.by") == "lanes")
      by_lanes.emplace(run.at.begin(), run.at.end());
  std::vector<const figures::MeasuredPoint*> points;
  for (const figures::MeasuredPoint& point : model.points()) {
    const auto& at = point.cells[0].at;
    if (by_lanes.contains({at.begin(), at.end()})) points.push_back(&point);
  }
  const ConfigurationFigures sums = ConfigurationFiguresOf(model, points);
  return sums.missed + sums.wrong == 0;
}

}  // namespace

VerifyText VerifyTable(const results::ResultFile& file, const std::vector<std::string>& left_out) {
  const Verified verified(file);
  Document document = verified.Made(left_out);
  const figures::Model model(file, {});
  AddQueries(model, figures::AllAxes(file), document);
  AddConfigurations(model, figures::AllAxes(file), document);
  return {TextOf(document, Format::kTerminal),
          verified.IsGood() && AnswersOfTreeAreGood(file) && HitsOfLanesAreGood(file, model)};
}

namespace {

using plan::Axis;

/// The graded axis; none if no axis has numbers.
std::optional<std::size_t> OwnAxis(const std::vector<Axis>& axes) {
  for (std::size_t i = axes.size(); i-- > 0;)
    if (axes[i].IsScale()) return i;
  return std::nullopt;
}

std::string Range(const Axis& axis, std::size_t begin, std::size_t end) {
  const auto text = [&](std::size_t i) {
    return fmt::format("{:.4g}", std::get<double>(axis.values[i]));
  };
  return end - begin == 1 ? text(begin) : fmt::format("{} .. {}", text(begin), text(end - 1));
}

std::string AlongAxis(const results::ResultFile& file, figures::Point at, std::size_t own) {
  const Axis& axis = file.axes()[own];
  std::string line, before;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= axis.values.size(); ++i) {
    std::string here;
    if (i < axis.values.size()) {
      at[own] = i;
      here = figures::WorstEnding(file, at).Word();
      if (i == 0) before = here;
    }
    if (here == before) continue;
    line += fmt::format("{}{} {}", line.empty() ? "" : " | ", before, Range(axis, begin, i));
    before = std::move(here);
    begin = i;
  }
  return line;
}

}  // namespace

std::string StabilityMap(const results::ResultFile& file) {
  const auto& axes = file.axes();
  const auto own = OwnAxis(axes);
  Section section = {.title = file.title()};
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (i != own) section.table.AddColumn(axes[i].name, !axes[i].IsText());
  section.table.AddColumn(
      own ? axes[*own].name + (axes[*own].unit.empty() ? "" : ", " + axes[*own].unit) : "verdict",
      false);
  for (const figures::Point& at : figures::AllPoints(file)) {
    if (own && at[*own] != 0) continue;
    std::vector<std::string> row;
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (i != own) row.push_back(terminal::CoordinateText(axes[i], at[i]));
    row.push_back(own ? AlongAxis(file, at, *own) : figures::WorstEnding(file, at).Word());
    section.table.rows.push_back(std::move(row));
  }
  return TextOf({section}, Format::kTerminal);
}

}  // namespace cdb::printers
