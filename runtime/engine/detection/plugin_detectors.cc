#include "runtime/engine/detection/plugin_detectors.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "compiler/plan/input_file.h"
#include "library/detectors/plugin.h"
#include "library/scene_error.h"
#include "runtime/protocol/recording.h"

namespace cdb::detection {
namespace {

using library::SceneError;
using schema::PluginDetector;

/// Of the one run that this process carries out; null where nobody listens.
std::atomic<std::uint32_t>* noted_in = nullptr;

/// Notes the call, and restores the floating-point environment at its end.
class WatchedCall {
 public:
  WatchedCall(protocol::PluginCall call, std::size_t index) {
    Set(protocol::PluginCallCode(call, index));
  }
  ~WatchedCall() { Set(0); }
  WatchedCall(const WatchedCall&) = delete;
  WatchedCall& operator=(const WatchedCall&) = delete;

  /// Throws std::runtime_error where the call changed what all later arithmetic depends on.
  void Check() const {
    if (floating_point_.IsChanged())
      throw std::runtime_error(
          "it changes the floating-point environment (rounding or denormals), and with it the "
          "physics; restore it before returning");
  }

 private:
  const detectors::KeepsFloatingPoint floating_point_;

  static void Set(std::uint32_t code) {
    if (noted_in != nullptr) noted_in->store(code, std::memory_order_relaxed);
  }
};

std::string HashOf(const PluginDetector& plugin) {
  std::string why;
  const auto bytes = plan::ReadInputFile(plugin.path, why);
  if (!bytes)
    throw SceneError(fmt::format("detector `{}`: cannot read its library '{}': {}", plugin.name,
                                 plugin.path, why));
  return plan::Sha256Hex(*bytes);
}

class WatchedDetector final : public Detector {
 public:
  WatchedDetector(std::size_t index, std::unique_ptr<Detector> detector)
      : index_(index), detector_(std::move(detector)) {}
  ~WatchedDetector() override {
    const WatchedCall call(protocol::PluginCall::kDestroy, index_);
    detector_.reset();
  }

  void Prepare(const Scene& scene) override {
    const WatchedCall call(protocol::PluginCall::kPrepare, index_);
    detector_->Prepare(scene);
    call.Check();
  }
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    const WatchedCall call(protocol::PluginCall::kFindPairs, index_);
    detector_->FindPairs(scene, pairs);
    call.Check();
  }
  bool FindChanges(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went) override {
    const WatchedCall call(protocol::PluginCall::kFindPairs, index_);
    const bool are_changes = detector_->FindChanges(scene, came, went);
    call.Check();
    return are_changes;
  }
  bool Handles(const Scene& scene, Id a, Id b) const override {
    const WatchedCall call(protocol::PluginCall::kHandles, index_);
    const bool handles = detector_->Handles(scene, a, b);
    call.Check();
    return handles;
  }
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    const WatchedCall call(protocol::PluginCall::kFindContacts, index_);
    detector_->FindContacts(scene, pairs, contacts);
    call.Check();
  }

 private:
  const std::size_t index_;
  std::unique_ptr<Detector> detector_;
};

}  // namespace

NotesPluginCalls::NotesPluginCalls(std::atomic<std::uint32_t>& place) { noted_in = &place; }
NotesPluginCalls::~NotesPluginCalls() { noted_in = nullptr; }

detectors::LoadedDetector LoadPluginDetector(const plan::Scene& scene, std::size_t index) {
  const PluginDetector& plugin = scene.plugins[index];
  if (HashOf(plugin) != plugin.sha256)
    throw SceneError(
        fmt::format("detector `{}`: '{}' differs from the file that the plan was made with; plan "
                    "again, or restore the old file",
                    plugin.name, plugin.path));
  const WatchedCall call(protocol::PluginCall::kLoad, index);
  try {
    const auto all = detectors::LoadPlugin(plugin.path);
    if (const auto* loaded = detectors::FindDetector(all, plugin.name)) return *loaded;
  } catch (const detectors::PluginError& error) {
    throw SceneError(fmt::format("detector `{}`: {}", plugin.name, error.what()));
  }
  throw SceneError(fmt::format("'{}' has no detector `{}`", plugin.path, plugin.name));
}

std::unique_ptr<Detector> MakePluginDetector(std::size_t index,
                                             const detectors::LoadedDetector& loaded,
                                             const Options& options) {
  std::unique_ptr<Detector> detector;
  {
    const WatchedCall call(protocol::PluginCall::kMake, index);
    detector = loaded.make(options);
    call.Check();
  }
  if (detector == nullptr) return nullptr;
  return std::make_unique<WatchedDetector>(index, std::move(detector));
}

}  // namespace cdb::detection
