// A scenario that is edited in a browser: its text, its parameters, its scene, and a run of it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/process/process.h"

namespace cdb::serve {

/// What the compiler says of a text.
struct Checked {
  std::string diagnostics;        ///< as a person reads them; also warnings
  std::vector<plan::Plan> plans;  ///< empty where there are errors
};

struct Scenario {
  std::filesystem::path file;
  std::string benchmark;
  std::string text;  ///< as it is on the disk
  std::function<Checked(const std::string& text)> check;
};

/// Answers are JSON documents. Errors of a text are part of an answer; those of the disk are thrown
/// as store::StoreError or std::system_error. Not for several threads.
class Editor {
 public:
  /// `program`: cdb itself, which runs are started with.
  Editor(Scenario scenario, std::filesystem::path program);
  ~Editor();  ///< stops the run
  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  /// The document of the page: the scene, and under `editor` the answer of Check.
  std::string Document();
  /// {text, diagnostics, parameters, scene: null where there are errors}
  std::string Check(const std::string& text);
  /// Check of the text with one value changed.
  std::string Set(const std::string& text, const std::string& group, const std::string& name,
                  const std::string& value);
  /// {message}: refused where another program has changed the file.
  std::string Save(const std::string& text);
  /// {message}: saves, and starts `cdb run` into BENCHMARK.view.h5, which it replaces.
  std::string Run(const std::string& text);
  /// {is_running, log, scene: of the results once it is done}
  std::string Progress();
  std::string Stop();

 private:
  std::string SaveFile(const std::string& text);  ///< why it was not saved; empty where it was
  std::string SceneOf(const std::vector<plan::Plan>& plans, std::string& trouble) const;
  std::string ResultScene() const;

  Scenario scenario_;
  const std::filesystem::path program_;
  std::optional<process::Descriptor> log_;
  pid_t run_ = 0;  ///< 0: none
  int run_status_ = 0;
};

}  // namespace cdb::serve
