// `cdb report`: writes a page for a browser from results files.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/result_names.h"
#include "runtime/pages/page/page.h"
#include "runtime/printers/results_document.h"
#include "runtime/protocol/bytes_text.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

struct ReportArguments {
  std::vector<std::string> files;
  std::string out;       ///< empty: the first file's name with .html
  std::string baseline;  ///< as in `cdb show`
  bool only_sound = false;
};

std::string PageName(const ReportArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  return std::filesystem::path(arguments.files[0]).replace_extension(".html").string();
}

/// A page must never replace a results file that it shows.
void CheckPageName(const ReportArguments& arguments) {
  for (const std::string& file : arguments.files) {
    std::error_code error;
    if (std::filesystem::equivalent(file, PageName(arguments), error))
      throw options::CommandError(
          fmt::format("{} is the results file; name another file for the page with -o", file));
  }
}

options::ExitStatus WriteReport(const ReportArguments& arguments) {
  CheckPageName(arguments);
  std::string title, documents;
  std::size_t bad_cells = 0;
  for (const std::string& name : arguments.files) {
    const results::ResultFile file(name);
    const printers::Printed document =
        printers::ResultsDocument(file, {.file = std::filesystem::path(name).filename().string(),
                                         .baseline = arguments.baseline,
                                         .only_sound = arguments.only_sound,
                                         .for_page = true});
    if (!title.empty()) title += ", ";
    title += file.title().empty() ? file.benchmark() : file.title();
    if (!documents.empty()) documents += ',';
    documents += document.text;
    bad_cells += document.bad_count;
  }
  const std::string page = page::Assemble(page::ReportTemplate(), title,
                                          fmt::format("{{\"documents\":[{}]}}", documents));
  files::WriteWhole(page, PageName(arguments));
  terminal::Print(fmt::format("{}: {}; open it in a browser\n", PageName(arguments),
                              protocol::BytesText(static_cast<double>(page.size()))));
  return bad_cells > 0 ? options::ExitStatus::kFailedRuns : options::ExitStatus::kGood;
}

void DeclareReport(options::Subcommand& command) {
  const auto arguments = std::make_shared<ReportArguments>();
  command.Required("FILE", arguments->files, "results files, or scenarios that were run");
  command.Out(arguments->out, "the page (default: the name of the first file, with .html)");
  command.Baseline(arguments->baseline);
  command.Sound(arguments->only_sound);
  command.Action([arguments] {
    for (std::string& file : arguments->files) file = plans::FindResult(file);
    return WriteReport(*arguments);
  });
}

}  // namespace

/// Writes one page of all files. Exit status 3 if a run failed, or its timings do not count.
options::Command ReportCommand() {
  return {.name = "report",
          .help = "write one page of figures for a browser from results files",
          .declare = DeclareReport};
}

}  // namespace cdb::cli
