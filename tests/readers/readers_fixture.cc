// Writes a real result whose every number is known, and what a reader must find in it:
//   readers_fixture FOLDER
// makes out.h5; numbers.tsv and texts.tsv with a line `name, shape, values` for each array (values
// in the order of the file, last dimension fastest, NaN or the fill value -1 where there is none);
// labels.tsv with a line `name, axis=label…, value`, of arrays in every group that has axes; and
// medians.tsv with a line `coordinates, median step time` for each cell that ran.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kCycles = 5, kObjects = 2, kRepeats = 2;

/// An array as the file should hold it.
template <typename Value>
struct Expected {
  std::vector<std::uint64_t> shape;
  std::vector<Value> values;
};

class Fixture {
 public:
  explicit Fixture(const std::filesystem::path& folder) : folder_(folder) {}

  void Write() {
    for (std::size_t i = 0; i < plan_.runs.size(); ++i) {
      if (i == 5) continue;  // is missing
      const plan::Run& run = plan_.runs[i];
      const FakeResult fake(run, i == 2 ? results::Status::kCrashed : results::Status::kDone,
                            i == 2 ? 2 : kCycles);
      WriteRun(plan_, run, fake.result, TestProvenance(), runs_.path());
      results_.emplace(CellOf(run.at, run.rep), std::pair(&run, fake.result));
    }
    WriteReferences();
    journal::Merge(plan_, TestProvenance(), runs_.path(), folder_ / "out.h5");
    Coordinates("");
    Coordinates("run/");
    Coordinates("accuracy/");
    for (const protocol::Series& series : protocol::AllSeries())
      if (protocol::IsRecordedBy(series, plan_)) ExpectSeries(series);
    ExpectContacts();
    ExpectRuns();
    ExpectErrors();
    Print("numbers.tsv", numbers_, [](double value) { return fmt::format("{}", value); });
    Print("texts.tsv", texts_, [](const std::string& text) { return text; });
    PrintMedians();
    PrintLabels();
  }

 private:
  std::size_t CellOf(const std::vector<std::size_t>& at, std::uint64_t rep) const {
    std::size_t cell = 0;
    for (std::size_t i = 0; i < at.size(); ++i) cell = cell * plan_.axes[i].values.size() + at[i];
    return cell * kRepeats + rep;
  }

  /// Every value is different.
  static double SampleOf(std::size_t reference, std::size_t index) {
    return static_cast<double>(1000 * reference + index) + 0.5;
  }

  void WriteReferences() const {
    for (std::size_t r = 0; r < plan_.references.size(); ++r) {
      const plan::Run& run = plan_.references[r];
      std::vector<double> samples(protocol::SampleShapeOf(run.scene)->Count());
      for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = SampleOf(r, i);
      results::RunResult result;
      result.status = results::Status::kDone;
      WriteReference(plan_, run, result, samples, TestProvenance(), runs_.path());
    }
  }

  /// Of the root, or of a group of arrays over the grid.
  void Coordinates(const std::string& group) {
    grid_.clear();
    for (const plan::Axis& axis : plan_.axes) {
      grid_.push_back(axis.values.size());
      for (const plan::Coordinate& value : axis.values) {
        if (axis.IsText()) {
          texts_[group + axis.name].shape = {grid_.back()};
          texts_[group + axis.name].values.push_back(std::get<std::string>(value));
        } else {
          numbers_[group + axis.name].shape = {grid_.back()};
          numbers_[group + axis.name].values.push_back(std::get<double>(value));
        }
      }
    }
    grid_.push_back(kRepeats);
    cells_ = 1;
    for (const std::uint64_t n : grid_) cells_ *= n;
    numbers_[group + "rep"] = {{kRepeats}, {0, 1}};
    if (group == "accuracy/") numbers_["accuracy/sample"] = {{3}, {0, 2, 4}};
    if (!group.empty()) return;
    numbers_["cycle"] = {{kCycles}, {0, 1, 2, 3, 4}};
    texts_["phase"] = {{protocol::kPhaseCount},
                       {protocol::PhaseNames().begin(), protocol::PhaseNames().end()}};
    texts_["pose"] = {{protocol::kPoseSize}, {"x", "y", "z", "qx", "qy", "qz", "qw"}};
  }

