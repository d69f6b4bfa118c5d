// `cdb compare`: compares two results files of one benchmark, or several in order.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/report_page.h"
#include "runtime/printers/compare.h"
#include "runtime/protocol/series.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct CompareArguments {
  std::vector<std::string> files;  ///< results files, or folders of them
  std::vector<std::string> fail_above, fail_if, allow;
  std::string phase;  ///< empty: all
  std::string out;    ///< the page; empty: compare.html
  std::vector<std::string> select;
  bool is_markdown = false, is_latex = false, is_json = false, is_page = false, is_relative = false,
       lists_all = false;
};

std::optional<protocol::Phase> ParsePhase(const std::string& name) {
  if (name.empty()) return std::nullopt;
  const auto names = protocol::PhaseNames();
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    throw options::CommandError(fmt::format("--phase {}: there is no such phase; there are {}",
                                            name, fmt::join(names, ", ")));
  return static_cast<protocol::Phase>(found - names.begin());
}

figures::Finding ParseFinding(const std::string& option, const std::string& word) {
  std::vector<std::string_view> words;
  for (const figures::FindingInfo& info : figures::Findings()) {
    if (info.word == word) return info.finding;
    words.push_back(info.word);
  }
  throw options::CommandError(fmt::format(
      "{} {}: {}", option, word,
      options::Suggestion(word, words, fmt::format("there are {}", fmt::join(words, ", ")))));
}

/// `5%` for all findings that have a limit, `memory=2%` for one.
void SetLimit(figures::Gate& gate, const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string percent = equals == text.npos ? text : text.substr(equals + 1);
  const double limit = options::ParsePercent("--fail-above", percent);
  if (limit > 0 && limit < 0.01 && !percent.ends_with('%'))
    throw options::CommandError(fmt::format(
        "--fail-above {0}: write {0}% for a limit of {0} %, or {1:g}% for the fraction {0}",
        percent, 1e4 * limit));
  std::vector<std::string_view> words;
  for (const figures::FindingInfo& info : figures::Findings()) {
    if (!info.has_limit) continue;
    words.push_back(info.word);
    if (equals == text.npos || info.word == text.substr(0, equals))
      gate.SetLimit(info.finding, limit);
  }
  if (equals != text.npos && std::ranges::count(words, text.substr(0, equals)) == 0)
    throw options::CommandError(
        fmt::format("--fail-above {}: only {} have a limit", text, fmt::join(words, ", ")));
}

/// Limits of one finding count over those of all, whatever their order.
figures::Gate GateOf(const CompareArguments& arguments) {
  figures::Gate gate;
  for (const bool is_of_one : {false, true})
    for (const std::string& text : arguments.fail_above)
      if ((text.find('=') != text.npos) == is_of_one) SetLimit(gate, text);
  for (const std::string& word : arguments.fail_if)
    gate.SetFails(ParseFinding("--fail-if", word), true);
  for (const std::string& word : arguments.allow) {
    if (std::ranges::count(arguments.fail_if, word) > 0)
      throw options::CommandError(fmt::format("--fail-if and --allow both name {}", word));
    gate.SetFails(ParseFinding("--allow", word), false);
  }
  return gate;
}

figures::CompareOptions OptionsOf(const CompareArguments& arguments) {
  if (arguments.files.size() < 2)
    throw options::CommandError(
        "compare takes two or more results files, or two or more folders of them");
  options::CheckOneForm({{"--markdown", arguments.is_markdown},
                         {"--latex", arguments.is_latex},
                         {"--json", arguments.is_json},
                         {"--page", arguments.is_page}});
  if (!arguments.out.empty() && !arguments.is_page)
    throw options::CommandError("-o names the page: it needs --page");
  return {arguments.select, ParsePhase(arguments.phase), GateOf(arguments), arguments.is_relative,
          arguments.lists_all};
}

/// The shortest trailing parts of the paths that distinguish them: `a.h5`, `before/first.h5`.
std::vector<std::string> NamesOf(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (std::size_t parts = 1;; ++parts) {
    names.clear();
    bool is_whole = true;
    for (const std::string& path : paths) {
      const fs::path whole = fs::path(path).lexically_normal();
      std::vector<fs::path> all(whole.begin(), whole.end());
      is_whole = is_whole && all.size() <= parts;
      fs::path name;
      for (std::size_t i = all.size() - std::min(parts, all.size()); i < all.size(); ++i)
        name /= all[i];
      names.push_back(name.string());
    }
    if (is_whole || std::set(names.begin(), names.end()).size() == names.size()) return names;
  }
}

/// The names of the results files in a folder.
std::set<std::string> ResultsIn(const std::string& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".h5" && !entry.path().stem().string().ends_with(".trace"))
      names.insert(entry.path().filename().string());
  return names;
}

/// The files of each benchmark, in the order of the arguments. Files that are not in all folders
/// are noted in `comparisons`.
std::vector<std::vector<std::string>> FilesOf(const std::vector<std::string>& arguments,
                                              figures::Comparisons& comparisons) {
  std::error_code error;
  const auto folders = std::ranges::count_if(
      arguments, [&](const std::string& path) { return fs::is_directory(path, error); });
  if (folders == 0) return {arguments};
  if (folders < static_cast<std::ptrdiff_t>(arguments.size()))
    throw options::CommandError(
        "compare takes files or folders, not both: name the file in each folder");
  std::set<std::string> all;
  std::vector<std::set<std::string>> of_folders;
  for (const std::string& folder : arguments) {
    of_folders.push_back(ResultsIn(folder));
    all.insert(of_folders.back().begin(), of_folders.back().end());
  }
  std::vector<std::vector<std::string>> files;
  for (const std::string& name : all) {
    std::vector<std::string> paths;
    for (std::size_t i = 0; i < arguments.size(); ++i)
      if (of_folders[i].contains(name)) paths.push_back((fs::path(arguments[i]) / name).string());
    if (paths.size() == arguments.size()) {
      files.push_back(std::move(paths));
      continue;
    }
    auto& unmatched = comparisons.unmatched;
    if (!of_folders.back().contains(name))
      comparisons.missing.insert(comparisons.missing.end(), paths.begin(), paths.end());
    unmatched.insert(unmatched.end(), paths.begin(), paths.end());
  }
  if (files.empty())
    throw options::CommandError(
        fmt::format("no .h5 file is in all of the folders {}", fmt::join(arguments, ", ")));
  return files;
}

