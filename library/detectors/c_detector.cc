#include "library/detectors/c_detector.h"

#include <cstddef>
#include <stdexcept>
#include <utility>

namespace cdb::detectors {
namespace {

// What the interfaces share is passed as it is.
template <typename To, typename From>
const To* As(const From* values) {
  static_assert(sizeof(To) == sizeof(From) && alignof(To) == alignof(From));
  return reinterpret_cast<const To*>(values);
}
static_assert(offsetof(cdb_filter, is_kinematic) == offsetof(Filter, is_kinematic) &&
              offsetof(cdb_filter, is_fixed) == offsetof(Filter, is_fixed) && sizeof(bool) == 1);
static_assert(offsetof(cdb_contact, distance) == offsetof(Contact, distance) &&
              offsetof(cdb_contact, normal) == offsetof(Contact, normal));
static_assert(static_cast<int>(ShapeKind::kSuperellipsoid) == CDB_SUPERELLIPSOID &&
              static_cast<int>(ShapeKind::kSurface) == CDB_SURFACE &&
              static_cast<int>(ShapeKind::kCapsule) == CDB_CAPSULE);

cdb_vec3 ToC(const Vec3& v) { return {v.x, v.y, v.z}; }

class CDetector final : public Detector {
 public:
  CDetector(const cdb_detector_functions& functions, void* self)
      : functions_(functions), self_(self) {}
  ~CDetector() override {
    if (functions_.destroy != nullptr) functions_.destroy(self_);
  }

  void Prepare(const Scene& scene) override {
    ConvertShapes(scene);
    if (functions_.prepare == nullptr) return;
    const cdb_scene given = ToC(scene);
    Check(functions_.prepare(self_, &given));
  }

  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    const cdb_scene given = ToC(scene);
    cdb_pairs found{};
    Check(functions_.find_pairs(self_, &given, &found));
    Append(found, pairs);
  }

  bool FindChanges(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went) override {
    if (functions_.find_changes == nullptr) return Detector::FindChanges(scene, came, went);
    const cdb_scene given = ToC(scene);
    cdb_pairs new_pairs{}, old_pairs{};
    Check(functions_.find_changes(self_, &given, &new_pairs, &old_pairs));
    Append(new_pairs, came);
    Append(old_pairs, went);
    return true;
  }

  bool Handles(const Scene& scene, Id a, Id b) const override {
    if (functions_.handles == nullptr)
      return scene.shapes[a].kind != ShapeKind::kSurface &&
             scene.shapes[b].kind != ShapeKind::kSurface;
    const cdb_scene given = ToC(scene);
    return functions_.handles(self_, &given, a, b) != 0;
  }

  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    const cdb_scene given = ToC(scene);
    cdb_contacts found{};
    Check(
        functions_.find_contacts(self_, &given, As<cdb_pair>(pairs.data()), pairs.size(), &found));
    Append(found, contacts);
  }

 private:
  static void Check(const char* failure) {
    if (failure != nullptr) throw std::runtime_error(failure);
  }

  template <typename List, typename Value>
  static void Append(const List& found, std::vector<Value>& values) {
    if (found.size == 0) return;
    if (found.data == nullptr) throw std::runtime_error("it returns a size without an array");
    if (found.size > values.max_size()) throw std::runtime_error("it returns too large a size");
    const Value* data = As<Value>(found.data);
    values.insert(values.end(), data, data + found.size);
  }

  cdb_scene ToC(const Scene& scene) const {
    const auto data = [](const auto& values) { return values.empty() ? nullptr : values.data(); };
    return {.size = scene.size,
            .boxes = As<cdb_box>(data(scene.boxes)),
            .filters = As<cdb_filter>(data(scene.filters)),
            .poses = As<cdb_pose>(data(scene.poses)),
            .shapes = scene.shapes.empty() ? nullptr : shapes_.data(),
            .is_asleep = data(scene.is_asleep)};
  }

  /// They do not change.
  void ConvertShapes(const Scene& scene) {
    std::size_t count = 0;
    for (const Shape& shape : scene.shapes) count += shape.hulls.size();
    hulls_.clear();
    hulls_.reserve(count);
    shapes_.clear();
    for (const Shape& shape : scene.shapes) {
      const cdb_hull* first = hulls_.data() + hulls_.size();
      for (const Hull& hull : shape.hulls)
        hulls_.push_back({As<cdb_vec3>(hull.vertices.data()), hull.vertices.size(),
                          As<std::uint32_t[3]>(hull.faces.data()), hull.faces.size()});
      shapes_.push_back({static_cast<std::uint32_t>(shape.kind), detectors::ToC(shape.half),
                         detectors::ToC(shape.centre), detectors::ToC(shape.normal),
                         shape.hulls.empty() ? nullptr : first, shape.hulls.size(), shape.e1,
                         shape.e2});
    }
  }

  const cdb_detector_functions& functions_;
  void* const self_;
  std::vector<cdb_hull> hulls_;
  std::vector<cdb_shape> shapes_;  ///< by body
};

}  // namespace

std::unique_ptr<Detector> MakeCDetector(const cdb_detector& row, const Options& options) {
  void* self = nullptr;
  if (row.functions->make != nullptr) {
    const cdb_options given{options.threads};
    self = row.functions->make(&given);
    if (self == nullptr) return nullptr;
  }
  return std::make_unique<CDetector>(*row.functions, self);
}

}  // namespace cdb::detectors
