/* The C interface of the library, for C and for languages that call C.
 *
 * Functions return FL_OK or an error; fl_error_message() then says, for the calling thread, what was given, what was
 * expected and what to do. A tree does not change, so any number of threads may query it at the same time.
 *
 *     const float line[6] = {-1, -1, -1, 1, 1, 1};
 *     const fl_ray ray = {.origin = {0, 0, -5}, .direction = {0, 0, 1}, .t_max = INFINITY};
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

/* What a call returns: `FL_OK`, or the reason why it failed. */
typedef enum fl_status {
  FL_OK = 0,          /* The call has done what it should. */
  FL_INPUT_ERROR = 1, /* An argument cannot be used. */
  FL_FILE_ERROR = 2,  /* A file cannot be read or written. */
  FL_NO_MEMORY = 3,   /* There is not enough memory. */
  FL_CANCELLED = 4,   /* The progress callback returned 0. */
  FL_OTHER_ERROR = 5  /* Anything else, such as an error of the operating system. */
} fl_status;

/* The named trees. All but `FL_BEST` and `FL_BEAMS` are those of the thesis. */
typedef enum fl_method {
  FL_BEST = 0,   /* The tree for the fastest queries. */
  FL_BVH_CL = 1, /* A BVH over whole lines. */
  FL_BVH_SS = 2, /* A BVH over lines that are cut by a grid of planes. */
  FL_BVH_D2 = 3, /* As `FL_BVH_SS`, but where a leaf looks best, it looks two levels ahead. */
  FL_KD_CL = 4,  /* A KD tree over a grid of planes. */
  FL_KD_D2 = 5,  /* As `FL_KD_CL`, but where a leaf looks best, it looks two levels ahead. */
  FL_BEAMS = 6   /* The least time of a build and one query, over dense long lines such as photon beams. */
} fl_method;

/* The place on the ray that t of a hit means, and which rays hit. */
typedef enum fl_at {
  FL_CLOSEST = 0, /* Where the ray comes closest to the line. */
  FL_SURFACE = 1, /* Where the ray enters the surface around the line. */
  FL_ENTRY = 2    /* The same, and only rays that enter hit: those that start inside, or on the surface, do not. */
} fl_at;

/* What the distance to a line is to. It makes no difference for lines without a radius. */
typedef enum fl_to {
  FL_TO_SURFACE = 0, /* To the surface. It is negative inside, where the deepest line is the nearest one. */
  FL_TO_AXIS = 1     /* To the axis. */
} fl_to;

/* What the hits of a ray are ranked by. */
typedef enum fl_rank {
  FL_BY_T = 0,       /* Their place on the ray. */
  FL_BY_DISTANCE = 1 /* The distance of the line from the ray, and then t. */
} fl_rank;

/* A callback for long calls. It gets the fraction that is done, on the thread that called. If it returns 0, the call
   fails with `FL_CANCELLED`. */
typedef int (*fl_progress)(double done, void* user_data);

/* Options of `fl_build`. All members that are 0 are at their defaults. */
typedef struct fl_options {
  fl_method method;     /* Which tree to build. */
  int has_effort;       /* Whether `effort` counts. */
  float effort;         /* From 0, the fastest build, to 1, the best tree. Only `FL_BEST` has it. */
  unsigned n_threads;   /* The number of threads; 0 means one for each core. The tree does not depend on it. */
  fl_progress progress; /* It is called while the tree is built. It may be NULL. */
  void* user_data;      /* It is passed to the callback. */
  const int64_t*
      strands; /* The strand (hair, polyline) of each line, -1 for none. They are copied. NULL: no strands. */
} fl_options;

