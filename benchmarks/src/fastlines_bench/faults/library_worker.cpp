// A program with the library for C++ and C, in which the allocations or new threads of one operation fail in turn. It
// is run with failing_memory.cpp loaded, and prints the same lines of JSON as memory_worker.py.
#include <dlfcn.h>
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "fastlines/fastlines.h"
#include "fastlines/fastlines.hpp"

namespace {

constexpr int n_lines = 400, n_rays = 800;
constexpr unsigned n_threads = 3;
constexpr float radius = 0.02f;
constexpr long all = 1L << 60;

/// The functions of the library that fails.
template <class Function>
Function* loaded(const char* name) {
  auto* const found = reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
  if (!found) std::fprintf(stderr, "%s is not loaded\n", name), std::exit(1);
  return found;
}

/// The bytes of arrays, one after the other.
struct Bytes {
  std::string text;
  template <class Range>
  Bytes& operator<<(const Range& values) {
    text.append(reinterpret_cast<const char*>(std::data(values)), std::size(values) * sizeof *std::data(values));
    return *this;
  }
};

std::string bytes_of(const fl::Hits& hits) {
  return (Bytes() << hits.t << hits.prim << hits.u << hits.distance << hits.t_out).text;
}
std::string bytes_of(const fl::HitLists& lists) { return (Bytes() << lists.offsets).text + bytes_of(lists.hits); }
std::string bytes_of(const fl::NearLines& lines) { return (Bytes() << lines.distance << lines.prim << lines.u).text; }
std::string bytes_of(const fl::NearLists& lists) { return (Bytes() << lists.offsets).text + bytes_of(lists.lines); }
std::string bytes_of(const fl::Pairs& pairs) {
  return (Bytes() << pairs.i << pairs.j << pairs.s << pairs.t << pairs.distance).text;
}
std::string bytes_of(const fl::Gathered& sums) { return (Bytes() << sums.sum << sums.squares << sums.count).text; }
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return (Bytes() << values).text;
}

/// A failure that is said as it has to be: the class of an exception, or the status of a call of C.
struct Refused {};

/// A call of C that is refused has no memory, and says so; any other status is wrong.
void require_ok(fl_status status) {
  if (status == FL_OK) return;
  const std::string text = fl_error_message();
  if (status != FL_NO_MEMORY) throw std::logic_error("status " + std::to_string(status) + ": " + text);
  // The message may be empty, if there is no memory for it.
  if (!text.empty() && text != "there is not enough memory") throw std::logic_error("the message is " + text);
  throw Refused();
}

struct Operation {
  std::string name;
  std::function<std::string()> call;
};

/// The scene, a tree over it, and all operations.
class Operations {
 public:
  explicit Operations(const std::string& folder) : file_(folder + "/tree.flt"), again_(folder + "/again.flt") {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> place(0, 1);
    std::normal_distribution<float> step(0, 0.2f);
    const auto point = [&] { return fl::Vec3{place(random), place(random), place(random)}; };
    for (int i = 0; i < n_lines; ++i) {
      const fl::Vec3 p = point(), q = {p.x + step(random), p.y + step(random), p.z + step(random)};
      segments_.push_back({p, q});
      cones_.push_back({p, q, 0.01f * place(random), 0.01f * place(random)});
      values_.push_back(place(random));
    }
    for (int i = 0; i < n_rays; ++i) {
      const fl::Vec3 from = {5 * step(random) + 0.5f, 5 * step(random) + 0.5f, 5 * step(random)}, to = point();
      origins_.push_back(from);
      directions_.push_back({to.x - from.x, to.y - from.y, to.z - from.z});
      points_.push_back({double(to.x), double(to.y), double(to.z)});
    }
    tree_ = fl::build(segments_, {.n_threads = n_threads});
    round_ = fl::build(cones_, {.n_threads = n_threads});
    tree_.save(file_);
    require_ok(fl_build(&segments_[0].p.x, segments_.size(), nullptr, &c_tree_));
  }
  ~Operations() { fl_free_tree(c_tree_); }
  Operations(const Operations&) = delete;
  Operations& operator=(const Operations&) = delete;

  /// What the trees from before answer.
  std::string check() const {
    return answers(tree_) + bytes_of(round_.first_hit(rays(), radius, {.at = fl::At::surface}));
  }

  std::vector<Operation> list() const {
    std::vector<Operation> made;
    const auto add = [&](const char* name, std::function<std::string()> call) { made.push_back({name, call}); };
    add("C++ build", [this] { return answers(fl::build(segments_, {.n_threads = n_threads})); });
    add("C++ build bvh_d2", [this] { return built(fl::Method::bvh_d2); });
    add("C++ build kd_cl", [this] { return built(fl::Method::kd_cl); });
    add("C++ build of round cones", [this] { return answers(fl::build(cones_, {.n_threads = n_threads})); });
    add("C++ refit", [this] { return answers(tree_.refit(segments_, n_threads)); });
    add("C++ load", [this] { return answers(fl::load(file_)); });
    add("C++ save", [this] { return tree_.save(again_), saved(); });
    add_rays(add);
    add_points(add);
    add_c(add);
    return made;
  }

