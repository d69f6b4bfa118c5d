#include "runtime/pages/view/selection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/metrics.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/layouts/exact_layouts.h"
#include "library/layouts/soft_nodes.h"
#include "runtime/figures/points.h"
#include "runtime/pages/view/scene_document.h"
#include "runtime/terminal/table.h"

namespace cdb::view {
namespace {

using files::StoreError;

/// Nullopt if the whole text is not a number.
std::optional<double> NumberOf(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::size_t OneOf(const plan::Axis& axis, const std::string& text) {
  const figures::NamedValues values = figures::FindValues(axis, text);
  if (values.indices.size() == 1 && values.unknown.empty()) return values.indices[0];
  if (text.find('=') != text.npos)
    throw StoreError(
        fmt::format("{0}={1}: this needs one value of the axis; for several axes, repeat "
                    "the option: --select {0}=… --select OTHER=…",
                    axis.name, text));
  throw StoreError(fmt::format("{}={}: {}the axis has the values {}", axis.name, text,
                               values.indices.empty() ? "" : "there are several; ",
                               figures::ValuesText(axis)));
}

std::uint64_t RepeatOf(const std::string& value, std::uint64_t repeats) {
  const auto number = NumberOf(value);
  if (!number || !(*number >= 0) || *number != std::floor(*number) ||
      *number >= static_cast<double>(repeats))
    throw StoreError(fmt::format("rep={}: the repeats are 0 to {}", value, repeats - 1));
  return static_cast<std::uint64_t>(*number);
}

}  // namespace

void Select(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
            const std::vector<figures::AxisSelection>& selections,
            results::ResultFile::Cell& cell) {
  for (const auto& [name, value] : selections) {
    if (name == "rep") {
      cell.rep = RepeatOf(value, repeats);
      continue;
    }
    std::vector<std::string> names;
    bool is_found = false;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      names.push_back(axes[i].name);
      if (axes[i].name != name) continue;
      cell.at[i] = OneOf(axes[i], value);
      is_found = true;
    }
    if (is_found) continue;
    names.emplace_back("rep");
    throw StoreError(
        fmt::format("there is no axis '{}'; there are {}", name, fmt::join(names, ", ")));
  }
}

std::string CellName(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
                     const results::ResultFile::Cell& cell) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < axes.size(); ++i)
    words.push_back(
        fmt::format("{} {}", axes[i].name, terminal::CoordinateText(axes[i], cell.at[i])));
  if (repeats > 1) words.push_back(fmt::format("rep {}", cell.rep));
  return fmt::format("{}", fmt::join(words, ", "));
}

namespace {

using results::ResultFile;

constexpr std::size_t kPose = protocol::kPoseSize, kBox = protocol::kBoxSize;

void RequireBodies(const plan::Scene& scene) {
  if (analysis::TraceOf(scene))
    throw StoreError(
        "a run on a trace has boxes and no bodies: view the run that the trace was recorded from");
}

/// The word of `record` that shows how the scene moves.
std::string_view MotionWord(const plan::Scene& scene) {
  return analysis::HasSoft(scene) ? "vertices" : "poses";
}

/// Places the objects, for a recording without poses.
void Start(SceneRecording& recording) {
  recording.state = layouts::MakeInitialState(recording.scene);
  for (const layouts::ObjectState& object : recording.state.objects)
    if (analysis::IsSoft(recording.scene.groups[object.group]))
      for (const Eigen::Vector3d& node : layouts::NodesAbout(recording.scene, object))
        for (const double value : Eigen::Vector3d(object.pose.position + node))
          recording.nodes.push_back(value);
  for (const layouts::ObjectState& object : recording.state.objects) {
    const auto [p, q] = objects::OriginOf(object.solid, object.pose);
    for (const double value : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()})
      recording.poses.push_back(value);
  }
  recording.unmoved.assign(recording.state.objects.size(), 0);
  if (std::ranges::any_of(recording.scene.groups, layouts::IsPile))
    recording.notices.emplace_back(
        "The objects of a pile are shown where they are dropped from: they settle before the first "
        "cycle, which a run with `record timing, counts, poses` shows.");
}

