#include "runtime/figures/detectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string_view>

#include "compiler/schema/catalogue.h"
#include "compiler/yaml/short_plan.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/model.h"

namespace cdb::figures {
namespace {

/// An incremental mean.
struct RunningMean {
  double sum = 0, count = 0;
  void Add(double value) {
    if (std::isnan(value)) return;
    sum += value;
    ++count;
  }
  double value() const { return count > 0 ? sum / count : kNone; }
};

/// The values of a series; empty if the file does not have it.
std::vector<double> Series(const results::ResultFile& file, const Cell& cell, const char* name) {
  return file.Has(name) ? file.ReadSeries(name, cell) : std::vector<double>();
}

/// Calls `visit` once for each run, whatever the number of its cells.
template <typename Visit>
void ForRuns(const results::ResultFile& file, Visit visit) {
  std::set<std::string> seen;
  for (const Cell& cell : AllCells(file)) {
    const Ending ending = EndingOf(file, cell);
    if (ending.Rank() < 0) continue;
    const std::string id = file.ReadText("run_id", cell);
    if (seen.insert(id).second) visit(cell, ending, id);
  }
}

/// The run was one of a narrow phase on the pairs of a trace.
bool RanNoBroadPhase(const results::ResultFile& file, const Cell& cell) {
  const auto has_values = [&](const char* name) {
    return std::ranges::any_of(Series(file, cell, name), [](double count) { return count >= 0; });
  };
  return has_values("unhandled_pairs") ||
         (has_values("exact_contacts") && !file.Has("exact_pairs"));
}

/// Cycles without a value are -1.
void AddPairs(const results::ResultFile& file, const Cell& cell, DetectorFindings& findings) {
  const auto exact = Series(file, cell, "exact_pairs"), missed = Series(file, cell, "missed_pairs"),
             false_positives = Series(file, cell, "phantom_pairs"),
             duplicate = Series(file, cell, "duplicate_pairs"),
             contacts = Series(file, cell, "missed_contacts"),  // a trace has none
      collisions = Series(file, cell, "exact_collisions"),
             missed_collisions = Series(file, cell, "missed_collisions");
  bool is_wrong = false, is_watched = false;
  for (std::uint64_t cycle = 0; cycle < exact.size(); ++cycle) {
    if (!(exact[cycle] >= 0)) continue;
    is_watched = true;
    ++findings.cycles;
    const auto add = [&](std::uint64_t& sum, const std::vector<double>& values) {
      sum += static_cast<std::uint64_t>(values[cycle]);
      return values[cycle] > 0;
    };
    add(findings.exact, exact);
    add(findings.false_positives, false_positives);
    const auto note = [&](std::uint64_t& sum, const std::vector<double>& values,
                          std::optional<Place>& first) {
      if (add(sum, values) && !first) first = {cell, cycle};
    };
    note(findings.missed, missed, findings.first_missed);
    note(findings.duplicate, duplicate, findings.first_duplicate);
    if (cycle < contacts.size() && contacts[cycle] >= 0) add(findings.missed_contacts, contacts);
    if (cycle < collisions.size() && collisions[cycle] >= 0) {
      const auto count = [&](std::optional<std::uint64_t>& sum, const std::vector<double>& values) {
        sum = sum.value_or(0) + static_cast<std::uint64_t>(values[cycle]);
      };
      count(findings.collisions, collisions);
      count(findings.missed_collisions, missed_collisions);
    }
    is_wrong = is_wrong || missed[cycle] > 0;
  }
  findings.wrong_runs += is_wrong ? 1 : 0;
  ++(is_watched ? findings.runs : findings.unwatched_runs);
}

struct ContactTally {
  ContactFindings findings;
  RunningMean depth, normal;
};

/// The contacts of a run for its own narrow phase and for Bullet, which may be given all or some
/// of the pairs.
struct ContactCounts {
  std::vector<double> exact, missed, uncompared, unlisted, bullet, bullet_missed, bullet_uncompared;
  ContactCounts(const results::ResultFile& file, const Cell& cell)
      : exact(Series(file, cell, "exact_contacts")),
        missed(Series(file, cell, "missed_contacts")),
        uncompared(Series(file, cell, "uncompared_contacts")),
        unlisted(Series(file, cell, "unlisted_contacts")),
        bullet(Series(file, cell, "bullet_contacts")),
        bullet_missed(Series(file, cell, "bullet_missed_contacts")),
        bullet_uncompared(Series(file, cell, "bullet_uncompared_contacts")) {}