/// Throws StoreError.
void ReadAll(const std::vector<std::vector<std::string>>& files,
             const figures::CompareOptions& options, figures::Comparisons& comparisons) {
  for (const std::vector<std::string>& paths : files) {
    const std::vector<std::string> names = NamesOf(paths);
    try {
      comparisons.benchmarks.push_back(
          figures::MakeHistory({paths.begin(), paths.end()}, names, options));
    } catch (const figures::UnlikeScenes& unlike) {
      comparisons.unlike.push_back(
          {results::ResultFile(paths[0]).benchmark(), unlike.what(), names, unlike.differences});
    }
  }
  figures::JudgeHistories(comparisons.benchmarks, options);
}

/// Reports of the files follow the comparison, unless it is of several benchmarks.
void WriteComparison(const CompareArguments& arguments, const figures::Comparisons& comparisons,
                     const std::vector<std::vector<std::string>>& files,
                     const figures::CompareOptions& options) {
  const bool has_times =
      std::ranges::none_of(comparisons.benchmarks, [](const figures::BenchmarkHistory& benchmark) {
        return std::ranges::any_of(benchmark.files,
                                   [](const auto& file) { return file->CountsInstructions(); });
      });
  const PageDocuments reports =
      files.size() == 1 && has_times ? ReadPageDocuments(files[0]) : PageDocuments();
  std::vector<std::string> shown = comparisons.unmatched;
  for (const std::vector<std::string>& paths : files)
    shown.insert(shown.end(), paths.begin(), paths.end());
  WriteReportPage(
      arguments.out.empty() ? "compare.html" : arguments.out,
      fmt::format("{} compared with {}", comparisons.names.back(), comparisons.names.front()),
      fmt::format("{{\"comparison\":{},\"documents\":[{}]}}",
                  printers::ComparePageJson(comparisons, options), reports.json),
      shown);
}

options::ExitStatus CompareResults(const CompareArguments& arguments) {
  const figures::CompareOptions options = OptionsOf(arguments);
  figures::Comparisons comparisons;
  comparisons.names = NamesOf(arguments.files);
  const auto files = FilesOf(arguments.files, comparisons);
  ReadAll(files, options, comparisons);
  if (arguments.is_page) {
    WriteComparison(arguments, comparisons, files, options);
    terminal::Print(printers::Headline(comparisons, options) + "\n");
  } else if (arguments.is_json) {
    terminal::PrintJson(printers::CompareJson(comparisons, options));
  } else if (arguments.is_markdown) {
    terminal::Print(printers::PullRequestText(comparisons, options));
  } else {
    terminal::Print(printers::TextOf(
        printers::AllDocument(comparisons, options),
        arguments.is_latex ? printers::Format::kLatex : printers::Format::kWrapped));
  }
  if (!comparisons.unlike.empty()) return options::ExitStatus::kOtherScenes;
  return comparisons.IsFailed(options) ? options::ExitStatus::kWorse : options::ExitStatus::kGood;
}

void DeclareCompare(options::Subcommand& command) {
  const auto arguments = std::make_shared<CompareArguments>();
  command.Required("FILES", arguments->files,
                   "two results files of one benchmark, several in order, or folders of them");
  command.ShortList("--fail-if", arguments->fail_if,
                    "exit status 4 also if physics differs (physics), or a time cannot be told "
                    "(unsure)");
  command.ShortList("--allow", arguments->allow,
                    "do not fail if something is of this kind: slower, memory, stability, "
                    "accuracy, missing, scenes");
  command.ShortList("--fail-above", arguments->fail_above,
                    "the limit of slower, memory and accuracy (default: 5%), or of one of them "
                    "(memory=2%)");
  command.Optional(
      "--phase", arguments->phase,
      fmt::format("only this phase: {} (default: all)", fmt::join(protocol::PhaseNames(), ", ")));
  command.ShortList("--select", arguments->select, "only points with this value (detector=sap)");
  command.Flag("--relative", arguments->is_relative,
               "judge each detector relative to the median of all");
  command.Flag("--all", arguments->lists_all, "list every point, also unchanged ones");
  command.Flag("--markdown", arguments->is_markdown,
               "print a summary in Markdown, for a pull request, with the rest folded");
  command.Flag("--latex", arguments->is_latex, "print the tables for LaTeX with booktabs");
  command.Flag("--json", arguments->is_json, "print JSON, for scripts");
  command.Flag("--page", arguments->is_page, "write a page of figures for a browser");
  command.Out(arguments->out, "the page (default: compare.html)");
  command.Action([arguments] { return CompareResults(*arguments); });
}

}  // namespace

/// Prints the changes between results files. Exit status 4 if something of --fail-if is found, 5 if
/// the scenes of a benchmark differ.
options::Command CompareCommand() {
  return {.name = "compare",
          .help = "report the changes from one results file to another",
          .declare = DeclareCompare};
}

}  // namespace cdb::cli
