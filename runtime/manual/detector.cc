#include "runtime/manual/detector.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "runtime/terminal/table.h"

namespace cdb::manual {
namespace {

using schema::DetectorInfo;

/// Limitations and requirements of a detector, the most important first.
std::vector<std::string> Limits(const DetectorInfo& detector) {
  std::vector<std::string> limits;
  const schema::DetectorPart* part = schema::FindDetectorPart(detector.part);
  if (part != nullptr && !part->is_built)
    limits.push_back(
        fmt::format("not in this build: install {} and run ./setup again, or ./setup "
                    "--third-party for all of them",
                    part->package));
  if (detector.max_bodies != 0)
    limits.push_back(fmt::format("at most {} bodies, walls included", detector.max_bodies));
  if (!detector.limits.empty()) limits.emplace_back(detector.limits);
  return limits;
}

/// Wraps text into lines of at most `columns` columns, where words allow.
std::vector<std::string> Lines(std::string_view text, std::size_t columns) {
  std::vector<std::string> lines = {""};
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    std::string& line = lines.back();
    if (line.empty()) {
      line = word;
    } else if (line.size() + 1 + word.size() <= columns) {
      line.append(" ").append(word);
    } else {
      lines.emplace_back(word);
    }
    text.remove_prefix(std::min(word.size() + 1, text.size()));
  }
  return lines;
}

std::string PhaseTable(const char* title, std::string_view phase) {
  constexpr std::size_t kColumns = 80;
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {title, "from", ""}) table.AddColumn(head, false);
  for (const DetectorInfo& detector : schema::Detectors()) {
    if (!detector.HasPhase(phase)) continue;
    table.AddRow(
        {std::string(detector.name), std::string(detector.source), std::string(detector.doc)});
    for (const std::string& limit : Limits(detector))
      for (const std::string& line : Lines(limit, kColumns)) table.AddRow({"", "", "  " + line});
  }
  return table.Text();
}

bool IsOfFamily(const DetectorInfo& detector, std::string_view family) {
  for (std::string_view rest = detector.family; !rest.empty();) {
    const std::size_t comma = rest.find(", ");
    if (rest.substr(0, comma) == family) return true;
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 2);
  }
  return false;
}

}  // namespace

std::string DetectorTables() {
  const std::string narrow = PhaseTable("narrow phase", "narrow");
  return PhaseTable("broad phase", "broad") + "\n" + narrow;
}

std::string FamilyTable() {
  std::string without;
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"family of the paper's section 2", "source", "here"})
    table.AddColumn(head, false);
  for (const schema::FamilyInfo& family : schema::Families()) {
    std::string here;
    for (const DetectorInfo& detector : schema::Detectors())
      if (IsOfFamily(detector, family.name))
        here += (here.empty() ? "" : " ") + std::string(detector.name);
    table.AddRow({std::string(family.name), std::string(family.source), here});
    if (!family.why_not.empty())
      for (const std::string& line : Lines(fmt::format("{}: {}.", family.name, family.why_not), 96))
        without += (line.starts_with(family.name) ? "  " : "    ") + line + "\n";
  }
  return table.Text() + "\nNo detector of:\n" + without;
}

}  // namespace cdb::manual
