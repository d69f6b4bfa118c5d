// The interface of collision detectors: their input, their output, and how a shared library offers
// them to cdb. It knows no physics engine and needs only the standard library.
//
// A detector gets the bodies at the start and is called once per cycle. It lists pairs (broad
// phase) and may compute contacts (narrow phase). Bullet provides any phase the detector does not.
//
// Units: metres. Numbers are double whatever the precision of the run; a float is held exactly.
// Errors: if a detector throws or returns an invalid result (an unknown body, a normal that is not
// a unit vector, NaN) or leaves another floating-point environment, its run fails with a message;
// other runs are not affected. Threads: called by one thread. A detector may start as many threads
// as Options permits. Source: Woulfe & Manzke 2009, section 3.2 (several algorithms behind one
// interface).
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

namespace cdb {

/// A body: its index in the scene, from 0. Objects come first, in the scene's order, then walls.
using Id = std::uint32_t;

struct Vec3 {
  double x, y, z;
};

/// An axis-aligned box. Sides may be infinite (a plane's box is); lower <= upper on each axis,
/// except that all sides are NaN while a body is not in the world, where objects come and go: such
/// a box overlaps none, not even itself. Only detectors of cdb and Bullet get scenes of that kind.
struct Box {
  Vec3 lower, upper;
};

/// The pose of a body: its centre of mass, and its axes in world coordinates, orthonormal.
struct Pose {
  Vec3 position;
  Vec3 x, y, z;
};

enum class ShapeKind : std::uint32_t {
  kEllipsoid,  ///< a ball if the half extents are equal
  kBox,
  kCylinder,  ///< along y, with an elliptic base
  kCone,      ///< along y, apex up, with an elliptic base
  kCapsule,   ///< along y: a cylinder between the halves of an ellipsoid as wide as x and z
  kHull,      ///< one convex piece
  kCompound,  ///< the union of convex pieces
  kPlane,     ///< the half space behind a plane through the body's position
  kSurface,   ///< triangles without an inside; their body is fixed
  /// |y|^(2/e1) + (|x|^(2/e2) + |z|^(2/e2))^(e2/e1) <= 1 in half extents, with 0 < e <= 2.
  kSuperellipsoid,
};

/// A face of a hull: three of its vertices, counter-clockwise from outside.
struct Face {
  std::uint32_t a, b, c;
};

/// A convex piece, in the body's frame.
struct Hull {
  std::span<const Vec3> vertices;
  std::span<const Face> faces;
};

/// A body's geometry, in its own frame, with the centre of mass as origin.
struct Shape {
  ShapeKind kind;
  Vec3 half;    ///< half extents along the body's axes; of a plane, infinite
  Vec3 centre;  ///< the middle of those extents; not the origin for cones and hulls
  Vec3 normal;  ///< of a plane: out of the half space, unit
  /// One for kHull, several for kCompound; of kSurface its triangles, each with one face, but
  /// none of a height field; none otherwise.
  std::span<const Hull> hulls;
  double e1 = 1, e2 = 1;  ///< exponents of a superellipsoid
};

/// Collision filter: two bodies may collide if the group of each is in the mask of the other, and
/// not both are fixed. Nothing pushes a fixed body; a kinematic one is fixed too, and yet moves as
/// its scenario says.
struct Filter {
  std::uint32_t group = 1, mask = ~0u;
  bool is_fixed = false, is_kinematic = false;
};

/// The bodies in the current cycle; each span has `size` values. Valid during the call. Between two
/// calls only boxes, poses and is_asleep change.
struct Scene {
  std::size_t size = 0;
  std::span<const Box> boxes;
  std::span<const Filter> filters;
  /// Only for detectors that ask for it (kNeedsPoses, kNarrow); empty otherwise.
  std::span<const Pose> poses;
  /// Empty if only boxes are known, as in a trace.
  std::span<const Shape> shapes;
  /// A body that is asleep and was so in the last call has not moved, and has the same box. Fixed
  /// bodies are asleep, kinematic ones never. Empty if this is not known, as in a trace.
  std::span<const std::uint8_t> is_asleep;

