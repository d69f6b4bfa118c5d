// `cdb report`: writes a page for a browser from results files.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "runtime/cli/options/browser.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/result_names.h"
#include "runtime/cli/report_page.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

struct ReportArguments {
  std::vector<std::string> files;
  std::string out;       ///< empty: the first file's name with .html
  std::string baseline;  ///< as in `cdb show`
  bool only_sound = false;
  bool opens = false;
  std::string figures;  ///< folder of SVG files; empty: none
  options::FigureChoices choices;
};

std::string PageName(const ReportArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  return std::filesystem::path(arguments.files[0]).replace_extension(".html").string();
}

/// Writes each figure of the page to a file of its own.
void WriteFigures(const ReportArguments& arguments) {
  const std::filesystem::path folder = arguments.figures;
  const auto figures = options::DrawFigures(PageName(arguments), arguments.choices);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  files::RequireFolder(folder, "for the figures");
  for (const auto& [name, svg] : figures) {
    files::WriteWhole(svg, folder / name);
    terminal::Print((folder / name).string() + "\n");
  }
  if (figures.empty()) terminal::Say("the page has no figures\n");
}

options::ExitStatus WriteReport(const ReportArguments& arguments) {
  const PageDocuments documents =
      ReadPageDocuments(arguments.files, arguments.baseline, arguments.only_sound);
  WriteReportPage(PageName(arguments), documents.title,
                  fmt::format("{{\"documents\":[{}]}}", documents.json), arguments.files,
                  arguments.opens);
  if (!arguments.figures.empty()) WriteFigures(arguments);
  return documents.bad_count > 0 ? options::ExitStatus::kFailedRuns : options::ExitStatus::kGood;
}

void DeclareReport(options::Subcommand& command) {
  const auto arguments = std::make_shared<ReportArguments>();
  command.Required("FILE", arguments->files, "results files, or scenarios that were run");
  command.Out(arguments->out, "the page (default: the name of the first file, with .html)");
  command.Baseline(arguments->baseline);
  command.Sound(arguments->only_sound);
  command.Flag("--open", arguments->opens, "open the page in a browser: $BROWSER, else xdg-open");
  command.Optional("--svg", arguments->figures,
                   "write the figures of the page to this folder, as SVG drawn by Chromium");
  command.Optional(
      "--size", arguments->choices.size,
      "with --svg: screen (default), or column or page of print, 8.5 and 17.5 cm wide, or a "
      "width such as 84mm");
  command.Optional("--view", arguments->choices.view,
                   "with --svg: what the address of the page has after #: quantity=time:broad");
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
