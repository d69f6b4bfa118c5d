// `cdb view`: writes a page with the bodies of a run, or of the start of a scenario, in 3-D.

#include "runtime/cli/view_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compiler/analysis/population.h"
#include "compiler/analysis/soft.h"
#include "dsl/diagnostics.h"
#include "dsl/text/utf8.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/pages/page/page.h"
#include "runtime/pages/serve/server.h"
#include "runtime/pages/view/glb.h"
#include "runtime/pages/view/scene_document.h"
#include "runtime/pages/view/selection.h"
#include "runtime/protocol/bytes_text.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/store.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

struct ViewArguments {
  std::vector<std::string> files;
  std::optional<std::string> benchmark;
  std::string out, gltf, cycles, every;
  std::vector<std::string> select, beside;
  std::vector<std::string> settings;  ///< NAME=VALUE, over those of the scenario
  bool serve = false;
};

/// A .glb file must be smaller than 4 GB; its poses take less than twice the bytes of a page's.
constexpr std::size_t kGltfBudget = 1'000'000'000;

using figures::AxisSelection;
using view::SceneRecording;

/// Decided by the contents of the file, or by its name if it is missing or empty.
bool IsResults(const std::string& file) {
  return file.ends_with(".h5") || file.ends_with(".nc") || results::IsStored(file);
}

std::vector<AxisSelection> ParseAll(const std::vector<std::string>& words) {
  std::vector<AxisSelection> selections;
  for (const std::string& word : words) selections.push_back(figures::ParseSelection(word));
  return selections;
}

bool HasAxis(const std::vector<plan::Axis>& axes, const AxisSelection& selection) {
  return selection.axis == "rep" ||
         std::ranges::find(axes, selection.axis, &plan::Axis::name) != axes.end();
}

/// The elements of `selections` that apply to this sweep. With two files, one of them may lack an
/// axis; `used` receives the axes that were found.
std::vector<AxisSelection> ForSweep(const std::vector<plan::Axis>& axes,
                                    std::vector<AxisSelection> selections,
                                    const ViewArguments& arguments, std::set<std::string>& used) {
  if (arguments.files.size() > 1)
    std::erase_if(selections,
                  [&](const AxisSelection& selection) { return !HasAxis(axes, selection); });
  for (const AxisSelection& selection : selections) used.insert(selection.axis);
  return selections;
}

view::FrameChoice FramesOf(const ViewArguments& arguments, std::size_t runs) {
  view::FrameChoice choice;
  choice.budget_bytes /= runs;
  const bool is_page = arguments.gltf.empty() || !arguments.out.empty();
  if (!is_page) choice.budget_bytes = kGltfBudget;
  if (!arguments.cycles.empty()) view::ParseCycles(arguments.cycles, choice);
  if (arguments.every.empty()) return choice;
  std::uint64_t every = 0;
  const char* end = arguments.every.data() + arguments.every.size();
  const auto parsed = std::from_chars(arguments.every.data(), end, every);
  if (parsed.ec != std::errc() || parsed.ptr != end || every == 0)
    throw options::CommandError(
        fmt::format("--every {}: expected a whole number of cycles, at least 1", arguments.every));
  choice.every = every;
  return choice;
}

/// The recordings from the files of a command line.
struct Viewed {
  std::vector<SceneRecording> recordings;
  std::set<std::string> axes;  ///< named by --select
};

/// The selected run of one results file, and the one beside it.
void ViewResults(const std::string& name, const ViewArguments& arguments,
                 const view::FrameChoice& choice, Viewed& viewed) {
  std::vector<SceneRecording>& recordings = viewed.recordings;
  try {
    const results::ResultFile file(name);
    results::ResultFile::Cell cell = view::DefaultCell(file);
    view::Select(file.axes(), file.repeats(),
                 ForSweep(file.axes(), ParseAll(arguments.select), arguments, viewed.axes), cell);
    recordings.push_back(view::ReadRecording(file, cell, choice));
    recordings.back().file = name;
    if (arguments.beside.empty()) return;
    view::Select(file.axes(), file.repeats(), ParseAll(arguments.beside), cell);
    recordings.push_back(view::ReadRecording(file, cell, choice));
    recordings.back().file = name;
  } catch (const std::exception& error) {
    const std::string what = error.what();
    throw options::CommandError(what.starts_with(name) ? what : fmt::format("{}: {}", name, what));
  }
}

