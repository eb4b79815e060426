// Rays and hits as tuples of NumPy arrays.
#pragma once

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <optional>
#include <stdexcept>
#include <string>

#include "arrays.hpp"
#include "fastlines/query/hit_assembler.hpp"
#include "fastlines/rays/ray_batch.hpp"

namespace fastlines {

/// Origins, directions, radius, t_min, t_max, spread, and limit, or None for no limit.
using RayArrays = std::tuple<Input<float>, Input<float>, Input<float>, Input<float>, Input<float>, Input<float>,
                             std::optional<Input<float>>>;

inline RayBatch batch_of(const RayArrays& rays) {
  const auto& [origins, directions, radius, t_min, t_max, spread, limit] = rays;
  return {rows<Vec3>(origins),
          rows<Vec3>(directions),
          rows<float>(radius),
          rows<float>(t_min),
          rows<float>(t_max),
          rows<float>(spread),
          limit ? rows<float>(*limit) : std::span<const float>(kNoLimit)};
}

/// Where t is taken, and which rays hit, by its name in Python.
inline At at_of(const std::string& name) {
  if (name == "closest") return At::closest;
  if (name == "surface") return At::surface;
  if (name == "entry") return At::entry;
  throw std::invalid_argument("at is " + name + "; expected closest, surface or entry");
}

/// Columns of hits: t, prim, u, distance, and t_out unless t is at the closest approach.
using HitTuple =
    std::tuple<Output<float>, Output<std::int64_t>, Output<float>, Output<float>, std::optional<Output<float>>>;

/// Lists of hits: offsets and columns. The hits of ray i are those from offsets[i] up to offsets[i + 1].
using ListTuple = std::tuple<Output<std::int64_t>, HitTuple>;

/// Allocates the columns of a HitTuple, one hit per ray, for queries that store hits in place.
class HitArrays {
 public:
  HitArrays(std::size_t n, bool with_t_out)
      : t_(make_array<float>(n)),
        u_(make_array<float>(n)),
        distance_(make_array<float>(n)),
        prim_(make_array<std::int64_t>(n)) {
    if (with_t_out) t_out_ = make_array<float>(n);
  }

  HitColumns columns() {
    return {t_.data(), prim_.data(), u_.data(), distance_.data(), t_out_ ? t_out_->data() : nullptr};
  }

  HitTuple tuple() const { return {t_, prim_, u_, distance_, t_out_}; }

 private:
  Output<float> t_, u_, distance_;
  std::optional<Output<float>> t_out_;
  Output<std::int64_t> prim_;
};

/// The lists as arrays, which take over their memory.
inline ListTuple arrays_of(HitAssembler& lists) {
  LargeVector<std::int64_t> offsets = lists.offsets();
  const auto n_hits = std::size_t(offsets.back());
  const auto array = [n_hits](auto& column) {
    column.set_size(n_hits);
    return adopt<typename std::remove_reference_t<decltype(column)>::value_type>(std::move(column));
  };
  std::optional<Output<float>> t_out;
  if (lists.with_t_out()) t_out = array(lists.t_out);
  return {adopt<std::int64_t>(std::move(offsets)),
          {array(lists.t), array(lists.prim), array(lists.u), array(lists.distance), t_out}};
}

}  // namespace fastlines