/// Tells which height fields are drawn without all of their heights.
void NoteCoarseHeights(SceneRecording& recording) {
  std::set<std::string> names;
  for (const layouts::ObjectState& object : recording.state.objects) {
    if (!object.solid.IsSurface() || !object.solid.compound->form().heights) continue;
    const objects::ConvexDecomposition& form = object.solid.compound->form();
    const terrain::HeightGrid& grid = form.heights->grid();
    const std::size_t columns = HeightStep(grid.columns), rows = HeightStep(grid.rows);
    if (columns * rows > 1 && names.insert(form.name).second)
      recording.notices.push_back(
          fmt::format("Of {}, one height in {} is drawn: objects may seem to float or to sink. The "
                      "run has all of them.",
                      form.name, columns * rows));
  }
}

/// Reads a recording frame by frame.
class FrameReader {
 public:
  FrameReader(const ResultFile& file, const ResultFile::Cell& cell, SceneRecording& recording)
      : file_(file), cell_(cell), out_(recording), objects_(recording.ObjectCount()) {
    if (!recording.has_contacts) return;
    std::uint64_t rows = 0;
    for (const double count : file.ReadSeries("contacts", cell)) {
      first_contact_.push_back(rows);
      rows += static_cast<std::uint64_t>(std::max(count, 0.0));
    }
    first_contact_.push_back(rows);
  }

  double BytesPerFrame(bool has_boxes) const {
    double bytes = static_cast<double>(objects_ * (kPoseBytes + (has_boxes ? kBoxBytes : 0)));
    if (!first_contact_.empty())
      bytes += static_cast<double>(first_contact_.back() * kContactBytes) /
               static_cast<double>(first_contact_.size());
    return bytes;
  }

  void Read(std::uint64_t cycle, bool has_boxes) {
    const std::vector<double> now = Poses(cycle);
    const std::vector<double> before = cycle == 0 ? std::vector<double>() : Poses(cycle - 1);
    for (std::size_t i = 0; i < objects_; ++i) {
      const auto at = static_cast<std::ptrdiff_t>(i * kPose);
      out_.unmoved.push_back(
          !before.empty() &&
          std::equal(now.begin() + at, now.begin() + at + kPose, before.begin() + at));
    }
    out_.poses.insert(out_.poses.end(), now.begin(),
                      now.begin() + static_cast<std::ptrdiff_t>(objects_ * kPose));
    if (has_boxes) {
      const std::vector<double> boxes = ReadCycle("boxes", kBox, cycle);
      out_.boxes.insert(out_.boxes.end(), boxes.begin(),
                        boxes.begin() + static_cast<std::ptrdiff_t>(objects_ * kBox));
    }
    if (out_.has_contacts)
      out_.contacts.push_back(file_.ReadContacts(
          cell_, first_contact_[cycle], first_contact_[cycle + 1] - first_contact_[cycle]));
  }

 private:
  const std::vector<double>& Poses(std::uint64_t cycle) {
    for (auto& [known, poses] : last_)
      if (known == cycle) return poses;
    std::swap(last_[0], last_[1]);
    last_[1] = {cycle, ReadCycle("poses", kPose, cycle)};
    if (!has_origins_) ToOrigins(last_[1].second);
    return last_[1].second;
  }

