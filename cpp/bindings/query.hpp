// What all queries on the wide layout have in common.
#pragma once

#include "fastlines/kernels/run/run_batch.hpp"
#include "layout.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace fastlines {

/// A batch of rays for a layout. One that is over soon is not watched for Ctrl-C and takes one thread.
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

  /// Run the query make(view), whose answers go straight to their places.
  template <class Make>
  void run(Make&& make) const {
    layout_.with_view([&](const auto& view) {
      watch_if(is_long_, progress_,
               [&](Progress& watched) { run_batch(view, rays, kernel_, make(view), n_threads_, watched); });
    });
  }

  /// Run the query make(view), which lists hits.
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