  void AddTo(ContactFindings& findings, const Cell& cell, bool is_bullet) const {
    bool is_watched = false;
    for (std::uint64_t i = 0; i < exact.size(); ++i) {
      if (!(exact[i] >= 0)) continue;
      is_watched = true;
      ++findings.cycles;
      const auto add = [&](std::uint64_t& sum, double of_bullet, double of_detector) {
        const double count = is_bullet ? of_bullet : of_detector;
        sum += static_cast<std::uint64_t>(count);
        return count > 0;
      };
      add(findings.exact, bullet[i], exact[i] - bullet[i] - unlisted[i]);
      add(findings.uncompared, bullet_uncompared[i], uncompared[i] - bullet_uncompared[i]);
      if (add(findings.missed, bullet_missed[i], missed[i] - bullet_missed[i] - unlisted[i]) &&
          !findings.first_missed)
        findings.first_missed = {cell, i};
    }
    findings.runs += is_watched;
  }
};

/// The narrow phase of each run, by its id: what the plan names.
std::map<std::string, std::string> NarrowPhases(const results::ResultFile& file) {
  std::map<std::string, std::string> phases;
  const auto runs = yaml::FindBriefRuns(file.ReadProvenance("plan_text"));
  if (!runs) return phases;
  for (const yaml::BriefRun& run : *runs)
    if (run.narrow_phase != "own") phases.emplace(run.id, run.narrow_phase);
  return phases;
}

constexpr std::size_t kLeastPoints = 3;

/// Adds the counts of the cycles that have a value.
double AddCounts(double sum, const std::vector<double>& counts) {
  for (const double count : counts)
    if (count >= 0) sum = (std::isnan(sum) ? 0 : sum) + count;
  return sum;
}

bool CanFit(const plan::Axis& axis) { return axis.IsScale() && axis.values.size() >= kLeastPoints; }

/// The number of objects at each point. Empty if it is not useful, or the plan cannot be read.
std::map<Point, double> ObjectCounts(const results::ResultFile& file) {
  std::map<Point, double> objects;
  if (std::ranges::none_of(file.axes(), CanFit)) return objects;
  const auto runs = yaml::FindBriefRuns(file.ReadProvenance("plan_text"));
  if (!runs) return objects;
  for (const yaml::BriefRun& run : *runs)
    if (const auto at = file.SelectedPoint(run.at)) objects[*at] = static_cast<double>(run.objects);
  return objects;
}

/// The axis to fit over: the only one that changes the number of objects. Nullopt if there is none,
/// or several.
std::optional<std::size_t> CountAxis(const results::ResultFile& file,
                                     const std::map<Point, double>& objects) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < file.axes().size(); ++i) {
    if (!CanFit(file.axes()[i])) continue;
    std::map<Point, double> of_others;
    const bool changes = std::ranges::any_of(objects, [&](const auto& point) {
      return of_others.emplace(Without(point.first, i), point.second).first->second != point.second;
    });
    if (!changes) continue;
    if (found) return std::nullopt;
    found = i;
  }
  return found;
}

/// Times of a phase at points that differ only in the number of objects.
struct TimesAtPoint {
  Point row;
  std::map<double, std::vector<double>> by_count;
};

std::map<Point, TimesAtPoint> TimesByCount(const Model& model,
                                           const std::map<Point, double>& objects,
                                           const DetectorGrowth& growth, protocol::Phase phase) {
  std::map<Point, TimesAtPoint> found;
  for (const MeasuredPoint& point : model.points()) {
    const auto count = objects.find(point.at);
    if (count == objects.end() || !point.IsSound()) continue;
    TimesAtPoint& at = found[Without(point.at, growth.axis)];
    at.row = Project(point.at, growth.rows);
    at.by_count[count->second].push_back(model.times().Of(point, phase).mean.value);
  }
  return found;
}

