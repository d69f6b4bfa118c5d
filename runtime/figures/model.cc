#include "runtime/figures/model.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "compiler/analysis/configurations.h"
#include "compiler/schema/catalogue.h"
#include "dsl/text/check.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/requirements.h"

namespace cdb::figures {
namespace {

/// The detector that finds nothing, by which the cost of a call is measured.
constexpr std::string_view kIdle = "null";

}  // namespace

Model::Model(const results::ResultFile& file, const ModelOptions& options)
    : file_(file),
      options_(options),
      points_(MeasuredPoints(file, options.only_sound)),
      detector_axis_(DetectorAxis(file)),
      times_(file, options.statistic, options.fastest_of) {
  for (const MeasuredPoint& point : points_) by_place_[point.at] = &point;
}

const MeasuredPoint* Model::Find(const Point& at) const {
  const auto found = by_place_.find(at);
  return found == by_place_.end() ? nullptr : found->second;
}

const std::vector<GridPoint>& Model::grid() const {
  if (grid_) return *grid_;
  grid_.emplace();
  for (const Point& at : AllPoints(file_)) {
    const MeasuredPoint* measured = Find(at);
    if (measured == nullptr && options_.only_sound) continue;
    const Ending ending = WorstEnding(file_, at);
    if (ending.Rank() >= 0) grid_->push_back({at, ending, measured});
  }
  return *grid_;
}

std::size_t Model::IndexOf(const Point& at) const {
  const auto found = std::ranges::lower_bound(grid(), at, {}, &GridPoint::at);
  CDB_CHECK(found != grid().end() && found->at == at);
  return static_cast<std::size_t>(found - grid().begin());
}

const CellGroups& Model::runs() const {
  if (!runs_) runs_ = GroupCells(file_);
  return *runs_;
}

const std::vector<std::size_t>& Model::scene_axes() const {
  if (!scene_axes_) scene_axes_ = SceneAxes(file_);
  return *scene_axes_;
}

const std::vector<DetectorFindings>& Model::findings() const {
  if (!findings_) findings_ = FindingsOf(file_);
  return *findings_;
}

const std::vector<JudgedRequirement>& Model::requirements() const {
  if (!requirements_)
    requirements_ =
        std::make_shared<const std::vector<JudgedRequirement>>(JudgeRequirements(*this));
  return *requirements_;
}

const std::vector<results::ReferenceTrouble>& Model::reference_troubles() const {
  if (!reference_troubles_) reference_troubles_ = file_.ReadReferenceTroubles();
  return *reference_troubles_;
}

std::string Model::ReferenceFaultOf(const MeasuredPoint& point) const {
  if (reference_troubles().empty() || !file_.Has("accuracy/truth")) return {};
  const std::string truth = file_.ReadText("accuracy/truth", point.cells[0]);
  const auto found = std::ranges::find_if(reference_troubles(), [&](const auto& trouble) {
    return trouble.is_unsound && trouble.id == truth;
  });
  return found == reference_troubles().end() ? std::string() : "reference " + found->text;
}

std::optional<std::size_t> Model::ComparedDetectors() const {
  if (!detector_axis_ || axis(*detector_axis_).values.size() < 2 || !HasTimes() || points_.empty())
    return std::nullopt;
  return detector_axis_;
}

std::vector<protocol::Phase> Model::TimedPhases() const {
  std::vector<protocol::Phase> phases = AllPhases();
  std::erase_if(phases, [this](protocol::Phase phase) {
    return std::ranges::none_of(points_, [&](const MeasuredPoint& point) {
      return std::isfinite(times_.Of(point, phase).mean.value);
    });
  });
  return phases;
}

double Model::CountOf(const MeasuredPoint& point, const std::string& series) const {
  return Mean(file_.ReadSeries(series, point.cells[0]));
}

double Model::NsPerPairOf(const MeasuredPoint& point) const {
  const double handled = CountOf(point, "pairs") - CountOf(point, "unhandled_pairs");
  return handled > 0 ? TimeOf(point, protocol::Phase::kNarrow).value / handled : kNone;
}

double Model::MemoryOf(const MeasuredPoint& point, const std::string& name) const {
  double largest = kNone;
  if (!file_.Has(name)) return largest;
  for (const Cell& cell : point.cells)
    largest = std::fmax(largest, name == "heap" ? Largest(file_.ReadSeries(name, cell))
                                                : file_.ReadReal(name, cell));
  return largest;
}

double Model::ErrorOf(const MeasuredPoint& point, const std::string& name) const {
  const std::string dataset = "accuracy/" + name;
  return file_.Has(dataset) ? file_.ReadReal(dataset, point.cells[0]) : kNone;
}

void Model::ReadTimeSteps() const {
  time_steps_.emplace();
  if (const auto plan = ReadPlan(file_))
    for (const plan::Run& run : plan->runs)
      time_steps_->emplace(run.id, analysis::HasConfigurations(run.scene)
                                       ? kNone  // nothing moves with time
                                       : run.scene.world.Real("timestep"));
}

double Model::TimeStepOf(const MeasuredPoint& point) const {
  if (file_.Has("accuracy/timestep")) return file_.ReadReal("accuracy/timestep", point.cells[0]);
  if (!time_steps_) ReadTimeSteps();
  const auto found = time_steps_->find(file_.ReadText("run_id", point.cells[0]));
  return found == time_steps_->end() ? kNone : found->second;
}

Estimate Model::MsPerSecondOf(const MeasuredPoint& point) const {
  return Scaled(times_.Of(point, protocol::Phase::kStep).mean, 1e-6 / TimeStepOf(point));
}

Estimate Model::TimeOf(const Row& row, protocol::Phase phase) const {
  std::vector<const Estimate*> times;
  for (const MeasuredPoint* point : row.points) times.push_back(&TimeOf(*point, phase));
  return MeanOf(times);
}

double Model::CountOf(const Row& row, const std::string& series) const {
  std::vector<double> means;
  for (const MeasuredPoint* point : row.points) means.push_back(CountOf(*point, series));
  return Mean(means);
}

double Model::MemoryOf(const Row& row, const std::string& name) const {
  std::vector<double> all;
  for (const MeasuredPoint* point : row.points) all.push_back(MemoryOf(*point, name));
  return Largest(all);
}

const Model& Model::slow() const {
  if (!slow_) {
    ModelOptions options = options_;
    options.statistic = CycleStatistic::kP99;
    slow_ = std::make_unique<const Model>(file_, options);
  }
  return *slow_;
}

std::size_t Model::bad_count() const {
  const auto wrong = std::ranges::count_if(findings(), [](const DetectorFindings& of) {
    const schema::DetectorInfo* info = schema::FindDetector(of.detector);
    return of.missed > 0 && of.detector != kIdle &&
           (info == nullptr || !info->Makes(schema::KnownErrors::kMissesPairs));
  });
  const auto failed =
      std::ranges::count(reference_troubles(), false, &results::ReferenceTrouble::is_unsound);
  // Beside the boundary that a search looks for, runs may end badly, which is its answer.
  const std::size_t bad = plan::SearchAxis(file_.axes()) ? 0 : runs().bad.size();
  return bad + static_cast<std::size_t>(failed + wrong);
}

namespace {

struct Total {
  double sum = kNone, largest = kNone, count = 0;
  double Mean() const { return sum / count; }
};

/// Over the values of all cycles that have one.
Total TotalOf(std::span<const MeasuredPoint* const> points,
              const std::function<std::vector<double>(const Cell&)>& read) {
  Total total;
  for (const MeasuredPoint* point : points)
    for (const Cell& cell : point->cells)
      for (const double value : read(cell)) {
        if (!(value >= 0)) continue;
        total.sum = std::isnan(total.sum) ? value : total.sum + value;
        total.largest = std::fmax(total.largest, value);
        ++total.count;
      }
  return total;
}

}  // namespace

bool HasQueries(const results::ResultFile& file) {
  return file.Has("query_time") || file.Has("query_count") || file.Has("compared_queries");
}

QueryFigures QueriesOf(const results::ResultFile& file,
                       std::span<const MeasuredPoint* const> points, schema::QueryType type) {
  const auto total = [&](const char* series) {
    if (!file.Has(series)) return Total();
    return TotalOf(points,
                   [&](const Cell& cell) { return file.ReadOfQueries(series, type, cell); });
  };
  const Total counts = total("query_count"), times = total("query_time");
  Total updates;
  if (file.Has("query_update_time"))
    updates = TotalOf(points,
                      [&](const Cell& cell) { return file.ReadSeries("query_update_time", cell); });
  return {.count = counts.Mean(),
          .hits = total("query_hits").Mean(),
          .time_ns = times.Mean(),
          .update_ns = updates.Mean(),
          .ns_per_query = counts.sum > 0 ? times.sum / counts.sum : kNone,
          .compared = total("compared_queries").sum,
          .missed = total("missed_hits").sum,
          .wrong = total("false_hits").sum,
          .error = total("hit_error").largest,
          .normal_error = total("hit_normal_error").largest};
}

double CounterOf(const results::ResultFile& file, std::span<const MeasuredPoint* const> points,
                 schema::Counter counter, protocol::Phase phase) {
  std::size_t cycles = 0;
  const Total total = TotalOf(points, [&](const Cell& cell) {
    std::vector<double> counts = file.ReadCounter(counter, phase, cell);
    cycles += counts.size();
    return counts;
  });
  // A mean of some of the cycles would be that of others.
  return total.count == static_cast<double>(cycles) ? total.Mean() : kNone;
}

}  // namespace cdb::figures
