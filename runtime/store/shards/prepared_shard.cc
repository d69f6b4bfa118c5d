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
                             const store::PlanFacts& facts, std::vector<std::byte> image)
    : template_(std::move(from)), plan_(plan), facts_(facts), image_(std::move(image)) {}

std::unique_ptr<PreparedShard> PreparedShard::Make(std::shared_ptr<const ShardTemplate> from,
                                                   const plan::Plan& plan,
                                                   const store::PlanFacts& facts,
                                                   const plan::Run& run,
                                                   const std::string& models) {
  if (facts.contacts || facts.samples > 0) return nullptr;
  const std::size_t outer = from->layout.grid.size();
  for (const store::Array& array : from->layout.arrays)
    if (array.series != nullptr && !IsOneChunk(array, outer)) return nullptr;
  hdf5::File file = hdf5::File::CopyImage(from->image);
  if (!models.empty()) file.OpenGroup("provenance").SetText("models", models);
  WriteHeadOfRun(file, run);
  std::unique_ptr<PreparedShard> made(
      new PreparedShard(std::move(from), plan, facts, file.Image()));
  made->FindPlaces(file, run);
  made->FindCoordinates(file);
  return made;
}

void PreparedShard::FindPlaces(const hdf5::File& file, const plan::Run& run) {
  for (const auto& [name, text] : HeadOfRun(run)) head_.push_back(image_.FindAttribute(file, name));
  for (const store::RunNumber& number : facts_.numbers)
    numbers_.push_back(image_.FindNumber(file.OpenDataset(number.name)));
  for (const store::RunText& text : facts_.texts)
    texts_.push_back(image_.FindTexts(file.OpenDataset(text.name)));
  texts_.push_back(image_.FindTexts(file.OpenDataset(kRunText)));
  for (const store::Array& array : template_->layout.arrays)
    if (array.series != nullptr)
      series_.push_back({&array, image_.FindChunk(file.OpenDataset(array.name))});
}

void PreparedShard::FindCoordinates(const hdf5::File& file) {
  const std::vector<RunCoordinate> coordinates = RunCoordinates(plan_, facts_);
  for (const RunCoordinate& coordinate : coordinates) {
    const hdf5::Dataset dataset = file.OpenDataset(coordinate.dataset);
    const bool is_text = dataset.type() == hdf5::Type::kText;
    coordinates_.push_back({coordinate, is_text ? hdf5::NumberPlace{image_.FindTexts(dataset)}
                                                : image_.FindNumber(dataset)});
  }
  for (const store::Dimension* labels : Labels(template_->layout, coordinates))
    labels_.emplace_back(labels, image_.FindTexts(file.OpenDataset(labels->name)));
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
                              const std::string& run_text) const {
  hdf5::ImageEditor editor(image_);
  const store::HeadTexts head = HeadOfRun(run);
  for (std::size_t i = 0; i < head_.size(); ++i) editor.SetAttribute(head_[i], head[i].second);
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    editor.SetNumber(numbers_[i], facts_.numbers[i].get(result));
  for (const auto& [coordinate, place] : coordinates_) {
    const plan::Coordinate value = ValueOf(coordinate, plan_, run);
    if (const auto* text = std::get_if<std::string>(&value))
      editor.SetText(place.begin, *text);
    else
      editor.SetNumber(place, std::get<double>(value));
  }
  for (const auto& [labels, place] : labels_)
    for (std::size_t i = 0; i < labels->texts.size(); ++i)
      editor.SetText(place + i * hdf5::EditableImage::kTextBytes, labels->texts[i]);
  for (std::size_t i = 0; i < facts_.texts.size(); ++i)
    editor.SetText(texts_[i], facts_.texts[i].get(run, result));
  editor.SetText(texts_.back(), run_text);
  ShardFile shard;
  for (std::size_t i = 0; i < series_.size(); ++i) {
    const hdf5::ChunkPlace chunk = editor.SetChunk(
        series_[i].chunk, hdf5::Filtered(values[i], hdf5::ItemBytes(series_[i].array->type)));
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
  if (!is_good_) return std::nullopt;
  try {
    ShardFile shard = Fill(run, result, values, run_text);
    const std::lock_guard lock(mutex_);
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