  /// Of bodies, as earlier versions recorded them.
  void ToOrigins(std::vector<double>& poses) const {
    for (std::size_t i = 0; i < objects_; ++i) {
      double* pose = &poses[i * kPose];
      const auto [p, q] = objects::OriginOf(
          out_.state.objects[i].solid,
          {{pose[0], pose[1], pose[2]}, Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5])});
      const double origin[kPose] = {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
      std::copy_n(origin, kPose, pose);
    }
  }

  /// `width` values for each object, and possibly more.
  std::vector<double> ReadCycle(const char* series, std::size_t width, std::uint64_t cycle) const {
    std::vector<double> values = file_.ReadCycle(series, cell_, cycle);
    if (values.size() < objects_ * width)
      throw StoreError(
          fmt::format("its {} have fewer objects than its plan: run it again", series));
    return values;
  }

  const ResultFile& file_;
  const ResultFile::Cell& cell_;
  SceneRecording& out_;
  const std::size_t objects_;
  const bool has_origins_ = file_.HasPosesOfOrigins();
  std::vector<std::uint64_t> first_contact_;
  std::pair<std::uint64_t, std::vector<double>> last_[2] = {{~0ULL, {}}, {~0ULL, {}}};
};

/// The last cycle of the frames; throws for cycles that did not run.
std::uint64_t LastCycle(const FrameChoice& choice, const SceneRecording& recording) {
  if (choice.first >= recording.n_cycles || choice.last.value_or(choice.first) < choice.first ||
      choice.last.value_or(0) >= recording.n_cycles)
    throw StoreError(fmt::format("--cycles {}..{}: the cycles of the run are 0 to {}", choice.first,
                                 choice.last ? fmt::format("{}", *choice.last) : "",
                                 recording.n_cycles - 1));
  return choice.last.value_or(recording.n_cycles - 1);
}

void ChooseStep(double bytes_per_frame, const FrameChoice& choice, std::uint64_t last,
                SceneRecording& recording) {
  const double bytes = bytes_per_frame * static_cast<double>(last - choice.first + 1);
  const auto fitting = static_cast<std::uint64_t>(
      std::max(1.0, std::ceil(bytes / static_cast<double>(choice.budget_bytes))));
  recording.every = choice.every.value_or(fitting);
  if (recording.every > 1 && !choice.every)
    recording.notices.push_back(
        fmt::format("One cycle in {} is shown, of {} to {}: with all of them the page would be too "
                    "large; --cycles A..B shows a part of the run in finer steps.",
                    recording.every, choice.first, last));
}

void ReadFrames(const ResultFile& file, const ResultFile::Cell& cell, const FrameChoice& choice,
                SceneRecording& recording) {
  const std::uint64_t last = LastCycle(choice, recording);
  recording.state = layouts::DrawObjects(recording.scene);
  const auto& record = recording.scene.world.Words("record");
  const auto records = [&](const char* word) {
    return std::ranges::find(record, word) != record.end();
  };
  const bool has_boxes = records("boxes");
  recording.has_contacts = records("contacts") && file.Has("contact_first");
  FrameReader reader(file, cell, recording);
  ChooseStep(reader.BytesPerFrame(has_boxes), choice, last, recording);
  for (std::uint64_t cycle = choice.first; cycle <= last; cycle += recording.every) {
    recording.cycles.push_back(cycle);
    reader.Read(cycle, has_boxes);
  }
}

/// Adds the pose of each object in a frame: of a soft body, the middle of its nodes, not turned.
/// `poses`: those recorded, without values in a file in which only soft bodies moved.
void AddSoftPoses(std::span<const double> nodes, std::span<const double> poses,
                  SceneRecording& recording) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < recording.state.objects.size(); ++i) {
    const layouts::ObjectState& object = recording.state.objects[i];
    const plan::Group& group = recording.scene.groups[object.group];
    auto [p, q] = objects::OriginOf(object.solid, object.pose);
    if (poses.size() >= (i + 1) * kPose && std::isfinite(poses[i * kPose])) {
      const double* pose = &poses[i * kPose];
      p = {pose[0], pose[1], pose[2]};
      q = {pose[6], pose[3], pose[4], pose[5]};
    } else if (analysis::IsSoft(group)) {
      const std::uint64_t count = analysis::NodeCount(group.settings.Get("type"));
      p.setZero();
      for (std::uint64_t node = 0; node < count; ++node, at += 3)
        p += Eigen::Vector3d(nodes[at], nodes[at + 1], nodes[at + 2]) / static_cast<double>(count);
      q.setIdentity();
    }
    for (const double value : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()})
      recording.poses.push_back(value);
    recording.unmoved.push_back(0);
  }
}

