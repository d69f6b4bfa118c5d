#include "compiler/grid/part.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/grid/survey.h"
#include "compiler/plan/input_file.h"
#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"

namespace cdb::grid {
namespace {

void AppendCondition(const PointCondition& condition, std::string& text) {
  text += fmt::format("condition {} [{}] ", static_cast<int>(condition.kind),
                      fmt::join(condition.by.axes(), " "));
  for (const bool value : condition.values) text += value ? '1' : '0';
  text += fmt::format(" {}\n", condition.items.size());
  for (const PointCondition& item : condition.items) AppendCondition(item, text);
}

void AppendBlock(const Block& block, std::string& text) {
  for (const Point& places : block.places)
    text += fmt::format("places {}\n", fmt::join(places, " "));
  for (const PointCondition& skip : block.skips) AppendCondition(skip, text);
  yaml::RunText base("");
  base.Set(block.base);
  text += fmt::format("base {}\n", base.Id(0));
  for (const VaryingSetting& setting : block.varying) {
    text += fmt::format("setting {} {} [{}]", static_cast<std::int64_t>(setting.group),
                        setting.parameter->name, fmt::join(setting.by.axes(), " "));
    for (const schema::Value& value : setting.values) text += "\t" + schema::ToText(value);
    text += '\n';
  }
}

/// Finds the runs of `grid` that maximise a number computed from their settings, or that are the
/// first with a word. A function of few settings is evaluated only a few times.
class BoundsFinder {
 public:
  explicit BoundsFinder(const Grid& grid) : survey_(grid), cursor_(grid), grid_(grid) {}

  void AddLargest(const std::function<std::uint64_t(const plan::Scene&)>& number) {
    std::optional<std::pair<std::uint64_t, Sample>> most;
    Look([&] { most.reset(); },
         [&](const Sample& sample, const plan::Scene& scene) {
           const std::uint64_t value = number(scene);
           if (!most || value > most->first) most = {value, sample};
         });
    if (most) Add(most->second);
  }

  void AddFirstOfEach(const std::function<schema::WordList(const plan::Scene&)>& words) {
    std::map<std::string, Sample> firsts;
    Look([&] { firsts.clear(); },
         [&](const Sample& sample, const plan::Scene& scene) {
           for (const std::string& word : words(scene)) firsts.try_emplace(word, sample);
         });
    for (const auto& [word, sample] : firsts) Add(sample);
  }

  std::vector<plan::Run> Take() { return std::move(runs_); }

 private:
  void Look(const std::function<void()>& begin,
            const std::function<void(const Sample&, const plan::Scene&)>& look) {
    survey_.Look(
        std::numeric_limits<std::uint64_t>::max(), {}, [&](bool) { begin(); }, look);
  }

  void Add(const Sample& sample) {
    const Point place = grid_.blocks[sample.block].PlaceOf(sample.local);
    if (std::ranges::find(runs_, place, &plan::Run::at) != runs_.end()) return;
    cursor_.MoveTo(sample.block, sample.local);
    const plan::Scene scene = cursor_.MakeScene();
    runs_.push_back({plan::RunId(scene, 0), place, 0, scene, {}, {}});
  }

  Survey survey_;
  Cursor cursor_;
  const Grid& grid_;
  std::vector<plan::Run> runs_;
};

/// The detectors that settings name.
schema::WordList DetectorsOf(const plan::Scene& scene) {
  schema::WordList words;
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.TakesDetectors())
      if (const schema::Word* word = schema::AsWord(scene.world.ValueOf(parameter)))
        words.push_back(word->text);
  return words;
}

std::vector<plan::Run> BoundsOf(const Grid& grid) {
  BoundsFinder bounds(grid);
  bounds.AddLargest([](const plan::Scene& scene) { return scene.world.Count("cycles"); });
  bounds.AddLargest([](const plan::Scene& scene) { return scene.ObjectCount(); });
  bounds.AddLargest([](const plan::Scene& scene) { return analysis::BodyCount(scene); });
  bounds.AddLargest([](const plan::Scene& scene) { return scene.QueryCount(); });
  bounds.AddLargest([](const plan::Scene& scene) { return analysis::NodeCount(scene); });
  bounds.AddLargest([](const plan::Scene& scene) {
    const auto sampling = analysis::SamplingOf(scene);
    return sampling ? sampling->count : 0;
  });
  bounds.AddFirstOfEach([](const plan::Scene& scene) { return scene.world.Words("record"); });
  bounds.AddFirstOfEach(
      [](const plan::Scene& scene) { return scene.world.Words("accuracy.metrics"); });
  bounds.AddFirstOfEach(DetectorsOf);
  // These words determine which programs are needed and which series are recorded.
  bounds.AddFirstOfEach([](const plan::Scene& scene) {
    return schema::WordList{std::string(scene.world.WordOr("precision")),
                            analysis::TraceOf(scene)             ? "trace"
                            : analysis::HasConfigurations(scene) ? "configurations"
                            : analysis::HasSoft(scene)           ? "soft"
                            : analysis::ComesOrGoes(scene)       ? "changing"
                                                                 : "scene",
                            analysis::NeedsReference(scene) ? "reference" : "none"};
  });
  return bounds.Take();
}

/// Groups of points that differ only on the axes of the detector, numbered so that neighbouring
/// groups have distant numbers.
class Groups {
 public:
  explicit Groups(const Grid& grid) {
    AxisSet detector;
    const schema::Parameter& parameter = *schema::WorldParameter("detector");
    for (const Block& block : grid.blocks) detector = Union(detector, block.AxesOf(parameter));
    AxisSet others;
    std::ranges::set_difference(AllAxes(grid.extents().size()), detector,
                                std::back_inserter(others));
    between_ = Subgrid(others, grid.extents());
    within_ = Subgrid(detector, grid.extents());
    const std::uint64_t size = between_.size();
    // The golden ratio suits the strides of any axes.
    step_ = static_cast<std::uint64_t>(0.6180339887498949 * static_cast<double>(size)) | 1;
    while (std::gcd(step_, size) != 1) ++step_;
  }