const plan::Run& RunAt(const plan::Plan& plan, const std::vector<AxisSelection>& selections) {
  results::ResultFile::Cell cell{plan.runs.at(0).at, plan.runs[0].rep};
  view::Select(plan.axes, plan.repeats, selections, cell);
  for (const plan::Run& run : plan.runs)
    if (run.at == cell.at && run.rep == cell.rep) return run;
  throw options::CommandError(
      fmt::format("`skip` skips {}", view::CellName(plan.axes, plan.repeats, cell)));
}

/// False after diagnostics were printed.
bool ViewScenario(const std::string& name, const ViewArguments& arguments, Viewed& viewed) {
  std::vector<SceneRecording>& recordings = viewed.recordings;
  const std::vector<plan::Plan> plans = options::LoadPlans(name, arguments.benchmark);
  if (plans.empty()) return false;
  if (plans.size() > 1 && !arguments.benchmark) {
    std::string names;
    for (const plan::Plan& plan : plans) names += (names.empty() ? "" : ", ") + plan.benchmark;
    terminal::Say(fmt::format("{} has the benchmarks {}: this is {}; choose another by -b\n", name,
                              names, plans[0].benchmark));
  }
  try {
    std::vector<AxisSelection> selections =
        ForSweep(plans[0].axes, ParseAll(arguments.select), arguments, viewed.axes);
    recordings.push_back(view::StartOf(plans[0], RunAt(plans[0], selections)));
    recordings.back().file = name;
    if (arguments.beside.empty()) return true;
    for (AxisSelection& other : ParseAll(arguments.beside)) selections.push_back(std::move(other));
    recordings.push_back(view::StartOf(plans[0], RunAt(plans[0], selections)));
    recordings.back().file = name;
  } catch (const options::CommandError&) {
    throw;
  } catch (const std::exception& error) {
    throw options::CommandError(fmt::format("{}: {}", name, error.what()));
  }
  return true;
}

void CheckOptions(const ViewArguments& arguments) {
  if (!arguments.gltf.empty() && (arguments.files.size() > 1 || !arguments.beside.empty()))
    throw options::CommandError("--gltf writes one run: name one file, without --beside");
  if (!arguments.gltf.empty() && !arguments.gltf.ends_with(".glb"))
    throw options::CommandError(
        fmt::format("--gltf {}: the name of a binary glTF file must end in .glb", arguments.gltf));
  if (arguments.files.size() > 2)
    throw options::CommandError("a page shows one run, or two side by side: name one or two files");
  if (arguments.files.size() == 2 && !arguments.beside.empty())
    throw options::CommandError(
        "--beside is for two runs of one file; two files are already shown side by side");
  const bool has_results = std::ranges::any_of(arguments.files, IsResults);
  if (!has_results && !(arguments.cycles.empty() && arguments.every.empty()))
    throw options::CommandError(
        "--cycles and --every are for results; of a scenario, only the start is shown");
  if (has_results && arguments.benchmark)
    throw options::CommandError("-b is for scenarios; a results file has only one benchmark");
}

void Write(const std::string& file, const std::string& bytes, const char* use) {
  files::WriteWhole(bytes, file);
  terminal::Say(fmt::format("{}: {}; {}\n", file,
                            protocol::BytesText(static_cast<double>(bytes.size())), use));
}

