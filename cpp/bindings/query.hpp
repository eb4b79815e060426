// A batch of rays on a wide layout: the part that all queries share.
#pragma once

#include "fastlines/kernels/run/run_batch.hpp"
#include "layout.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace fastlines {

/// A batch of rays for a layout. A short batch runs on one thread and is not watched for Ctrl-C.
class BatchQuery {
 public:
  BatchQuery(const LayoutView& layout, const RayArrays& rays, int kernel, unsigned n_threads, nanobind::object progress)
      : rays(batch_of(rays)),
        layout_(layout),
        is_long_(may_be_long(this->rays.size(), layout.refs.size())),
        kernel_(Kernel(kernel)),
        n_threads_(is_long_ ? n_threads : 1),
        progress_(std::move(progress)) {}

  const RayBatch rays;

  /// Runs the query make(view), which stores its answers in place.
  template <class Make>
  void run(Make&& make) const {
    layout_.with_view([&](const auto& view) {
      watch_if(is_long_, progress_,
               [&](Progress& watched) { run_batch(view, rays, kernel_, make(view), n_threads_, watched); });
    });
  }

  /// Runs the query make(view), which lists hits, and returns the lists.
  template <At at, class Make>
  ListTuple list(Make&& make) const {
    std::optional<HitAssembler> lists;
    layout_.with_view([&](const auto& view) {
      watch_if(is_long_, progress_, [&](Progress& watched) {
        run_lists(view, rays, kernel_, make(view), n_threads_, watched, lists.emplace(rays.size(), at == At::surface));
      });
    });
    return arrays_of(*lists);
  }

 private:
  const LayoutView& layout_;
  bool is_long_;
  Kernel kernel_;
  unsigned n_threads_;
  nanobind::object progress_;
};

}  // namespace fastlines
