// The interface of collision detectors: what one is given, what it has to say, and how a shared
// library offers one to cdb. It knows no physics engine and needs the standard library alone.
//
// A detector learns the bodies at the start and is called once a cycle. It lists pairs (broad
// phase) and, where it has a narrow phase of its own, contacts; what it lacks, Bullet supplies.
//
// Units: metres. Numbers are double whatever the precision of the run: a float is held exactly.
// Errors: whatever a detector throws, and whatever nonsense it returns (a body that is not there, a
// normal that is not unit, a number that is none), fails its run with a message and no other.
// Threads: one thread calls. A detector may start threads of its own, as many as Options says.
// Source: Woulfe & Manzke 2009, section 3.2 (several algorithms behind one interface).
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

namespace cdb {

/// A body: its place in the scene, from 0. Objects come first, in the scene's order, then walls.
using Id = std::uint32_t;

struct Vec3 {
  double x, y, z;
};

/// An axis-aligned box. Sides may be infinite (a plane's box is); lower <= upper on each axis.
struct Box {
  Vec3 lower, upper;
};

/// Where a body is: its centre of mass, and its own axes in the world, unit and at right angles.
struct Pose {
  Vec3 position;
  Vec3 x, y, z;
};

enum class ShapeKind : std::uint32_t {
  kEllipsoid,  ///< a ball where the half extents are equal
  kBox,
  kCylinder,  ///< along y, on an ellipse
  kCone,      ///< along y, the tip up, on an ellipse
  kCapsule,   ///< along y: a cylinder between the halves of an ellipsoid as wide as x and z
  kHull,      ///< one convex piece
  kCompound,  ///< the union of convex pieces
  kPlane,     ///< the half space behind a plane through the body's position
};

/// A face of a hull: three of its vertices, counter-clockwise from outside.
struct Face {
  std::uint32_t a, b, c;
};

/// A convex piece, in the body's own frame.
struct Hull {
  std::span<const Vec3> vertices;
  std::span<const Face> faces;
};

/// A body's geometry, in its own frame: the centre of mass is the origin.
struct Shape {
  ShapeKind kind;
  Vec3 half;                    ///< half extents along the body's axes; of a plane, infinite
  Vec3 centre;                  ///< the middle of those extents; not the origin for cones and hulls
  Vec3 normal;                  ///< of a plane: out of the half space, unit
  std::span<const Hull> hulls;  ///< one for kHull, several for kCompound, else none
};

/// What a body may meet: two may where each one's group is in the other's mask, and not both are
/// fixed.
struct Filter {
  std::uint32_t group = 1, mask = ~0u;
  bool is_fixed = false;
};

/// The bodies as they stand in this cycle, each span of `size` values. Valid during the call;
/// between two calls only boxes, poses and is_asleep change.
struct Scene {
  std::size_t size = 0;
  std::span<const Box> boxes;
  std::span<const Filter> filters;
  /// Only for detectors that say so (kNeedsPoses, kNarrow); else empty.
  std::span<const Pose> poses;
  /// Empty where boxes are all that is known, as in a trace.
  std::span<const Shape> shapes;
  std::span<const std::uint8_t> is_asleep;

  bool MayCollide(Id a, Id b) const {
    const Filter &first = filters[a], &second = filters[b];
    return !(first.is_fixed && second.is_fixed) && (first.group & second.mask) != 0 &&
           (second.group & first.mask) != 0;
  }
};

/// Two bodies, a < b.
struct Pair {
  Id a, b;
  bool operator==(const Pair&) const = default;
  auto operator<=>(const Pair&) const = default;
};

/// One point where two bodies touch or overlap.
struct Contact {
  Id a, b;          ///< a < b
  Vec3 on_a, on_b;  ///< on the surface of each, in the world
  Vec3 normal;      ///< unit, from b to a
  double distance;  ///< negative where they overlap
};

/// Boxes that touch overlap.
inline bool Overlap(const Box& a, const Box& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
         b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

struct Options {
  unsigned threads = 1;  ///< may work on so many, the caller's included
};

/// A detector. Broad phases override FindPairs, narrow phases Handles and FindContacts; one may do
/// both.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Called once, before the first cycle and outside all timing of cycles.
  virtual void Prepare(const Scene&) {}

  /// Every cycle: lists each pair whose boxes overlap, a < b, once, in any order. `pairs` comes
  /// empty. Pairs that Scene::MayCollide refuses may be listed; they are dropped.
  virtual void FindPairs(const Scene&, std::vector<Pair>& /*pairs*/) {}

  /// This narrow phase takes the pair. Asked once for a pair, when it is new; what it refuses goes
  /// to Bullet's.
  virtual bool Handles(const Scene&, Id /*a*/, Id /*b*/) const { return true; }

  /// Every cycle: appends the contacts of the pairs that it handles, `pairs` being all of those. A
  /// pair may have none, or several. Bodies that come within a small distance of each other are
  /// worth a contact too (Bullet keeps those up to 0.02 m apart); one alone is enough, Bullet
  /// gathers up to four over the cycles.
  virtual void FindContacts(const Scene&, std::span<const Pair> /*pairs*/,
                            std::vector<Contact>& /*contacts*/) {}
};

// A shared library with detectors in it.

/// Raised with every change of what this file declares.
inline constexpr std::uint32_t kDetectorAbi = 1;

enum class Phases : std::uint32_t {
  kBroad = 1,       ///< FindPairs
  kNarrow = 2,      ///< FindContacts
  kNeedsPoses = 4,  ///< wants Scene::poses though it has no narrow phase
};
using enum Phases;
constexpr Phases operator|(Phases a, Phases b) {
  return static_cast<Phases>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
/// `phases` has at least one of those in `asked`.
constexpr bool HasAny(Phases phases, Phases asked) {
  return (static_cast<std::uint32_t>(phases) & static_cast<std::uint32_t>(asked)) != 0;
}

/// One detector of a shared library.
struct DetectorEntry {
  const char* name;  ///< as a .cdb file writes it: letters, digits, _
  const char* doc;   ///< one line
  Phases phases;
  std::uint64_t max_bodies;                   ///< walls included; 0 means no limit
  Detector* (*make)(const Options& options);  ///< with new; the caller deletes it
};

/// What the library's one function returns. `abi` and `build` stay where they are for ever.
struct Plugin {
  std::uint32_t abi;
  const char* build;  ///< DetectorBuild() of the compiler that made it
  std::size_t count;
  const DetectorEntry* entries;
};

#define CDB_TEXT_(x) #x
#define CDB_TEXT(x) CDB_TEXT_(x)
/// What has to be equal for two builds to understand each other's classes.
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

/// Offers the entries of an array: CDB_DETECTORS(kEntries), once in a shared library.
#define CDB_DETECTORS(array)                                                                      \
  extern "C" __attribute__((visibility("default"))) const cdb::Plugin* cdb_plugin() {             \
    static const cdb::Plugin plugin = {cdb::kDetectorAbi, cdb::DetectorBuild(), std::size(array), \
                                       std::data(array)};                                         \
    return &plugin;                                                                               \
  }

}  // namespace cdb
