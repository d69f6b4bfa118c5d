#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "runtime/figures/points.h"
#include "runtime/figures/times.h"
#include "runtime/printers/compare.h"
#include "runtime/printers/document.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

std::string PlaceOf(const figures::FileComparison& of, std::size_t point) {
  return of.match.points[point].PlaceText(of.match.axes);
}

constexpr std::size_t kMostPlaces = 6;

class ResultText {
 public:
  ResultText(const figures::FileComparison& comparison, const figures::CompareOptions& options)
      : of_(comparison), options_(options) {}

  std::vector<std::string> ChangedFacts() const {
    std::vector<std::string> lines;
    if (!of_.states.other.empty() || !of_.states.unsettled.empty()) AddStates(lines);
    AddPairs(lines);
    for (const figures::FactComparison& fact : of_.facts) AddFact(lines, fact);
    return lines;
  }

  std::vector<std::string> Results() const {
    std::vector<std::string> lines;
    AddTimes(lines);
    AddStates(lines);
    AddPairs(lines);
    for (const figures::FactComparison& fact : of_.facts) AddFact(lines, fact);
    AddUnchanged(lines);
    for (std::string& line : GateLines(of_, options_)) lines.push_back(std::move(line));
    return lines;
  }

 private:
  double Limit() const { return options_.gate.LimitOf(figures::Finding::kSlower); }
  /// Of percentages, after the point.
  int Digits() const { return of_.times.counts_instructions ? 2 : 1; }

  void AddTimes(std::vector<std::string>& lines) const {
    const figures::TimeComparison& times = of_.times;
    if (times.groups.empty()) {
      lines.push_back("Times: nothing to compare");
    } else {
      AddCommonShift(lines);
      const bool counts = times.counts_instructions;
      AddVerdict(lines, figures::ChangeVerdict::kSlower, counts ? "MORE INSTRUCTIONS" : "SLOWER");
      AddVerdict(lines, figures::ChangeVerdict::kFaster, counts ? "FEWER INSTRUCTIONS" : "FASTER");
      AddSame(lines);
      AddUnknown(lines);
      AddPointCounts(lines);
    }
    if (!times.left_out.empty()) {
      std::vector<std::string> places;
      for (const auto& [point, why] : times.left_out)
        places.push_back(
            of_.match.points.size() > 1 ? fmt::format("{} ({})", PlaceOf(of_, point), why) : why);
      lines.push_back("Times not compared: " + PlacesText(places));
    }
  }

  /// Groups with the phases of that verdict: `grid broad, detect; sweep`, the latter in all phases.
  /// `bound` is raised to the largest bound of their distances from 1.
  std::vector<std::string> GroupsJudged(figures::ChangeVerdict verdict, double& bound) const {
    std::vector<std::string> groups;
    for (const figures::TimedGroup& group : of_.times.groups) {
      std::vector<std::string> phases;
      for (const figures::TimeChange& change : group.phases) {
        const figures::JudgedChange& judged = figures::JudgementOf(change, options_);
        if (judged.verdict != verdict) continue;
        phases.push_back(figures::PhaseName(change.phase));
        if (judged.tested.IsTested()) bound = std::fmax(bound, judged.tested.Bound());
      }
      if (phases.empty()) continue;
      groups.push_back(phases.size() == group.phases.size()
                           ? group.name
                           : fmt::format("{} {}", group.name, fmt::join(phases, ", ")));
    }
    return groups;
  }

  void AddSame(std::vector<std::string>& lines) const {
    double bound = 0;
    const std::vector<std::string> groups = GroupsJudged(figures::ChangeVerdict::kSame, bound);
    if (!groups.empty())
      lines.push_back(
          fmt::format("Same within {:.{}f} %: {}", 100 * bound, Digits(), PlacesText(groups)));
  }