/* The points `origin` + t * `direction` with `t_min` <= t <= `t_max`. Set the members that you do not need to 0. */
typedef struct fl_ray {
  float origin[3];               /* Where t is 0. */
  float direction[3];            /* It need not have length 1, but it must not be zero. */
  float t_min, t_max;            /* The ends of the ray. `t_min` must be below infinity. */
  float spread;                  /* By how much the radius of the query grows for each unit of length along the ray. */
  const int64_t* ignore;         /* The lines that queries leave out, as if they were not there; -1 names none. */
  size_t n_ignore;               /* Their number. */
  const int64_t* ignore_strands; /* The strands that queries leave out. */
  size_t n_ignore_strands;       /* Their number. */
} fl_ray;

/* A hit, or a miss. */
typedef struct fl_hit {
  float t;        /* The place on the ray, in units of the length of its direction. A miss has infinity. */
  float u;        /* The place on the line: 0 at its start, 1 at its end. */
  float distance; /* The distance of the ray from the line, at the closest approach. */
  float t_out;    /* Where the ray leaves the surface; infinite with `FL_CLOSEST`. */
  int64_t prim;   /* The index of the line, or -1 for a miss. */
} fl_hit;

/* A batch of rays. Set the members that you do not need to 0. */
typedef struct fl_rays {
  size_t n;                /* The number of rays. */
  const float* origins;    /* The origins, 3 floats each. */
  const float* directions; /* The directions, 3 floats each. */
  const float* t_min;      /* One number for each ray. NULL means 0. */
  const float* t_max;      /* One number for each ray. NULL means infinity. */
  const float* radii;      /* One number for each ray. If it is NULL, `radius` is for all rays. */
  float radius;            /* The radius for all rays. */
  unsigned n_threads;      /* The number of threads; 0 means one for each core. Short batches take one. */
  const float* spreads;    /* By how much each ray's radius grows along it. If it is NULL, `spread` is for all rays. */
  float spread;            /* The spread for all rays. */
  const int64_t* ignore;   /* The lines that all rays leave out; -1 names none. */
  size_t n_ignore;         /* Their number. */
  const int64_t* ignore_strands; /* The strands that all rays leave out. */
  size_t n_ignore_strands;       /* Their number. */
} fl_rays;

/* A point, in double and in the caller's coordinates: queries subtract the offset of the tree from it. */
typedef struct fl_point {
  double position[3];            /* Its coordinates. */
  const int64_t* ignore;         /* The lines that queries leave out, as if they were not there; -1 names none. */
  size_t n_ignore;               /* Their number. */
  const int64_t* ignore_strands; /* The strands that queries leave out. */
  size_t n_ignore_strands;       /* Their number. */
} fl_point;

/* A line near a point. */
typedef struct fl_near_line {
  float distance; /* The distance of the line from the point, to its axis or to its surface. */
  float u;        /* The place on the line that is nearest: 0 at its start, 1 at its end. */
  int64_t prim;   /* The index of the line. */
} fl_near_line;

/* A batch of points. Set the members that you do not need to 0. */
typedef struct fl_points {
  size_t n;                /* The number of points. */
  const double* positions; /* The coordinates, 3 doubles each. */
  const float*
      radii; /* The radius, or the largest distance, of each point. NULL: the argument of the call is for all. */
  fl_to to;  /* What distances are to. */
  unsigned n_threads;            /* The number of threads; 0 means one for each core. Short batches take one. */
  const int64_t* ignore;         /* The lines that queries leave out for all points; -1 names none. */
  size_t n_ignore;               /* Their number. */
  const int64_t* ignore_strands; /* The strands that queries leave out for all points. */
  size_t n_ignore_strands;       /* Their number. */
} fl_points;

/* Which pairs `fl_find_pairs` finds. All members that are 0 are at their defaults. */
typedef struct fl_pair_options {
  fl_to to;                /* What distances are between. Surfaces count if the lines of either tree have a radius. */
  int has_skip_neighbours; /* Whether `skip_neighbours` counts; without it, 1 does. */
  size_t skip_neighbours;  /* Pairs of one strand are left out if their positions along it differ by at most this. */
  int skip_strand;         /* Whether all pairs of one strand are left out. It is for one tree. */
  unsigned n_threads;      /* The number of threads; 0 means one for each core. */
  fl_progress progress;    /* It is called during the query. It may be NULL. */
  void* user_data;         /* It is passed to the callback. */
} fl_pair_options;

