/* A broad phase for cdb in C: bodies sorted along x, and each compared with those that begin before
 * it ends. The order of the last cycle is nearly that of this one.
 *
 *   cc -O3 -shared -fPIC -I PREFIX/include my_detector.c -o my_detector.so
 *   cdb run compare.cdb
 */
#include <cdb/detector_c.h>
#include <stdlib.h>

struct sorted {
  uint32_t* order;
  cdb_pair* pairs;
  size_t size, count, capacity;
};

static void* make(const cdb_options* options) {
  (void)options;
  return calloc(1, sizeof(struct sorted));
}

static void destroy(void* self) {
  struct sorted* sorted = self;
  free(sorted->order);
  free(sorted->pairs);
  free(sorted);
}

static const char* prepare(void* self, const cdb_scene* scene) {
  struct sorted* sorted = self;
  sorted->size = scene->size;
  sorted->order = malloc(scene->size * sizeof *sorted->order);
  if (sorted->order == NULL) return "no memory";
  for (uint32_t i = 0; i < scene->size; ++i) sorted->order[i] = i;
  return NULL;
}

static int add(struct sorted* sorted, uint32_t a, uint32_t b) {
  if (sorted->count == sorted->capacity) {
    const size_t capacity = 2 * sorted->capacity + 64;
    cdb_pair* pairs = realloc(sorted->pairs, capacity * sizeof *pairs);
    if (pairs == NULL) return 0;
    sorted->pairs = pairs;
    sorted->capacity = capacity;
  }
  sorted->pairs[sorted->count++] = (cdb_pair){a, b};
  return 1;
}

static const char* find_pairs(void* self, const cdb_scene* scene, cdb_pairs* pairs) {
  struct sorted* sorted = self;
  uint32_t* order = sorted->order;
  /* Insertion sort: few bodies change places in a cycle. */
  for (size_t i = 1; i < sorted->size; ++i) {
    const uint32_t body = order[i];
    size_t at = i;
    for (; at > 0 && scene->boxes[order[at - 1]].lower.x > scene->boxes[body].lower.x; --at)
      order[at] = order[at - 1];
    order[at] = body;
  }
  sorted->count = 0;
  for (size_t i = 0; i < sorted->size; ++i) {
    const cdb_box* one = &scene->boxes[order[i]];
    for (size_t j = i + 1; j < sorted->size; ++j) {
      const cdb_box* other = &scene->boxes[order[j]];
      if (other->lower.x > one->upper.x) break;
      if (cdb_overlap(one, other) && cdb_may_collide(scene, order[i], order[j]) &&
          !add(sorted, order[i], order[j]))
        return "no memory";
    }
  }
  pairs->data = sorted->pairs;
  pairs->size = sorted->count;
  return NULL;
}

static const cdb_detector_functions functions = {
    .make = make, .destroy = destroy, .prepare = prepare, .find_pairs = find_pairs};

#define ROWS(X) X(sorted_in_c, BROAD, 0, 0, functions)
CDB_C_DETECTORS(ROWS)