 private:
  using Add = std::function<void(const char*, std::function<std::string()>)>;

  fl::Rays rays() const { return {.origins = origins_, .directions = directions_}; }

  static std::string answers(const fl::Tree& tree) {
    const fl::TreeFacts facts = tree.facts();
    return facts.method + " " + std::to_string(facts.n_refs) + " " + std::to_string(facts.cost);
  }

  /// The bytes of the file that was saved, by functions of C, whose allocations do not fail.
  std::string saved() const {
    std::string bytes(1 << 20, 0);
    std::FILE* const file = std::fopen(again_.c_str(), "rb");
    bytes.resize(file ? std::fread(bytes.data(), 1, bytes.size(), file) : 0);
    if (file) std::fclose(file);
    return bytes;
  }

  std::string built(fl::Method method) const {
    return answers(fl::build(segments_, {.method = method, .n_threads = n_threads}));
  }

  void add_rays(const Add& add) const {
    static const fl::QueryOptions options{.n_threads = n_threads};
    const auto ray = [this] { return fl::Ray(origins_[0], directions_[0]); };
    add("C++ first_hit", [this] { return bytes_of(tree_.first_hit(rays(), radius, options)); });
    add("C++ first_hit, one ray", [this, ray] { return std::to_string(tree_.first_hit(ray(), 0.1f).prim); });
    add("C++ any_hit", [this] { return bytes_of(tree_.any_hit(rays(), radius, options)); });
    add("C++ count_hits", [this] { return bytes_of(tree_.count_hits(rays(), radius, options)); });
    add("C++ all_hits", [this] { return bytes_of(tree_.all_hits(rays(), radius, options)); });
    add("C++ all_hits, one ray", [this, ray] { return std::to_string(tree_.all_hits(ray(), 0.1f).size()); });
    add("C++ all_hits to a function", [this] {
      std::size_t n = 0;
      tree_.all_hits(rays(), radius, [&](std::size_t, const fl::Hits& hits) { n += hits.size(); }, options);
      return std::to_string(n);
    });
    add("C++ next_hits", [this] { return bytes_of(tree_.next_hits(rays(), radius, 3, options)); });
    add("C++ all_hits of round cones",
        [this] { return bytes_of(round_.all_hits(rays(), 0.0f, {.at = fl::At::surface, .n_threads = n_threads})); });
    add("C++ gather", [this] { return bytes_of(tree_.gather(rays(), radius, {.values = values_}, options)); });
  }

  void add_points(const Add& add) const {
    static const fl::PointOptions options{.n_threads = n_threads};
    add("C++ nearest", [this] { return bytes_of(tree_.nearest(fl::Points{.positions = points_}, 1.0f, options)); });
    add("C++ k_nearest",
        [this] { return bytes_of(tree_.k_nearest(fl::Points{.positions = points_}, 5, fl::infinity, options)); });
    add("C++ within", [this] { return bytes_of(tree_.within(fl::Points{.positions = points_}, 0.1f, options)); });
    add("C++ within, one point", [this] { return std::to_string(tree_.within(fl::Point(points_[0]), 0.1f).size()); });
    add("C++ count_within",
        [this] { return bytes_of(tree_.count_within(fl::Points{.positions = points_}, 0.1f, options)); });
    add("C++ pairs", [this] { return bytes_of(tree_.pairs(radius, {.n_threads = n_threads})); });
    add("C++ pairs of two trees", [this] { return bytes_of(tree_.pairs(radius, round_, {.n_threads = n_threads})); });
  }

  void add_c(const Add& add) const {
    add("C build", [this] { return c_tree([&](fl_tree** to) { return fl_build(first(), n_lines, nullptr, to); }); });
    add("C load", [this] { return c_tree([&](fl_tree** to) { return fl_load(file_.c_str(), to); }); });
    add("C save", [this] { return require_ok(fl_save(c_tree_, again_.c_str())), saved(); });
    add("C first_hits", [this] {
      std::vector<float> t(n_rays);
      const fl_rays asked = c_rays();
      require_ok(fl_first_hits(c_tree_, &asked, FL_CLOSEST, t.data(), nullptr, nullptr, nullptr, nullptr));
      return bytes_of(t);
    });
    add("C list_hits", [this] {
      const fl_rays asked = c_rays();
      fl_hit_lists* lists = nullptr;
      require_ok(fl_list_hits(c_tree_, &asked, SIZE_MAX, FL_CLOSEST, FL_BY_T, &lists));
      const fl_list_arrays found = fl_get_lists(lists);
      const std::string bytes = (Bytes() << std::span(found.t, found.n_hits)).text;
      fl_free_lists(lists);
      return bytes;
    });
    add("C find_pairs", [this] {
      fl_pairs* pairs = nullptr;
      require_ok(fl_find_pairs(c_tree_, nullptr, radius, nullptr, &pairs));
      const fl_pair_arrays found = fl_get_pairs(pairs);
      const std::string bytes = (Bytes() << std::span(found.distance, found.n)).text;
      fl_free_pairs(pairs);
      return bytes;
    });
  }

