// The changes that an attacker makes to the file of a tree: to numbers, rows, boxes, whole trees and to the header.
#pragma once

#include <bit>
#include <limits>

#include "file_parts.hpp"
#include "random_tree.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace fastlines::fuzz {

/// Makes changes to one file. Others lend their parts.
class Changes {
 public:
  Changes(FileParts& file, const FileParts* other, test::Random& random)
      : file_(file), other_(other), random_(random) {}

  /// One change, or none where the file has not what it would change.
  void change() {
    if (file_.parts.empty()) return change_metadata();
    switch (random_.below(16)) {
      default:
        return change_word(any_part());
      case 8:
        return change_rows(any_part());
      case 9:
        return change_metadata();
      case 10:
        return change_header(any_part());
      case 11:
        return change_bytes(any_part());
      case 12:
        return take_part();
      case 13:
        return fit_boxes();
      case 14:
        return count_refs();
      case 15:
        return regrow();
    }
  }

 private:
  FilePart& any_part() { return file_.parts[random_.below(file_.parts.size())]; }

  template <class T, std::size_t n>
  const T& one_of(const T (&of)[n]) {
    return of[random_.below(n)];
  }

  /// Changes a word of 32 bits as a number of either type, or copies another one of the same column.
  void change_word(FilePart& part) {
    const std::span<std::uint32_t> words = part.rows<std::uint32_t>();
    if (words.empty()) return;
    std::uint32_t& word = words[random_.below(words.size())];
    const std::size_t n_columns = std::max<std::size_t>(part.row_size() / 4, 1);
    const std::size_t n_rows = (words.size() + n_columns - 1) / n_columns;
    static constexpr std::uint32_t whole[] = {0, 1, 2, 3, 0xff, 0xffff, 0x7fff'ffff, 0x8000'0000, 0xffff'ffff};
    static constexpr float floats[] = {0.0f,  -0.0f,  1.0f,          0.5f,   INFINITY, -INFINITY, NAN,
                                       1e30f, -1e30f, 1.0000001e30f, 1e-30f, 1e-45f,   3.4e38f};
    switch (random_.below(8)) {
      case 0:
        word ^= 1u << random_.below(32);
        return;
      case 1: {  // near floats, and near whole numbers
        const std::uint32_t by = 1u << random_.below(16);
        word += random_.below(2) ? by : 0 - by;
        return;
      }
      case 2:
        word = one_of(whole);
        return;
      case 3:
        word = std::bit_cast<std::uint32_t>(one_of(floats));
        return;
      case 4:
        word = std::uint32_t(n_rows + random_.below(3)) - 1;
        return;
      case 5:
        word = std::uint32_t(random_.below(n_rows + 1));
        return;
      case 6: {
        const std::size_t column = std::size_t(&word - words.data()) % n_columns;
        const std::size_t from = random_.below(n_rows) * n_columns + column;
        if (from < words.size()) word = words[from];
        return;
      }
      default:
        word = words[random_.below(words.size())];
    }
  }

  /// Copies, removes, swaps or repeats rows.
  void change_rows(FilePart& part) {
    const std::size_t size = part.row_size();
    if (size == 0 || part.bytes.size() < size) return;
    const std::size_t n = part.bytes.size() / size;
    const auto row = [&](std::size_t i) { return part.bytes.begin() + std::ptrdiff_t(i * size); };
    const std::size_t a = random_.below(n), b = random_.below(n);
    switch (random_.below(4)) {
      case 0:
        std::copy_n(row(a), size, row(b));
        break;
      case 1:
        part.bytes.erase(row(a), row(a + 1));
        break;
      case 2:
        if (a != b) std::swap_ranges(row(a), row(a + 1), row(b));
        break;
      default: {
        const std::vector<std::byte> copied(row(a), row(a + 1));
        part.bytes.insert(row(b), copied.begin(), copied.end());
      }
    }
    if (random_.below(8)) part.count_rows();
  }

  void change_text(std::string& text) {
    constexpr std::size_t most_grown = 16;
    const std::size_t size = text.size();
    text.resize(size + most_grown);
    text.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(text.data()), size, text.size()));
  }

  void change_metadata() {
    static constexpr const char* values[] = {"",
                                             "[]",
                                             "[[0, 0, 0], [1, 1, 1]]",
                                             "[[-9, -9, -9], [9, 9, 9]]",
                                             R"({"offset": [1e6, -5, 0.5]})",
                                             "{}",
                                             "null",
                                             R"({"offset": [1e999]})",
                                             "1.5",
                                             "NaN"};
    static constexpr const char* names[] = {"frame", "metadata", "built_cost", "boxes", "kind", "up"};
    if (file_.metadata.empty() || random_.below(4) == 0) {
      file_.metadata.emplace_back(one_of(names), one_of(values));
      return;
    }
    const std::size_t at = random_.below(file_.metadata.size());
    std::string& text = file_.metadata[at].second;
    switch (random_.below(4)) {
      case 0:
        file_.metadata.erase(file_.metadata.begin() + std::ptrdiff_t(at));
        return;
      case 1:
        text = one_of(values);
        return;
      case 2:
        return swap_rule();
      default:
        return change_text(text);
    }
  }

  /// Calls a tree of one rule one of the other rule.
  void swap_rule() {
    for (auto& [name, text] : file_.metadata) {
      const std::size_t cut = text.find("cut\""), tight = text.find("tight\"");
      if (cut != std::string::npos) text.replace(cut, 3, "tight");
      if (tight != std::string::npos) text.replace(tight, 5, "cut");
      if (text == "cut" || text == "tight") text = text == "cut" ? "tight" : "cut";
    }
  }

  /// Changes what the header says of a section.
  void change_header(FilePart& part) {
    static constexpr const char* types[] = {"F32", "U32", "I64", "U8", "F64", "BOOL", "F16", ""};
    switch (random_.below(4)) {
      case 0:
        part.dtype = one_of(types);
        if (part.dtype.empty()) change_text(part.dtype);
        return;
      case 1:
        return change_text(part.name);
      case 2:
        part.name = any_part().name;
        return;
      default:
        return change_text(part.shape);
    }
  }

  void change_bytes(FilePart& part) {
    const std::size_t size = part.bytes.size();
    part.bytes.resize(size + 64);
    part.bytes.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(part.bytes.data()), size, part.bytes.size()));
    if (random_.below(2)) part.count_rows();
  }

  /// Takes a section of another file, drops one, or puts them in another order.
  void take_part() {
    FilePart& part = any_part();
    if (other_ && !other_->parts.empty()) {
      const FilePart& taken = other_->parts[random_.below(other_->parts.size())];
      if (FilePart* const same = file_.find(taken.name))
        *same = taken;
      else
        file_.parts.push_back(taken);
    } else if (random_.below(2)) {
      std::swap(part, any_part());
    } else {
      file_.parts.erase(file_.parts.begin() + (&part - file_.parts.data()));
    }
  }

  /// The nodes, if the section has whole rows of them.
  std::span<Node> nodes() {
    FilePart* const part = file_.find("nodes");
    return part && part->bytes.size() % sizeof(Node) == 0 ? part->rows<Node>() : std::span<Node>();
  }

  /// Let the root bound all primitives, and each box what is in its parent's.
  void fit_boxes() {
    const std::span<Node> all = nodes();
    if (all.empty()) return;
    with_primitives([&](const auto& prims) { all[0].box = bounds_of_all(prims); });
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Node& node = all[i];
      if (node.is_leaf() || i + 1 >= all.size() || node.right >= all.size()) continue;
      for (Node* child : {&all[i + 1], &all[node.right]})
        for (int k = 0; k < 3; ++k) {
          child->box.lo[k] = std::max(child->box.lo[k], node.box.lo[k]);
          child->box.hi[k] = std::min(child->box.hi[k], node.box.hi[k]);
        }
    }
  }

  /// Number the references below all nodes by those of the leaves.
  void count_refs() {
    const std::span<Node> all = nodes();
    std::uint32_t n = 0;
    for (Node& node : all) {
      node.first_ref = n;
      if (node.is_leaf()) n += node.n_refs;
    }
    for (std::size_t i = all.size(); i-- > 0;)
      if (!all[i].is_leaf() && i + 1 < all.size() && all[i].right < all.size())
        all[i].n_refs = all[i + 1].n_refs + all[all[i].right].n_refs;
  }

  /// Replaces the tree by a random one over the same primitives.
  void regrow() {
    FilePart *const nodes = file_.find("nodes"), *const refs = file_.find("refs");
    if (!nodes || !refs) return;
    bool is_cut = false;
    for (const auto& [name, text] : file_.metadata)
      is_cut |= text == "cut" || text.find("\"cut\"") != std::string::npos;
    with_primitives([&]<class P>(const P& prims) {
      const Tree tree = RandomTree<P>(prims, is_cut, random_)();
      nodes->assign(std::span(tree.nodes));
      refs->assign(std::span(tree.refs));
    });
  }

  /// Calls use(prims) with the primitives of the tree, if they can be used: the axes of lines, or shapes.
  template <class Use>
  void with_primitives(Use&& use) {
    constexpr std::size_t most = 512;
    FilePart* part = file_.find("segments");
    if (!part) part = file_.find("data");
    if (!part || part->dtype != "F32" || part->bytes.size() > most * sizeof(Shape)) return;
    for (const float number : part->rows<float>())
      if (!(std::fabs(number) <= 1e30f)) return;
    const std::size_t size = part->row_size();
    if (size == sizeof(Segment)) return use(Segments{part->rows<Segment>()});
    if (size == sizeof(RoundCone)) {
      std::vector<Segment> axes;
      for (const RoundCone& cone : part->rows<RoundCone>()) axes.push_back(cone.axis);
      return use(Segments{axes});
    }
    if (size != sizeof(Shape)) return;
    for (const Shape& shape : part->rows<Shape>())
      if (!(shape.kind_number >= 0.0f && shape.kind_number <= 2.0f)) return;
    use(Shapes{part->rows<Shape>()});
  }

  FileParts& file_;
  const FileParts* const other_;
  test::Random& random_;
};

}  // namespace fastlines::fuzz
