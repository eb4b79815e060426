/* The example of the thesis (§5.4.3) in C: one segment and one ray.
 *
 *     gcc -c $(python -m fastlines --cflags) examples/first_hit.c -o first_hit.o
 *     g++ first_hit.o $(python -m fastlines --libs) -o first_hit && ./first_hit
 */
#include <fastlines/fastlines.h>
#include <math.h>
#include <stdio.h>

int main(void) {
  const float line[6] = {-1, -1, -1, 1, 1, 1};
  const fl_ray ray = {.origin = {0, 0, -5}, .direction = {0, 0, 1}, .t_max = INFINITY};
  const fl_method methods[2] = {FL_BVH_D2, FL_KD_D2};
  const char* names[2] = {"BVH", "KD tree"};
  fl_options options = {0};
  for (int i = 0; i < 2; ++i) {
    fl_tree* tree = NULL;
    fl_hit hit;
    options.method = methods[i];
    if (fl_build(line, 1, &options, &tree) != FL_OK || fl_first_hit(tree, &ray, 0.5f, FL_CLOSEST, &hit) != FL_OK) {
      fprintf(stderr, "%s\n", fl_error_message());
      fl_free_tree(tree);
      return 1;
    }
    if (hit.prim >= 0) printf("%s: segment %d at t = %g\n", names[i], (int)hit.prim, hit.t);
    fl_free_tree(tree);
  }
  return 0;
}
