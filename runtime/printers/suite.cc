#include "runtime/printers/suite.h"

#include "compiler/schema/metrics.h"
#include "runtime/figures/history/histories.h"
#include "runtime/printers/history.h"
#include "runtime/printers/json_points.h"

namespace cdb::printers {
namespace {

Json IntervalJson(const figures::Interval& interval) {
  return {JsonNumber(interval.low), JsonNumber(interval.high)};
}

Json ConfigurationJson(const figures::SceneFigures& scene,
                       const figures::ConfigurationFigures& of) {
  Json json = {{"name", of.name},
               {"fault", of.fault.empty() ? Json(nullptr) : Json(of.fault)},
               {"speedup", of.HasScore() ? JsonNumber(of.speedup.value) : Json(nullptr)},
               {"disturbed", of.is_disturbed ? JsonNumber(of.speedup.value) : Json(nullptr)},
               {"interval", of.HasScore() ? IntervalJson(of.speedup_interval) : Json(nullptr)},
               {"ms_per_s", JsonNumber(of.ms_per_s.value)},
               {"step_ns", JsonNumber(of.step_ns)},
               {"slow_step_ns", JsonNumber(of.slow_step_ns)},
               {"time_step", JsonNumber(of.time_step_s)},
               {"error", JsonNumber(of.error)},
               {"verdict", protocol::VerdictName(of.verdict)},
               {"memory", JsonNumber(of.memory_bytes)},
               {"repeats", of.repeats},
               {"noisy", of.noisy},
               {"bullets_own", of.is_bullets_own},
               {"on_front", scene.IsOnFront(of)}};
  Json fits = Json::array();
  for (const figures::TimeBudget& budget : figures::kTimeBudgets)
    fits.push_back(of.HasScore() && of.Fits(budget.seconds));
  json["fits"] = std::move(fits);
  return json;
}

/// The documentation of the error, as text for people.
std::string ErrorDoc(std::string_view name) {
  for (const schema::ErrorInfo& error : schema::Errors())
    if (error.name == name) return std::string(error.doc);
  return {};
}

Json SceneJson(const figures::SceneFigures& scene, const results::ResultFile& file,
               const SuiteFacts& facts) {
  Json json = {{"kind", scene.scene->kind},
               {"name", scene.scene->name},
               {"what", scene.scene->what},
               {"file", scene.scene->ResultName()}};
  const auto sha256 = facts.sha256.find(scene.scene->ResultName());
  json["sha256"] = sha256 == facts.sha256.end() ? Json(nullptr) : Json(sha256->second);
  json["plan_sha256"] = file.plan_sha256();
  json["host"] = file.ReadProvenance("host");
  json["error"] = {{"name", scene.scene->error},
                   {"bound", scene.scene->bound},
                   {"doc", ErrorDoc(scene.scene->error)}};
  json["answer"] = AnswerText(scene);
  Json picks = Json::array(), own = Json::array();
  for (const figures::TimeBudget& budget : figures::kTimeBudgets)
    for (const bool only_own : {false, true}) {
      Json names = Json::array();
      for (const figures::ConfigurationFigures* of :
           figures::Recommend(scene, budget.seconds, only_own))
        names.push_back(of->name);
      (only_own ? own : picks).push_back(std::move(names));
    }
  json["picks"] = std::move(picks);
  json["picks_of_bullet"] = std::move(own);
  json["configurations"] = Json::array();
  for (const figures::ConfigurationFigures& of : scene.configurations)
    json["configurations"].push_back(ConfigurationJson(scene, of));
  return json;
}

Json KindJson(const figures::KindFigures& kind) {
  Json json = {{"kind", kind.kind->name}, {"what", kind.kind->doc}, {"baseline", kind.baseline}};
  json["scenes"] = Json::array();
  for (const figures::SceneFigures* scene : kind.scenes)
    json["scenes"].push_back(scene->scene->name);
  json["scores"] = Json::array();
  for (const figures::KindScore& score : kind.scores)
    json["scores"].push_back({{"name", score.name},
                              {"score", JsonNumber(score.score)},
                              {"interval", IntervalJson(score.interval)},
                              {"memory", JsonNumber(score.memory_bytes)},
                              {"faults", score.faults}});
  return json;
}

/// The day on which the first scene began.
std::string DayOfSuite(const std::vector<const results::ResultFile*>& files) {
  double first = 0;
  for (const results::ResultFile* file : files)
    if (const double started = history::StartOf(*file);
        started > 0 && (first == 0 || started < first))
      first = started;
  return DayOf(first);
}

}  // namespace

std::string SuiteJson(const std::vector<figures::SceneFigures>& scenes,
                      const std::vector<const results::ResultFile*>& files,
                      const SuiteFacts& facts) {
  Json json = {{"suite", figures::kSuiteVersion},
               {"variant", facts.is_long ? "long" : "short"},
               {"seed", facts.seed ? Json(*facts.seed) : Json(nullptr)},
               {"missing", facts.missing},
               {"measured", DayOfSuite(files)}};
  if (!files.empty()) {
    json["machine"] = DocumentMachine(*files[0]);
    json["build"] = DocumentBuild(*files[0]);
  }
  json["defaults"] = DefaultsText(scenes);
  json["budgets"] = Json::array();
  for (const figures::TimeBudget& budget : figures::kTimeBudgets)
    json["budgets"].push_back(budget.name);
  json["kinds"] = Json::array();
  for (const figures::KindFigures& kind : figures::ScoreKinds(scenes))
    json["kinds"].push_back(KindJson(kind));
  json["scenes"] = Json::array();
  for (std::size_t i = 0; i < scenes.size(); ++i)
    json["scenes"].push_back(SceneJson(scenes[i], *files[i], facts));
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cdb::printers