void WritePage(const ViewArguments& arguments, const std::vector<SceneRecording>& recordings) {
  const SceneRecording& first = recordings[0];
  const std::string title = first.title.empty() ? first.benchmark : first.title;
  const std::string page = page::Assemble(page::ViewTemplate(), title + " (cdb view)",
                                          view::SceneDocument(title, recordings));
  // The name of the benchmark comes from a results file, which may contain anything; here it
  // becomes a file name.
  const std::string name = text::IsPlainName(first.benchmark) ? first.benchmark : "view";
  Write(arguments.out.empty() ? name + ".scene.html" : arguments.out, page, "open it in a browser");
}

/// Throws CommandError for options that --serve does not take: the browser chooses what to show.
void CheckServe(const ViewArguments& arguments) {
  if (arguments.files.size() != 1 || IsResults(arguments.files[0]))
    throw options::CommandError("--serve edits one scenario file: name it");
  for (const auto& [name, is_given] : {std::pair("-o", !arguments.out.empty()),
                                       {"--gltf", !arguments.gltf.empty()},
                                       {"--select", !arguments.select.empty()},
                                       {"--beside", !arguments.beside.empty()}})
    if (is_given)
      throw options::CommandError(fmt::format("{} is for a page in a file, not --serve", name));
}

/// Throws CommandError for two runs whose durations have different units.
void RequireOneClock(const std::vector<SceneRecording>& recordings) {
  if (recordings.size() < 2 || recordings[0].durations.empty() || recordings[1].durations.empty() ||
      recordings[0].durations[0].unit == recordings[1].durations[0].unit)
    return;
  const auto words = [](const SceneRecording& of) {
    return of.durations[0].unit == view::kInstructions ? "numbers of instructions" : "times";
  };
  throw options::CommandError(fmt::format(
      "{} has {} and {} has {}, which cannot be side by side: run both with the same `clock`",
      recordings[0].file, words(recordings[0]), recordings[1].file, words(recordings[1])));
}

options::ExitStatus View(const ViewArguments& arguments) {
  CheckOptions(arguments);
  if (arguments.serve) {
    CheckServe(arguments);
    return ServeScenario(arguments.files[0], arguments.benchmark);
  }
  const view::FrameChoice choice =
      FramesOf(arguments, arguments.files.size() > 1 || !arguments.beside.empty() ? 2 : 1);
  Viewed viewed;
  for (const std::string& file : arguments.files) {
    if (IsResults(file)) {
      ViewResults(file, arguments, choice, viewed);
    } else if (!ViewScenario(file, arguments, viewed)) {
      return options::ExitStatus::kScenarioError;
    }
  }
  for (const AxisSelection& selection : ParseAll(arguments.select))
    if (!viewed.axes.contains(selection.axis))
      throw options::CommandError(fmt::format("no file has the axis '{}'", selection.axis));
  const std::vector<SceneRecording>& recordings = viewed.recordings;
  RequireOneClock(recordings);
  for (const SceneRecording& recording : recordings) {
    terminal::Say(fmt::format(
        "{}{}{}: {} {}, {}\n", recording.file, recording.name.empty() ? "" : ", ", recording.name,
        recording.ObjectCount(), recording.ObjectCount() == 1 ? "object" : "objects",
        recording.cycles.empty() ? "the start" : fmt::format("{} frames", recording.FrameCount())));
    for (const std::string& notice : recording.notices) terminal::Say("  " + notice + "\n");
  }
  if (!arguments.gltf.empty() && analysis::HasSoft(recordings[0].scene))
    throw options::CommandError(
        fmt::format("--gltf {}: the file would lack the soft bodies of this scene, as it moves "
                    "rigid parts alone; use the page: cdb view -o scene.html",
                    arguments.gltf));
  if (!arguments.gltf.empty() && analysis::ComesOrGoes(recordings[0].scene))
    throw options::CommandError(fmt::format(
        "--gltf {}: objects come and go in this scene, and a node of glTF is there all the time; "
        "use the page: cdb view -o scene.html",
        arguments.gltf));
  if (!arguments.gltf.empty())
    Write(arguments.gltf, view::SceneGlb(recordings[0]), "open it in a program that reads glTF");
  if (arguments.gltf.empty() || !arguments.out.empty()) WritePage(arguments, recordings);
  return options::ExitStatus::kGood;
}

