#include "library/layouts/pose_table.h"

#include <fmt/format.h>

#include <charconv>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/plan/sha256.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/layouts/path.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using library::SceneError;

constexpr std::string_view kPlanAgain = "plan again from the .cdb file, or put the other file back";

ReadHdf5Poses& Hdf5Reader() {
  static ReadHdf5Poses reader;
  return reader;
}

const std::string& FileOf(const schema::Call& poses) {
  return std::get<schema::Text>(schema::ArgumentOf(poses, "file")).text;
}

struct Unreadable : SceneError {
  using SceneError::SceneError;
};

[[noreturn]] void FailToRead(const std::string& path, const std::string& why) {
  throw Unreadable(fmt::format("{}: {}", path, why),
                   "the path is relative to the folder of the .cdb file");
}

/// The table, and the hash of its source: the CSV file, or the values read from HDF5.
std::pair<PoseTable, std::string> ReadWithHash(const schema::Call& poses) {
  if (analysis::IsCsv(poses)) {
    std::string why;
    const auto bytes = plan::ReadInputFile(FileOf(poses), why);
    if (!bytes) FailToRead(FileOf(poses), why);
    const auto parse = poses.name == schema::kPathCall ? ParsePathCsv : ParsePoseCsv;
    return {parse(*bytes, FileOf(poses)), plan::Sha256Hex(*bytes)};
  }
  if (!Hdf5Reader())
    throw SceneError(fmt::format("{}: nothing here reads HDF5", FileOf(poses)),
                     "run it by `cdb run`");
  PoseTable table = Hdf5Reader()(poses);
  std::string sha256 = plan::Sha256Hex(ToCsv(table));
  return {std::move(table), std::move(sha256)};
}

/// The line before each table: `b` or `o` for body or object axes, and the lengths of key and
/// table.
std::string HeadOf(bool of_body, std::size_t key, std::size_t csv) {
  return fmt::format("{} {} {}\n", of_body ? 'b' : 'o', key, csv);
}

}  // namespace

void SetPoseReader(ReadHdf5Poses reader) { Hdf5Reader() = std::move(reader); }

PoseTable ReadPoseTable(const schema::Call& poses) {
  auto [table, sha256] = ReadWithHash(poses);
  const auto* planned = std::get_if<schema::Text>(&schema::ArgumentOf(poses, "sha256"));
  if (planned != nullptr && planned->text != sha256)
    throw SceneError(
        fmt::format("{}: it differs from the file that the plan was made with", FileOf(poses)),
        std::string(kPlanAgain));
  return std::move(table);
}

std::optional<analysis::PoseFacts> ReadPoseFacts(const schema::Call& poses,
                                                 analysis::PoseFault& why) {
  try {
    if (const std::string fault = plan::WhyNotReadable(FileOf(poses)); !fault.empty())
      FailToRead(FileOf(poses), fault);
    const auto [table, sha256] = ReadWithHash(poses);
    if (poses.name == schema::kPathCall) return FactsOfPath(Path(poses, table), sha256);
    return analysis::PoseFacts{sha256, table.rows.size(), table.has_orientation,
                               table.has_linear_velocity, table.has_angular_velocity};
  } catch (const SceneError& error) {
    why = {dynamic_cast<const Unreadable*>(&error) != nullptr, error.cause(), error.remedy()};
    return std::nullopt;
  }
}

std::string PackPoses(const plan::Scene& scene) {
  std::string packed;
  for (const plan::Group& group : scene.groups) {
    const schema::Call* poses = analysis::PosesOf(group);
    if (poses == nullptr || analysis::IsCsv(*poses)) continue;
    const PoseTable table = ReadPoseTable(*poses);
    const std::string key = schema::ToText(schema::Value(*poses)), csv = ToCsv(table);
    packed += HeadOf(table.of_body, key.size(), csv.size()) + key + csv;
  }
  return packed;
}

PoseTable UnpackPoses(std::string_view packed, const schema::Call& poses) {
  const std::string wanted = schema::ToText(schema::Value(poses));
  while (!packed.empty()) {
    const bool of_body = packed[0] == 'b';
    std::size_t sizes[2] = {0, 0};
    const char *at = packed.data() + 1, *end = packed.data() + packed.size();
    for (std::size_t& size : sizes) {
      CDB_CHECK(at < end);
      at = std::from_chars(at + 1, end, size).ptr;
    }
    packed.remove_prefix(static_cast<std::size_t>(at - packed.data()) + 1);
    CDB_CHECK(sizes[0] + sizes[1] <= packed.size());
    if (packed.substr(0, sizes[0]) == wanted) {
      PoseTable table = ParsePoseCsv(packed.substr(sizes[0], sizes[1]), FileOf(poses));
      table.of_body = of_body;
      return table;
    }
    packed.remove_prefix(sizes[0] + sizes[1]);
  }
  throw SceneError(fmt::format("{}: its poses did not come with the run", FileOf(poses)),
                   "run it by `cdb run`");
}

}  // namespace cdb::layouts
