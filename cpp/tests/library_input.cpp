// The library refuses input that it cannot use, and no call ends the process.
#include "library.hpp"

namespace {

void check_bad_input() {
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<fl::Segment> bad{{{0, 0, 0}, {1, 1, 1}}, {{0, nan, 0}, {1, 1, 1}}};
  const std::string why = message_of<fl::InputError>([&] { fl::build(bad); });
  check(why.find("line 1") != std::string::npos, "a bad line is named");
  const fl::RoundCone large{{0, 0, 0}, {1, 1, 1}, 1e13f, 0};
  check(!message_of<fl::InputError>([&] { fl::build(std::span(&large, 1)); }).empty(), "a radius is not too large");
  const fl::Tree tree = fl::build(std::span(bad).first(1));
  const fl::Ray ray({0, 0, -5}, {0, 0, 1});
  const auto refuses = [&](const fl::Ray& of, float radius) {
    return !message_of<fl::InputError>([&] { tree.first_hit(of, radius); }).empty() &&
           !message_of<fl::InputError>([&] { tree.all_hits(of, radius); }).empty();
  };
  check(!refuses(ray, 0.5f), "a good ray is traced");
  check(refuses(ray, nan) && refuses(ray, -1), "a radius is a number that is not negative");
  check(refuses(fl::Ray({0, 0, nan}, {0, 0, 1}), 0), "origins are finite");
  check(refuses(fl::Ray({0, 0, 0}, {0, 0, 0}), 0), "directions are not zero");
  check(refuses(fl::Ray({0, 0, 0}, {0, 0, 1}, 2, 1), 0), "t_min is at most t_max");
  const std::vector<fl::Vec3> three(3), two(2);
  check(!message_of<fl::InputError>([&] { tree.all_hits(fl::Rays{three, three}, 0.1f, fl::Tree::Sink()); }).empty(),
        "an empty sink is refused");
  check(!message_of<fl::InputError>([&] { tree.first_hit(fl::Rays{three, two}, 0.1f); }).empty(), "sizes must match");
  check(!message_of<fl::InputError>([&] { tree.all_hits(fl::Rays{three, two}, 0.1f, [](auto, auto&&) {}); }).empty(),
        "sizes must match for a sink");
  check(!message_of<fl::InputError>([] { fl::set_simd("mmx"); }).empty(), "an unknown instruction set is refused");
  check(!message_of<fl::FileError>([] { fl::load("no/such/file.flt"); }).empty(), "a missing file is refused");
  check(!message_of<fl::FileError>([&] { tree.save("no/such/folder/a.flt"); }).empty(), "a missing folder is refused");
}

/// Null pointers and counts that cannot be: each is refused, and no call ends the process.
void check_nulls() {
  const auto is_refused = [](auto&& call) { return !message_of<fl::InputError>(call).empty(); };
  const float line[6] = {-1, -1, -1, 1, 1, 1};
  fl::BVH bvh;
  check(is_refused([&] { bvh.Build(nullptr, 2); }), "Build refuses a null array");
  check(is_refused([&] { bvh.Build(line, -1); }), "Build refuses a negative number of lines");
  check(is_refused([&] { bvh.Build(nullptr, std::numeric_limits<int>::max()); }), "Build refuses a huge null array");
  check(is_refused([&] { fl::AccTree(fl::Method(9)).Build(line, 1); }), "Build refuses an unknown method");
  bvh.Build(nullptr, 0);
  const fl::Ray ray({0, 0, -5}, {0, 0, 1});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  check(!bvh.Intersect(ray, nullptr, 1) && !bvh.IntersectAll(ray, nullptr, 1), "a tree over no lines misses");
  bvh.Build(line, 1);
  check(bvh.Intersect(ray, nullptr, 1) && bvh.IntersectAll(ray, nullptr, 1), "the hit may be null");
  check(is_refused([&] { bvh.Intersect(ray, nullptr, nan); }), "the distance is a number");
  check(is_refused([&] { bvh.IntersectAll(ray, nullptr, -1); }), "the distance is not negative");

  const auto null_of = []<class T>(T*, std::size_t n) { return std::span<const T>(static_cast<const T*>(nullptr), n); };
  for (const std::size_t n : {std::size_t(2), ~std::size_t(0)}) {
    check(is_refused([&] { fl::build(null_of((fl::Segment*)nullptr, n)); }), "null segments are refused");
    check(is_refused([&] { fl::build(null_of((fl::RoundCone*)nullptr, n)); }), "null round cones are refused");
  }
  check(is_refused([&] { fl::build(std::span(reinterpret_cast<const fl::Segment*>(line), ~std::size_t(0))); }),
        "more lines than there can be are refused");
  const fl::Tree& tree = bvh.tree();
  const auto nulls = null_of((fl::Vec3*)nullptr, 2);
  const auto null_floats = null_of((float*)nullptr, 2);
  const std::vector<fl::Vec3> origins(2, ray.origin), directions(2, ray.direction);
  const std::span<const fl::Vec3> too_many(origins.data(), ~std::size_t(0));
  const auto all_refuse = [&](const fl::Rays& rays, const fl::PerRay& radius, fl::QueryOptions options = {}) {
    return is_refused([&] { tree.first_hit(rays, radius, options); }) &&
           is_refused([&] { tree.any_hit(rays, radius, options); }) &&
           is_refused([&] { tree.count_hits(rays, radius, options); }) &&
           is_refused([&] { tree.all_hits(rays, radius, options); }) &&
           is_refused([&] { tree.next_hits(rays, radius, 2, options); }) &&
           is_refused([&] { tree.all_hits(rays, radius, [](auto, auto&&) {}, options); });
  };
  check(all_refuse({nulls, directions}, 1) && all_refuse({origins, nulls}, 1), "null rays are refused");
  check(all_refuse({origins, directions, null_floats}, 1), "a null t_min is refused");
  check(all_refuse({origins, directions, 0.0f, null_floats}, 1), "a null t_max is refused");
  check(all_refuse({origins, directions}, null_floats), "null radii are refused");
  check(all_refuse({origins, directions}, nan) && all_refuse({origins, directions}, -1), "radii are numbers from 0");
  check(all_refuse({origins, directions, nan}, 1), "t_min is a number");
  check(all_refuse({too_many, too_many}, 1), "more rays than there can be are refused");
  fl::QueryOptions unknown;
  unknown.kernel = fl::QueryOptions::Kernel(9);
  check(all_refuse({origins, directions}, 1, unknown), "an unknown kernel is refused");
  fl::QueryOptions many;
  many.n_threads = ~0u;
  const std::size_t most = ~std::size_t(0);
  check(
      tree.next_hits({origins, directions}, 1, most, many).hits.size() == 2 && tree.next_hits(ray, 1, most).size() == 1,
      "k and the number of threads may be huge");
  check(tree.next_hits({origins, directions}, 1, 0).hits.size() == 0 && tree.next_hits(ray, 1, 0).empty(),
        "k may be 0");
}

void check_input() {
  check_bad_input();
  check_nulls();
}

}  // namespace

int main() { return fastlines::test::run(check_input); }