void DeclareView(options::Subcommand& command) {
  const auto arguments = std::make_shared<ViewArguments>();
  command.Required("FILE", arguments->files,
                   "results file or scenario; two files are shown side by side");
  command.Benchmark(arguments->benchmark);
  command.Out(arguments->out, "the page (default: BENCHMARK.scene.html)");
  command.Optional(
      "--gltf", arguments->gltf,
      "OUT.glb: write the animated scene as binary glTF 2.0; the page is written only with -o");
  command.Optional("--select", arguments->select,
                   "AXIS=VALUE…: the run of a sweep to show (default: the first that ran)");
  command.Optional("--beside", arguments->beside,
                   "AXIS=VALUE…: a second run beside it, which differs in these axes");
  command.Optional("--cycles", arguments->cycles, "A..B: only these cycles, from 0");
  command.Optional("--every", arguments->every, "only every N-th cycle");
  command.Flag("--serve", arguments->serve,
               "edit the scenario in a browser (values, text, scene and runs) until Ctrl-C");
  command.Set(arguments->settings);
  command.Action([arguments] {
    if (!arguments->settings.empty() && (arguments->serve || arguments->files.size() > 1))
      throw options::CommandError(arguments->serve ? "--serve edits the file itself; remove --set"
                                                   : "--set is for one scenario file at a time");
    options::SetInScenario(arguments->files[0], arguments->benchmark, arguments->settings);
    return View(*arguments);
  });
}

}  // namespace

/// Writes a page with the bodies of a run in 3-D, or those of a scenario at its start.
options::Command ViewCommand() {
  return {.name = "view",
          .help = "write a page that shows a run, or the start of a scenario, in 3-D",
          .declare = DeclareView};
}

namespace {

/// Reads the edited file from the editor and all others from the disk.
scenario::ReadFile ReadEdited(const std::string& file, const std::string& text) {
  return [file, text](const std::string& path, std::string& why) -> std::optional<std::string> {
    if (path == file) return text;
    return compiler::ReadFromDisk(path, why);
  };
}

std::string ChooseBenchmark(const std::string& file, const std::string& text,
                            const std::optional<std::string>& wanted) {
  const std::vector<std::string> names =
      options::CompileWith(file, ReadEdited(file, text), std::nullopt).benchmarks;
  if (names.empty())
    throw options::CommandError(
        fmt::format("{}: there is no benchmark to edit; `cdb check` explains why", file));
  if (!wanted) return names[0];
  if (std::ranges::find(names, *wanted) == names.end())
    throw options::CommandError(fmt::format("{} has no benchmark '{}'; there are {}", file, *wanted,
                                            fmt::join(names, ", ")));
  return *wanted;
}

}  // namespace

options::ExitStatus ServeScenario(const std::string& file,
                                  const std::optional<std::string>& benchmark) {
  if (options::FindScenario(file) != file)
    throw options::CommandError(fmt::format(
        "{} comes with cdb and cannot be edited: write a file that extends it, or copy it", file));
  const std::string text = options::ReadText(file);
  const auto compile = [](const std::string& path, const scenario::ReadFile& read) {
    return options::CompileWith(path, read, std::nullopt, {}, /*lists_runs=*/false);
  };
  const std::string chosen = ChooseBenchmark(file, text, benchmark);
  process::StopFlag stop;
  const process::StopOnSignals on_signals(stop);
  serve::Editor editor({file, chosen, text, compile, options::ScenarioLibrary()},
                       std::filesystem::read_symlink("/proc/self/exe"));
  serve::Serve(editor, stop.fd(), [](const std::string& address) {
    terminal::Print(fmt::format("{}\n", address));
    terminal::Flush();  // a program may be waiting for it
    terminal::Say("open this address in a browser on this machine; Ctrl-C ends\n");
  });
  return options::ExitStatus::kGood;
}

}  // namespace cdb::cli
