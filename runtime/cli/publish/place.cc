#include "runtime/cli/publish/place.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <system_error>

#include "compiler/plan/input_file.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/publish/digest.h"
#include "runtime/cli/publish/publish.h"
#include "runtime/pages/page/page.h"
#include "runtime/printers/json_points.h"
#include "runtime/results/files/safe_file.h"

namespace cdb::publish {
namespace {

namespace fs = std::filesystem;
using printers::Json;
using Outcome = Verification::Outcome;

/// A summary of more bytes is none.
constexpr std::size_t kMostSummaryBytes = 16 << 20;

bool HasResults(const fs::path& folder) {
  std::error_code error;
  return std::ranges::any_of(figures::StandardScenes(), [&](const figures::StandardScene& scene) {
    return fs::exists(folder / scene.ResultName(), error);
  });
}

bool IsThisVersion(const PlaceEntry& entry) { return entry.version == figures::kSuiteVersion; }

/// Checks an entry, each of whose faults is one of the folder.
PlaceEntry ReadEntry(const fs::path& folder) {
  PlaceEntry entry;
  entry.name = folder.filename().string();
  try {
    std::string why;
    const auto summary =
        plan::ReadInputFile((folder / plans::kSuiteSummary).string(), why, kMostSummaryBytes);
    entry.version = summary ? plans::VersionOf(*summary) : std::nullopt;
    entry.signature = CheckSignature(folder);
    entry.faults = FindDigestFaults(folder);
    if (!entry.faults.empty()) return entry;
    const Digest digest = ReadDigest(folder);  // that of the files, as they have no faults
    if (!entry.version) {
      entry.faults.push_back(
          fmt::format("{}: it is not a summary of the suite", plans::kSuiteSummary));
    } else if (*entry.version > figures::kSuiteVersion) {
      entry.faults.push_back(fmt::format(
          "{}: it is of version {} of the suite, which this cdb does not know; it has version {}",
          plans::kSuiteSummary, *entry.version, figures::kSuiteVersion));
    } else if (IsThisVersion(entry)) {
      CheckedResults checked = CheckResults(folder);
      entry.faults.insert(entry.faults.end(), checked.faults.begin(), checked.faults.end());
      // So that no results are here twice, and verify themselves.
      if (const std::string name = NameOf(checked.read); entry.name != name)
        entry.faults.push_back(fmt::format("the name of the folder should be {}", name));
      for (const auto& [name, hex] : digest)
        if (name != plans::kSuiteSummary && !checked.read.facts.sha256.contains(name))
          entry.faults.push_back(fmt::format("{}: it is not a file of the suite", name));
      entry.summary = std::move(checked.summary);
    } else {
      if (const std::string word = ResultsWord(digest); !entry.name.ends_with(word))
        entry.faults.push_back(fmt::format(
            "the name of the folder should end with {}, the digest of its results", word));
      if (std::ranges::none_of(digest,
                               [](const auto& file) { return file.first.ends_with(".h5"); }))
        entry.faults.emplace_back("it has no results files");
      entry.summary = *summary;
    }
  } catch (const std::exception& error) {
    entry.faults.emplace_back(error.what());
  }
  if (entry.signature.state == SignatureState::kBad) entry.faults.push_back(entry.signature.text);
  return entry;
}

/// The results of one scene of an entry.
struct SceneOf {
  PlaceEntry* entry;
  std::unique_ptr<figures::ComparedFile> file;
  figures::SceneFigures figures;
};

/// Adds the verification of a scene to that of the whole entry.
void Add(const figures::SceneVerification& scene, Verification& of) {
  ++of.scenes;
  of.same_states += scene.outcome == figures::SceneVerification::Outcome::kSameStates;
  for (const std::string& reason : scene.disagreements)
    of.reasons.push_back(fmt::format("{}: {}", scene.scene, reason));
  Outcome outcome = Outcome::kAgrees;
  if (scene.outcome == figures::SceneVerification::Outcome::kDisagrees)
    outcome = Outcome::kDisagrees;
  else if (scene.timed < scene.claimed || scene.claimed == 0)
    outcome = Outcome::kPartly;
  of.outcome = std::max(of.outcome, outcome);
}

void VerifyScene(const SceneOf& claimed, const SceneOf& here, Verification& of) {
  try {
    Add(figures::VerifyScene({*claimed.file, claimed.figures}, {*here.file, here.figures}), of);
  } catch (const files::StoreError& error) {
    of.outcome = std::max(of.outcome, Outcome::kNotCompared);
    of.reasons.push_back(fmt::format("{}: {}", claimed.figures.scene->Id(), error.what()));
  }
}

/// Verifies each entry by each other one. Scene by scene, so that no more files are open at once
/// than there are entries.
void VerifyAll(const fs::path& place, std::vector<PlaceEntry*>& entries) {
  for (PlaceEntry* entry : entries)
    for (const PlaceEntry* other : entries)
      if (other != entry) entry->verified.push_back({other->name, Outcome::kAgrees});
  for (const figures::StandardScene& scene : figures::StandardScenes()) {
    std::vector<SceneOf> all;
    for (PlaceEntry* entry : entries) {
      auto file = std::make_unique<figures::ComparedFile>(place / entry->name / scene.ResultName(),
                                                          entry->name);
      figures::SceneFigures collected = figures::CollectScene(scene, file->model);
      all.push_back({entry, std::move(file), std::move(collected)});
    }
    for (SceneOf& claimed : all) {
      std::size_t next = 0;
      for (const SceneOf& here : all)
        if (&here != &claimed) VerifyScene(claimed, here, claimed.entry->verified[next++]);
    }
  }
}

/// The value of a member, if it is of that kind; else null. Summaries of other versions are not
/// those of this program.
Json MemberOf(const Json& json, const char* name) {
  const auto member = json.is_object() ? json.find(name) : json.end();
  return member == json.end() ? Json(nullptr) : *member;
}

Json TextOf(const Json& json, const char* name) {
  Json member = MemberOf(json, name);
  return member.is_string() ? member : Json(nullptr);
}

Json RealOf(const Json& json, const char* name) {
  Json member = MemberOf(json, name);
  return member.is_number() ? member : Json(nullptr);
}

Json ScoresJson(const Json& summary) {
  Json scores = Json::array();
  for (const Json& kind : MemberOf(summary, "kinds"))
    for (const Json& score : MemberOf(kind, "scores")) {
      Json interval = MemberOf(score, "interval"), faults = Json::array();
      if (!interval.is_array() || interval.size() != 2 ||
          !std::ranges::all_of(interval, [](const Json& end) { return end.is_number(); }))
        interval = nullptr;
      for (const Json& fault : MemberOf(score, "faults"))
        if (fault.is_string()) faults.push_back(fault);
      scores.push_back({{"kind", TextOf(kind, "kind")},
                        {"name", TextOf(score, "name")},
                        {"score", RealOf(score, "score")},
                        {"interval", std::move(interval)},
                        {"faults", std::move(faults)}});
    }
  return scores;
}

Json FactsJson(const Json& facts) {
  Json all = Json::object();
  if (facts.is_object())
    for (const auto& [name, value] : facts.items())
      if (value.is_string()) all[name] = value;
  return all;
}

constexpr const char* kSignatureWords[] = {"none", "good", "stranger", "bad", "unchecked"};
constexpr const char* kOutcomeWords[] = {"agrees", "partly", "not_compared", "disagrees"};

Json EntryJson(const PlaceEntry& entry) {
  const Json summary = Json::parse(entry.summary, nullptr, false);
  Json json = {{"name", entry.name},
               {"faults", entry.faults},
               {"signature",
                {{"state", kSignatureWords[static_cast<std::size_t>(entry.signature.state)]},
                 {"text", entry.signature.text}}},
               {"variant", TextOf(summary, "variant")},
               {"seed", RealOf(summary, "seed")},
               {"measured", TextOf(summary, "measured")},
               {"machine", FactsJson(MemberOf(summary, "machine"))},
               {"build", FactsJson(MemberOf(summary, "build"))},
               {"scores", ScoresJson(summary)}};
  json["verified"] = Json::array();
  for (const Verification& of : entry.verified)
    json["verified"].push_back({{"by", of.by},
                                {"outcome", kOutcomeWords[static_cast<std::size_t>(of.outcome)]},
                                {"scenes", of.scenes},
                                {"same_states", of.same_states},
                                {"reasons", of.reasons}});
  return json;
}

/// Versions, the newest first, each with its entries; entries of no known version are the last.
Json PlaceJson(const Place& place) {
  std::map<int, Json, std::greater<>> versions;
  for (const PlaceEntry& entry : place.entries) {
    Json& version = versions[entry.version.value_or(0)];
    if (version.is_null())
      version = {{"version", entry.version ? Json(*entry.version) : Json(nullptr)},
                 {"is_checked", IsThisVersion(entry)},
                 {"entries", Json::array()}};
    version["entries"].push_back(EntryJson(entry));
  }
  Json json = {{"suite", figures::kSuiteVersion}};
  json["kinds"] = Json::array();
  for (const figures::SuiteKind& kind : figures::SuiteKinds())
    json["kinds"].push_back({{"kind", kind.name}, {"what", kind.doc}});
  json["versions"] = Json::array();
  for (auto& [number, version] : versions) json["versions"].push_back(std::move(version));
  json["left_out"] = Json::array();
  for (const auto& [folder, why] : place.left_out)
    json["left_out"].push_back({{"folder", folder}, {"why", why}});
  return json;
}

}  // namespace

Place ReadPlace(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    // Names with a dot are of temporary folders, or of git.
    const std::string name = entry->path().filename().string();
    if (entry->is_directory(error) && !name.starts_with('.')) names.push_back(name);
  }
  if (error)
    throw options::CommandError(
        fmt::format("cannot read the folder '{}': {}", folder.string(), error.message()));
  std::ranges::sort(names);
  Place place;
  for (const std::string& name : names) {
    if (IsPublished(folder / name) || HasResults(folder / name))
      place.entries.push_back(ReadEntry(folder / name));
    else
      place.left_out.emplace_back(name, "it has no results of the suite");
  }
  if (place.entries.empty())
    throw options::CommandError(
        fmt::format("'{}' has no published results; `cdb suite -o RESULTS --publish {}` adds some",
                    folder.string(), folder.string()));
  std::vector<PlaceEntry*> comparable;
  for (PlaceEntry& entry : place.entries)
    if (IsThisVersion(entry) && entry.faults.empty()) comparable.push_back(&entry);
  VerifyAll(folder, comparable);
  return place;
}

void WritePlacePage(const Place& place, const fs::path& folder) {
  const std::string json = PlaceJson(place).dump(-1, ' ', false, Json::error_handler_t::replace);
  files::WriteWhole(page::Assemble(page::ReportTemplate(), "Results of the standard suite of cdb",
                                   fmt::format("{{\"place\":{}}}", json)),
                    folder / kPlacePage);
}

}  // namespace cdb::publish