/// Drops the numbers of objects that some point lacks, if enough remain to fit over.
void MatchCounts(std::map<Point, TimesAtPoint>& found, DetectorGrowth& growth) {
  std::map<double, std::size_t> having;
  for (const auto& [point, at] : found)
    for (const auto& [count, times] : at.by_count) ++having[count];
  const std::size_t all = having.size();
  std::erase_if(having, [&](const auto& count) { return count.second < found.size(); });
  growth.is_matched = having.size() == all || having.size() >= kLeastPoints;
  if (!growth.is_matched) return;
  growth.dropped = all - having.size();
  for (auto& [point, at] : found)
    std::erase_if(at.by_count, [&](const auto& count) { return !having.contains(count.first); });
}

}  // namespace

std::vector<DetectorFindings> FindingsOf(const results::ResultFile& file) {
  const bool has_pairs = file.Has("exact_pairs");
  const CellDetectors detectors(file);
  std::vector<DetectorFindings> all;
  const auto findings_of = [&](const std::string& detector) -> DetectorFindings& {
    const auto found = std::ranges::find(all, detector, &DetectorFindings::detector);
    if (found != all.end()) return *found;
    all.emplace_back().detector = detector;
    return all.back();
  };
  if (const auto axis = DetectorAxis(file))
    for (const auto& value : file.axes()[*axis].values) findings_of(std::get<std::string>(value));
  ForRuns(file, [&](const Cell& cell, const Ending& ending, const std::string&) {
    if (ending.status == results::Status::kDone && RanNoBroadPhase(file, cell)) return;
    DetectorFindings& findings = findings_of(detectors.Of(cell));
    if (ending.status != results::Status::kDone) {
      ++findings.failed_runs;
      if (!findings.first_failed) findings.first_failed = cell;
    }
    if (has_pairs)
      AddPairs(file, cell, findings);
    else
      ++findings.unwatched_runs;
  });
  return all;
}

std::vector<ContactFindings> ContactFindingsOf(const results::ResultFile& file) {
  if (!file.Has("exact_contacts")) return {};
  const CellDetectors detectors(file);
  const std::map<std::string, std::string> named = NarrowPhases(file);
  std::vector<ContactTally> tallies;
  const auto tally_of = [&](const std::string& phase) -> ContactTally& {
    const auto found = std::ranges::find(
        tallies, phase, [](const ContactTally& tally) { return tally.findings.narrow_phase; });
    if (found != tallies.end()) return *found;
    ContactTally& tally = tallies.emplace_back();
    tally.findings.narrow_phase = phase;
    return tally;
  };
  ForRuns(file, [&](const Cell& cell, const Ending&, const std::string& id) {
    const ContactCounts counts(file, cell);
    ContactFindings of_run, of_bullet;
    counts.AddTo(of_run, cell, /*is_bullet=*/false);
    counts.AddTo(of_bullet, cell, /*is_bullet=*/true);
    if (of_run.runs == 0) return;
    const auto name = named.find(id);
    const std::string own = name != named.end() ? name->second : detectors.Of(cell);
    const bool is_bullet = of_run.All() == 0;  // all contacts, or there are none
    ContactTally& tally = tally_of(!is_bullet            ? own
                                   : of_bullet.All() > 0 ? std::string(kBulletPhase)
                                                         : std::string());
    counts.AddTo(tally.findings, cell, is_bullet);
    for (const double error : Series(file, cell, "depth_error")) tally.depth.Add(error);
    for (const double error : Series(file, cell, "normal_error")) tally.normal.Add(error);
    if (!is_bullet && of_bullet.All() > 0)
      counts.AddTo(tally_of(kBulletPhase).findings, cell, /*is_bullet=*/true);
  });
  if (tallies.size() > 1)
    std::erase_if(tallies, [](const ContactTally& of) { return of.findings.All() == 0; });
  std::vector<ContactFindings> all;
  for (ContactTally& tally : tallies) {
    tally.findings.depth_error = tally.depth.value();
    tally.findings.normal_error = tally.normal.value();
    all.push_back(std::move(tally.findings));
  }
  return all;
}