  const Subgrid& within() const { return within_; }

  /// The groups of a part, in ascending order.
  std::vector<std::uint64_t> Of(Part part) const {
    __extension__ using Wide = unsigned __int128;
    const auto begin_of = [&](std::uint64_t index) {
      return static_cast<std::uint64_t>(Wide{between_.size()} * index / part.count);
    };
    std::vector<std::uint64_t> groups;
    for (std::uint64_t i = begin_of(part.index); i < begin_of(part.index + 1); ++i)
      groups.push_back(static_cast<std::uint64_t>(Wide{i} * step_ % between_.size()));
    std::ranges::sort(groups);
    return groups;
  }

  void MoveTo(std::uint64_t group, Point& place) const { between_.MoveTo(group, place); }

 private:
  Subgrid between_, within_;
  std::uint64_t step_ = 1;
};

/// `bounds` must include every plug-in.
std::string HashOf(const Grid& grid, const std::vector<plan::Run>& bounds) {
  std::string text = fmt::format("grid {}\n{}\nrepeats {}\n", plan::kPlanVersion,
                                 grid.head.benchmark, grid.head.repeats);
  for (const plan::Axis& axis : grid.head.axes) {
    text += fmt::format("axis {} {} {}", axis.name, axis.parameter, axis.unit);
    for (const plan::Coordinate& value : axis.values) text += "\t" + plan::CoordinateText(value);
    text += '\n';
  }
  text += fmt::format("cases {}\n", fmt::join(grid.case_axes, " "));
  for (const Block& block : grid.blocks) AppendBlock(block, text);
  for (const plan::Run& run : bounds)
    for (const schema::PluginDetector& plugin : run.scene.plugins)
      text += fmt::format("plugin {} {}\n", plugin.name, plugin.sha256);
  return plan::Sha256Hex(text);
}

}  // namespace

plan::WholePlan MakeWhole(std::shared_ptr<const Grid> grid) {
  plan::WholePlan whole;
  whole.run_count = grid->run_count();
  whole.bounds = BoundsOf(*grid);
  whole.sha256 = HashOf(*grid, whole.bounds);
  whole.for_each_run = [grid](const plan::WholePlan::VisitRun& visit) {
    yaml::RunText text("");
    ForEachPoint(*grid, [&](const Cursor& cursor, const Point& place) {
      if (IsLaid(cursor.configured())) {
        text.Set(cursor.MakeScene());
      } else {
        text.Set(cursor.configured());
      }
      for (std::uint64_t rep = 0; rep < grid->head.repeats; ++rep) visit(text.Id(rep), place, rep);
      return true;
    });
  };
  whole.for_each_skipped = [grid](const plan::WholePlan::VisitPoint& visit) {
    ForEachSkipped(*grid, visit);
  };
  return whole;
}

plan::Plan ListPart(const Grid& grid, std::shared_ptr<const plan::WholePlan> whole, Part part) {
  plan::Plan plan = grid.head;
  plan.whole = std::move(whole);
  const Groups groups(grid);
  Cursor cursor(grid);
  for (const std::uint64_t group : groups.Of(part)) {
    Point place(grid.head.axes.size(), 0);
    groups.MoveTo(group, place);
    do {
      if (!cursor.MoveTo(place)) continue;
      const plan::Scene scene = cursor.MakeScene();
      for (std::uint64_t rep = 0; rep < plan.repeats; ++rep)
        plan.runs.push_back({plan::RunId(scene, rep), place, rep, scene, {}, {}});
    } while (groups.within().Advance(place));
  }
  std::ranges::stable_sort(plan.runs, {}, &plan::Run::at);
  analysis::AddReferences(plan);
  return plan;
}

}  // namespace cdb::grid
