/* The C interface of sums over all hits of rays. `fastlines.h` includes it. */
#ifndef FASTLINES_GATHER_H
#define FASTLINES_GATHER_H

#include "fastlines.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The kernel K that spreads a hit over the reach R of its ray: the radius of the query and of the line together. */
typedef enum fl_blur {
  FL_BOX_BLUR = 0,          /* 1 / (2R). */
  FL_EPANECHNIKOV_BLUR = 1, /* 3 / (4R) * (1 - (distance / R)^2). */
  FL_NO_BLUR = 2            /* No kernel: K / sin(angle) is 1. */
} fl_blur;

/* What a hit adds to the sum of its ray, with the angle between ray and line:
 * `value * K / sin(angle) * exp(-sigma * t * |d|) * exp(-line_sigma * u * length) * p`.
 * All members that are 0 are at their defaults. */
typedef struct fl_gather_options {
  fl_blur blur;               /* The kernel K. */
  size_t n_channels;          /* The number of sums of each ray, up to 8; 0 means 1. */
  const float* values;        /* What each line adds: `n_channels` numbers for each line. NULL means 1. */
  float sigma[8];             /* The extinction of each channel, per unit of length along the ray. */
  float line_sigma[8];        /* The extinction of each channel, per unit of length along the line. */
  const float* optical_depth; /* In place of `sigma`, optical depths of each ray, linear in between. NULL: none. */
  size_t n_depths;            /* How many depths a ray has, at equal steps from t_min to t_max; 2 or more. */
  int has_depth_channels;     /* Whether each depth has `n_channels` numbers, or one for all. */
  int has_phase;              /* Whether `phase` counts; without it, p is 1. */
  float phase;                /* g of the Henyey-Greenstein phase function p, from -1 to 1. */
  int with_ends;              /* Whether hits count whose t is an end of the ray, or that are at an end of a line. */
  fl_progress progress;       /* It is called during the query. It may be NULL. */
  void* user_data;            /* It is passed to the callback. */
} fl_gather_options;

/* Sums over all hits of each ray, without listing them. `sum` has room for `n_channels` numbers for each ray. So has
   `squares`, for the sums of squares, and `count` for the number of hits that have added something; both may be NULL.
   `options` may be NULL. The sums are the same for every tree and number of threads, bit for bit. */
FASTLINES_API fl_status fl_gather(const fl_tree* tree, const fl_rays* rays, const fl_gather_options* options,
                                  double* sum, double* squares, int64_t* count);

#ifdef __cplusplus
}
#endif

#endif