/// The same for a run with soft bodies, from `record vertices`.
void ReadSoftFrames(const ResultFile& file, const ResultFile::Cell& cell, const FrameChoice& choice,
                    SceneRecording& recording) {
  const std::uint64_t last = LastCycle(choice, recording);
  recording.state = layouts::MakeInitialState(recording.scene);
  const std::size_t count = 3 * analysis::NodeCount(recording.scene);
  ChooseStep(
      static_cast<double>(kCoordinateBytes * count + kPoseBytes * recording.state.objects.size()),
      choice, last, recording);
  for (std::uint64_t cycle = choice.first; cycle <= last; cycle += recording.every) {
    recording.cycles.push_back(cycle);
    const std::vector<double> nodes = file.ReadCycle("vertex_positions", cell, cycle);
    if (nodes.size() < count)
      throw StoreError("its vertices have fewer nodes than its plan: run it again");
    AddSoftPoses(nodes,
                 file.Has("poses") ? file.ReadCycle("poses", cell, cycle) : std::vector<double>(),
                 recording);
    recording.nodes.insert(recording.nodes.end(), nodes.begin(),
                           nodes.begin() + static_cast<std::ptrdiff_t>(count));
  }
}

void ReadAllSeries(const ResultFile& file, const ResultFile::Cell& cell,
                   SceneRecording& recording) {
  if (recording.n_cycles == 0) return;
  const std::string unit = figures::CountsInstructions(file) ? kInstructions : "ns";
  if (file.Has("duration"))
    for (std::size_t i = 0; i < protocol::kPhaseCount; ++i)
      recording.durations.push_back({std::string(protocol::PhaseNames()[i]), unit,
                                     file.ReadDuration(static_cast<protocol::Phase>(i), cell)});
  for (const protocol::Series& series : protocol::AllSeries()) {
    if (series.shape != protocol::SeriesShape::kScalar || !file.Has(series.name)) continue;
    CycleSeries values{std::string(series.name),
                       series.unit == "ns" ? unit : std::string(series.unit),
                       file.ReadSeries(series.name, cell)};
    if (series.type == protocol::SeriesType::kInt32)
      for (double& value : values.values)
        if (value < 0) value = std::nan("");
    if (std::ranges::any_of(values.values, [](double value) { return std::isfinite(value); }))
      recording.series.push_back(std::move(values));
  }
}

/// The errors of the run at its samples, if it is compared with a truth.
void ReadErrors(const ResultFile& file, const ResultFile::Cell& cell, SceneRecording& recording) {
  const auto sampling = analysis::SamplingOf(recording.scene);
  if (!sampling || recording.n_cycles == 0) return;
  for (const schema::ErrorInfo& error : schema::Errors()) {
    if (!file.Has(error.series)) continue;
    CycleSeries series{fmt::format("error of {}", error.name), std::string(error.unit),
                       file.ReadSamples(error.series, cell), sampling->interval_s};
    if (std::ranges::any_of(series.values, [](double value) { return std::isfinite(value); }))
      recording.series.push_back(std::move(series));
  }
}

const plan::Run& FindRun(const plan::Plan& plan, const ResultFile::Cell& cell) {
  for (const plan::Run& run : plan.runs)
    if (run.at == cell.at && run.rep == cell.rep) return run;
  throw StoreError(fmt::format("{}: this run was skipped by `skip`; choose another by --select",
                               CellName(plan.axes, plan.repeats, cell)));
}

}  // namespace