namespace {

std::vector<std::string> DetectorNames(const results::ResultFile& file) {
  std::vector<std::string> names;
  if (const auto axis = DetectorAxis(file))
    for (const auto& value : file.axes()[*axis].values)
      names.push_back(std::get<std::string>(value));
  return names;
}

}  // namespace

bool IsOfBullet(const std::string& detector) {
  const schema::DetectorInfo* info = schema::FindDetector(detector);
  return info != nullptr && info->source == "Bullet";
}

namespace {

bool AnyWorld(const std::optional<plan::Plan>& plan, auto holds) {
  return plan && std::ranges::any_of(plan->runs,
                                     [&](const plan::Run& run) { return holds(run.scene.world); });
}

bool Sorts(const plan::WorldSettings& world) { return world.WordOr("pair_order") == "sorted"; }

/// What keeps the motion alike under all detectors; empty if it is set already.
std::string RemedyOfMotion(const results::ResultFile& file) {
  const auto plan = ReadPlan(file);
  const bool sorts = AnyWorld(plan, Sorts);
  const bool sleeps =
      AnyWorld(plan, [](const plan::WorldSettings& world) { return world.On("sleeping"); });
  if (sorts && !sleeps) return {};
  if (sorts)
    return "; pairs that do not touch decide which objects sleep together: `sleeping off` keeps it "
           "alike";
  return sleeps ? "; `pair_order sorted` and `sleeping off` keep it alike"
                : "; `pair_order sorted` keeps it alike";
}

}  // namespace

bool SortsPairs(const results::ResultFile& file) { return AnyWorld(ReadPlan(file), Sorts); }

std::string SameMotionText(const results::ResultFile& file) {
  const auto axis = DetectorAxis(file);
  if (!axis || !file.Has("state_hash")) return {};
  const std::vector<std::string> names = DetectorNames(file);
  struct Motions {
    std::set<std::size_t> detectors;
    std::set<std::string> hashes;
    std::set<protocol::Verdict> verdicts;
  };
  std::map<Point, Motions> by_place;
  for (const Cell& cell : AllCells(file)) {
    const schema::DetectorInfo* info = schema::FindDetector(names[cell.at[*axis]]);
    if (info != nullptr && info->family == "none") continue;
    const Ending ending = EndingOf(file, cell);
    const std::string hash = file.ReadText("state_hash", cell);
    if (ending.status != results::Status::kDone || hash.empty() ||
        ending.judgement.verdict == protocol::Verdict::kUnknown)
      continue;
    Motions& motions = by_place[Without(cell.at, *axis)];
    motions.detectors.insert(cell.at[*axis]);
    motions.hashes.insert(hash);
    motions.verdicts.insert(ending.judgement.verdict);
  }
  std::erase_if(by_place, [](const auto& of) { return of.second.detectors.size() < 2; });
  if (by_place.empty()) return {};
  const auto count = [&](auto differs) { return std::ranges::count_if(by_place, differs); };
  const auto motions = count([](const auto& of) { return of.second.hashes.size() > 1; });
  const auto verdicts = count([](const auto& of) { return of.second.verdicts.size() > 1; });
  if (motions == 0) return "All detectors moved every object alike, to the last bit.";
  const std::string where =
      by_place.size() == 1 ? "" : fmt::format(" at {} of {} points", motions, by_place.size());
  const std::string judged = verdicts == 0 ? ""
                             : by_place.size() == 1
                                 ? ", and so do the verdicts"
                                 : fmt::format(", and the verdict at {}", verdicts);
  return fmt::format("The motion differs between detectors{}{}{}.", where, judged,
                     RemedyOfMotion(file));
}

