/* The interface of collision detectors in C, for languages that have no C++: arrays and counts. It
 * offers what cdb/detector.h does, and needs C99 and its standard library alone.
 *
 * Units: metres. Arrays of the scene are valid during the call. Arrays that a detector returns are
 * its own, and must stay until its next call; cdb copies them. Errors: a function returns null, or
 * a text that says what failed, which fails its run; so does an invalid result (an unknown body, a
 * normal that is not a unit vector, NaN) or another floating-point environment at the end of a
 * call. Threads: called by one thread. A detector may start as many as cdb_options permits. */
#ifndef CDB_DETECTOR_C_H_
#define CDB_DETECTOR_C_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cdb_vec3 {
  double x, y, z;
} cdb_vec3;

/* An axis-aligned box. Sides may be infinite (a plane's box is); lower <= upper on each axis. */
typedef struct cdb_box {
  cdb_vec3 lower, upper;
} cdb_box;

/* The pose of a body: its centre of mass, and its axes in world coordinates, orthonormal. */
typedef struct cdb_pose {
  cdb_vec3 position;
  cdb_vec3 x, y, z;
} cdb_pose;

/* Two bodies may collide if the group of each is in the mask of the other, and not both are fixed.
 * A kinematic body is fixed, and yet moves as its scenario says. */
typedef struct cdb_filter {
  uint32_t group, mask;
  uint8_t is_fixed, is_kinematic;
} cdb_filter;

enum {
  CDB_ELLIPSOID, /* a ball if the half extents are equal */
  CDB_BOX,
  CDB_CYLINDER, /* along y, with an elliptic base */
  CDB_CONE,     /* along y, apex up, with an elliptic base */
  CDB_CAPSULE,  /* along y: a cylinder between the halves of an ellipsoid as wide as x and z */
  CDB_HULL,     /* one convex piece */
  CDB_COMPOUND, /* the union of convex pieces */
  CDB_PLANE,    /* the half space behind a plane through the body's position */
  CDB_SURFACE,  /* triangles without an inside; their body is fixed */
  /* |y|^(2/e1) + (|x|^(2/e2) + |z|^(2/e2))^(e2/e1) <= 1 in half extents, with 0 < e <= 2 */
  CDB_SUPERELLIPSOID
};

/* A convex piece, in the body's frame. */
typedef struct cdb_hull {
  const cdb_vec3* vertices;
  size_t vertex_count;
  const uint32_t (*faces)[3]; /* three vertices each, counter-clockwise from outside */
  size_t face_count;
} cdb_hull;

/* A body's geometry, in its own frame, with the centre of mass as origin. */
typedef struct cdb_shape {
  uint32_t kind;
  cdb_vec3 half;   /* half extents along the body's axes; of a plane, infinite */
  cdb_vec3 centre; /* the middle of those extents; not the origin for cones and hulls */
  cdb_vec3 normal; /* of a plane: out of the half space, unit */
  /* One for CDB_HULL, several for CDB_COMPOUND; of CDB_SURFACE its triangles, each with one face,
   * but none of a height field; none otherwise. */
  const cdb_hull* hulls;
  size_t hull_count;
  double e1, e2; /* exponents of a superellipsoid */
} cdb_shape;

/* The bodies of the scene in the current cycle: `size` values each. A body is known by its index;
 * objects come first, in the scene's order, then walls. Between two calls only boxes, poses and
 * is_asleep change. */
typedef struct cdb_scene {
  size_t size;
  const cdb_box* boxes;
  const cdb_filter* filters;
  const cdb_pose* poses;    /* null unless the detector asks for them (CDB_PHASES_...) */
  const cdb_shape* shapes;  /* null if only boxes are known, as in a trace */
  const uint8_t* is_asleep; /* 1: it is where it was in the last call; null if not known */
} cdb_scene;

static inline int cdb_may_collide(const cdb_scene* scene, uint32_t a, uint32_t b) {
  const cdb_filter *first = &scene->filters[a], *second = &scene->filters[b];
  return !(first->is_fixed && second->is_fixed) && (first->group & second->mask) != 0 &&
         (second->group & first->mask) != 0;
}

/* Touching boxes overlap. */
static inline int cdb_overlap(const cdb_box* a, const cdb_box* b) {
  return a->lower.x <= b->upper.x && b->lower.x <= a->upper.x && a->lower.y <= b->upper.y &&
         b->lower.y <= a->upper.y && a->lower.z <= b->upper.z && b->lower.z <= a->upper.z;
}

typedef struct cdb_pair {
  uint32_t a, b;
} cdb_pair;

typedef struct cdb_pairs {
  const cdb_pair* data;
  size_t size;
} cdb_pairs;

/* A point at which two bodies touch or overlap. */
typedef struct cdb_contact {
  uint32_t a, b;       /* a < b, as in the pair that was asked for */
  cdb_vec3 on_a, on_b; /* on the surface of each, in the world */
  cdb_vec3 normal;     /* unit, from b to a */
  double distance;     /* negative if they overlap */
} cdb_contact;

