#include <cmath>

#include "runtime/figures/history/histories.h"
#include "runtime/figures/model.h"
#include "runtime/results/store.h"

namespace cdb::history {
namespace {

/// Facts of /provenance that may explain a change, or tell machines apart.
constexpr const char* kReadFacts[] = {
    "cdb_version", "commit",       "bullet_version", "build_type", "compiler", "host",
    "cpu",         "cpu_governor", "system",         "kernel",     "jobs",     "compiler_flags"};

/// The identity of each point's scene, by its place in the grid.
std::map<figures::Point, std::string> ScenesOf(const results::ResultFile& file) {
  std::map<figures::Point, std::string> scenes;
  const std::optional<plan::Plan> plan = figures::ReadPlan(file);
  if (!plan) return scenes;
  for (const plan::Run& run : plan->runs) {
    if (run.rep != 0 || scenes.contains(run.at)) continue;
    plan::Scene scene = run.scene;
    scene.plugins.clear();
    scene.world.Set("repeats", std::uint64_t{1});
    scenes.emplace(run.at, plan::RunId(scene, 0));
  }
  return scenes;
}

/// `counts_instructions`: the times of the file are numbers of instructions.
double FigureOf(const figures::Model& model, const figures::MeasuredPoint& point,
                const FigureInfo& info, bool counts_instructions) {
  std::string name = info.name;
  if (info.kind == FigureKind::kMemory) return model.MemoryOf(point, name);
  if (info.kind == FigureKind::kCount)
    return model.file().Has(name) ? model.CountOf(point, name) : figures::kNone;
  const bool is_count = info.kind == FigureKind::kInstructions;
  if (!model.HasTimes() || is_count != counts_instructions) return figures::kNone;
  name = name.substr(0, name.find('_'));
  for (const protocol::Phase phase : figures::AllPhases())
    if (figures::PhaseName(phase) == name) return model.TimeOf(point, phase).value;
  return figures::kNone;
}

/// Empty if it is unknown, or repeats differ.
std::string StateOf(const results::ResultFile& file, const figures::MeasuredPoint& point) {
  if (!file.Has("state_hash")) return {};
  std::string state;
  for (const figures::Cell& cell : point.cells) {
    const std::string of_cell = file.ReadText("state_hash", cell);
    if (!state.empty() && of_cell != state) return {};
    state = of_cell;
  }
  return state;
}

}  // namespace

double StartOf(const results::ResultFile& file) {
  double first = 0;
  if (!file.Has("started")) return first;
  for (const figures::Cell& cell : figures::AllCells(file))
    if (const double started = file.ReadReal("started", cell);
        started > 0 && (first == 0 || started < first))
      first = started;
  return first;
}

FileFigures ReadFigures(const std::filesystem::path& path, const std::string& name) {
  const results::ResultFile file(path);
  const figures::Model model(file);
  FileFigures read;
  read.file = name;
  read.benchmark = file.benchmark();
  read.title = file.title();
  read.started = read.place = StartOf(file);
  read.has_counters = figures::HasCounters(file);
  for (const char* fact : kReadFacts)
    if (std::string text = file.ReadProvenance(fact); !text.empty())
      read.facts.emplace(fact, std::move(text));
  const bool counts_instructions = figures::CountsInstructions(file);
  const std::map<figures::Point, std::string> scenes = ScenesOf(file);
  const std::vector<std::size_t> axes = figures::AllAxes(file);
  for (const figures::MeasuredPoint& point : model.points()) {
    if (!point.IsSound()) {
      ++read.unsound;
      continue;
    }
    const auto scene = scenes.find(point.at);
    PointFigures of = {figures::PlaceText(file, axes, point.at),
                       scene == scenes.end() ? "" : scene->second,
                       {},
                       StateOf(file, point)};
    for (const FigureInfo& info : kFigures)
      if (const double value = FigureOf(model, point, info, counts_instructions);
          std::isfinite(value) && (value > 0 || info.kind == FigureKind::kCount))
        of.figures.emplace(info.name, value);
    read.points.push_back(std::move(of));
  }
  return read;
}

}  // namespace cdb::history