  /// The number of repeats that would do: intervals shrink as 1 / sqrt(repeats), until they are
  /// within the limit, or away from 1.
  std::string RepeatsText(std::uint64_t present) const {
    double factor = 1;
    for (const figures::TimedGroup& group : of_.times.groups)
      for (const figures::TimeChange& change : group.phases) {
        const figures::JudgedChange& judged = figures::JudgementOf(change, options_);
        if (judged.verdict != figures::ChangeVerdict::kCannotTell || !judged.tested.IsTested())
          continue;
        const double distance = std::fabs(judged.tested.ratio - 1),
                     half = (judged.tested.interval.high - judged.tested.interval.low) / 2,
                     room = std::fmax(Limit() - distance, distance - figures::kNegligible);
        factor = std::fmax(factor, room > 0 ? half / room : INFINITY);
      }
    const double repeats = std::ceil(static_cast<double>(present) * factor * factor);
    constexpr double kMost = 1000;
    return repeats > kMost
               ? fmt::format("More than {:g} repeats would tell", kMost)
               : fmt::format("About {:.0f} repeats would tell, in place of {}", repeats, present);
  }

  void AddUnknown(std::vector<std::string>& lines) const {
    double bound = 0;
    const std::vector<std::string> groups =
        GroupsJudged(figures::ChangeVerdict::kCannotTell, bound);
    if (groups.empty()) return;
    const std::uint64_t least = std::min(of_.a->file.begun_repeats(), of_.b->file.begun_repeats());
    std::string why =
        fmt::format("the noise is larger than {:g} %: the ratio may be up to {:.0f} % from 1. {}",
                    100 * Limit(), 100 * bound, RepeatsText(least));
    if (bound == 0) why = "repeats are missing or void";
    if (!of_.times.has_intervals)
      why = fmt::format(
          "there {} {} repeat{}, but an interval needs {} in each file (facts below are exact)",
          least == 1 ? "is" : "are", least, least == 1 ? "" : "s",
          figures::Bootstrap::kLeastForInterval);
    lines.push_back(fmt::format("Cannot tell, as {}: {}", why, PlacesText(groups)));
  }

  void AddCommonShift(std::vector<std::string>& lines) const {
    const figures::TimeComparison& times = of_.times;
    if (!times.HasCommonShift()) return;
    const figures::TestedChange& common = *times.common;
    const std::string phase = figures::PhaseName(times.common_phase);
    std::string line = fmt::format(
        "EVERYTHING is {}: the median {} over all groups is {} ({}). The cause is the machine, or "
        "shared code",
        times.counts_instructions ? (common.ratio > 1 ? "more work" : "less work")
                                  : (common.ratio > 1 ? "slower" : "faster"),
        phase, PercentText(common.ratio), PercentRange(common.interval.low, common.interval.high));
    if (times.harness && times.harness->IsTested())
      line += fmt::format("; cdb's own overhead, which no detector changes, is {} ({})",
                          PercentText(times.harness->ratio),
                          PercentRange(times.harness->interval.low, times.harness->interval.high));
    lines.push_back(line);
    lines.push_back(
        options_.is_relative
            ? "Below, each group relative to that median"
            : "The column `relative` has each group over that median; --relative judges by it");
  }

  /// `SLOWER: grid: detect +5.2 % (+4.6 .. +5.8 %), step …`.
  void AddVerdict(std::vector<std::string>& lines, figures::ChangeVerdict verdict,
                  const char* name) const {
    for (const figures::TimedGroup& group : of_.times.groups) {
      std::string phases;
      for (const figures::TimeChange& change : group.phases) {
        const figures::JudgedChange& judged = figures::JudgementOf(change, options_);
        if (judged.verdict == verdict)
          phases += fmt::format(
              "{}{} {} ({})", phases.empty() ? "" : ", ", figures::PhaseName(change.phase),
              PercentText(judged.tested.ratio, Digits()),
              PercentRange(judged.tested.interval.low, judged.tested.interval.high, Digits()));
      }
      const std::string but = verdict == figures::ChangeVerdict::kSlower && !of_.setup.doubt.empty()
                                  ? ", but " + of_.setup.doubt
                                  : "";
      if (!phases.empty())
        lines.push_back(fmt::format("{}{}: {}: {}", name, but, group.name, phases));
    }
  }

  /// Counts the points that changed in groups that did not.
  void AddPointCounts(std::vector<std::string>& lines) const {
    if (of_.times.points.size() == of_.times.groups.size()) return;
    std::size_t tests = 0, slower = 0, faster = 0;
    for (const figures::TimedPoint& point : of_.times.points)
      for (const figures::TimeChange& change : point.phases) {
        tests += change.absolute.tested.IsTested() ? 1 : 0;
        slower += change.absolute.verdict == figures::ChangeVerdict::kSlower ? 1 : 0;
        faster += change.absolute.verdict == figures::ChangeVerdict::kFaster ? 1 : 0;
      }
    if (tests > 0)
      lines.push_back(
          fmt::format("Single points: {} slower and {} faster, of {} tests (points times phases)",
                      slower, faster, tests));
  }