typedef struct cdb_contacts {
  const cdb_contact* data;
  size_t size;
} cdb_contacts;

typedef struct cdb_options {
  unsigned threads; /* the number it may use, including the caller's */
} cdb_options;

/* `self` is what make returned. Functions that are not needed are null: a broad phase needs
 * find_pairs, a narrow phase find_contacts. */
typedef struct cdb_detector_functions {
  /* Null: self is null. Otherwise null is a failure. */
  void* (*make)(const cdb_options* options);
  void (*destroy)(void* self);
  /* Called once, before the first cycle and outside all timing of cycles. */
  const char* (*prepare)(void* self, const cdb_scene* scene);
  /* Every cycle: each pair whose boxes overlap, once, in any order and with either body first.
   * Pairs that cdb_may_collide refuses are dropped. `pairs` is empty on entry. */
  const char* (*find_pairs)(void* self, const cdb_scene* scene, cdb_pairs* pairs);
  /* Instead of it, for detectors that know the changes: the pairs that overlap and did not in the
   * last call, and those that did and do not. `came` may have more pairs that overlap, and `went`
   * more that do not. */
  const char* (*find_changes)(void* self, const cdb_scene* scene, cdb_pairs* came, cdb_pairs* went);
  /* Whether the narrow phase handles the pair, 0 or 1. Called once for each new pair; Bullet
   * handles the others. Null: it handles all but those with a CDB_SURFACE. */
  int (*handles)(void* self, const cdb_scene* scene, uint32_t a, uint32_t b);
  /* Every cycle: the contacts of `pairs`, which are all pairs that it handles. A pair may have none
   * or several. Bodies that are a small distance apart should have a contact too (Bullet keeps
   * those up to 0.02 m apart). */
  const char* (*find_contacts)(void* self, const cdb_scene* scene, const cdb_pair* pairs,
                               size_t pair_count, cdb_contacts* contacts);
} cdb_detector_functions;

/* A shared library of detectors. */

/* Incremented with every change of the declarations in this file. */
#define CDB_C_ABI 2

typedef struct cdb_detector {
  const char* name;    /* as written in a .cdb file: letters, digits, _ */
  const char* phases;  /* CDB_PHASES_... */
  int needs_poses;     /* of a broad phase alone; narrow phases get them */
  uint64_t max_bodies; /* walls included; 0 means no limit */
  const cdb_detector_functions* functions;
} cdb_detector;

/* `abi` must never move. */
typedef struct cdb_c_plugin {
  uint32_t abi;
  size_t count;
  const cdb_detector* detectors;
} cdb_c_plugin;

#define CDB_PHASES_BROAD "broad"
#define CDB_PHASES_NARROW "narrow"
#define CDB_PHASES_BOTH "broad narrow"

#define CDB_TEXT_OF_(x) #x
#define CDB_TEXT_OF(x) CDB_TEXT_OF_(x)
#if defined(__GNUC__)
#define CDB_EXPORT_ __attribute__((visibility("default")))
#define CDB_MANIFEST_ __attribute__((visibility("default"), used, section(".cdb_detectors")))
#endif

/* What another language writes out: a text in the section .cdb_detectors of the library, which is
 * read without running it, with a line for the interface and one for each detector, `NAME <tab>
 * PHASES <tab> MAX_BODIES`, and a function cdb_c_plugin_table that returns the table. */
#define CDB_MANIFEST_HEAD CDB_TEXT_OF(CDB_C_ABI) "\tC\n"
#define CDB_DETECTOR_LINE_(name, phases, needs_poses, most, functions) \
#name "\t" CDB_PHASES_##phases "\t" #most "\n"
#define CDB_DETECTOR_ROW_(name, phases, needs_poses, most, functions) \
  {#name, CDB_PHASES_##phases, needs_poses, most, &functions},

/* Exports the rows of a list, once in a shared library:
 *
 *   #define ROWS(X) X(sorted_along_x, BROAD, 0, 0, functions)
 *   CDB_C_DETECTORS(ROWS)
 *
 * A row: its name, BROAD, NARROW or BOTH, whether it needs poses, its limit, its functions. */
#define CDB_C_DETECTORS(rows)                                                              \
  CDB_MANIFEST_ const char cdb_manifest[] = CDB_MANIFEST_HEAD rows(CDB_DETECTOR_LINE_);    \
  CDB_EXPORT_ const cdb_c_plugin* cdb_c_plugin_table(void) {                               \
    static const cdb_detector detectors[] = {rows(CDB_DETECTOR_ROW_)};                     \
    static const cdb_c_plugin plugin = {CDB_C_ABI, sizeof detectors / sizeof detectors[0], \
                                        detectors};                                        \
    return &plugin;                                                                        \
  }

#ifdef __cplusplus
}
#endif

#endif /* CDB_DETECTOR_C_H_ */
