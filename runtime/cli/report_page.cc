#include "runtime/cli/report_page.h"

#include <fmt/format.h>

#include <filesystem>

#include "runtime/cli/options/browser.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/points.h"
#include "runtime/pages/page/page.h"
#include "runtime/printers/results_document.h"
#include "runtime/protocol/bytes_text.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {

PageDocuments ReadPageDocuments(const std::vector<std::string>& files, const std::string& baseline,
                                bool only_sound) {
  PageDocuments pages;
  for (const std::string& name : files) {
    const results::ResultFile file(name);
    figures::RequireTimes(file, name);
    const printers::Printed document =
        printers::ResultsDocument(file, {.file = std::filesystem::path(name).filename().string(),
                                         .baseline = baseline,
                                         .only_sound = only_sound,
                                         .for_page = true});
    if (!pages.title.empty()) pages.title += ", ";
    pages.title += file.title().empty() ? file.benchmark() : file.title();
    if (!pages.json.empty()) pages.json += ',';
    pages.json += document.text;
    pages.bad_count += document.bad_count;
  }
  return pages;
}

void WriteReportPage(const std::string& name, const std::string& title, const std::string& json,
                     const std::vector<std::string>& files, bool opens) {
  for (const std::string& file : files) {
    std::error_code error;
    if (std::filesystem::equivalent(file, name, error))
      throw options::CommandError(
          fmt::format("{} is the results file; name another file for the page with -o", file));
  }
  const std::string page = page::Assemble(page::ReportTemplate(), title, json);
  files::WriteWhole(page, name);
  std::string next = "open it in a browser";
  if (opens) {
    const std::string browser = options::OpenInBrowser(name);
    next = browser.empty() ? fmt::format(
                                 "no browser found ($BROWSER, or xdg-open and a display): "
                                 "open {} in one",
                                 options::AddressOf(name))
                           : "opened by " + browser;
  }
  terminal::Print(fmt::format("{}: {}; {}\n", name,
                              protocol::BytesText(static_cast<double>(page.size())), next));
}

}  // namespace cdb::cli
