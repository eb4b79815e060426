// The C interface: sums over all hits of rays.
#include <algorithm>
#include <string>

#include "c_rays.hpp"

using namespace fl::detail;

namespace {

fl::Blur blur_of(fl_blur blur) {
  if (blur == FL_BOX_BLUR) return fl::Blur::box;
  if (blur == FL_EPANECHNIKOV_BLUR) return fl::Blur::epanechnikov;
  if (blur == FL_NO_BLUR) return fl::Blur::none;
  throw fl::InputError("unknown fl_blur; expected FL_BOX_BLUR, FL_EPANECHNIKOV_BLUR or FL_NO_BLUR");
}

fl::GatherOptions options_of(const fl_gather_options& given, std::size_t n_rays, std::size_t n_lines) {
  fl::GatherOptions what;
  what.blur = blur_of(given.blur);
  what.n_channels = std::max<std::size_t>(given.n_channels, 1);
  if (given.values) what.values = {given.values, n_lines * what.n_channels};
  std::copy_n(given.sigma, what.sigma.size(), what.sigma.begin());
  std::copy_n(given.line_sigma, what.line_sigma.size(), what.line_sigma.begin());
  if (!given.optical_depth != !given.n_depths)
    throw fl::InputError(std::string("optical_depth is ") + (given.optical_depth ? "an array" : "NULL") +
                         ", and n_depths is " + std::to_string(given.n_depths) + "; set both, or neither");
  what.n_depths = given.n_depths;
  if (given.optical_depth)
    what.optical_depth = {given.optical_depth,
                          n_rays * given.n_depths * (given.has_depth_channels ? what.n_channels : 1)};
  if (given.has_phase) what.phase = given.phase;
  what.inner = !given.with_ends;
  return what;
}

}  // namespace

fl_status fl_gather(const fl_tree* tree, const fl_rays* rays, const fl_gather_options* options, double* sum,
                    double* squares, int64_t* count) {
  return guarded([&] {
    require(tree, "tree");
    RayBatch batch(rays, fl::At::closest);
    if (batch.rays.size() > 0) require(sum, "sum");
    fl::GatherOptions what;
    if (options) {
      what = options_of(*options, batch.rays.size(), tree->tree.size());
      if (options->progress)
        batch.options.progress = [options](double done) { return options->progress(done, options->user_data) != 0; };
    }
    what.squares = squares != nullptr;
    const fl::Gathered sums = tree->tree.gather(batch.rays, batch.radius, what, batch.options);
    copy_if<double>(sums.sum, sum);
    copy_if<double>(sums.squares, squares);
    copy_if<std::int64_t>(sums.count, count);
  });
}
