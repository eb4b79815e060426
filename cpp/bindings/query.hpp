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
      : tree(layout.view),
        rays(batch_of(rays)),
        is_long_(may_be_long(this->rays.size(), layout.refs.size())),
        kernel_(Kernel(kernel)),
        n_threads_(is_long_ ? n_threads : 1),
        progress_(std::move(progress)) {}

  const WideBvhView<Segments>& tree;
  const RayBatch rays;

  /// Run a job whose answers go straight to their places.
  template <class Query>
  void run(const Query& job) const {
    watch_if(is_long_, progress_, [&](Progress& watched) { run_batch(tree, rays, kernel_, job, n_threads_, watched); });
  }

  template <At at, class Query>
  ListTuple list(const Query& job) const {
    std::optional<HitAssembler> lists;
    watch_if(is_long_, progress_, [&](Progress& watched) {
      run_lists(tree, rays, kernel_, job, n_threads_, watched, lists.emplace(rays.size(), at == At::surface));
    });
    return arrays_of(*lists);
  }

 private:
  bool is_long_;
  Kernel kernel_;
  unsigned n_threads_;
  nanobind::object progress_;
};

}  // namespace fastlines