  void AddStates(std::vector<std::string>& lines) const {
    const figures::StateComparison& states = of_.states;
    const std::size_t known = of_.match.points.size() - states.unknown;
    if (known == 0) return;
    if (states.same == known) {
      const std::size_t points = of_.match.points.size();
      lines.push_back(fmt::format(
          "{}{}{}{}",
          states.of_pairs ? "Pairs: the same in the last cycle" : "Physics: the same last state",
          points > 1 ? fmt::format(" at {} of {}", states.same, Counted(points, "point")) : "",
          states.of_pairs ? "" : ", to the last bit",
          states.unknown > 0 ? "; at the others, a run did not reach its end" : ""));
      return;
    }
    std::vector<std::string> other, unsettled;
    for (const std::size_t point : states.other) other.push_back(PlaceOf(of_, point));
    for (const std::size_t point : states.unsettled) unsettled.push_back(PlaceOf(of_, point));
    const bool is_one = of_.match.points.size() == 1;
    if (!other.empty()) {
      const char *head = states.of_pairs ? "PAIRS DIFFER: other pairs in the last cycle"
                                         : "PHYSICS DIFFERS: another last state",
                 *what = states.of_pairs ? "other pairs" : "another motion";
      lines.push_back(is_one ? fmt::format("{}, and times of {}", head, what)
                             : fmt::format("{} at {} of {}, whose times are of {}: {}", head,
                                           other.size(), Counted(known, "point"), what,
                                           PlacesText(other)));
    }
    if (!unsettled.empty())
      lines.push_back(fmt::format("NOT REPEATABLE: repeats in one file end in different states{}",
                                  is_one ? "" : ": " + PlacesText(unsettled)));
  }

  /// Other numbers of pairs of the same motion, and whether any pairs were compared with exact
  /// ones.
  void AddPairs(std::vector<std::string>& lines) const {
    const std::vector<std::size_t> points = of_.OtherPairs();
    if (points.empty()) return;
    const auto pairs = std::ranges::find(of_.facts, "pairs", &figures::FactComparison::name);
    if (pairs != of_.facts.end()) {
      const auto most = std::ranges::find_if(pairs->changes, [&](const auto& change) {
        return std::ranges::count(points, change.point) > 0;
      });
      if (most != pairs->changes.end())
        lines.push_back(fmt::format(
            "OTHER NUMBERS OF PAIRS{}: {}",
            of_.match.points.size() > 1
                ? fmt::format(" at {} of {}, the most: {}", points.size(),
                              Counted(pairs->points, "point"), PlaceOf(of_, most->point))
                : "",
            ChangeText(*most)));
    }
    if (!of_.HasExactPairs())
      lines.push_back(
          "Pairs not compared with exact ones, so a missed pair would not be found: both files "
          "need `record pairs`");
  }

  static const char* HeadOf(figures::FactComparison::Kind kind, figures::Direction direction) {
    const bool is_worse = direction == figures::Direction::kWorse;
    switch (kind) {
      case figures::FactComparison::Kind::kVerdict:
        return is_worse ? "LESS STABLE" : "MORE STABLE";
      case figures::FactComparison::Kind::kError:
      case figures::FactComparison::Kind::kPairs:
        return is_worse ? "LESS TRUE" : "MORE TRUE";
      default:
        return is_worse ? "MORE MEMORY" : "LESS MEMORY";
    }
  }

  void AddFact(std::vector<std::string>& lines, const figures::FactComparison& fact) const {
    for (const figures::Direction direction :
         {figures::Direction::kWorse, figures::Direction::kBetter}) {
      const std::size_t count = fact.Count(direction);
      if (count == 0) continue;
      const auto most = std::ranges::find(fact.changes, direction, &figures::FactChange::direction);
      std::string places;
      if (of_.match.points.size() > 1)
        places = fmt::format(" at {} of {}{}: {}", count, Counted(fact.points, "point"),
                             count > 1 ? ", the most" : "", PlaceOf(of_, most->point));
      lines.push_back(fmt::format("{}: {}{}: {}", HeadOf(fact.kind, direction), fact.name, places,
                                  ChangeText(*most)));
    }
  }

