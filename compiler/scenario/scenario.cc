#include "compiler/scenario/scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "compiler/plan/gltf_buffers.h"
#include "compiler/plan/input_file.h"
#include "compiler/plan/kept_files.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/schema.h"
#include "dsl/parser.h"

namespace cdb::scenario {
namespace {

constexpr std::size_t kMaxUses = 64;

/// Calls `visit` for `file` and all files it uses, each once, nearest first; stops when `visit`
/// returns true.
template <typename Visit>
void ForEachVisible(const ScenarioFile& file, Visit visit) {
  std::vector<const ScenarioFile*> queue = {&file};
  for (std::size_t i = 0; i < queue.size(); ++i) {
    if (visit(*queue[i])) return;
    for (const ScenarioFile* used : queue[i]->uses)
      if (std::ranges::find(queue, used) == queue.end()) queue.push_back(used);
  }
}

template <typename Item, typename Visit>
void ForEachItem(const ScenarioFile& file, Visit visit) {
  for (const auto& item : file.tree.items)
    if (const auto* found = std::get_if<Item>(&item)) visit(*found);
}

}  // namespace

Scenario::Scenario(const std::string& path, const std::string& library, const ReadFile& read,
                   const PluginSource& plugins, const analysis::ReadTrace& read_trace,
                   const analysis::ReadPoses& read_poses, const analysis::ReadModel& read_model,
                   const analysis::ReadRobot& read_robot, dsl::Diagnostics& diagnostics)
    : library_(library),
      read_(read),
      describe_(plugins.describe),
      read_trace_(read_trace),
      read_poses_(read_poses),
      read_model_(read_model),
      read_robot_(read_robot) {
  for (const std::string& file : plugins.files) LoadPlugin(file, nullptr, diagnostics);
  main_ = Load(path, nullptr, diagnostics);
}

const ScenarioFile* Scenario::Load(const std::string& path, const dsl::Use* use,
                                   dsl::Diagnostics& diagnostics) {
  for (const ScenarioFile* open : loading_) {
    if (open->path != path) continue;
    diagnostics.Report(kCircular, use->path_span, fmt::format("'{}' refers to itself", use->path),
                       "files cannot use one another in a circle");
    is_complete_ = false;
    return nullptr;
  }
  for (const auto& file : files_)
    if (file->path == path) return file.get();

  ScenarioFile& file = *files_.emplace_back(std::make_unique<ScenarioFile>());
  file.path = path;
  std::string why;
  std::optional<std::string> text = read_(path, why);
  // A missing main file has its location on the command line; an empty text stands for it.
  const auto source = std::make_shared<const text::Source>(path, text ? std::move(*text) : "");
  if (!text) {
    file.tree.source = source;
    const text::Span span = use != nullptr ? use->path_span : text::Span{source.get(), 0, 0};
    diagnostics.Report(kNoSuchFile, span, fmt::format("cannot read '{}': {}", path, why));
    is_complete_ = false;
    return nullptr;
  }
  file.tree = dsl::Parse(source, diagnostics);
  is_complete_ = is_complete_ && file.tree.damage == dsl::Damage::kNone;
  ForEachItem<dsl::Let>(file, [&](const dsl::Let& let) { file.lets.emplace(let.name.text, &let); });
  ForEachItem<dsl::Benchmark>(file, [&](const dsl::Benchmark& benchmark) {
    file.benchmarks.emplace(benchmark.name.text, &benchmark);
  });
  LoadUsed(file, diagnostics);
  ForEachItem<dsl::Let>(file, [&](const dsl::Let& let) {
    let_order_.emplace(&let, static_cast<int>(let_order_.size()));
  });
  return &file;
}

void Scenario::LoadUsed(ScenarioFile& file, dsl::Diagnostics& diagnostics) {
  loading_.push_back(&file);
  ForEachItem<dsl::Use>(file, [&](const dsl::Use& wanted) {
    if (wanted.path_span.source == nullptr) return;  // not a path; reported by the parser
    if (files_.size() + plugin_files_.size() >= kMaxUses) {
      diagnostics.Report(kTooManyRuns, wanted.span,
                         fmt::format("a scenario can read at most {} files", kMaxUses));
      return;
    }
    if (wanted.detector) {
      LoadPlugin(Find(wanted.path, file.path, ""), &wanted, diagnostics);
    } else if (const ScenarioFile* used =
                   Load(Find(wanted.path, file.path, ".cdb"), &wanted, diagnostics)) {
      file.uses.push_back(used);
    }
  });
  loading_.pop_back();
}

std::string Scenario::Find(const std::string& wanted, const std::string& path,
                           std::string_view extension) const {
  namespace fs = std::filesystem;
  const fs::path beside = fs::path(path).parent_path() / wanted;
  std::vector<std::string> candidates = {beside.lexically_normal().string()};
  if (!library_.empty())
    candidates.push_back((fs::path(library_) / wanted).lexically_normal().string());
  for (std::string& candidate : candidates)
    if (!candidate.ends_with(extension)) candidate += extension;
  std::string ignored;
  for (const std::string& candidate : candidates)
    if (read_(candidate, ignored)) return candidate;
  return candidates[0];
}

void Scenario::LoadPlugin(const std::string& path, const dsl::Use* use,
                          dsl::Diagnostics& diagnostics) {
  if (!plugin_files_.emplace(path, use).second) return;
  const text::Span span = use != nullptr ? use->path_span : text::Span{};
  std::string why;
  const auto bytes = read_(path, why);
  if (!bytes) {
    is_complete_ = false;
    diagnostics.Report(kNoSuchFile, span, fmt::format("cannot read '{}': {}", path, why),
                       use != nullptr
                           ? "the path is relative to the folder of the file that names it"
                           : "--plugin takes a shared library");
    return;
  }
  auto detectors = describe_ ? describe_(*bytes, path, why) : std::nullopt;
  if (!detectors) {
    is_complete_ = false;
    diagnostics.Report(kUnavailable, span,
                       describe_ ? why : fmt::format("'{}' cannot be read here", path));
    return;
  }
  const std::string hash = plan::Sha256Hex(*bytes);
  for (schema::PluginDetector& detector : *detectors) {
    detector.path = path;
    detector.sha256 = hash;
    AddDetector(std::move(detector), use, diagnostics);
  }
}

void Scenario::AddDetector(schema::PluginDetector detector, const dsl::Use* use,
                           dsl::Diagnostics& diagnostics) {
  const text::Span span = use != nullptr ? use->path_span : text::Span{};
  const auto place =
      std::ranges::lower_bound(plugins_, detector.name, {}, &schema::PluginDetector::name);
  if (place != plugins_.end() && place->name == detector.name) {
    const dsl::Use* first = plugin_files_.at(place->path);
    std::vector<dsl::Note> notes;
    if (first != nullptr) notes.push_back({first->path_span, "the other is used here"});
    diagnostics.Report(kSetTwice, span,
                       fmt::format("'{}' and '{}' both have a detector '{}'", place->path,
                                   detector.path, detector.name),
                       "remove one of them, or rename its detector", std::move(notes));
  } else if (std::ranges::any_of(schema::Schema(), [&](const schema::Parameter& parameter) {
               return parameter.TakesDetectors() && parameter.HasWord(detector.name);
             })) {
    diagnostics.Report(
        kSetTwice, span,
        fmt::format("'{}' has a detector '{}', which is also the name of one of cdb's",
                    detector.path, detector.name),
        "rename it; `cdb list detectors` lists the names in use");
  } else {
    plugins_.insert(place, std::move(detector));
  }
}

void Scenario::CheckNames(dsl::Diagnostics& diagnostics) const {
  const auto once = [&](auto& seen, const dsl::Name& name, const char* what) {
    if (name.span.source == nullptr) return;  // it has no name; reported by the parser
    const auto [first, is_new] = seen.emplace(name.text, &name);
    if (!is_new)
      diagnostics.Report(kSetTwice, name.span,
                         fmt::format("there is already a {} '{}'", what, name.text), {},
                         {{first->second->span, "the first is here"}});
  };
  for (const auto& file : files_) {
    std::map<std::string_view, const dsl::Name*> lets, benchmarks;
    ForEachItem<dsl::Let>(*file, [&](const dsl::Let& let) { once(lets, let.name, "let"); });
    ForEachItem<dsl::Benchmark>(
        *file, [&](const dsl::Benchmark& b) { once(benchmarks, b.name, "benchmark"); });
  }
}

std::vector<BenchmarkRef> Scenario::Benchmarks() const {
  std::vector<BenchmarkRef> all;
  if (main_ != nullptr)
    ForEachItem<dsl::Benchmark>(*main_, [&](const dsl::Benchmark& benchmark) {
      all.push_back({main_, &benchmark});
    });
  return all;
}

std::optional<BenchmarkRef> Scenario::FindBenchmark(const ScenarioFile& file, std::string_view name,
                                                    const dsl::Benchmark* other_than) const {
  std::optional<BenchmarkRef> found;
  ForEachVisible(file, [&](const ScenarioFile& visible) {
    const auto benchmark = visible.benchmarks.find(name);
    if (benchmark != visible.benchmarks.end() && benchmark->second != other_than)
      found = {&visible, benchmark->second};
    return found.has_value();
  });
  return found;
}

std::optional<LetRef> Scenario::FindLet(const ScenarioFile& file, std::string_view name) const {
  std::optional<LetRef> found;
  ForEachVisible(file, [&](const ScenarioFile& visible) {
    const auto let = visible.lets.find(name);
    if (let != visible.lets.end()) found = {&visible, let->second};
    return found.has_value();
  });
  return found;
}

std::vector<std::string_view> Scenario::BenchmarkNames(const ScenarioFile& file) const {
  std::vector<std::string_view> names;
  ForEachVisible(file, [&](const ScenarioFile& visible) {
    ForEachItem<dsl::Benchmark>(visible,
                                [&](const dsl::Benchmark& b) { names.push_back(b.name.text); });
    return false;
  });
  return names;
}

std::vector<std::string_view> Scenario::LetNames(const ScenarioFile& file) const {
  std::vector<std::string_view> names;
  ForEachVisible(file, [&](const ScenarioFile& visible) {
    ForEachItem<dsl::Let>(visible, [&](const dsl::Let& l) { names.push_back(l.name.text); });
    return false;
  });
  return names;
}

int Scenario::LetOrder(const dsl::Let& let) const { return let_order_.at(&let); }

std::optional<std::string> Scenario::HashOf(const std::string& path, std::string& why) const {
  static plan::FileMemo<FileHash> kept;
  const auto [hash, is_new] = hashes_.try_emplace(path);
  if (is_new)
    hash->second = kept.Of(path, "", [&] {
      FileHash made;
      auto bytes = read_(path, made.why);
      if (bytes)
        bytes =
            plan::WithGltfBuffers(path, *std::move(bytes), read_, plan::kMaxInputBytes, made.why);
      if (bytes) made.sha256 = plan::Sha256Hex(*bytes);
      return made;
    });
  why = hash->second.why;
  return hash->second.sha256;
}

std::optional<analysis::TraceFacts> Scenario::TraceAt(const std::string& path,
                                                      std::string& why) const {
  const auto [trace, is_new] = traces_.try_emplace(path);
  if (is_new && read_trace_) trace->second.facts = read_trace_(path, trace->second.why);
  why = read_trace_ ? trace->second.why : "nothing here reads traces";
  return trace->second.facts;
}

std::optional<analysis::PoseFacts> Scenario::PosesAt(const schema::Call& poses,
                                                     analysis::PoseFault& why) const {
  const auto [table, is_new] = poses_.try_emplace(schema::LabelOf(poses));
  if (is_new && read_poses_) table->second.facts = read_poses_(poses, table->second.why);
  why = read_poses_ ? table->second.why : analysis::PoseFault{true, "nothing here reads poses", {}};
  return table->second.facts;
}

std::optional<analysis::ModelFacts> Scenario::ModelAt(const schema::Value& type,
                                                      analysis::ModelFault& why) const {
  // Without the number of nodes that a plan states.
  const auto [model, is_new] = models_.try_emplace(schema::LabelOf(type));
  if (is_new && read_model_) model->second.facts = read_model_(type, model->second.why);
  why = model->second.why;
  return model->second.facts;
}

std::shared_ptr<const analysis::Robot> Scenario::RobotAt(
    const std::string& path, const analysis::RobotOptions& options,
    std::vector<analysis::RobotFault>& faults) const {
  auto read = std::ranges::find_if(robots_, [&](const RobotRead& known) {
    return known.path == path && known.options == options;
  });
  if (read == robots_.end()) {
    read = robots_.insert(read, {path, options, nullptr, {}});
    if (!read_robot_)
      read->faults.push_back({fmt::format("{}: robots cannot be read here", path), ""});
    else if (auto robot = read_robot_(path, options, read->faults))
      read->robot = std::make_shared<const analysis::Robot>(*std::move(robot));
  }
  faults = read->faults;
  return read->robot;
}

std::vector<std::string> Scenario::RobotTexts() const {
  std::vector<std::string> texts;
  for (const RobotRead& read : robots_)
    if (read.robot != nullptr) texts.push_back(read.robot->summary);
  for (const std::string& note : robot_notes_) texts.push_back(note + "\n");
  return texts;
}

void Scenario::NoteOnRobot(std::string line) const {
  if (std::ranges::find(robot_notes_, line) == robot_notes_.end())
    robot_notes_.push_back(std::move(line));
}

std::vector<std::string> Scenario::ModelTexts() const {
  std::vector<std::string> texts;
  for (const auto& [type, model] : models_)
    if (model.facts && !model.facts->text.empty()) texts.push_back(model.facts->text);
  return texts;
}

std::string Scenario::FullText() const {
  std::string text;
  for (const auto& file : files_) {
    if (file.get() != main_) text += fmt::format("\n# ---- {} ----\n", file->path);
    text += file->tree.source->text();
  }
  return text;
}

}  // namespace cdb::scenario