std::string SortingText(const results::ResultFile& file) {
  std::vector<std::string> of_bullet;
  const std::vector<std::string> names = DetectorNames(file);
  std::ranges::copy_if(names, std::back_inserter(of_bullet), IsOfBullet);
  if (of_bullet.empty() || of_bullet.size() == names.size() || !SortsPairs(file)) return {};
  return fmt::format(
      "Pairs are sorted in the narrow phase of {}, and in the broad phase of the other detectors.",
      JoinWords(of_bullet));
}

DetectorCosts CostsOf(const Model& model, const Row& row, protocol::Phase phase) {
  const results::ResultFile& file = model.file();
  DetectorCosts costs = {.mean = model.TimeOf(row, phase)};
  for (const MeasuredPoint* point : row.points) {
    costs.worst = std::fmax(costs.worst, Largest(model.times().Of(*point, phase).cycles));
    if (!file.Has("exact_pairs")) continue;
    for (const Cell& cell : point->cells) {
      costs.missed = AddCounts(costs.missed, file.ReadSeries("missed_pairs", cell));
      costs.phantom = AddCounts(costs.phantom, file.ReadSeries("phantom_pairs", cell));
    }
  }
  if (file.Has("pairs")) costs.pairs = model.CountOf(row, "pairs");
  costs.peak_rss = model.MemoryOf(row, "peak_rss");
  costs.heap = model.MemoryOf(row, "heap");
  return costs;
}

std::optional<DetectorGrowth> GrowthByRow(const Model& model, const std::vector<std::size_t>& rows,
                                          protocol::Phase phase) {
  const std::map<Point, double> objects = ObjectCounts(model.file());
  const auto axis = CountAxis(model.file(), objects);
  if (!axis) return std::nullopt;
  DetectorGrowth growth = {*axis, rows, {}};
  std::erase(growth.rows, *axis);
  auto found = TimesByCount(model, objects, growth, phase);
  MatchCounts(found, growth);
  for (const auto& [point, at] : found) {
    PowerGroup curve;
    for (const auto& [count, values] : at.by_count) curve.emplace_back(count, Median(values));
    DetectorGrowth::Exponent& row = growth.exponents[at.row];
    row.least = std::fmin(row.least, curve.front().first);
    row.most = std::fmax(row.most, curve.back().first);
    row.curves.push_back(std::move(curve));
  }
  for (auto& [row, exponent] : growth.exponents) exponent.fit = FitPower(exponent.curves);
  growth.is_mean = found.size() > growth.exponents.size();
  for (const MeasuredPoint& point : model.points())
    for (const std::string& name : point.unlike)
      if (point.IsSound() && std::ranges::find(growth.unlike, name) == growth.unlike.end())
        growth.unlike.push_back(name);
  return growth;
}

std::optional<HarnessCost> HarnessCostOf(const Model& model) {
  const results::ResultFile& file = model.file();
  if (!model.HasTimes() || !file.Has("harness")) return std::nullopt;
  std::vector<double> harness;
  std::map<std::string, std::vector<double>> detect;
  const CellDetectors detectors(file);
  for (const MeasuredPoint& point : model.points()) {
    if (!point.IsSound()) continue;
    for (const Cell& cell : point.cells)
      if (const double ns = file.ReadReal("harness", cell); std::isfinite(ns))
        harness.push_back(ns);
    const std::string detector = detectors.Of(point.cells[0]);
    const schema::DetectorInfo* info = schema::FindDetector(detector);
    // For a detector that finds nothing, the whole time is harness.
    if (info == nullptr || info->family != "none")
      detect[detector].push_back(model.times().Of(point, protocol::Phase::kDetect).mean.value);
  }
  if (harness.empty()) return std::nullopt;
  HarnessCost cost = {Median(harness), std::nullopt};
  std::vector<std::pair<double, std::string>> timed;
  for (auto& [detector, of_points] : detect)
    if (const double time = Median(of_points); std::isfinite(time))
      timed.emplace_back(time, detector);
  if (!timed.empty()) {
    const auto& [time, detector] = *std::ranges::min_element(timed);
    cost.fastest = {time, detector, timed.size() == 1};
  }
  return cost;
}

}  // namespace cdb::figures