  void AddUnchanged(std::vector<std::string>& lines) const {
    std::vector<std::string> names;
    for (const figures::FactComparison& fact : of_.facts)
      if (fact.changes.empty()) names.push_back(fact.name);
    if (!names.empty()) lines.push_back(fmt::format("Unchanged: {}", fmt::join(names, ", ")));
  }

  const figures::FileComparison& of_;
  const figures::CompareOptions options_;
};

constexpr std::size_t kMostPoints = 24;

class ComparisonText {
 public:
  ComparisonText(const figures::FileComparison& comparison, const figures::CompareOptions& options)
      : of_(comparison), options_(options), a_(comparison.a->name), b_(comparison.b->name) {}

  Document Sections() const {
    Document document = {Head(), {"Result", ResultLines(of_, options_)}};
    for (Section section :
         {BoundaryChanges(of_.a->file, of_.b->file), Facts(false), Facts(true), Groups(), Points()})
      if (!section.table.rows.empty()) document.push_back(std::move(section));
    return document;
  }

 private:
  /// Facts that a reader must know before any figure.
  Section Head() const {
    Section head = {fmt::format("{}: from {} to {}", of_.a->file.title(), a_, b_)};
    for (const auto* list : {&of_.setup.scenes, &of_.setup.machine, &of_.setup.parameters})
      for (const figures::SetupDifference& of : *list)
        head.table.rows.push_back({of.name, of.a, of.b});
    head.table.columns = {{"differs", false}, {a_, false}, {b_, false}};
    if (of_.setup.machine.empty())
      head.lines.push_back("The same machine, versions and kind of build");
    for (const std::string& note : of_.match.notes) head.notes.push_back("Axis ignored: " + note);
    std::string points = Counted(of_.match.points.size(), "point") + " in both files";
    for (const auto& [name, places] :
         {std::pair{a_, of_.match.only_a}, std::pair{b_, of_.match.only_b}})
      if (!places.empty())
        points += fmt::format("; {} only in {}: {}", places.size(), name, PlacesText(places));
    head.notes.push_back(points);
    for (const std::string& note : of_.setup.notes) head.notes.push_back(note);
    if (of_.setup.is_interleaved)
      head.notes.push_back("The runs of both files were interleaved in time");
    for (const figures::ComparedFile* file : {of_.a, of_.b}) {
      const std::string noise = NoiseNote(file->file, file->model.runs().good);
      if (!noise.empty()) head.notes.push_back(file->name + ": " + noise);
    }
    return head;
  }

  /// `is_memory`: of the memory, which varies, or of the other facts.
  Section Facts(bool is_memory) const {
    Section facts = {
        is_memory ? "Memory: the largest of the repeats, if it changed by more than they vary"
                  : "Facts that are the same in every repeat, compared exactly"};
    facts.table.columns = {{"fact", false}, {"better", true}, {"worse", true},
                           {"other", true}, {"points", true}, {"the largest change", false}};
    for (const figures::FactComparison& fact : of_.facts) {
      if (fact.changes.empty() ||
          (fact.kind == figures::FactComparison::Kind::kMemory) != is_memory)
        continue;
      const figures::FactChange& most = fact.changes[0];
      facts.table.rows.push_back(
          {fact.name, fmt::format("{}", fact.Count(figures::Direction::kBetter)),
           fmt::format("{}", fact.Count(figures::Direction::kWorse)),
           fmt::format("{}", fact.Count(figures::Direction::kOther)),
           fmt::format("{}", fact.points),
           (of_.match.points.size() > 1 ? PlaceOf(of_, most.point) + ": " : "") +
               ChangeText(most)});
    }
    if (!is_memory)
      facts.notes = {"Other: neither better nor worse, or an error within its floor."};
    return facts;
  }

  void AddTimeColumns(Table& table, const std::string& a, const std::string& b) const {
    for (const std::string& head :
         {std::string("phase"), a, b, std::string("ratio"),
          std::string(of_.times.counts_instructions ? "within noise" : "95 % interval"),
          std::string("verdict")})
      table.AddColumn(head, head != "phase" && head != "verdict");
  }

