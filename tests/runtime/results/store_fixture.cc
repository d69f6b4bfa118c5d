#include "tests/runtime/results/store_fixture.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "compiler/analysis/reference.h"
#include "runtime/results/journal/journals.h"
#include "tests/runtime/results/journal/change_facts.h"

namespace cdb::tests {
namespace {

/// A number that is small, and different for each run of a plan.
std::uint64_t NumberOf(const plan::Run& run) {
  return run.scene.world.Count("seed") * 10 + run.rep;
}

}  // namespace

plan::Axis NumberAxis(std::string name, std::vector<double> values, std::string unit) {
  plan::Axis axis{name, "objects." + name, std::move(unit), {}};
  for (const double value : values) axis.values.emplace_back(value);
  return axis;
}

plan::Axis TextAxis(std::string name, const std::vector<std::string>& values) {
  plan::Axis axis{name, name, "", {}};
  for (const std::string& value : values) axis.values.emplace_back(value);
  return axis;
}

void Resize(plan::Run& run, const SceneSize& size) {
  run.scene.world.Set("cycles", size.cycles);
  run.scene.world.Set("record", size.record);
  run.scene.world.Set("accuracy.metrics", size.metrics);
  run.scene.world.Set("accuracy.interval", 2.0);
  run.scene.world.Set("accuracy.closed_form", schema::Word{"none"});
  run.scene.world.Set("timestep", 1.0);
  run.scene.world.Set("warmup", std::uint64_t{0});
  run.scene.world.Set("world.walls", schema::Word{"all"});
  run.scene.world.Set("trace", schema::Word{"none"});
  run.scene.world.Set("accuracy.reference.timestep", 1.0);
  run.scene.world.Set("accuracy.reference.precision", schema::Word{"double"});
  run.scene.world.Set("accuracy.reference.detector", schema::Word{"dbvt"});
  run.scene.world.Set("accuracy.reference.iterations", std::uint64_t{100});
  run.scene.world.Set("accuracy.reference.contact", schema::Word{"same"});
  run.scene.groups = {{"objects", {}}};
  run.scene.groups[0].settings.Set("quantity", size.objects);
  run.id = plan::RunId(run.scene, run.rep);
}

plan::Plan MakePlan(std::vector<plan::Axis> axes, std::uint64_t repeats, const SceneSize& size,
                    std::vector<std::vector<std::size_t>> skipped) {
  plan::Plan plan;
  plan.benchmark = "fixture";
  plan.title = "A plan for tests – µ";
  plan.source = "fixture.cdb";
  plan.scenario_text = "benchmark fixture { }\n";
  plan.axes = std::move(axes);
  plan.repeats = repeats;
  plan.skipped = std::move(skipped);
  std::uint64_t points = 1;
  for (const plan::Axis& axis : plan.axes) points *= axis.values.size();
  for (std::uint64_t point = 0; point < points; ++point) {
    std::vector<std::size_t> at(plan.axes.size());
    std::uint64_t rest = point;
    for (std::size_t i = at.size(); i-- > 0; rest /= plan.axes[i].values.size())
      at[i] = rest % plan.axes[i].values.size();
    if (std::ranges::find(plan.skipped, at) != plan.skipped.end()) continue;
    for (std::uint64_t rep = 0; rep < repeats; ++rep) {
      plan::Run run;
      run.at = at;
      run.rep = rep;
      run.scene.world.Set("seed", point);
      Resize(run, size);
      plan.runs.push_back(std::move(run));
    }
  }
  analysis::AddReferences(plan);
  return plan;
}

double ValueAt(const plan::Run& run, const protocol::Series& series, std::size_t index) {
  if (series.name == "contacts") return ContactsIn(run, index);
  const auto row = static_cast<double>(&series - protocol::AllSeries().data());
  const auto number = static_cast<double>(NumberOf(run) % 1'000'000);  // fits an int32
  const double whole = 1e6 * (row + 1) + 1000 * number + static_cast<double>(index);
  const bool is_whole = series.type == protocol::SeriesType::kInt32 || series.name == "duration";
  return is_whole ? whole : whole + 0.1;
}

std::int32_t ContactsIn(const plan::Run& run, std::size_t cycle) {
  return static_cast<std::int32_t>((NumberOf(run) + cycle) % 4);
}

protocol::ContactRecord ContactAt(const plan::Run& run, std::size_t row) {
  const auto n = static_cast<double>(NumberOf(run));
  const auto r = static_cast<double>(row);
  return {r, r + 1, {n + 0.1, r + 0.2, 0.3}, {0, 1, n}, -0.001 * (n + 1) * (r + 1)};
}

FakeResult::FakeResult(const plan::Run& run, results::Status status, std::uint64_t n_cycles) {
  const std::uint64_t cycles = run.scene.world.Count("cycles");
  const std::uint64_t objects = run.scene.ObjectCount();
  const std::uint64_t bodies = analysis::BodyCount(run.scene);
  for (const protocol::Series& series : protocol::AllSeries()) {
    if (!protocol::IsRecordedBy(series, run.scene)) continue;
    const std::size_t count = series.ValueCount({cycles, objects, bodies});
    std::vector<std::byte>& bytes = memory_.emplace_back(count * series.ItemBytes());
    const std::size_t per_cycle =
        series.shape == protocol::SeriesShape::kPhase ? 1 : count / cycles;
    for (std::size_t i = 0; i < count; ++i) {
      const bool ran = !series.HasCycles() || i / per_cycle % cycles < n_cycles;
      if (series.type == protocol::SeriesType::kInt32) {
        const std::int32_t value = ran ? static_cast<std::int32_t>(ValueAt(run, series, i)) : -1;
        std::memcpy(&bytes[i * sizeof(value)], &value, sizeof(value));
      } else {
        const double value =
            ran ? ValueAt(run, series, i) : std::numeric_limits<double>::quiet_NaN();
        std::memcpy(&bytes[i * sizeof(value)], &value, sizeof(value));
      }
    }
  }
  std::size_t next = 0;
  for (const protocol::Series& series : protocol::AllSeries())
    if (protocol::IsRecordedBy(series, run.scene))
      result.series.emplace_back(&series, memory_[next++]);
  if (run.scene.world.Lists("record", "contacts")) {
    std::size_t rows = 0;
    for (std::size_t i = 0; i < n_cycles; ++i) rows += static_cast<std::size_t>(ContactsIn(run, i));
    for (std::size_t row = 0; row < rows; ++row) result.contacts.push_back(ContactAt(run, row));
  }
  const auto n = static_cast<double>(NumberOf(run));
  for (const schema::ErrorInfo* error : analysis::ErrorsOf(run.scene)) {
    auto& values = result.errors.values;
    values[std::string(error->name)] = {n + 0.25};
    if (error->needs_truth) values[std::string(error->name) + "_floor"] = {n + 0.125};
    auto& series = values[std::string(error->name) + "_series"];
    for (std::size_t i = 0; i < protocol::SampleShapeOf(run.scene)->samples; ++i)
      series.push_back(n + static_cast<double>(i) / 4);
  }
  if (!run.reference.empty()) result.errors.truth = run.reference;
  result.status = status;
  result.n_cycles = n_cycles;
  result.started_s = 1.7e9 + n + 0.5;
  result.host = "nöde-" + std::to_string(NumberOf(run) % 3);
  result.omitted = NumberOf(run) % 2 == 0 ? "walls raycast_tree" : "";
  result.decisions = "walls: left out: run " + std::to_string(NumberOf(run)) +
                     "\ngravity: kept: the acceleration is (0, -9.8, 0)\n";
  result.load = 0.25 + n;
  result.scalars.peak_rss_bytes = 5e6 + n;
  result.scalars.place_ns = 1000 + n;
  result.scalars.build_ns = 2000 + n;
  result.scalars.fill_fraction = 0.125;
  result.scalars.harness_ns = 40 + n;
  if (status == results::Status::kDone) {
    result.state_hash = run.id;
  } else {
    result.message = "ended by signal 11 (SIGSEGV) in cycle " + std::to_string(n_cycles);
  }
}

results::Provenance TestProvenance() {
  return {{"cdb_version", "0.1.0"}, {"bullet_version", "3.24"}, {"cpu", "a µ-processor"}};
}

void WriteRun(const plan::Plan& plan, const plan::Run& run, const results::RunResult& result,
              const results::Provenance& provenance, const std::filesystem::path& folder) {
  journal::RunWriter writer(plan, provenance);
  auto journal = journal::Journal::OpenToWrite(folder, plan.Sha256());
  writer.Write(run, result, journal);
}

void WriteReference(const plan::Plan& plan, const plan::Run& run, const results::RunResult& result,
                    std::span<const double> samples, const results::Provenance& provenance,
                    const std::filesystem::path& folder) {
  auto journal = journal::Journal::OpenToWrite(folder, plan.Sha256());
  journal::RunWriter(plan, provenance).WriteReference(run, result, samples, journal);
}

void ChangeFacts(const std::filesystem::path& journal, const std::string& run_id) {
  const std::vector<std::byte> facts =
      journal::Journal::OpenToRead(journal).Read(run_id).value().EncodeFacts();
  const std::string text(reinterpret_cast<const char*>(facts.data()), facts.size());
  std::string bytes = ReadFile(journal);
  // SQLite may leave earlier copies of a row in the file.
  for (std::size_t at = 0; (at = bytes.find(text, at)) != std::string::npos; ++at)
    bytes[at + 20] = static_cast<char>(bytes[at + 20] ^ 1);
  WriteFile(journal, bytes);
}

std::map<std::string, std::int64_t> RunsIn(const std::filesystem::path& folder) {
  std::map<std::string, std::int64_t> runs;
  for (const std::filesystem::path& file : journal::JournalsIn(folder))
    journal::Journal::OpenToRead(file).ForEachRun(
        [&](const journal::Journal::Row& row) { runs[row.run_id] = row.written_ns; });
  return runs;
}

}  // namespace cdb::tests
