#include "runtime/figures/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "compiler/analysis/coverage.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// A smaller fraction of objects asleep is not reported.
constexpr double kNoticeableSleep = 0.1;

/// The parts of a text between separators.
std::vector<std::string> Split(const std::string& text, std::string_view separator) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find(separator, from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + separator.size();
  }
  return parts;
}

}  // namespace

std::vector<std::string> CheckedQuestions(const results::ResultFile& file,
                                          const std::vector<Cell>& cells) {
  if (!file.Has("checked") || cells.empty()) return {};
  std::vector<std::string> all = Split(file.ReadText("checked", cells[0]), ", ");
  for (const Cell& cell : cells) {
    const std::vector<std::string> here = Split(file.ReadText("checked", cell), ", ");
    std::erase_if(all, [&](const std::string& question) {
      return std::ranges::find(here, question) == here.end();
    });
  }
  return all;
}

std::vector<OpenQuestion> OpenQuestions(const results::ResultFile& file,
                                        const std::vector<Cell>& cells) {
  std::vector<OpenQuestion> all;
  if (!file.Has("unchecked")) return all;
  for (const Cell& cell : cells)
    for (const std::string& one : Split(file.ReadText("unchecked", cell), "; ")) {
      const std::size_t colon = one.find(": ");
      if (colon == std::string::npos) continue;
      const std::string question = one.substr(0, colon), why = one.substr(colon + 2);
      const auto found = std::ranges::find_if(all, [&](const OpenQuestion& open) {
        return open.question == question && open.why == why;
      });
      if (found != all.end()) {
        ++found->runs;
      } else {
        all.push_back({question, why, 1});
      }
    }
  return all;
}

std::string OpenQuestionsText(const results::ResultFile& file, const std::vector<Cell>& cells) {
  // Questions that are open for one reason in the same number of runs are named together.
  std::vector<OpenQuestion> grouped;
  for (OpenQuestion& open : OpenQuestions(file, cells)) {
    const auto same = std::ranges::find_if(grouped, [&](const OpenQuestion& other) {
      return other.why == open.why && other.runs == open.runs;
    });
    if (same != grouped.end()) {
      same->question += ", " + open.question;
    } else {
      grouped.push_back(std::move(open));
    }
  }
  std::string text;
  for (const OpenQuestion& open : grouped) {
    const std::string where =
        open.runs < cells.size() ? fmt::format(" in {} of {} runs", open.runs, cells.size()) : "";
    text += fmt::format("{}{} ({}){}", text.empty() ? "" : "; ", open.question, open.why, where);
  }
  return text.empty() ? text : fmt::format("Not checked: {}.", text);
}

bool LeavesVitalOpen(const results::ResultFile& file, const std::vector<Cell>& cells) {
  return std::ranges::any_of(OpenQuestions(file, cells), [](const OpenQuestion& open) {
    const auto all = analysis::Questions();
    const auto info = std::ranges::find(all, open.question, &analysis::QuestionInfo::name);
    return info == all.end() || info->is_vital;
  });
}

double MovingObjectsOf(const results::ResultFile& file, const Cell& cell) {
  if (!file.Has("moving_objects")) return std::numeric_limits<double>::quiet_NaN();
  const double count = file.ReadReal("moving_objects", cell);
  return count < 0 ? std::numeric_limits<double>::quiet_NaN() : count;
}

std::string BadObjectsText(const results::ResultFile& file, const Cell& cell) {
  const std::int64_t bad = file.ReadJudgement(cell).bad_objects;
  if (bad < 0) return {};
  const double of = MovingObjectsOf(file, cell);
  // Pairs may be more than the objects.
  if (!(of >= static_cast<double>(bad)))
    return fmt::format("{} object{}", bad, bad == 1 ? "" : "s");
  return fmt::format("{} of {} object{}", bad, of, of == 1 ? "" : "s");
}

std::string UnsoundText(const results::ResultFile& file, const Row& row) {
  if (row.is_void) return {};
  std::size_t unsound = 0;
  std::string text;
  for (const MeasuredPoint* point : row.points) {
    // Of the repeats behind its figures; the others are void.
    const Cell& worst = *std::ranges::max_element(
        point->cells, {}, [&](const Cell& cell) { return file.ReadJudgement(cell).verdict; });
    const auto judgement = file.ReadJudgement(worst);
    if (judgement.verdict <= protocol::Verdict::kStable) continue;
    ++unsound;
    const std::string objects = BadObjectsText(file, worst);
    text = protocol::VerdictText(judgement) + (objects.empty() ? "" : ", " + objects);
  }
  if (unsound == 0 || row.points.size() == 1) return text;
  return fmt::format("{} of {} not stable", unsound, row.points.size());
}

std::string SleepNote(const results::ResultFile& file, const std::vector<Cell>& cells) {
  if (!file.Has("mean_asleep")) return {};
  double most = 0, asleep = 0, objects = 0;
  std::size_t runs = 0;
  for (const Cell& cell : cells) {
    const double here = file.ReadReal("mean_asleep", cell), of = MovingObjectsOf(file, cell);
    if (!(here >= kNoticeableSleep * of)) continue;
    ++runs;
    if (here / of <= most) continue;
    most = here / of;
    asleep = here;
    objects = of;
  }
  if (runs == 0) return {};
  const std::string where =
      cells.size() > 1 ? fmt::format(" (a tenth or more in {} of {} runs)", runs, cells.size())
                       : "";
  return fmt::format(
      "{} of {} objects were asleep on average{}; a step over sleeping objects is less work.",
      (cells.size() > 1 ? "Up to " : "") + terminal::ShortNumber(asleep), objects, where);
}

}  // namespace cdb::figures
