// The C interface: lines near points, and pairs of lines.
#include "c_calls.hpp"

struct fl_near_lists {
  fl::NearLists lists;
};
struct fl_pairs {
  fl::Pairs pairs;
};

using namespace fl::detail;

namespace {

fl::To to_of(fl_to to) {
  if (to != FL_TO_SURFACE && to != FL_TO_AXIS)
    throw fl::InputError("unknown fl_to; expected FL_TO_SURFACE or FL_TO_AXIS");
  return to == FL_TO_AXIS ? fl::To::axis : fl::To::surface;
}

fl::Point point_of(const fl_point& given) {
  fl::Point point(given.position[0], given.position[1], given.position[2]);
  point.ignore = {given.ignore, given.n_ignore};
  point.ignore_strands = {given.ignore_strands, given.n_ignore_strands};
  return point;
}

/// Writes lines to an array that has room for some of them.
void write(const std::vector<fl::NearLine>& from, fl_near_line* to, std::size_t room, std::size_t* n) {
  *n = from.size();
  for (std::size_t i = 0; i < from.size() && i < room; ++i) to[i] = {from[i].distance, from[i].u, from[i].prim};
}

/// A batch of the C interface as one of C++.
struct PointBatch {
  fl::Points points;
  fl::PerPoint radius = 0.0f;
  fl::PointOptions options;

  PointBatch(const fl_points* given, float for_all) {
    require(given, "points");
    if (given->n > 0) require(given->positions, "points->positions");
    points.positions = {reinterpret_cast<const fl::Vec3d*>(given->positions), given->n};
    points.ignore = {given->ignore, given->n_ignore};
    points.ignore_strands = {given->ignore_strands, given->n_ignore_strands};
    radius = given->radii ? fl::PerPoint(std::span<const float>(given->radii, given->n)) : fl::PerPoint(for_all);
    options.to = to_of(given->to);
    options.n_threads = given->n_threads;
  }
};

fl::PairOptions options_of(const fl_pair_options* given) {
  fl::PairOptions options;
  if (!given) return options;
  options.to = to_of(given->to);
  if (given->has_skip_neighbours) options.skip_neighbours = given->skip_neighbours;
  options.skip_strand = given->skip_strand != 0;
  options.n_threads = given->n_threads;
  if (given->progress)
    options.progress = [progress = given->progress, data = given->user_data](double done) {
      return progress(done, data) != 0;
    };
  return options;
}

}  // namespace

fl_status fl_nearest(const fl_tree* tree, const fl_point* point, float max_distance, fl_to to, size_t k,
                     fl_near_line* lines, size_t* n) {
  return guarded([&] {
    require(tree, "tree");
    require(point, "point");
    require(n, "n");
    if (k > 0) require(lines, "lines");
    if (k == 1) {
      const fl::NearLine line = tree->tree.nearest(point_of(*point), max_distance, to_of(to));
      *n = bool(line);
      if (line) *lines = {line.distance, line.u, line.prim};
      return;
    }
    write(tree->tree.k_nearest(point_of(*point), k, max_distance, to_of(to)), lines, k, n);
  });
}

fl_status fl_within(const fl_tree* tree, const fl_point* point, float radius, fl_to to, fl_near_line* lines,
                    size_t room, size_t* n) {
  return guarded([&] {
    require(tree, "tree");
    require(point, "point");
    require(n, "n");
    if (room > 0) require(lines, "lines");
    write(tree->tree.within(point_of(*point), radius, to_of(to)), lines, room, n);
  });
}

fl_status fl_count_within(const fl_tree* tree, const fl_point* point, float radius, fl_to to, size_t* n) {
  return guarded([&] {
    require(tree, "tree");
    require(point, "point");
    require(n, "n");
    *n = tree->tree.count_within(point_of(*point), radius, to_of(to));
  });
}

fl_status fl_get_near_place(const fl_tree* tree, const fl_point* point, const fl_near_line* line, fl_to to,
                            double* place) {
  return guarded([&] {
    require(tree, "tree");
    require(point, "point");
    require(line, "line");
    require(place, "place");
    const auto [x, y, z] = tree->tree.place(point_of(*point), {line->distance, line->prim, line->u}, to_of(to));
    place[0] = x, place[1] = y, place[2] = z;
  });
}

fl_status fl_nearest_batch(const fl_tree* tree, const fl_points* points, float max_distance, size_t k, float* distance,
                           int64_t* prim, float* u) {
  return guarded([&] {
    require(tree, "tree");
    const PointBatch batch(points, max_distance);
    const fl::NearLines lines = tree->tree.k_nearest(batch.points, k, batch.radius, batch.options);
    copy_if(lines.distance, distance);
    copy_if(lines.prim, prim);
    copy_if(lines.u, u);
  });
}

fl_status fl_count_within_batch(const fl_tree* tree, const fl_points* points, float radius, int64_t* n) {
  return guarded([&] {
    require(tree, "tree");
    const PointBatch batch(points, radius);
    if (batch.points.size() > 0) require(n, "n");
    copy_if<std::int64_t>(tree->tree.count_within(batch.points, batch.radius, batch.options), n);
  });
}

fl_status fl_list_within(const fl_tree* tree, const fl_points* points, float radius, fl_near_lists** lists) {
  return guarded([&] {
    require(tree, "tree");
    require(lists, "lists");
    *lists = nullptr;
    const PointBatch batch(points, radius);
    *lists = new fl_near_lists{tree->tree.within(batch.points, batch.radius, batch.options)};
  });
}

fl_near_arrays fl_get_near_lists(const fl_near_lists* lists) {
  if (!lists) return {};
  const auto& [offsets, lines, owner] = lists->lists;
  return {lists->lists.n_points(), lines.size(),      offsets.data(),
          lines.distance.data(),   lines.prim.data(), lines.u.data()};
}

void fl_free_near_lists(fl_near_lists* lists) { delete lists; }

fl_status fl_find_pairs(const fl_tree* first, const fl_tree* second, float radius, const fl_pair_options* options,
                        fl_pairs** pairs) {
  return guarded([&] {
    require(first, "first");
    require(pairs, "pairs");
    *pairs = nullptr;
    const fl::PairOptions given = options_of(options);
    *pairs = new fl_pairs{second ? first->tree.pairs(radius, second->tree, given) : first->tree.pairs(radius, given)};
  });
}

fl_pair_arrays fl_get_pairs(const fl_pairs* pairs) {
  if (!pairs) return {};
  const auto& [i, j, s, t, distance, owner] = pairs->pairs;
  return {i.size(), i.data(), j.data(), s.data(), t.data(), distance.data()};
}

void fl_free_pairs(fl_pairs* pairs) { delete pairs; }
