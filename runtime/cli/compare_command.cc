// `cdb compare`: compares two results files of one benchmark, or several in order.
#include <fmt/format.h>

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
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct CompareArguments {
  std::vector<std::string> files;  ///< results files, or folders of them
  std::string fail_above = "5%";
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
  return {arguments.select, ParsePhase(arguments.phase),
          options::ParsePercent("--fail-above", arguments.fail_above), arguments.is_relative,
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

/// The files of each benchmark, in the order of the arguments. `unmatched` receives the files that
/// are not in all of the folders.
std::vector<std::vector<std::string>> FilesOf(const std::vector<std::string>& arguments,
                                              std::vector<std::string>& unmatched) {
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
    } else {
      unmatched.insert(unmatched.end(), paths.begin(), paths.end());
    }
  }
  if (files.empty())
    throw options::CommandError(
        fmt::format("no .h5 file is in all of the folders {}", fmt::join(arguments, ", ")));
  return files;
}

/// Throws StoreError.
std::vector<figures::BenchmarkHistory> ReadAll(const std::vector<std::vector<std::string>>& files,
                                               const figures::CompareOptions& options) {
  std::vector<figures::BenchmarkHistory> benchmarks;
  for (const std::vector<std::string>& paths : files)
    benchmarks.push_back(
        figures::MakeHistory({paths.begin(), paths.end()}, NamesOf(paths), options));
  figures::JudgeHistories(benchmarks, options);
  return benchmarks;
}

/// `names`: the names of the files or folders on the command line.
printers::Document DocumentOf(const std::vector<figures::BenchmarkHistory>& benchmarks,
                              const std::vector<std::string>& names,
                              const std::vector<std::string>& unmatched,
                              const figures::CompareOptions& options) {
  printers::Document document;
  if (!unmatched.empty())
    document.push_back({.title = "Not compared, because not in all folders", .lines = unmatched});
  if (benchmarks[0].files.size() > 2) {
    printers::Document history = printers::HistoryDocument(benchmarks, names, options);
    std::ranges::move(history, std::back_inserter(document));
    return document;
  }
  for (const figures::BenchmarkHistory& benchmark : benchmarks) {
    printers::Document sections = printers::CompareDocument(benchmark.steps[0], options);
    std::ranges::move(sections, std::back_inserter(document));
  }
  return document;
}

/// Reports of the files follow the comparison, unless it is of several benchmarks.
void WriteComparison(const CompareArguments& arguments,
                     const std::vector<figures::BenchmarkHistory>& benchmarks,
                     const std::vector<std::vector<std::string>>& files,
                     const std::vector<std::string>& unmatched,
                     const figures::CompareOptions& options) {
  const std::vector<std::string> names = NamesOf(arguments.files);
  const PageDocuments reports = files.size() == 1 ? ReadPageDocuments(files[0]) : PageDocuments();
  std::vector<std::string> shown = unmatched;
  for (const std::vector<std::string>& paths : files)
    shown.insert(shown.end(), paths.begin(), paths.end());
  WriteReportPage(
      arguments.out.empty() ? "compare.html" : arguments.out,
      fmt::format("{} compared with {}", names.back(), names.front()),
      fmt::format("{{\"comparison\":{},\"documents\":[{}]}}",
                  printers::ComparePageJson(benchmarks, names, unmatched, options), reports.json),
      shown);
}

options::ExitStatus CompareResults(const CompareArguments& arguments) {
  const figures::CompareOptions options = OptionsOf(arguments);
  std::vector<std::string> unmatched;
  const auto files = FilesOf(arguments.files, unmatched);
  const auto benchmarks = ReadAll(files, options);
  if (arguments.is_page) {
    WriteComparison(arguments, benchmarks, files, unmatched, options);
  } else if (arguments.is_json) {
    terminal::PrintJson(printers::CompareJson(benchmarks, unmatched, options));
  } else {
    const printers::Document document =
        DocumentOf(benchmarks, NamesOf(arguments.files), unmatched, options);
    terminal::Print(printers::TextOf(document, arguments.is_markdown ? printers::Format::kMarkdown
                                               : arguments.is_latex  ? printers::Format::kLatex
                                                                     : printers::Format::kWrapped));
  }
  const bool is_worse = std::ranges::any_of(benchmarks, [&](const auto& benchmark) {
    return !figures::WorseThings(benchmark.Whole(), options).empty();
  });
  return is_worse ? options::ExitStatus::kWorse : options::ExitStatus::kGood;
}

void DeclareCompare(options::Subcommand& command) {
  const auto arguments = std::make_shared<CompareArguments>();
  command.Required("FILES", arguments->files,
                   "two results files of one benchmark, several in order, or folders of them");
  command.Optional("--fail-above", arguments->fail_above,
                   "exit status 4 if something is worse by more than this (5%)");
  command.Optional("--phase", arguments->phase, "only this phase (detect)");
  command.ShortList("--select", arguments->select, "only points with this value (detector=sap)");
  command.Flag("--relative", arguments->is_relative,
               "judge each detector relative to the median of all");
  command.Flag("--all", arguments->lists_all, "list every point, also unchanged ones");
  command.Flag("--markdown", arguments->is_markdown, "print Markdown, for a pull request");
  command.Flag("--latex", arguments->is_latex, "print the tables for LaTeX with booktabs");
  command.Flag("--json", arguments->is_json, "print JSON, for scripts");
  command.Flag("--page", arguments->is_page, "write a page of figures for a browser");
  command.Out(arguments->out, "the page (default: compare.html)");
  command.Action([arguments] { return CompareResults(*arguments); });
}

}  // namespace

/// Prints the changes between results files. Exit status 4 if something is worse by more than
/// --fail-above.
options::Command CompareCommand() {
  return {.name = "compare",
          .help = "report the changes from one results file to another",
          .declare = DeclareCompare};
}

}  // namespace cdb::cli