  void ExpectSeries(const protocol::Series& series) {
    Expected<double>& array = numbers_[std::string(series.name)];
    array.shape = grid_;
    if (series.shape == protocol::SeriesShape::kPhase) array.shape.push_back(protocol::kPhaseCount);
    array.shape.push_back(kCycles);
    if (series.shape == protocol::SeriesShape::kPose) {
      array.shape.push_back(kObjects);
      array.shape.push_back(protocol::kPoseSize);
    }
    const std::size_t count = series.ValueCount({kCycles, kObjects, 0});
    const std::size_t per_cycle =
        series.shape == protocol::SeriesShape::kPose ? kObjects * protocol::kPoseSize : 1;
    const double fill = series.type == protocol::SeriesType::kInt32 ? -1 : kNaN;
    array.values.assign(cells_ * count, fill);
    for (const auto& [cell, result] : results_)
      for (std::size_t i = 0; i < count; ++i)
        if (i / per_cycle % kCycles < result.second.n_cycles)
          array.values[cell * count + i] = ValueAt(*result.first, series, i);
  }

  void ExpectContacts() {
    Expected<double> first = {grid_, std::vector<double>(cells_, kNaN)};
    std::vector<double> bodies, points, normals, distances;
    for (const auto& [cell, result] : results_) {
      first.values[cell] = static_cast<double>(distances.size());
      for (const protocol::ContactRecord& contact : result.second.contacts) {
        bodies.insert(bodies.end(), {contact.body_a, contact.body_b});
        points.insert(points.end(), std::begin(contact.point), std::end(contact.point));
        normals.insert(normals.end(), std::begin(contact.normal), std::end(contact.normal));
        distances.push_back(contact.distance);
      }
    }
    const std::uint64_t n = distances.size();
    numbers_["contact_first"] = std::move(first);
    numbers_["contact_body"] = {{n, 2}, std::move(bodies)};
    numbers_["contact_point"] = {{n, 3}, std::move(points)};
    numbers_["contact_normal"] = {{n, 3}, std::move(normals)};
    numbers_["contact_distance"] = {{n}, std::move(distances)};
  }

  void ExpectRuns() {
    const auto number = [this](const char* name, double missing, auto get) {
      Expected<double> array = {grid_, std::vector<double>(cells_, missing)};
      for (const auto& [cell, result] : results_) array.values[cell] = get(result.second);
      numbers_[name] = std::move(array);
    };
    number("status", 0, [](const results::RunResult& r) { return static_cast<double>(r.status); });
    for (const auto& point : plan_.skipped)
      for (std::uint64_t rep = 0; rep < kRepeats; ++rep)
        numbers_["status"].values[CellOf(point, rep)] =
            static_cast<double>(results::Status::kSkipped);
    number("n_cycles", -1,
           [](const results::RunResult& r) { return static_cast<double>(r.n_cycles); });
    number("run/load_average", kNaN, [](const results::RunResult& r) { return r.load; });
    number("run/peak_rss", kNaN,
           [](const results::RunResult& r) { return r.scalars.peak_rss_bytes; });
    number("run/build_time", kNaN, [](const results::RunResult& r) { return r.scalars.build_ns; });
    for (const char* name :
         {"run/state_hash", "run/host", "run/run_id", "run/message", "run/omitted"})
      texts_[name] = {grid_, std::vector<std::string>(cells_)};
    for (const auto& [cell, result] : results_) {
      texts_["run/state_hash"].values[cell] = result.second.state_hash;
      texts_["run/host"].values[cell] = result.second.host;
      texts_["run/message"].values[cell] = result.second.message;
      texts_["run/omitted"].values[cell] = result.second.omitted;
    }
    for (const plan::Run& run : plan_.runs)
      texts_["run/run_id"].values[CellOf(run.at, run.rep)] = run.id;
  }

  void ExpectErrors() {
    for (const char* name : {"position", "position_floor", "penetration", "position_series"}) {
      const std::size_t samples = std::string_view(name).ends_with("_series") ? 3 : 1;
      Expected<double> array = {grid_, std::vector<double>(cells_ * samples, kNaN)};
      if (samples > 1) array.shape.push_back(samples);
      for (const auto& [cell, result] : results_)
        std::ranges::copy(result.second.errors.values.at(name),
                          array.values.begin() + static_cast<std::ptrdiff_t>(cell * samples));
      numbers_[std::string("accuracy/") + name] = std::move(array);
    }
  }