/* Properties of a tree. */
typedef struct fl_facts {
  size_t n_prims;        /* The number of lines. */
  size_t n_nodes;        /* The number of nodes. */
  size_t n_refs;         /* The number of references: lines, or pieces of them, in all leaves. */
  size_t n_bytes;        /* The memory of the tree, its lines and its layout. */
  double cost;           /* The expected cost of a ray (thesis 3.3), with the constants of the method. */
  float low[3], high[3]; /* The corners of the box around all lines, without their radii. */
  char method[16];       /* The name of the method in Python, such as "bvh-cl", or "custom". */
  char simd[16];         /* The instruction set of the queries. */
} fl_facts;

/* Where a hit is. All members of a miss are NaN. */
typedef struct fl_place {
  double point[3];   /* The point of the ray at t. */
  double normal[3];  /* The unit normal of the surface there, outwards; NaN with `FL_CLOSEST`. */
  double tangent[3]; /* The unit vector from the start to the end of the line. NaN if its length is zero. */
  double outside[3]; /* The point, moved along the normal: a ray that starts here does not hit the surface again. */
} fl_place;

/* A tree over lines. It does not change, so any number of threads may query it at the same time. */
typedef struct fl_tree fl_tree;
/* The hits of many rays. */
typedef struct fl_hit_lists fl_hit_lists;
/* The lines within a radius of many points. */
typedef struct fl_near_lists fl_near_lists;
/* Pairs of lines. */
typedef struct fl_pairs fl_pairs;

/* Returns the version of the library, such as "0.1.0". */
FASTLINES_API const char* fl_version(void);
/* Returns what was wrong with the last call of this thread that failed. The text is valid until the next call. */
FASTLINES_API const char* fl_error_message(void);
/* Returns the instruction set of trees to come: "avx512", "avx2", "sse42", "neon" or "portable". */
FASTLINES_API const char* fl_simd(void);
/* Chooses the instruction set of trees that are built or loaded from now on. NULL chooses the widest that this
   processor has, which is the default. */
FASTLINES_API fl_status fl_set_simd(const char* name);

/* Builds a tree over n segments of 6 floats each, which are both ends. They are copied. `options` may be NULL.
   A call that fails sets `tree` to NULL. */
FASTLINES_API fl_status fl_build(const float* segments, size_t n, const fl_options* options, fl_tree** tree);
/* Builds a tree over n round cones of 8 floats each, which are both ends and the radius at each. */
FASTLINES_API fl_status fl_build_round_cones(const float* cones, size_t n, const fl_options* options, fl_tree** tree);
/* Reads a tree over lines that this library or Python has written. */
FASTLINES_API fl_status fl_load(const char* path, fl_tree** tree);
/* Makes the same tree over as many segments, or round cones, that have moved, with new boxes. It is faster to make than
   a new tree, and slower to query the farther lines have moved. `n_threads` 0 means one for each core. */
FASTLINES_API fl_status fl_refit(const fl_tree* tree, const float* segments, size_t n, unsigned n_threads,
                                 fl_tree** refitted);
/* Does the same for a tree over round cones. */
FASTLINES_API fl_status fl_refit_round_cones(const fl_tree* tree, const float* cones, size_t n, unsigned n_threads,
                                             fl_tree** refitted);
