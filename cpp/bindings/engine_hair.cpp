// The scattering of light by hair: the near field at points of fibres, and the far field from tables.
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "engine.hpp"
#include "fastlines/shading/hair_points.hpp"
#include "shading.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// Points of fibres as rows of arrays.
struct HairRows {
  const HairMaterial material;
  const Input<float>&to_eye, &tangents, &h;

  std::size_t size() const { return h.size(); }
  HairPoints points(std::size_t first, int n) const {
    return {material, Vec3Lanes::load(to_eye.data() + 3 * first, n), Vec3Lanes::load(tangents.data() + 3 * first, n),
            load_lanes(h.data() + first, n)};
  }
};

Output<float> hair_evaluate(const HairNumbers& material, Input<float> to_eye, Input<float> tangents, Input<float> h,
                            Input<float> towards) {
  const HairRows rows{HairMaterial(material), to_eye, tangents, h};
  Output<float> values = make_array<float>(rows.size(), 3);
  in_lanes(rows.size(), [&](std::size_t first, int n) {
    const HairPoints points = rows.points(first, n);
    points.evaluate(Vec3Lanes::load(towards.data() + 3 * first, n)).store(values.data() + 3 * first, n);
  });
  return values;
}

Output<float> hair_pdf(const HairNumbers& material, Input<float> to_eye, Input<float> tangents, Input<float> h,
                       Input<float> towards) {
  const HairRows rows{HairMaterial(material), to_eye, tangents, h};
  Output<float> densities = make_array<float>(rows.size());
  in_lanes(rows.size(), [&](std::size_t first, int n) {
    const HairPoints points = rows.points(first, n);
    store_lanes(points.pdf(Vec3Lanes::load(towards.data() + 3 * first, n)), densities.data() + first, n);
  });
  return densities;
}

std::tuple<Output<float>, Output<float>, Output<float>> hair_sample(const HairNumbers& material, Input<float> to_eye,
                                                                    Input<float> tangents, Input<float> h,
                                                                    Input<float> u4) {
  const HairRows rows{HairMaterial(material), to_eye, tangents, h};
  Output<float> towards = make_array<float>(rows.size(), 3), weights = make_array<float>(rows.size(), 3);
  Output<float> densities = make_array<float>(rows.size());
  in_lanes(rows.size(), [&](std::size_t first, int n) {
    FloatLanes u[4];
    for (int k = 0; k < 4; ++k)
      for (int i = 0; i < kLanes; ++i) u[k].set(i, u4.data()[4 * (first + std::min(i, n - 1)) + k]);
    const HairPoints::Sampled drawn = rows.points(first, n).sample(u);
    drawn.towards.store(towards.data() + 3 * first, n);
    drawn.weight.store(weights.data() + 3 * first, n);
    store_lanes(drawn.pdf, densities.data() + first, n);
  });
  return {towards, weights, densities};
}

Output<float> averaged_hair(const HairNumbers& material, Input<float> azimuths, Input<float> inclinations,
                            Input<float> sin_o, Input<float> sin_i, Input<float> phi) {
  const HairMaterial lobes(material);
  const HairTable table = table_of(lobes, azimuths, inclinations);
  Output<float> values = make_array<float>(phi.size(), 3);
  in_lanes(phi.size(), [&](std::size_t first, int n) {
    const auto lanes = [&](const Input<float>& from) { return load_lanes(from.data() + first, n); };
    table.evaluate(lanes(sin_o), lanes(sin_i), lanes(phi)).store(values.data() + 3 * first, n);
  });
  return values;
}

std::tuple<Output<float>, Output<float>> averaged_attenuations(const HairNumbers& material, Input<float> azimuths,
                                                               Input<float> inclinations, Input<float> sin_theta) {
  const HairMaterial lobes(material);
  const HairTable table = table_of(lobes, azimuths, inclinations);
  const std::size_t n_rows = sin_theta.size();
  Output<float> forward = make_array<float>(n_rows, 3), backward = make_array<float>(n_rows, 3);
  in_lanes(n_rows, [&](std::size_t first, int n) {
    const FloatLanes sine = load_lanes(sin_theta.data() + first, n);
    table.forward(sine).store(forward.data() + 3 * first, n);
    table.backward(sine).store(backward.data() + 3 * first, n);
  });
  return {forward, backward};
}

}  // namespace

void bind_hair(nb::module_& m) {
  m.def("hair_evaluate", &hair_evaluate, "material"_a, "to_eye"_a.noconvert(), "tangents"_a.noconvert(),
        "h"_a.noconvert(), "towards"_a.noconvert());
  m.def("hair_pdf", &hair_pdf, "material"_a, "to_eye"_a.noconvert(), "tangents"_a.noconvert(), "h"_a.noconvert(),
        "towards"_a.noconvert());
  m.def("hair_sample", &hair_sample, "material"_a, "to_eye"_a.noconvert(), "tangents"_a.noconvert(), "h"_a.noconvert(),
        "u4"_a.noconvert());
  m.def("averaged_hair", &averaged_hair, "material"_a, "azimuths"_a.noconvert(), "inclinations"_a.noconvert(),
        "sin_o"_a.noconvert(), "sin_i"_a.noconvert(), "phi"_a.noconvert());
  m.def("averaged_attenuations", &averaged_attenuations, "material"_a, "azimuths"_a.noconvert(),
        "inclinations"_a.noconvert(), "sin_theta"_a.noconvert());
}

}  // namespace fastlines
