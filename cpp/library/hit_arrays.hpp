// Hits in memory of the library's own, for the arrays of `Hits`.
#pragma once

#include "fastlines/api/ray.hpp"
#include "fastlines/query/hit_assembler.hpp"

namespace fl::detail {

/// The columns of hits: one for each ray, or those of lists.
struct HitArrays {
  fastlines::Buffer<float> t, u, distance, t_out;
  fastlines::Buffer<std::int64_t> prim;

  HitArrays(std::size_t n, At at) {
    for (auto* column : {&t, &u, &distance}) column->reset(n);
    prim.reset(n);
    if (at != At::closest) t_out.reset(n);
    set_size(n, at != At::closest);
  }
  HitArrays(fastlines::HitAssembler&& lists, std::size_t n)
      : t(std::move(lists.t)),
        u(std::move(lists.u)),
        distance(std::move(lists.distance)),
        t_out(std::move(lists.t_out)),
        prim(std::move(lists.prim)) {
    set_size(n, lists.with_t_out());
  }

  fastlines::HitColumns columns() {
    return {t.data(), prim.data(), u.data(), distance.data(), t_out.size() ? t_out.data() : nullptr};
  }
  Hits hits(std::shared_ptr<const void> owner) const { return {t, prim, u, distance, t_out, std::move(owner)}; }

 private:
  void set_size(std::size_t n, bool with_t_out) {
    for (auto* column : {&t, &u, &distance}) column->set_size(n);
    prim.set_size(n);
    t_out.set_size(with_t_out ? n : 0);
  }
};

}  // namespace fl::detail