  const float* first() const { return &segments_[0].p.x; }

  fl_rays c_rays() const {
    fl_rays asked{};
    asked.n = n_rays, asked.origins = &origins_[0].x, asked.directions = &directions_[0].x;
    asked.radius = radius, asked.n_threads = n_threads;
    return asked;
  }

  /// Makes a tree, and frees it. A call that fails must set it to NULL.
  template <class Make>
  static std::string c_tree(const Make& make) {
    fl_tree* made = reinterpret_cast<fl_tree*>(1);
    const fl_status status = make(&made);
    if (status != FL_OK && made) throw std::logic_error("the tree is not NULL");
    require_ok(status);
    fl_free_tree(made);
    return "a tree";
  }

  std::string file_, again_;
  std::vector<fl::Segment> segments_;
  std::vector<fl::RoundCone> cones_;
  std::vector<float> values_;
  std::vector<fl::Vec3> origins_, directions_;
  std::vector<fl::Vec3d> points_;
  fl::Tree tree_, round_;
  fl_tree* c_tree_ = nullptr;
};

/// An operation whose n-th allocation, or all from there, or n-th new thread fails.
class Trial {
 public:
  Trial(const Operation& operation, const Operations& operations, const std::string& mode)
      : operation_(operation), operations_(operations), is_once_(mode == "once"), kind_(mode == "threads" ? 2 : 1) {
    for (const char* name : {"/libfastlines", "/libstdc++"})
      if (!loaded<int(const char*)>("faults_watch")(name)) std::exit(1);
    expected_ = operation.call();
    before_ = operations.check();
  }

  /// Fails call n; returns whether it was reached, and says what was wrong, or nothing.
  bool run(long n, std::string& wrong) const {
    std::string answer, error;
    bool is_refused = false;
    arm_(kind_, n, is_once_ ? n : all);
    try {
      answer = operation_.call();
    } catch (const Refused&) {
      is_refused = true;
    } catch (const std::bad_alloc&) {
      is_refused = true;
    } catch (const std::exception& what) {
      error = what.what();
    }
    const long n_calls = disarm_();
    wrong = error;
    if (error.empty() && !is_refused && answer != expected_) wrong = "another answer without an error";
    return n_calls >= n;
  }

  /// Says what is wrong with the trees from before, and with the next call.
  std::string check_after() const {
    if (operations_.check() != before_) return "a tree from before answers differently";
    if (operation_.call() != expected_) return "the next call answers differently";
    return {};
  }

  /// The bytes that stay in use for each of many faults, the least of several rounds; see memory_worker.py.
  double leaked(long n_calls) const {
    constexpr int repeats = 50, rounds = 24;
    double least = 1e30;
    std::string ignored;
    for (int round = 0; round < rounds && least > 0; ++round) {
      const auto before = in_use();
      for (int i = 0; i < repeats; ++i) run(1 + i * std::max(1L, n_calls - 1) / repeats, ignored);
      least = std::min(least, (double(in_use()) - double(before)) / repeats);
    }
    return std::max(0.0, least);
  }

 private:
  static std::size_t in_use() {
    const auto info = mallinfo2();
    return info.uordblks + info.hblkhd;
  }

  const Operation& operation_;
  const Operations& operations_;
  bool is_once_;
  int kind_;
  void (*arm_)(int, long, long) = loaded<void(int, long, long)>("faults_arm");
  long (*disarm_)() = loaded<long()>("faults_disarm");
  std::string expected_, before_;
};

void say_wrong(long n, std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::printf("{\"n\": %ld, \"wrong\": \"%s\"}\n", n, text.c_str());
}

}  // namespace

/// Prints the names of all operations of a folder, or runs one: its name, the mode, the first call, the folder.
int main(int argc, char** argv) {
  const Operations operations(argv[argc - 1]);
  const std::vector<Operation> list = operations.list();
  if (argc == 2) {
    for (const Operation& each : list) std::printf("%s\n", each.name.c_str());
    return 0;
  }
  const auto found = std::find_if(list.begin(), list.end(), [&](const auto& each) { return each.name == argv[1]; });
  if (argc != 5 || found == list.end()) return 2;
  const Trial trial(*found, operations, argv[2]);
  long n = std::atol(argv[3]);
  for (;; ++n) {
    std::printf("{\"trying\": %ld}\n", n);
    std::fflush(stdout);
    std::string wrong;
    const bool was_reached = trial.run(n, wrong);
    if (was_reached && wrong.empty()) wrong = trial.check_after();
    if (!wrong.empty()) say_wrong(n, wrong);
    if (!was_reached) break;
  }
  std::printf("{\"n_calls\": %ld, \"leaked\": %g}\n", n - 1, n > 1 ? trial.leaked(n - 1) : 0.0);
}