  template <typename Value, typename Format>
  void Print(const char* name, const std::map<std::string, Expected<Value>>& arrays,
             Format format) const {
    std::ofstream out(folder_ / name);
    for (const auto& [dataset, array] : arrays) {
      out << fmt::format("{}\t{}", dataset, fmt::join(array.shape, " "));
      for (const Value& value : array.values) out << '\t' << format(value);
      out << '\n';
    }
  }

  void PrintMedians() const {
    std::ofstream out(folder_ / "medians.tsv");
    const protocol::Series& duration = *protocol::FindSeries("duration");
    for (std::size_t point = 0; point < cells_ / kRepeats; ++point) {
      std::vector<double> values;
      for (std::uint64_t rep = 0; rep < kRepeats; ++rep) {
        const auto found = results_.find(point * kRepeats + rep);
        if (found == results_.end()) continue;
        for (std::size_t i = 0; i < found->second.second.n_cycles; ++i)
          values.push_back(ValueAt(*found->second.first, duration,
                                   protocol::IndexOf(protocol::Phase::kStep) * kCycles + i));
      }
      if (values.empty()) continue;
      std::ranges::sort(values);
      const std::size_t half = values.size() / 2;
      const double median =
          values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
      std::size_t rest = point;
      std::string text;
      for (std::size_t i = plan_.axes.size(); i-- > 0; rest /= grid_[i]) {
        const plan::Coordinate& value = plan_.axes[i].values[rest % grid_[i]];
        const auto* real = std::get_if<double>(&value);
        text = (real != nullptr ? fmt::format("{}", *real) : std::get<std::string>(value)) + '\t' +
               text;
      }
      out << text << fmt::format("{}\n", median);
    }
  }

  /// Values that a reader finds by the labels of the coordinates in the array's own group.
  void PrintLabels() const {
    std::ofstream out(folder_ / "labels.tsv");
    for (const auto& [cell, result] : results_) {
      const plan::Run& run = *result.first;
      std::string at;
      for (std::size_t i = 0; i < plan_.axes.size(); ++i) {
        const plan::Coordinate& value = plan_.axes[i].values[run.at[i]];
        const auto* real = std::get_if<double>(&value);
        at +=
            fmt::format("\t{}={}", plan_.axes[i].name,
                        real != nullptr ? fmt::format("{}", *real) : std::get<std::string>(value));
      }
      at += fmt::format("\trep={}", run.rep);
      out << fmt::format("run/host{}\t{}\n", at, result.second.host)
          << fmt::format("run/peak_rss{}\t{}\n", at, result.second.scalars.peak_rss_bytes)
          << fmt::format("accuracy/position{}\t{}\n", at,
                         result.second.errors.values.at("position")[0])
          << fmt::format("accuracy/position_series{}\tsample=4\t{}\n", at,
                         result.second.errors.values.at("position_series")[2])
          << fmt::format("duration{}\tphase=solve\tcycle=0\t{}\n", at,
                         ValueAt(run, *protocol::FindSeries("duration"),
                                 protocol::IndexOf(protocol::Phase::kSolve) * kCycles));
    }
    const protocol::SampleShape shape = *protocol::SampleShapeOf(plan_.references[1].scene);
    out << fmt::format("accuracy/reference/states\treference={}\tsample=2\tbody=1\tstate=vx\t{}\n",
                       plan_.references[1].id, SampleOf(1, shape.State(1, 1) + 7));
  }

  const std::filesystem::path folder_;
  const TemporaryFolder runs_;
  const plan::Plan plan_ =
      MakePlan({NumberAxis("quantity", {10, 20, 30}), NumberAxis("size", {0.5, 1.25}, "m"),
                TextAxis("detector", {"simple", "dbvt"})},
               kRepeats,
               {.cycles = kCycles,
                .objects = kObjects,
                .record = {"timing", "counts", "stability", "contacts", "poses"},
                .metrics = {"position", "penetration"}},
               {{1, 0, 1}});
  std::vector<std::uint64_t> grid_;
  std::size_t cells_ = 0;
  std::map<std::size_t, std::pair<const plan::Run*, results::RunResult>> results_;
  std::map<std::string, Expected<double>> numbers_;
  std::map<std::string, Expected<std::string>> texts_;
};

}  // namespace
}  // namespace cdb::tests

using namespace cdb::tests;

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  std::filesystem::create_directories(argv[1]);
  Fixture(argv[1]).Write();
}
