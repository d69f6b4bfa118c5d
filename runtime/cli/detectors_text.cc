#include "runtime/cli/detectors_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "library/catalogue.h"
#include "runtime/cli/reference.h"
#include "runtime/cli/table.h"

namespace cdb::runtime {
namespace {

using library::DetectorInfo;

/// What it cannot do, or needs; in the order of how much it matters.
std::vector<std::string> Limits(const DetectorInfo& detector) {
  std::vector<std::string> limits;
  const library::DetectorPart* part = library::FindDetectorPart(detector.part);
  if (part != nullptr && !part->is_built)
    limits.push_back(
        fmt::format("not in this build: install {} and run ./setup again, or ./setup "
                    "--rivals for all of them",
                    part->package));
  if (detector.max_bodies != 0)
    limits.push_back(fmt::format("at most {} bodies, walls included", detector.max_bodies));
  if (!detector.limits.empty()) limits.emplace_back(detector.limits);
  return limits;
}

std::string PhaseTable(const char* title, std::string_view phase) {
  Table table;
  for (const char* head : {title, "from", "family", ""}) table.AddColumn(head, false);
  for (const DetectorInfo& detector : library::Detectors()) {
    if (!detector.HasPhase(phase)) continue;
    table.AddRow({std::string(detector.name), std::string(detector.source),
                  std::string(detector.family), std::string(detector.doc)});
    for (const std::string& limit : Limits(detector)) table.AddRow({"", "", "", "  " + limit});
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

/// Lines of at most 100 columns, all but the first indented.
std::string Wrapped(std::string_view text, std::size_t indent) {
  std::string lines;
  std::size_t column = 0;
  while (!text.empty()) {
    const std::size_t space = std::min(text.find(' '), text.size());
    if (column > indent && column + 1 + space > 100) {
      lines += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (column > 0 && column != indent) {
      lines += ' ';
      ++column;
    }
    lines += text.substr(0, space);
    column += space;
    text.remove_prefix(std::min(space + 1, text.size()));
  }
  return lines + "\n";
}

std::string FamilyTable() {
  std::string without;
  Table table;
  for (const char* head : {"family of the paper's section 2", "source", "here"})
    table.AddColumn(head, false);
  for (const library::FamilyInfo& family : library::Families()) {
    std::string here;
    for (const DetectorInfo& detector : library::Detectors())
      if (IsOfFamily(detector, family.name))
        here += (here.empty() ? "" : " ") + std::string(detector.name);
    table.AddRow({std::string(family.name), std::string(family.source), here});
    if (!family.why_not.empty())
      without += "  " + Wrapped(fmt::format("{}: {}.", family.name, family.why_not), 4);
  }
  return table.Text() + "\nNo detector of:\n" + without;
}

}  // namespace

std::string DetectorTables() {
  const std::string narrow = PhaseTable("narrow phase", "narrow");
  return PhaseTable("broad phase", "broad") + "\n" + narrow;
}

std::string DetectorReference() {
  return std::string(kDetectorsReference) + DetectorTables() + "\n" + FamilyTable();
}

}  // namespace cdb::runtime
