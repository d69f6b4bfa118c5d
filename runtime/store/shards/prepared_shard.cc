#include "runtime/store/shards/prepared_shard.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <variant>

namespace cdb::shards {
namespace {

constexpr const char* kRunText = "provenance/run_text";

/// True if a cell is exactly one chunk.
bool IsOneChunk(const store::Array& array, std::size_t outer) {
  return std::equal(array.chunk.begin() + static_cast<std::ptrdiff_t>(outer), array.chunk.end(),
                    array.shape.begin() + static_cast<std::ptrdiff_t>(outer), array.shape.end()) &&
         std::all_of(array.chunk.begin(), array.chunk.begin() + static_cast<std::ptrdiff_t>(outer),
                     [](std::uint64_t n) { return n == 1; });
}

bool SameNumber(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

PreparedShard::PreparedShard(std::shared_ptr<const ShardTemplate> from, const plan::Plan& plan,
                             const store::PlanFacts& facts, const std::string& models)
    : template_(std::move(from)),
      plan_(plan),
      facts_(facts),
      file_(hdf5::File::CopyImage(template_->image)) {
  if (!models.empty()) file_.OpenGroup("provenance").SetText("models", models);
}

std::unique_ptr<PreparedShard> PreparedShard::Make(std::shared_ptr<const ShardTemplate> from,
                                                   const plan::Plan& plan,
                                                   const store::PlanFacts& facts,
                                                   const plan::Run& run,
                                                   const std::string& models) {
  if (facts.contacts || facts.samples > 0) return nullptr;
  std::unique_ptr<PreparedShard> made(new PreparedShard(std::move(from), plan, facts, models));
  if (!made->FindSeries() || !made->FindTexts() || !made->FindPlaces(run)) return nullptr;
  return made;
}

bool PreparedShard::FindSeries() {
  const store::Layout& layout = template_->layout;
  const std::size_t outer = layout.grid.size();
  for (const store::Array& array : layout.arrays) {
    if (array.series == nullptr) continue;
    if (!IsOneChunk(array, outer)) return false;
    file_.OpenDataset(array.name)
        .WriteChunk(hdf5::Shape(array.shape.size(), 0), 0, {{std::byte{0}}});
    series_.push_back({&array, 0});
  }
  const std::vector<std::byte> image = file_.Image();
  for (SeriesPlace& series : series_) {
    const std::size_t rank = series.array->shape.size();
    const auto chunk = file_.OpenDataset(series.array->name).FindChunk(hdf5::Shape(rank, 0));
    const auto entry = chunk ? hdf5::FindChunkEntry(image, *chunk, rank) : std::nullopt;
    if (!entry) return false;
    series.entry = *entry;
  }
  return true;
}

bool PreparedShard::FindTexts() {
  std::vector<std::string> names;
  for (const store::RunText& text : facts_.texts) names.push_back(text.name);
  names.emplace_back(kRunText);
  for (const std::string& name : names) {
    hdf5::Dataset dataset = file_.OpenDataset(name);
    dataset.WriteText({{std::string()}});
    const auto place = dataset.FindValues();
    if (!place) return false;
    texts_.push_back(*place);
  }
  return true;
}

bool PreparedShard::FindPlaces(const plan::Run& run) {
  for (const store::RunNumber& number : facts_.numbers) {
    hdf5::Dataset dataset = file_.OpenDataset(number.name);
    dataset.Write({{number.missing}});
    const auto place = hdf5::FindNumber(dataset);
    if (!place) return false;
    numbers_.push_back(*place);
  }
  WritePlace(file_, plan_, facts_, run);
  for (const std::string& group : {std::string(), std::string(store::kRunGroup)}) {
    for (std::size_t i = 0; i <= plan_.axes.size(); ++i) {
      const bool is_rep = i == plan_.axes.size();
      if (!is_rep && plan_.axes[i].IsText()) continue;
      const auto place =
          hdf5::FindNumber(file_.OpenDataset(group + (is_rep ? "rep" : plan_.axes[i].name)));
      if (!place) return false;
      coordinates_.emplace_back(*place, i);
    }
  }
  return true;
}

std::vector<std::span<const std::byte>> PreparedShard::SeriesOf(
    const store::RunResult& result) const {
  std::vector<std::span<const std::byte>> values;
  for (const SeriesPlace& place : series_) {
    const auto found = std::ranges::find_if(
        result.series, [&](const auto& series) { return series.first == place.array->series; });
    std::size_t bytes = hdf5::ItemBytes(place.array->type);
    for (const std::uint64_t n : place.array->shape) bytes *= n;
    if (found == result.series.end() || found->second.size() != bytes) return {};
    values.push_back(found->second);
  }
  return values;
}

ShardFile PreparedShard::Fill(const plan::Run& run, const store::RunResult& result,
                              std::span<const std::span<const std::byte>> values,
                              const std::string& run_text) {
  WriteHeadOfRun(file_, run);
  hdf5::ImageEditor editor(file_.Image());
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    editor.SetNumber(numbers_[i], facts_.numbers[i].get(result));
  for (const auto& [place, axis] : coordinates_)
    editor.SetNumber(place, axis == plan_.axes.size()
                                ? static_cast<double>(run.rep)
                                : std::get<double>(plan_.axes[axis].values[run.at[axis]]));
  for (std::size_t i = 0; i < facts_.texts.size(); ++i)
    editor.SetText(texts_[i], facts_.texts[i].get(run, result));
  editor.SetText(texts_.back(), run_text);
  ShardFile shard;
  for (std::size_t i = 0; i < series_.size(); ++i) {
    const store::Array& array = *series_[i].array;
    const hdf5::ChunkPlace chunk =
        editor.SetChunk(series_[i].entry, array.shape.size(),
                        hdf5::Filtered(values[i], hdf5::ItemBytes(array.type)));
    shard.chunks.push_back(
        {static_cast<std::uint32_t>(i), 0, chunk.filter_mask, chunk.begin, chunk.bytes});
  }
  shard.image = editor.Finish();
  return shard;
}

std::optional<ShardFile> PreparedShard::Write(const plan::Run& run, const store::RunResult& result,
                                              const std::string& run_text) {
  const auto values = SeriesOf(result);
  if (result.n_cycles != facts_.cycles || values.size() != series_.size()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!is_good_) return std::nullopt;
  try {
    ShardFile shard = Fill(run, result, values, run_text);
    if (!std::exchange(is_checked_, true)) is_good_ = ReadsBack(shard, run, result, run_text);
    if (is_good_) return shard;
  } catch (const hdf5::Error&) {
    is_good_ = false;  // from now on HDF5 writes the whole shard, or reports the error
  }
  return std::nullopt;
}

bool PreparedShard::ReadsBack(const ShardFile& shard, const plan::Run& run,
                              const store::RunResult& result, const std::string& run_text) const {
  try {
    const hdf5::File file = hdf5::File::OpenImage(shard.image);
    for (const store::RunNumber& number : facts_.numbers)
      if (!SameNumber(file.OpenDataset(number.name).Read().at(0),
                      hdf5::AsStored(number.get(result), number.type)))
        return false;
    for (const store::RunText& text : facts_.texts)
      if (file.OpenDataset(text.name).ReadText().at(0) != text.get(run, result).c_str())
        return false;
    if (file.OpenDataset(kRunText).ReadText().at(0) != run_text) return false;
    const auto values = SeriesOf(result);
    for (std::size_t i = 0; i < series_.size(); ++i) {
      const store::Array& array = *series_[i].array;
      hdf5::RawChunk chunk;
      if (!file.OpenDataset(array.name).ReadChunk(hdf5::Shape(array.shape.size(), 0), chunk) ||
          chunk.bytes != hdf5::Filtered(values[i], hdf5::ItemBytes(array.type)))
        return false;
      const std::vector<double> read = file.OpenDataset(array.name).Read();
      for (std::size_t at = 0; at < read.size(); ++at) {
        double expected = 0;
        std::int32_t count = 0;
        if (array.type == hdf5::Type::kFloat64)
          std::memcpy(&expected, &values[i][at * sizeof expected], sizeof expected);
        else
          std::memcpy(&count, &values[i][at * sizeof count], sizeof count);
        if (!SameNumber(read[at], array.type == hdf5::Type::kFloat64 ? expected : count))
          return false;
      }
    }
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

std::shared_ptr<PreparedShard> PreparedShards::Prepare(
    const std::shared_ptr<const ShardTemplate>& from, const plan::Run& run,
    const std::string& models) const {
  try {
    return PreparedShard::Make(from, plan_, facts_, run, models);
  } catch (const hdf5::Error&) {
    return nullptr;
  }
}

std::optional<ShardFile> PreparedShards::Write(const std::shared_ptr<const ShardTemplate>& from,
                                               const plan::Run& run, const store::RunResult& result,
                                               const std::string& run_text) {
  constexpr std::size_t kMost = 64, kRunsBefore = 2;
  std::shared_ptr<PreparedShard> shard;
  {
    const std::lock_guard lock(mutex_);
    const Key key(from, result.models);
    if (shards_.size() >= kMost && !shards_.contains(key)) shards_.clear();
    Entry& entry = shards_[key];
    if (entry.runs++ == kRunsBefore) entry.shard = Prepare(from, run, result.models);
    shard = entry.shard;
  }
  return shard == nullptr ? std::nullopt : shard->Write(run, result, run_text);
}

}  // namespace cdb::shards
