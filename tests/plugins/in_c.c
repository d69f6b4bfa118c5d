/* Detectors in C: brute force, changes only, contacts of balls and boxes by their shapes, and one
 * for each kind of failure. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "library/detectors/detector_c.h"

struct state {
  cdb_pair* pairs[2]; /* of this call and the last */
  size_t counts[2];
  cdb_pair *came, *went;
  cdb_contact* contacts;
  size_t size;
};

static void* make(const cdb_options* options) {
  return options->threads == 1 ? calloc(1, sizeof(struct state)) : NULL;
}

static void destroy(void* self) {
  struct state* state = self;
  free(state->pairs[0]);
  free(state->pairs[1]);
  free(state->came);
  free(state->went);
  free(state->contacts);
  free(state);
}

static const char* prepare(void* self, const cdb_scene* scene) {
  struct state* state = self;
  const size_t most = scene->size * scene->size;
  state->size = scene->size;
  state->pairs[0] = malloc(most * sizeof(cdb_pair));
  state->pairs[1] = malloc(most * sizeof(cdb_pair));
  state->came = malloc(most * sizeof(cdb_pair));
  state->went = malloc(most * sizeof(cdb_pair));
  state->contacts = malloc(most * sizeof(cdb_contact));
  return NULL;
}

static size_t every_pair(const cdb_scene* scene, cdb_pair* pairs) {
  size_t count = 0;
  for (uint32_t a = 0; a < scene->size; ++a)
    for (uint32_t b = a + 1; b < scene->size; ++b)
      if (cdb_may_collide(scene, a, b) && cdb_overlap(&scene->boxes[a], &scene->boxes[b]))
        pairs[count++] = (cdb_pair){a, b};
  return count;
}

static const char* find_pairs(void* self, const cdb_scene* scene, cdb_pairs* pairs) {
  struct state* state = self;
  pairs->data = state->pairs[0];
  pairs->size = every_pair(scene, state->pairs[0]);
  return NULL;
}

static size_t missing_in(const cdb_pair* some, size_t count, const cdb_pair* others,
                         size_t other_count, cdb_pair* missing) {
  size_t found = 0, at = 0; /* both are sorted */
  for (size_t i = 0; i < count; ++i) {
    while (at < other_count &&
           (others[at].a < some[i].a || (others[at].a == some[i].a && others[at].b < some[i].b)))
      ++at;
    if (at == other_count || others[at].a != some[i].a || others[at].b != some[i].b)
      missing[found++] = some[i];
  }
  return found;
}

static const char* find_changes(void* self, const cdb_scene* scene, cdb_pairs* came,
                                cdb_pairs* went) {
  struct state* state = self;
  cdb_pair* const last = state->pairs[0];
  const size_t last_count = state->counts[0];
  state->pairs[0] = state->pairs[1];
  state->pairs[1] = last;
  state->counts[1] = last_count;
  state->counts[0] = every_pair(scene, state->pairs[0]);
  came->data = state->came;
  came->size = missing_in(state->pairs[0], state->counts[0], last, last_count, state->came);
  went->data = state->went;
  went->size = missing_in(last, last_count, state->pairs[0], state->counts[0], state->went);
  return NULL;
}