/* Writes the tree and its lines to a file (`.flt`), which Python reads too. */
FASTLINES_API fl_status fl_save(const fl_tree* tree, const char* path);
/* Gets the tree's size, cost and box. */
FASTLINES_API fl_status fl_get_facts(const fl_tree* tree, fl_facts* facts);
/* The lines of a tree. The arrays are valid until the tree is freed. */
typedef struct fl_line_arrays {
  size_t n;               /* The number of lines. */
  int has_radii;          /* Whether lines have radii of their own: 1 for round cones, 0 for segments. */
  const float* lines;     /* 8 floats for each round cone, 6 for each segment, as they were given. */
  const int64_t* strands; /* The strand of each line, -1 for none. It is NULL if no line has one. */
  double offset[3];       /* The offset of lines that Python has read with one. All coordinates here are less it. */
} fl_line_arrays;
/* Returns the lines of a tree that was built or loaded. */
FASTLINES_API fl_line_arrays fl_get_lines(const fl_tree* tree);
/* Finds where a hit is. The ray and the radius are those of the query. */
FASTLINES_API fl_status fl_get_place(const fl_tree* tree, const fl_ray* ray, float radius, const fl_hit* hit,
                                     fl_place* place);
/* Frees a tree. It may be NULL. */
FASTLINES_API void fl_free_tree(fl_tree* tree);

/* Finds the hit with the least t, or a miss. Of hits at the same t, the line with the lower index comes first. */
FASTLINES_API fl_status fl_first_hit(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, fl_hit* hit);
/* Sets `found` to 1 if the ray hits any line, and to 0 otherwise. */
FASTLINES_API fl_status fl_any_hit(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, int* found);
/* Counts the lines that the ray hits. */
FASTLINES_API fl_status fl_count_hits(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, size_t* n);
/* Writes one hit for each line that the ray hits, in the order of t, but no more than `room`. Sets `n` to the number of
   all hits, which may be more. */
FASTLINES_API fl_status fl_all_hits(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, fl_hit* hits,
                                    size_t room, size_t* n);
/* Writes the first k of all hits by their rank, and sets `n` to their number. `hits` has room for k. */
FASTLINES_API fl_status fl_next_hits(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, size_t k,
                                     fl_rank rank, fl_hit* hits, size_t* n);

/* Finds the hit of each ray that has the least t, or a miss. Each array has room for a number for each ray, or is
   NULL if it is not wanted. */
FASTLINES_API fl_status fl_first_hits(const fl_tree* tree, const fl_rays* rays, fl_at at, float* t, int64_t* prim,
                                      float* u, float* distance, float* t_out);
/* Writes 1 for each ray that hits any line, and 0 for the others. */
FASTLINES_API fl_status fl_any_hits(const fl_tree* tree, const fl_rays* rays, fl_at at, uint8_t* found);
/* Counts the lines that each ray hits. */
FASTLINES_API fl_status fl_counts(const fl_tree* tree, const fl_rays* rays, fl_at at, int64_t* n);

/* Lists the first k of all hits of each ray by their rank. `SIZE_MAX` lists all hits, which takes `FL_BY_T`. */
FASTLINES_API fl_status fl_list_hits(const fl_tree* tree, const fl_rays* rays, size_t k, fl_at at, fl_rank rank,
                                     fl_hit_lists** lists);
/* The arrays of lists of hits. They are valid until the lists are freed. */
typedef struct fl_list_arrays {
  size_t n_rays;          /* The number of rays. */
  size_t n_hits;          /* The number of hits of all rays. */
  const int64_t* offsets; /* The hits of ray i are those from `offsets[i]` up to `offsets[i + 1]`. */
  const float* t;         /* The places on the rays. */
  const int64_t* prim;    /* The indices of the lines. */
  const float* u;         /* The places on the lines. */
  const float* distance;  /* The distances of the rays from the lines. */
  const float* t_out;     /* Where rays leave the surfaces. It is NULL with `FL_CLOSEST`. */
} fl_list_arrays;
/* Returns the arrays of lists. */
FASTLINES_API fl_list_arrays fl_get_lists(const fl_hit_lists* lists);
/* Frees lists. They may be NULL. */
FASTLINES_API void fl_free_lists(fl_hit_lists* lists);