  /// The verdict in the words of the clock.
  std::string VerdictOf(const figures::JudgedChange& change) const {
    if (!of_.times.counts_instructions) return VerdictText(change);
    switch (change.verdict) {
      case figures::ChangeVerdict::kSlower:
        return "MORE";
      case figures::ChangeVerdict::kFaster:
        return "fewer";
      default:
        return change.verdict == figures::ChangeVerdict::kSame ? "same" : VerdictText(change);
    }
  }

  std::vector<std::string> TimeCells(const figures::TimeChange& change) const {
    const figures::TestedChange& tested = change.absolute.tested;
    const bool counts = of_.times.counts_instructions;
    const auto text = [&](double value) {
      return counts ? CountText(value) : TimeText(value, change.a_ns);
    };
    const auto ratio = [&](double value) {
      return counts ? fmt::format("{:.5f}", value) : FourDigits(value);
    };
    return {figures::PhaseName(change.phase),
            text(change.a_ns),
            text(change.b_ns),
            ratio(tested.ratio),
            tested.IsTested()
                ? fmt::format("{} .. {}", ratio(tested.interval.low), ratio(tested.interval.high))
                : "-",
            VerdictOf(change.absolute)};
  }

  bool ShowsRelative() const { return options_.is_relative || of_.times.HasCommonShift(); }

  Section Groups() const {
    const bool pools = of_.times.points.size() > of_.times.groups.size();
    const std::string by = of_.match.group ? of_.match.axes[*of_.match.group] : "";
    Section groups = {
        fmt::format("{} of a cycle{}{}{}",
                    of_.times.counts_instructions ? "Mean number of instructions" : "Mean",
                    pools ? ", geometric mean over the points" : "",
                    by.empty() || !pools ? "" : " of each ", pools ? by : "")};
    groups.table.columns = {{by, false}};
    if (pools) groups.table.AddColumn("points", true);
    AddTimeColumns(groups.table, a_, b_);
    if (ShowsRelative()) {
      groups.table.AddColumn("relative", true);
      groups.table.AddColumn("", false);
    }
    for (const figures::TimedGroup& group : of_.times.groups)
      for (const figures::TimeChange& change : group.phases) {
        std::vector<std::string> row = {group.name};
        if (pools) row.push_back(fmt::format("{}", group.points));
        for (std::string& cell : TimeCells(change)) row.push_back(std::move(cell));
        if (ShowsRelative()) {
          row.push_back(FourDigits(change.relative.tested.ratio));
          row.push_back(VerdictOf(change.relative));
        }
        groups.table.rows.push_back(std::move(row));
      }
    groups.notes = StatisticNotes();
    return groups;
  }

  std::vector<std::string> StatisticNotes() const {
    if (of_.times.counts_instructions)
      return {fmt::format(
          "Instructions counted by Valgrind, the mean over cycles. Below 1: {} executes "
          "fewer. More, fewer: by more than {:g} %, the noise of a count. Fewer "
          "instructions need not be faster: cdb doc compare.",
          b_, 100 * figures::kCountNoise)};
    const std::size_t n_a = of_.a->file.begun_repeats(), n_b = of_.b->file.begun_repeats();
    std::string statistic = "Mean";
    if (const std::size_t m = figures::FastestOf(std::min(n_a, n_b)); n_a > 1 || n_b > 1)
      statistic = fmt::format(
          "Fastest of {} repeats per cycle, averaged over all choices of that many (of {} and {}), "
          "then mean",
          m, n_a, n_b);
    std::vector<std::string> notes = {
        fmt::format("{} over cycles. Below 1: {} is faster.", statistic, b_)};
    if (of_.times.has_intervals)
      notes.push_back(
          fmt::format("Intervals by bootstrap over the repeats of each file by itself. Slower, "
                      "faster: by more than {:.0f} %, with Holm's correction for all groups and "
                      "phases (5 %): cdb doc compare.",
                      100 * figures::kNegligible));
    return notes;
  }