  bool MayCollide(Id a, Id b) const {
    const Filter &first = filters[a], &second = filters[b];
    return !(first.is_fixed && second.is_fixed) && (first.group & second.mask) != 0 &&
           (second.group & first.mask) != 0;
  }
};

/// Two bodies, a < b, except that a broad phase may list them either way.
struct Pair {
  Id a, b;
  bool operator==(const Pair&) const = default;
  auto operator<=>(const Pair&) const = default;
};

/// A point at which two bodies touch or overlap.
struct Contact {
  Id a, b;          ///< a < b, as in the pair that was asked for
  Vec3 on_a, on_b;  ///< on the surface of each, in the world
  Vec3 normal;      ///< unit, from b to a
  double distance;  ///< negative if they overlap
};

/// Touching boxes overlap.
inline bool Overlap(const Box& a, const Box& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
         b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

struct Options {
  unsigned threads = 1;  ///< the number it may use, including the caller's
};

/// A detector. Broad phases override FindPairs, narrow phases Handles and FindContacts; one may do
/// both.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Called once, before the first cycle and outside all timing of cycles.
  virtual void Prepare(const Scene&) {}

  /// Every cycle: lists each pair whose boxes overlap, once, in any order and with either body
  /// first. `pairs` is empty on entry. Pairs that Scene::MayCollide refuses are dropped.
  virtual void FindPairs(const Scene&, std::vector<Pair>& /*pairs*/) {}

  /// The same for callers that keep the pairs from cycle to cycle, such as Bullet's pair cache; for
  /// detectors that know the changes. Returns false if `came` has all pairs, as by FindPairs, and
  /// true if it has those that overlap and did not in the last call of either function; then `went`
  /// has those that did and do not. `came` may have more pairs that overlap, and `went` more that
  /// do not. Both are empty on entry.
  virtual bool FindChanges(const Scene& scene, std::vector<Pair>& came,
                           std::vector<Pair>& /*went*/) {
    FindPairs(scene, came);
    return false;
  }

  /// Whether this narrow phase handles the pair. Called once for each new pair; Bullet's narrow
  /// phase handles the others; leave a kSurface to it.
  virtual bool Handles(const Scene&, Id /*a*/, Id /*b*/) const { return true; }

  /// Every cycle: appends the contacts of `pairs`, which are all pairs that it handles. A pair may
  /// have none or several. Bodies that are a small distance apart should have a contact too (Bullet
  /// keeps those up to 0.02 m apart). One contact per pair suffices; Bullet accumulates up to four
  /// over several cycles.
  virtual void FindContacts(const Scene&, std::span<const Pair> /*pairs*/,
                            std::vector<Contact>& /*contacts*/) {}
};

// A shared library of detectors.

/// Incremented with every change of the declarations in this file.
inline constexpr std::uint32_t kDetectorAbi = 5;

enum class Phases : std::uint32_t {
  kBroad = 1,       ///< FindPairs
  kNarrow = 2,      ///< FindContacts
  kNeedsPoses = 4,  ///< needs Scene::poses without having a narrow phase
};
using enum Phases;
constexpr Phases operator|(Phases a, Phases b) {
  return static_cast<Phases>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
/// `phases` contains at least one of `asked`.
constexpr bool HasAny(Phases phases, Phases asked) {
  return (static_cast<std::uint32_t>(phases) & static_cast<std::uint32_t>(asked)) != 0;
}

/// One detector of a shared library.
struct DetectorEntry {
  const char* name;  ///< as written in a .cdb file: letters, digits, _
  const char* doc;   ///< one line
  Phases phases;
  std::uint64_t max_bodies;                   ///< walls included; 0 means no limit
  Detector* (*make)(const Options& options);  ///< with new; the caller deletes it
};

/// The result of the library's only function. `abi` and `build` must never move.
struct Plugin {
  std::uint32_t abi;
  const char* build;  ///< DetectorBuild() of the compiler that built it
  std::size_t count;
  const DetectorEntry* entries;
};

#define CDB_TEXT_(x) #x
#define CDB_TEXT(x) CDB_TEXT_(x)
/// Must be equal for two builds to be binary compatible.
constexpr const char* DetectorBuild() {
#if defined(_GLIBCXX_RELEASE)
  return "libstdc++ abi " CDB_TEXT(_GLIBCXX_USE_CXX11_ABI)
#ifdef _GLIBCXX_DEBUG
      " debug"
#endif
      ", pointers of " CDB_TEXT(__SIZEOF_POINTER__) " bytes";
#else
  return "another standard library";
#endif
}

#define CDB_MANIFEST_SECTION ".cdb_detectors"
/// Where a library's list of detectors stands, to be read without loading it.
inline constexpr const char* kManifestSection = CDB_MANIFEST_SECTION;

/// A list of detectors as text: `ABI <tab> BUILD`, and a line `NAME <tab> PHASES <tab> MAX_BODIES`
/// for each. Ends with NUL.
template <std::size_t kSize>
struct Manifest {
  char text[kSize];
};

/// Appends to a text, or counts its bytes where there is no place for it.
class ManifestWriter {
 public:
  constexpr explicit ManifestWriter(char* place) : place_(place) {}
  constexpr void Add(char c) {
    if (place_ != nullptr) place_[size_] = c;
    ++size_;
  }
  constexpr void Add(const char* text) {
    for (; *text != '\0'; ++text) Add(*text);
  }
  constexpr void Add(std::uint64_t number) {
    if (number >= 10) Add(number / 10);
    Add(static_cast<char>('0' + number % 10));
  }
  constexpr std::size_t size() const { return size_; }

 private:
  char* place_;
  std::size_t size_ = 0;
};

/// The bytes of the list, which is written to `place` if that is not null.
constexpr std::size_t WriteManifest(std::span<const DetectorEntry> entries, char* place) {
  ManifestWriter writer(place);
  writer.Add(std::uint64_t{kDetectorAbi});
  writer.Add('\t');
  writer.Add(DetectorBuild());
  writer.Add('\n');
  for (const DetectorEntry& entry : entries) {
    writer.Add(entry.name);
    writer.Add('\t');
    writer.Add(!HasAny(entry.phases, kNarrow) ? "broad"
               : HasAny(entry.phases, kBroad) ? "broad narrow"
                                              : "narrow");
    writer.Add('\t');
    writer.Add(entry.max_bodies);
    writer.Add('\n');
  }
  writer.Add('\0');
  return writer.size();
}

template <std::size_t kSize>
constexpr Manifest<kSize> MakeManifest(std::span<const DetectorEntry> entries) {
  Manifest<kSize> manifest{};
  WriteManifest(entries, manifest.text);
  return manifest;
}

/// Exports the entries of a constexpr array: CDB_DETECTORS(kEntries), once in a shared library.
#define CDB_DETECTORS(array)                                                                      \
  extern "C" __attribute__((visibility("default"))) const cdb::Plugin* cdb_plugin() {             \
    static const cdb::Plugin plugin = {cdb::kDetectorAbi, cdb::DetectorBuild(), std::size(array), \
                                       std::data(array)};                                         \
    return &plugin;                                                                               \
  }                                                                                               \
  extern "C" __attribute__((                                                                      \
      visibility("default"), used,                                                                \
      section(CDB_MANIFEST_SECTION))) constexpr cdb::Manifest<cdb::WriteManifest(array, nullptr)> \
      cdb_manifest = cdb::MakeManifest<cdb::WriteManifest(array, nullptr)>(array);

}  // namespace cdb
