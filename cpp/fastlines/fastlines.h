/* The C interface of the library, for C and for languages that call C.
 *
 * Functions return FL_OK or an error; fl_error_message() then says, for the calling thread, what was given, what was
 * expected and what to do. A tree does not change, so any number of threads may query it at the same time.
 *
 *     const float line[6] = {-1, -1, -1, 1, 1, 1};
 *     const fl_ray ray = {{0, 0, -5}, {0, 0, 1}, 0.0f, INFINITY};
 *     fl_tree* tree = NULL;
 *     fl_hit hit;
 *     if (fl_build(line, 1, NULL, &tree) == FL_OK && fl_first_hit(tree, &ray, 0.5f, FL_CLOSEST, &hit) == FL_OK)
 *       printf("line %lld\n", (long long)hit.prim);
 *     fl_free_tree(tree);
 */
#ifndef FASTLINES_H
#define FASTLINES_H

#include <stddef.h>
#include <stdint.h>

#include "api/export.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fl_status {
  FL_OK = 0,
  FL_INPUT_ERROR = 1, /* an argument cannot be used */
  FL_FILE_ERROR = 2,  /* a file cannot be read or written */
  FL_NO_MEMORY = 3,
  FL_CANCELLED = 4, /* the progress callback returned 0 */
  FL_OTHER_ERROR = 5
} fl_status;

typedef enum fl_method {
  FL_BEST = 0, /* made for fast queries; the others are those of the thesis */
  FL_BVH_CL = 1,
  FL_BVH_SS = 2,
  FL_BVH_D2 = 3,
  FL_KD_CL = 4,
  FL_KD_D2 = 5
} fl_method;

/* Where t is taken: where the ray comes closest to the line, or where it enters the surface around it. */
typedef enum fl_at { FL_CLOSEST = 0, FL_SURFACE = 1 } fl_at;

/* Called now and then, from the thread that called, with the fraction that is done. Returns 0 to cancel. */
typedef int (*fl_progress)(double done, void* user_data);

/* How to build. fl_default_options() sets all members. */
typedef struct fl_options {
  fl_method method;
  float effort;       /* of FL_BEST: 0, the fastest build, to 1, the best tree; a negative number for the default */
  unsigned n_threads; /* 0: one for each core */
  fl_progress progress;
  void* user_data;
} fl_options;

/* The points origin + t * direction, t_min <= t <= t_max. */
typedef struct fl_ray {
  float origin[3], direction[3];
  float t_min, t_max;
} fl_ray;

/* A hit; a miss has prim = -1 and t = infinity. */
typedef struct fl_hit {
  float t;        /* along the ray, in units of its direction */
  float u;        /* where on the line: 0 at its start, 1 at its end */
  float distance; /* from the ray to the line, at the closest approach */
  float t_out;    /* where the ray leaves the surface; infinity with FL_CLOSEST */
  int64_t prim;   /* the index of the line */
} fl_hit;

/* A batch of n rays: 3 floats each. The others hold one number for each ray, or are NULL: then t_min is 0 and t_max
   infinity. `radii` may be NULL if `radius` is for all rays. */
typedef struct fl_rays {
  size_t n;
  const float *origins, *directions;
  const float *t_min, *t_max;
  const float* radii;
  float radius;
  unsigned n_threads; /* 0: one for each core */
} fl_rays;

typedef struct fl_facts {
  size_t n_prims, n_nodes, n_refs, n_bytes;
  double cost;
  float low[3], high[3]; /* the corners of the box around all lines, without their radii */
} fl_facts;

typedef struct fl_tree fl_tree;
typedef struct fl_hit_lists fl_hit_lists;

FASTLINES_API const char* fl_version(void);
/* What was wrong with the last call of this thread that failed. Valid until its next call. */
FASTLINES_API const char* fl_error_message(void);
/* The instruction set of trees that are made from now on; NULL chooses the widest that this processor has. */
FASTLINES_API const char* fl_simd(void);
FASTLINES_API fl_status fl_set_simd(const char* name);

/* Build a tree over n segments of 6 floats each, which are copied. `options` may be NULL. */
FASTLINES_API void fl_default_options(fl_options* options);
FASTLINES_API fl_status fl_build(const float* segments, size_t n, const fl_options* options, fl_tree** tree);
/* The same over round cones of 8 floats: both ends, and the radius at each. */
FASTLINES_API fl_status fl_build_round_cones(const float* cones, size_t n, const fl_options* options, fl_tree** tree);
FASTLINES_API fl_status fl_load(const char* path, fl_tree** tree);
FASTLINES_API fl_status fl_save(const fl_tree* tree, const char* path);
FASTLINES_API fl_status fl_get_facts(const fl_tree* tree, fl_facts* facts);
FASTLINES_API void fl_free_tree(fl_tree* tree); /* NULL is allowed */

/* One ray, on the calling thread. */
FASTLINES_API fl_status fl_first_hit(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, fl_hit* hit);
FASTLINES_API fl_status fl_any_hit(const fl_tree* tree, const fl_ray* ray, float radius, int* found);
FASTLINES_API fl_status fl_count_hits(const fl_tree* tree, const fl_ray* ray, float radius, size_t* n);
/* Write up to `room` of all hits, in the order of t, and how many there are. */
FASTLINES_API fl_status fl_all_hits(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, fl_hit* hits,
                                    size_t room, size_t* n);

/* Batches. Each array has room for one number, or one byte, for each ray. `t_out` may be NULL; with it, t is where rays
   enter the surfaces, else where they come closest. */
FASTLINES_API fl_status fl_first_hits(const fl_tree* tree, const fl_rays* rays, float* t, int64_t* prim, float* u,
                                      float* distance, float* t_out);
FASTLINES_API fl_status fl_any_hits(const fl_tree* tree, const fl_rays* rays, uint8_t* found);
FASTLINES_API fl_status fl_counts(const fl_tree* tree, const fl_rays* rays, int64_t* n);

/* All hits of each ray, or its first k; SIZE_MAX for all. */
FASTLINES_API fl_status fl_list_hits(const fl_tree* tree, const fl_rays* rays, size_t k, fl_at at,
                                     fl_hit_lists** lists);
/* The hits of ray i are those from offsets[i] up to offsets[i + 1]. The arrays are valid until the lists are freed;
   t_out is NULL with FL_CLOSEST. */
typedef struct fl_list_arrays {
  size_t n_rays, n_hits;
  const int64_t* offsets;
  const float* t;
  const int64_t* prim;
  const float *u, *distance, *t_out;
} fl_list_arrays;
FASTLINES_API fl_list_arrays fl_get_lists(const fl_hit_lists* lists);
FASTLINES_API void fl_free_lists(fl_hit_lists* lists); /* NULL is allowed */

#ifdef __cplusplus
}
#endif

#endif