  /// The points that changed, or all points; empty if each group is a single point.
  Section Points() const {
    Section points = {options_.lists_all ? "Each point" : "Points that changed"};
    if (of_.times.points.size() == of_.times.groups.size() && !options_.lists_all) return points;
    for (std::size_t i = 0; i < of_.match.axes.size(); ++i)
      points.table.AddColumn(of_.match.axes[i], !of_.match.is_text[i]);
    AddTimeColumns(points.table, a_, b_);
    std::vector<std::pair<double, std::vector<std::string>>> rows;
    for (const figures::TimedPoint& point : of_.times.points)
      for (const figures::TimeChange& change : point.phases) {
        if (!options_.lists_all && change.absolute.verdict <= figures::ChangeVerdict::kSame)
          continue;
        std::vector<std::string> row = of_.match.points[point.point].place;
        for (std::string& cell : TimeCells(change)) row.push_back(std::move(cell));
        rows.emplace_back(std::fabs(std::log(change.change.ratio())), std::move(row));
      }
    const std::size_t count = rows.size();
    if (!options_.lists_all && count > kMostPoints) {
      std::ranges::stable_sort(rows, std::greater(), [](const auto& row) { return row.first; });
      rows.resize(kMostPoints);
    }
    for (auto& [size, row] : rows) points.table.rows.push_back(std::move(row));
    if (count > rows.size())
      points.notes.push_back(fmt::format("The {} largest of {} changes; --all lists every point.",
                                         rows.size(), count));
    if (of_.times.has_intervals && !of_.times.counts_instructions)
      points.notes.push_back(
          "By Benjamini and Hochberg's correction for all points and phases: at most 5 % of the "
          "changes found are expected to be false.");
    return points;
  }

  const figures::FileComparison& of_;
  const figures::CompareOptions options_;
  const std::string a_, b_;
};

}  // namespace

Document CompareDocument(const figures::FileComparison& comparison,
                         const figures::CompareOptions& options) {
  return ComparisonText(comparison, options).Sections();
}

std::vector<std::string> ResultLines(const figures::FileComparison& comparison,
                                     const figures::CompareOptions& options) {
  return ResultText(comparison, options).Results();
}

std::vector<std::string> FactLines(const figures::FileComparison& comparison) {
  return ResultText(comparison, {}).ChangedFacts();
}

std::string FourDigits(double value) {
  if (!std::isfinite(value)) return "-";
  if (std::fabs(value) >= 1000 && std::fabs(value) < 1e7) return fmt::format("{:.0f}", value);
  return fmt::format("{:#.4g}", value);
}

std::string PercentText(double ratio, int digits) {
  return std::isfinite(ratio) ? fmt::format("{:+.{}f} %", 100 * (ratio - 1), digits) : "-";
}

std::string PercentRange(double low, double high, int digits) {
  if (!std::isfinite(low) || !std::isfinite(high)) return "-";
  return fmt::format("{0:+.{2}f} .. {1:+.{2}f} %", 100 * (low - 1), 100 * (high - 1), digits);
}

std::string TimeText(double ns, double like_ns) {
  const terminal::TimeUnit unit = terminal::TimeUnit::For(like_ns);
  return fmt::format("{} {}", FourDigits(ns / unit.ns), unit.name);
}

std::string CountText(double count) {
  if (count < 1e4) return FourDigits(count);
  if (count < 1e6) return FourDigits(count / 1e3) + " k";
  return count < 1e9 ? FourDigits(count / 1e6) + " M" : FourDigits(count / 1e9) + " G";
}

std::string Counted(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string PlacesText(const std::vector<std::string>& places) {
  const auto shown = static_cast<std::ptrdiff_t>(std::min(places.size(), kMostPlaces));
  std::string text = fmt::format("{}", fmt::join(places.begin(), places.begin() + shown, "; "));
  if (places.size() > kMostPlaces)
    text += fmt::format("; and {} more", places.size() - kMostPlaces);
  return text;
}

std::string ChangeText(const figures::FactChange& change) {
  const double relative = change.RelativeChange();
  return fmt::format("{} -> {}{}", change.text_a, change.text_b,
                     std::isfinite(relative) ? fmt::format(" ({:+.3g} %)", 100 * relative) : "");
}

std::string VerdictText(const figures::JudgedChange& change) {
  switch (change.verdict) {
    case figures::ChangeVerdict::kFaster:
      return "faster";
    case figures::ChangeVerdict::kSlower:
      return "SLOWER";
    case figures::ChangeVerdict::kSame:
      return fmt::format("same within {:.1f} %", 100 * change.tested.Bound());
    case figures::ChangeVerdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

}  // namespace cdb::printers