static cdb_vec3 along(cdb_vec3 a, double s, cdb_vec3 b) {
  return (cdb_vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static int is_ball(const cdb_shape* shape) {
  return shape->kind == CDB_ELLIPSOID && shape->half.x == shape->half.y &&
         shape->half.y == shape->half.z;
}

static int handles(void* self, const cdb_scene* scene, uint32_t a, uint32_t b) {
  (void)self;
  return is_ball(&scene->shapes[a]) && is_ball(&scene->shapes[b]);
}

static const char* find_contacts(void* self, const cdb_scene* scene, const cdb_pair* pairs,
                                 size_t pair_count, cdb_contacts* contacts) {
  struct state* state = self;
  size_t count = 0;
  for (size_t i = 0; i < pair_count; ++i) {
    const uint32_t a = pairs[i].a, b = pairs[i].b;
    const double radius_a = scene->shapes[a].half.x, radius_b = scene->shapes[b].half.x;
    const cdb_vec3 at_a = scene->poses[a].position, at_b = scene->poses[b].position;
    const cdb_vec3 apart = along(at_a, -1, at_b);
    const double distance = sqrt(apart.x * apart.x + apart.y * apart.y + apart.z * apart.z);
    if (!(distance > 0) || distance > radius_a + radius_b + 0.02) continue;
    const cdb_vec3 normal = {apart.x / distance, apart.y / distance, apart.z / distance};
    state->contacts[count++] = (cdb_contact){a,
                                             b,
                                             along(at_a, -radius_a, normal),
                                             along(at_b, radius_b, normal),
                                             normal,
                                             distance - radius_a - radius_b};
  }
  contacts->data = state->contacts;
  contacts->size = count;
  return NULL;
}

static const char* check_shapes(void* self, const cdb_scene* scene) {
  for (size_t i = 0; scene->shapes != NULL && i < scene->size; ++i) {
    const cdb_shape* shape = &scene->shapes[i];
    double farthest = 0;
    for (size_t hull = 0; hull < shape->hull_count; ++hull)
      for (size_t j = 0; j < shape->hulls[hull].vertex_count; ++j)
        farthest = fmax(farthest, fabs(shape->hulls[hull].vertices[j].y - shape->centre.y));
    for (size_t hull = 0; hull < shape->hull_count; ++hull)
      for (size_t j = 0; j < shape->hulls[hull].face_count; ++j)
        for (int corner = 0; corner < 3; ++corner)
          if (shape->hulls[hull].faces[j][corner] >= shape->hulls[hull].vertex_count)
            return "a face has no such vertex";
    if ((shape->kind == CDB_HULL) != (shape->hull_count == 1)) return "a hull has one piece";
    if (shape->hull_count > 0 && fabs(farthest - shape->half.y) > 1e-6 * shape->half.y)
      return "the vertices do not reach the half extents";
  }
  return prepare(self, scene);
}

static const char* fails(void* self, const cdb_scene* scene, cdb_pairs* pairs) {
  (void)self, (void)scene, (void)pairs;
  return "out of luck in C";
}
static const char* has_no_array(void* self, const cdb_scene* scene, cdb_pairs* pairs) {
  (void)self, (void)scene;
  pairs->size = 3;
  return NULL;
}
static void* makes_nothing(const cdb_options* options) {
  (void)options;
  return NULL;
}

static const cdb_detector_functions all = {make, destroy, prepare, find_pairs, NULL, NULL, NULL};
static const cdb_detector_functions changes = {make,         destroy, prepare, find_pairs,
                                               find_changes, NULL,    NULL};
static const cdb_detector_functions balls = {make, destroy, prepare,      find_pairs,
                                             NULL, handles, find_contacts};
static const cdb_detector_functions pieces = {make, destroy, check_shapes, find_pairs,
                                              NULL, NULL,    NULL};
static const cdb_detector_functions failing = {NULL, NULL, NULL, fails, NULL, NULL, NULL};
static const cdb_detector_functions arrayless = {NULL, NULL, NULL, has_no_array, NULL, NULL, NULL};
static const cdb_detector_functions nothing = {makes_nothing, NULL, NULL, fails, NULL, NULL, NULL};

#define ROWS(X)                          \
  X(c_all, BROAD, 0, 0, all)             \
  X(c_changes, BROAD, 0, 0, changes)     \
  X(c_balls, BOTH, 0, 0, balls)          \
  X(c_pieces, BROAD, 1, 0, pieces)       \
  X(c_few, BROAD, 0, 10, all)            \
  X(c_fails, BROAD, 0, 0, failing)       \
  X(c_arrayless, BROAD, 0, 0, arrayless) \
  X(c_nothing, BROAD, 0, 0, nothing)
#if defined(OTHER_C_ABI)
__attribute__((used, section(".cdb_detectors"))) const char cdb_manifest[] =
    "1000000\tC\nc_all\tbroad\t0\n";
#elif defined(ROW_WITHOUT_FUNCTION)
static const cdb_detector_functions none = {0};
#define ROW(X) X(c_none, BROAD, 0, 0, none)
CDB_C_DETECTORS(ROW)
#else
CDB_C_DETECTORS(ROWS)
#endif
