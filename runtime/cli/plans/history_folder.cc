#include "runtime/cli/plans/history_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/plan/plan.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/store.h"

namespace cdb::plans {
namespace {

namespace fs = std::filesystem;
using history::FileFigures;
using history::PointFigures;

/// Increased if anything is read from the files differently.
constexpr int kCacheVersion = 2;

/// What tells a file from its later versions.
struct Stamp {
  std::uint64_t size = 0;
  std::int64_t changed = 0;
  bool operator==(const Stamp&) const = default;
};

struct CachedFile {
  Stamp stamp;
  FileFigures figures;
};
using Cache = std::map<std::string, CachedFile>;

nlohmann::json ToJson(const CachedFile& of) {
  nlohmann::json points = nlohmann::json::array();
  for (const PointFigures& point : of.figures.points)
    points.push_back({{"place", point.place},
                      {"scene", point.scene},
                      {"figures", point.figures},
                      {"state", point.state}});
  return {{"size", of.stamp.size},
          {"changed", of.stamp.changed},
          {"benchmark", of.figures.benchmark},
          {"title", of.figures.title},
          {"started", of.figures.started},
          {"facts", of.figures.facts},
          {"points", std::move(points)},
          {"unsound", of.figures.unsound},
          {"counters", of.figures.has_counters}};
}

/// Throws nlohmann::json::exception.
CachedFile FromJson(const std::string& name, const nlohmann::json& of) {
  CachedFile file = {{of.at("size"), of.at("changed")}, {}};
  FileFigures& figures = file.figures;
  figures.file = name;
  figures.benchmark = of.at("benchmark");
  figures.title = of.at("title");
  figures.started = figures.place = of.at("started");
  figures.facts = of.at("facts");
  figures.unsound = of.at("unsound");
  figures.has_counters = of.at("counters");
  for (const nlohmann::json& point : of.at("points"))
    figures.points.push_back(
        {point.at("place"), point.at("scene"), point.at("figures"), point.at("state")});
  return file;
}

/// Empty if there is none that can be used.
Cache ReadCache(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string digest;
  if (!stream || !std::getline(stream, digest)) return {};
  const std::string text((std::istreambuf_iterator<char>(stream)), {});
  if (plan::Sha256Hex(text) != digest) return {};
  try {
    const nlohmann::json all = nlohmann::json::parse(text);
    if (all.at("cdb_history_cache") != kCacheVersion || all.at("plan") != plan::kPlanVersion)
      return {};
    Cache cache;
    for (const auto& [name, of] : all.at("files").items()) cache.emplace(name, FromJson(name, of));
    return cache;
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

std::string CacheText(const Cache& cache) {
  nlohmann::json files = nlohmann::json::object();
  for (const auto& [name, of] : cache) files[name] = ToJson(of);
  const std::string text = nlohmann::json{
      {"cdb_history_cache", kCacheVersion},
      {"plan", plan::kPlanVersion},
      {"files",
       std::move(files)}}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return plan::Sha256Hex(text) + "\n" + text;
}

/// Paths below the folder, in order.
std::vector<std::string> ResultsBelow(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  constexpr auto kReadable = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator at(folder, kReadable, error), end; at != end;
       at.increment(error)) {
    const fs::path& path = at->path();
    const bool is_hidden = path.filename().string().starts_with(".");
    if (at->is_directory(error)) {
      if (is_hidden || path.extension() == ".runs") at.disable_recursion_pending();
    } else if (!is_hidden && path.extension() == ".h5") {
      names.push_back(path.lexically_relative(folder).generic_string());
    }
  }
  std::ranges::sort(names);
  return names;
}

/// Nullopt if there is no such file.
std::optional<Stamp> StampOf(const fs::path& path) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(path, error);
  if (error) return std::nullopt;
  const auto changed = fs::last_write_time(path, error);
  if (error) return std::nullopt;
  return Stamp{size, changed.time_since_epoch().count()};
}

}  // namespace

HistoryFolder ReadHistoryFolder(const fs::path& folder) {
  if (std::error_code error; !fs::is_directory(folder, error))
    throw files::StoreError(
        fmt::format("{} is not a folder: name the folder of results files, such as of `cdb run -o "
                    "history/NAME-COMMIT.h5` (cdb doc history)",
                    folder.string()));
  const Cache before = ReadCache(folder / kHistoryCache);
  HistoryFolder read;
  Cache after;
  for (const std::string& name : ResultsBelow(folder)) {
    const std::optional<Stamp> stamp = StampOf(folder / name);
    if (!stamp) continue;
    if (const auto found = before.find(name);
        found != before.end() && found->second.stamp == *stamp) {
      after.insert(*found);
      continue;
    }
    try {
      if (results::ReadSchema(folder / name) == "cdb-trace") continue;
      after[name] = {*stamp, history::ReadFigures(folder / name, name)};
      ++read.read;
    } catch (const std::runtime_error& error) {
      read.left_out.push_back({name, error.what()});
    }
  }
  for (const auto& [name, of] : after) read.files.push_back(of.figures);
  if (read.read == 0 && after.size() == before.size()) return read;
  try {
    files::WriteWhole(CacheText(after), folder / kHistoryCache);
  } catch (const files::StoreError& error) {
    read.cache_trouble = error.what();
  }
  return read;
}

}  // namespace cdb::plans
