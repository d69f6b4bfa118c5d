// The editor of a scenario in a browser: its text, its parameters, its scene, and a run of it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runtime/editor/documents.h"
#include "runtime/sweep/process/process.h"

namespace cdb::serve {

struct Scenario {
  std::filesystem::path file;
  std::string benchmark;  ///< the one that is shown
  std::string text;       ///< as stored on the disk
  editor::CompileFile compile;
  std::string library;  ///< folder of the scenarios that come with cdb; may be empty
};

/// Answers are JSON documents. Errors in a text are part of an answer; disk errors are thrown as
/// files::StoreError or std::system_error. Not thread-safe.
class Editor {
 public:
  /// `program`: cdb itself, which executes the runs.
  Editor(Scenario scenario, std::filesystem::path program);
  ~Editor();  ///< stops the run
  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  /// Shows another benchmark from now on. A benchmark that is renamed in the text is followed.
  void Choose(const std::string& benchmark) { scenario_.benchmark = benchmark; }
  /// The document of the page: the scene, and under `editor` the answer of Check, the file, and the
  /// vocabulary of highlighting.
  std::string Document();
  /// {text, benchmark, benchmarks, notice, diagnostics: as of the language server, parameters: null
  /// if the text does not parse, scene: null if there are errors}
  std::string Check(const std::string& text);
  /// The answer of Check for the text with one value changed, or {message}.
  std::string Set(const std::string& text, const std::string& group, const std::string& name,
                  const std::string& value);
  /// The answers of the language server at a position of the text.
  std::string Complete(const std::string& text, const editor::Position& position);
  std::string Hover(const std::string& text, const editor::Position& position);
  /// {message}: refuses if another program has changed the file.
  std::string Save(const std::string& text);
  /// {message}: saves, and starts `cdb run` into BENCHMARK.view.h5, which it replaces. Refuses a
  /// text with errors.
  std::string Run(const std::string& text);
  /// {is_running, log, scene: of the results once it is done}
  std::string Progress();
  std::string Stop();

 private:
  /// The reason why it was not saved; empty if it was.
  std::string SaveFile(const std::string& text);
  std::shared_ptr<const editor::Analysis> Analyse(const std::string& text);
  /// Chooses the benchmark that the text has in place of the shown one. Returns a notice; empty if
  /// it is still there.
  std::string Follow(const editor::Analysis& analysis);
  /// Null if the benchmark has errors; `diagnostics` receives the reason why a scene cannot be
  /// built.
  std::string SceneOf(const editor::Analysis& analysis, nlohmann::json& diagnostics) const;
  std::string ResultScene() const;

  Scenario scenario_;
  editor::Documents documents_;
  std::vector<std::string> names_;  ///< of the benchmarks of the last text that was followed
  const std::filesystem::path program_;
  std::string run_benchmark_;
  std::optional<process::Descriptor> log_;
  pid_t run_ = 0;  ///< 0: none
  int run_status_ = 0;
};

/// Serves until `stop_fd` becomes readable; while a text is compiled, SIGINT, SIGTERM and SIGHUP
/// end the process with status 0. `begin` is called with the address. Throws std::system_error if
/// no port is available.
void Serve(Editor& editor, int stop_fd, const std::function<void(const std::string&)>& begin);

}  // namespace cdb::serve
