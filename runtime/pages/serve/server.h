// The editor of a scenario in a browser: its text, its parameters, its scene, and a run of it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/sweep/process/process.h"

namespace cdb::serve {

/// The result of compiling a text.
struct Checked {
  std::string diagnostics;        ///< for people; includes warnings
  std::vector<plan::Plan> plans;  ///< empty if there are errors
};

struct Scenario {
  std::filesystem::path file;
  std::string benchmark;
  std::string text;  ///< as stored on the disk
  std::function<Checked(const std::string& text)> check;
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

  /// The document of the page: the scene, and under `editor` the answer of Check.
  std::string Document();
  /// {text, diagnostics, parameters, scene: null if there are errors}
  std::string Check(const std::string& text);
  /// The answer of Check for the text with one value changed.
  std::string Set(const std::string& text, const std::string& group, const std::string& name,
                  const std::string& value);
  /// {message}: refuses if another program has changed the file.
  std::string Save(const std::string& text);
  /// {message}: saves, and starts `cdb run` into BENCHMARK.view.h5, which it replaces.
  std::string Run(const std::string& text);
  /// {is_running, log, scene: of the results once it is done}
  std::string Progress();
  std::string Stop();

 private:
  std::string SaveFile(const std::string& text);  ///< the reason why it was not saved; empty if it
                                                  ///< was
  std::string SceneOf(const std::vector<plan::Plan>& plans, std::string& trouble) const;
  std::string ResultScene() const;

  Scenario scenario_;
  const std::filesystem::path program_;
  std::optional<process::Descriptor> log_;
  pid_t run_ = 0;  ///< 0: none
  int run_status_ = 0;
};

/// Serves until `stop_fd` becomes readable; while a text is compiled, SIGINT, SIGTERM and SIGHUP
/// end the process with status 0. `begin` is called with the address. Throws std::system_error if
/// no port is available.
void Serve(Editor& editor, int stop_fd, const std::function<void(const std::string&)>& begin);

}  // namespace cdb::serve
