#include "tests/runtime/engine/foresight.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "library/layouts/pose_table.h"
#include "library/objects/solid_factory.h"
#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

Prediction PredictionOf(const lints::LintNumber& number) {
  return number.IsBad() ? kBad : number.IsDoubtful() ? kDoubtful : kSound;
}

}  // namespace

Prediction Foresight::prediction() const {
  Prediction worst = kSound;
  for (const lints::LintNumber& number : numbers) worst = std::max(worst, PredictionOf(number));
  return worst;
}

std::string Foresight::Text() const {
  std::string text = fmt::format("{}:", protocol::VerdictName(verdict));
  for (const lints::LintNumber& number : numbers)
    if (number.Severity() > 0.1)
      text += fmt::format(" {} {:.2g}{}", InfoOf(number.lint).kind.id, number.Severity(),
                          number.open ? " open" : "");
  return text;
}

std::optional<Foresight> Foresee(const plan::Scene& scene, std::string* why) {
  const Recorded recorded = RunHere(scene);
  if (!recorded.done()) {
    if (why != nullptr) *why = recorded.message();
    return std::nullopt;
  }
  const protocol::Judgement judged =
      protocol::Judge(scene, recorded.recording, recorded.header().cycles_done.load());
  EXPECT_NE(judged.verdict, protocol::Verdict::kUnknown);
  const lints::FactReaders read{layouts::ReadPoseFacts,
                                objects::ModelReader({.decomposes = false})};
  return Foresight{lints::LintScene(scene, read), judged.verdict};
}

double Confusion::Agreement(Prediction prediction, bool stable) const {
  const auto& row = runs[prediction];
  return static_cast<double>(row[stable]) / (row[0] + row[1]);
}

void ConfusionTable::Add(const std::string& name, const Foresight& foresight) {
  const bool stable = foresight.is_stable();
  ++all_.runs[foresight.prediction()][stable];
  ++names_[name].runs[foresight.prediction()][stable];
  for (const lints::LintNumber& number : foresight.numbers)
    if (number.IsDoubtful()) ++lints_[number.lint].runs[PredictionOf(number)][stable];
}

std::string ConfusionTable::Text() const {
  std::string text = fmt::format("{:28} {:>20} {:>20} {:>20}\n", world::EnginePrecision(),
                                 "sound: stable, not", "doubtful: stable, not", "bad: stable, not");
  const auto add = [&text](std::string_view name, const Confusion& confusion) {
    text += fmt::format("{:28}", name);
    for (const auto& row : confusion.runs) text += fmt::format(" {:14} {:5}", row[1], row[0]);
    text += "\n";
  };
  for (const auto& [name, confusion] : names_) add(name, confusion);
  for (const auto& [lint, confusion] : lints_)
    add(fmt::format("{} {}", lints::InfoOf(lint).kind.code, lints::InfoOf(lint).kind.id),
        confusion);
  add("all", all_);
  return text;
}

}  // namespace cdb::tests
