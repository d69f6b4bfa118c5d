// The requirements of a scenario: for a terminal, and as JUnit XML.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "dsl/text/markup.h"
#include "runtime/figures/boundaries.h"
#include "runtime/figures/requirements.h"
#include "runtime/printers/show.h"

namespace cdb::printers {
namespace {

using figures::Answer;
using figures::JudgedPoint;
using figures::JudgedRequirement;

/// Points that are named for each requirement.
constexpr std::size_t kMostNamedPoints = 3;

/// `quantity 400, detector dbvt`; `the only point`.
std::string PlaceOf(const results::ResultFile& file, const JudgedPoint& point) {
  const std::string place = figures::PlaceText(file, figures::AllAxes(file), point.at);
  return place.empty() ? "the only point" : place;
}

/// The first points with an answer, and where it begins along an axis.
void NamePoints(const figures::Model& model, const JudgedRequirement& of, Answer answer,
                std::vector<std::string>& lines) {
  const std::size_t count = of.Count(answer);
  if (count == 0) return;
  std::string text = fmt::format("{}: {}", of.what.text, figures::AnswerName(answer));
  if (count < of.points.size()) {
    const figures::BoundaryWords words = {.good = "met"};
    std::map<figures::Point, std::string> states;
    for (const JudgedPoint& point : of.points) states[point.at] = figures::AnswerName(point.answer);
    text += fmt::format(" at {} of {} points.{}", count, of.points.size(),
                        figures::BoundaryText(model.file(), states, words));
  } else {
    text += of.points.size() > 1 ? fmt::format(" at any of {} points.", count) : ".";
  }
  lines.push_back(std::move(text));
  std::size_t named = 0;
  for (const JudgedPoint& point : of.points) {
    if (point.answer != answer) continue;
    if (++named > kMostNamedPoints) break;
    const std::string reason = figures::ReasonText(of, point, model.times().IntervalName());
    lines.push_back(of.points.size() > 1
                        ? fmt::format("  {}: {}", PlaceOf(model.file(), point), reason)
                        : fmt::format("  {}", reason));
  }
  if (count > kMostNamedPoints)
    lines.push_back(fmt::format("  and {} more", count - kMostNamedPoints));
}

}  // namespace

void AddRequirements(const figures::Model& model, Document& document) {
  const std::vector<JudgedRequirement>& all = model.requirements();
  if (std::ranges::all_of(all, &JudgedRequirement::is_budget)) return;
  Section section = {.title = "Requirements"};
  for (const char* head : {"requirement", "answer"}) section.table.AddColumn(head, false);
  for (const char* head : {"met", "not met", "cannot tell"}) section.table.AddColumn(head, true);
  for (const JudgedRequirement& of : all) {
    const auto count = [&](Answer answer) { return fmt::format("{}", of.Count(answer)); };
    section.table.rows.push_back({of.what.text, std::string(figures::AnswerName(of.Whole())),
                                  count(Answer::kMet), count(Answer::kNotMet),
                                  count(Answer::kCannotTell)});
    NamePoints(model, of, Answer::kNotMet, section.notes);
    NamePoints(model, of, Answer::kCannotTell, section.notes);
  }
  document.push_back(std::move(section));
}

Printed JunitText(const results::ResultFile& file) {
  const figures::Model model(file);
  std::string cases;
  std::size_t tests = 0, skipped = 0;
  for (const JudgedRequirement& of : model.requirements())
    for (const JudgedPoint& point : of.points) {
      ++tests;
      cases +=
          fmt::format("    <testcase classname=\"{}\" name=\"{}\"",
                      text::EscapedMarkup(fmt::format("{}: {}", file.benchmark(), of.what.text)),
                      text::EscapedMarkup(PlaceOf(file, point)));
      const std::string reason =
          text::EscapedMarkup(figures::ReasonText(of, point, model.times().IntervalName()));
      if (point.answer == Answer::kNotMet) {
        cases += fmt::format(">\n      <failure message=\"{}\"/>\n    </testcase>\n", reason);
      } else if (point.answer == Answer::kMet) {
        cases += "/>\n";
      } else {
        ++skipped;
        cases += fmt::format(">\n      <skipped message=\"cannot tell: {}\"/>\n    </testcase>\n",
                             reason);
      }
    }
  const std::size_t not_met = figures::CountNotMet(model.requirements());
  const std::string counts =
      fmt::format("tests=\"{}\" failures=\"{}\" skipped=\"{}\"", tests, not_met, skipped);
  return {fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {0}>\n  <testsuite "
                      "name=\"{1}\" {0}>\n{2}  </testsuite>\n</testsuites>\n",
                      counts, text::EscapedMarkup(file.benchmark()), cases),
          model.bad_count(), not_met};
}

}  // namespace cdb::printers
