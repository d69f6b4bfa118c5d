// Compiles scenarios from texts and files in memory.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "compiler/analysis/soft.h"
#include "compiler/compile.h"
#include "compiler/plan/input_file.h"
#include "compiler/schema/parametrised_words.h"
#include "library/layouts/pose_columns.h"
#include "library/objects/formula_ground.h"
#include "library/objects/solid.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"

namespace cdb::tests {

/// Replaces the reading of a shared library: each line of the text is a detector with its name,
/// limit and phases. A text without detectors is not a library.
inline scenario::DescribePlugin DescribeText() {
  return [](const std::string& bytes, const std::string& path,
            std::string& why) -> std::optional<std::vector<schema::PluginDetector>> {
    std::vector<schema::PluginDetector> detectors;
    std::istringstream lines(bytes);
    schema::PluginDetector detector;
    while (lines >> detector.name >> detector.max_bodies &&
           std::getline(lines >> std::ws, detector.phases))
      detectors.push_back(detector);
    if (!detectors.empty()) return detectors;
    why = "'" + path + "' has no detectors";
    return std::nullopt;
  };
}

/// Traces of a hundred cycles: 1000 bodies in single precision, with pairs or without, and too many
/// for `sap` in double precision.
inline std::optional<analysis::TraceFacts> MadeUpTraces(const std::string& path, std::string& why) {
  if (path.ends_with("crowd.trace.h5"))
    return analysis::TraceFacts{std::string(64, 'c'), 1000, 100, 1.0 / 60, false};
  if (path.ends_with("large.trace.h5"))
    return analysis::TraceFacts{std::string(64, '1'), 100'000, 100, 1.0 / 240, true};
  if (path.ends_with("pairs.trace.h5"))
    return analysis::TraceFacts{std::string(64, 'c'), 1000, 100, 1.0 / 60, false,
                                std::string(64, 'p'), 5000};
  why = path.ends_with("result.h5") ? "it is HDF5, but no trace (cdb-results)"
                                    : "there is no such file";
  return std::nullopt;
}

/// Facts about closed forms, and about three models: one of 2 x 1 x 0.5 that is placed at a corner,
/// one whose hulls do not fit it, and one that is open.
inline std::optional<analysis::ModelFacts> MadeUpModels(const schema::Value& type,
                                                        analysis::ModelFault& why) {
  const schema::Call* call = schema::AsCall(type);
  if (call == nullptr)
    return std::ranges::count(objects::kClosedShapes, schema::AsWord(type)->text, objects::TypeOf) >
                   0
               ? objects::ReadModel(type, {}, why)
               : std::nullopt;
  if (!schema::PartsOf(*call).empty() || analysis::IsSoft(type) || objects::IsFormulaGround(*call))
    return objects::ReadModel(type, {}, why);
  const std::string& file = std::get<schema::Text>(schema::ArgumentOf(*call, "file")).text;
  if (file.ends_with("plate.obj"))
    return analysis::ModelFacts{{2, 1, 0.5}, true, {-0.5, -0.5, -0.5}, 1, 1, "plate: 1 hull"};
  if (file.ends_with("rough.obj"))
    return analysis::ModelFacts{{1, 1, 1}, true, {}, 0.65, 40, "rough: 40 hulls, IoU 0.65"};
  if (file.ends_with("open.obj")) why = {file + ": is not watertight", "close it"};
  return std::nullopt;
}

/// Tables in CSV files, as returned by `read`.
inline analysis::ReadPoses ReadTables(const scenario::ReadFile& read) {
  return [read](const schema::Call& poses,
                analysis::PoseFault& why) -> std::optional<analysis::PoseFacts> {
    const std::string& path = std::get<schema::Text>(schema::ArgumentOf(poses, "file")).text;
    try {
      std::string missing;
      const auto text = read(path, missing);
      if (!text) {
        why = {true, path + ": " + missing, "write it"};
        return std::nullopt;
      }
      const layouts::PoseTable table = layouts::ParsePoseText(*text, poses);
      if (poses.name == schema::kPathCall)
        return layouts::FactsOfPath(layouts::Path(poses, table), plan::Sha256Hex(*text));
      return analysis::PoseFacts{plan::Sha256Hex(*text), table.rows.size(), table.has_orientation,
                                 table.has_linear_velocity, table.has_angular_velocity};
    } catch (const library::SceneError& error) {
      why = {false, error.cause(), error.remedy()};
      return std::nullopt;
    }
  };
}

/// Compiles `text` as `test.cdb` beside `others`; `plugins` are those of a command line.
inline compiler::Compilation CompileText(const std::string& text,
                                         std::map<std::string, std::string> others = {},
                                         const std::vector<std::string>& plugins = {}) {
  others["test.cdb"] = text;
  const scenario::ReadFile read = [&](const std::string& path,
                                      std::string& why) -> std::optional<std::string> {
    const auto file = others.find(path);
    if (file != others.end()) return file->second;
    why = "No such file or directory";
    return std::nullopt;
  };
  return compiler::Compile("test.cdb", read,
                           {"lib",
                            std::nullopt,
                            {plugins, DescribeText()},
                            MadeUpTraces,
                            {},
                            ReadTables(read),
                            MadeUpModels});
}

}  // namespace cdb::tests