void ParseCycles(const std::string& text, FrameChoice& choice) {
  const auto number = [&](std::string_view part) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size())
      throw StoreError(fmt::format("--cycles {}: write A..B, two cycles from 0 on", text));
    return value;
  };
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) {
    choice.first = number(text);
    choice.last = choice.first;
    return;
  }
  const std::string_view from = std::string_view(text).substr(0, dots),
                         to = std::string_view(text).substr(dots + 2);
  if (!from.empty()) choice.first = number(from);
  if (!to.empty()) choice.last = number(to);
}

ResultFile::Cell DefaultCell(const ResultFile& file) {
  const std::vector<ResultFile::Cell> cells = figures::AllCells(file);
  const auto ran = std::ranges::find_if(cells, [&](const ResultFile::Cell& cell) {
    const results::Status status = file.ReadStatus(cell);
    return status != results::Status::kMissing && status != results::Status::kSkipped &&
           file.ReadCycleCount(cell) > 0;
  });
  return ran == cells.end() ? cells.front() : *ran;
}

SceneRecording ReadRecording(const ResultFile& file, const ResultFile::Cell& cell,
                             const FrameChoice& choice) {
  const auto plan = figures::ReadPlan(file);
  if (!plan)
    throw StoreError(
        "its plan is from another version of cdb, and bodies cannot be drawn: run it again, or use "
        "the cdb that wrote it");
  const plan::Run& run = FindRun(*plan, cell);
  RequireBodies(run.scene);
  SceneRecording recording;
  recording.benchmark = file.benchmark();
  recording.title = file.title();
  recording.name = CellName(file.axes(), file.repeats(), cell);
  recording.scene = run.scene;
  recording.is_run = true;
  recording.status = file.ReadStatus(cell);
  recording.judgement = file.ReadJudgement(cell);
  if (file.Has("unchecked")) recording.unchecked = file.ReadText("unchecked", cell);
  if (recording.status != results::Status::kMissing) {
    recording.message = file.ReadText("message", cell);
    recording.n_cycles = file.ReadCycleCount(cell);
  }
  ReadAllSeries(file, cell, recording);
  ReadErrors(file, cell, recording);
  const bool is_soft = analysis::HasSoft(run.scene);
  if (is_soft && run.scene.world.Lists("record", "vertices") && recording.n_cycles > 0) {
    ReadSoftFrames(file, cell, choice, recording);
    return recording;
  }
  if (run.scene.world.Lists("record", "poses") && recording.n_cycles > 0) {
    ReadFrames(file, cell, choice, recording);
    NoteCoarseHeights(recording);
    return recording;
  }
  if (choice.first != 0 || choice.last || choice.every)
    throw StoreError(
        fmt::format("--cycles and --every need {0}, but it has none: run it again with `record "
                    "timing, counts, {0}`",
                    MotionWord(run.scene)));
  recording.notices.push_back(
      recording.n_cycles == 0
          ? fmt::format("This run is {} and has no cycles: the start of its scene is shown.",
                        results::StatusName(recording.status))
          : fmt::format("This run has no {0}: the start of its scene is shown. To see it move, add "
                        "`{0}` to `record`, as in `record timing, counts, {0}`, and run it again.",
                        MotionWord(run.scene)));
  Start(recording);
  NoteCoarseHeights(recording);
  return recording;
}

SceneRecording StartOf(const plan::Plan& plan, const plan::Run& run) {
  RequireBodies(run.scene);
  SceneRecording recording;
  recording.benchmark = plan.benchmark;
  recording.title = plan.title;
  recording.name = CellName(plan.axes, plan.repeats, {run.at, run.rep});
  recording.scene = run.scene;
  recording.notices.push_back(
      fmt::format("The start of the scene, without a run: `cdb run` with `record timing, counts, "
                  "{}` records how it moves.",
                  MotionWord(run.scene)));
  Start(recording);
  NoteCoarseHeights(recording);
  return recording;
}

}  // namespace cdb::view