/* Writes the k nearest lines of a point that are at most `max_distance` away, by their distance and then by their
   index. Sets `n` to their number, which is less than k if there are fewer. `lines` has room for k. */
FASTLINES_API fl_status fl_nearest(const fl_tree* tree, const fl_point* point, float max_distance, fl_to to, size_t k,
                                   fl_near_line* lines, size_t* n);
/* Writes the lines within a radius of a point in the same order, but no more than `room`. Sets `n` to the number of all
   of them, which may be more. */
FASTLINES_API fl_status fl_within(const fl_tree* tree, const fl_point* point, float radius, fl_to to,
                                  fl_near_line* lines, size_t room, size_t* n);
/* Counts the lines within a radius of a point. */
FASTLINES_API fl_status fl_count_within(const fl_tree* tree, const fl_point* point, float radius, fl_to to, size_t* n);

/* Finds the point of a line near a point that is nearest to it, in the caller's coordinates: that of the surface, or of
   the axis. `place` has room for its 3 coordinates. */
FASTLINES_API fl_status fl_get_near_place(const fl_tree* tree, const fl_point* point, const fl_near_line* line,
                                          fl_to to, double* place);

/* Finds the k nearest lines of each point that are at most `max_distance` away. Each array has room for k numbers for
   each point, or is NULL if it is not wanted. Where there are fewer lines, the rest are infinity, -1 and 0. */
FASTLINES_API fl_status fl_nearest_batch(const fl_tree* tree, const fl_points* points, float max_distance, size_t k,
                                         float* distance, int64_t* prim, float* u);
/* Counts the lines within a radius of each point. */
FASTLINES_API fl_status fl_count_within_batch(const fl_tree* tree, const fl_points* points, float radius, int64_t* n);
/* Lists the lines within a radius of each point. */
FASTLINES_API fl_status fl_list_within(const fl_tree* tree, const fl_points* points, float radius,
                                       fl_near_lists** lists);
/* The arrays of lists of lines. They are valid until the lists are freed. */
typedef struct fl_near_arrays {
  size_t n_points;        /* The number of points. */
  size_t n_lines;         /* The number of lines of all points. */
  const int64_t* offsets; /* The lines of point i are those from `offsets[i]` up to `offsets[i + 1]`. */
  const float* distance;  /* The distances of the lines. */
  const int64_t* prim;    /* The indices of the lines. */
  const float* u;         /* The places on the lines. */
} fl_near_arrays;
/* Returns the arrays of lists. */
FASTLINES_API fl_near_arrays fl_get_near_lists(const fl_near_lists* lists);
/* Frees lists. They may be NULL. */
FASTLINES_API void fl_free_near_lists(fl_near_lists* lists);

/* Finds all pairs of a line of the first tree and a line of the second one whose distance is at most the radius. If
   `second` is NULL, they are the pairs of one tree. `options` may be NULL. */
FASTLINES_API fl_status fl_find_pairs(const fl_tree* first, const fl_tree* second, float radius,
                                      const fl_pair_options* options, fl_pairs** pairs);
/* The arrays of pairs, sorted by i and then by j. They are valid until the pairs are freed. */
typedef struct fl_pair_arrays {
  size_t n;              /* The number of pairs. */
  const int64_t* i;      /* The indices of the first lines. In pairs of one tree, i < j. */
  const int64_t* j;      /* The indices of the second lines. */
  const float* s;        /* The places on the first lines where they are nearest. */
  const float* t;        /* The places on the second lines. */
  const float* distance; /* How far these places are from each other; less both radii there with `FL_TO_SURFACE`. */
} fl_pair_arrays;
/* Returns the arrays of pairs. */
FASTLINES_API fl_pair_arrays fl_get_pairs(const fl_pairs* pairs);
/* Frees pairs. They may be NULL. */
FASTLINES_API void fl_free_pairs(fl_pairs* pairs);

#ifdef __cplusplus
}
#endif

#include "gather.h"

#endif
