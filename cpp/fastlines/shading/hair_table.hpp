// The scattering of fibres thinner than a pixel: the far field, from tables of a material. Modules `table` and
// `averaged` of fastlines.rendering.hair have the formulas.
#pragma once

#include <algorithm>
#include <cstddef>

#include "hair_lobes.hpp"

namespace fastlines {

class HairTable {
 public:
  /// The values in a cell of `azimuths`: N̄ of R, of TT and of TRT for red, green and blue, and one that is not used.
  static constexpr int kValues = 8;
  /// The values in a cell of `inclinations`: N̄ of the rest, a_f and a_b, each for red, green and blue.
  static constexpr int kRest = 9;

  /// Tables of equal steps: `azimuths` has rows for inclinations and columns for |φ|, `inclinations` has rows. The
  /// material and the tables must outlive this view.
  HairTable(const HairMaterial& material, const float* azimuths, const float* inclinations, int n_rows, int n_columns)
      : material_(material), azimuths_(azimuths), inclinations_(inclinations), n_rows_(n_rows), n_columns_(n_columns) {}

  /// The light that goes from one direction to another, by their inclinations and the azimuth between them.
  Vec3Lanes evaluate(const FloatLanes& sin_o, const FloatLanes& sin_i, const FloatLanes& phi) const {
    const FloatLanes cos_o = cosine_of(sin_o), cos_i = cosine_of(sin_i);
    const Cell row = row_of(cos_o), column = cell_of(abs(turned(phi)) * (float(n_columns_ - 1) / kPi), n_columns_);
    FloatLanes around[kValues];
    look_up(row, column, around);
    const Vec3Lanes rest = look_up(row, 0);

    FloatLanes along[HairMaterial::kLobes];
    for (int p = 0; p < HairMaterial::kLobes; ++p) {
      const HairMaterial::Lobe& lobe = material_.lobes[p];
      const FloatLanes tilted = sin_o * lobe.cos_tilt + cos_o * lobe.sin_tilt;
      const FloatLanes across = abs(cos_o * lobe.cos_tilt - sin_o * lobe.sin_tilt);
      along[p] = longitudinal_density(lobe, sin_i, cos_i, tilted, across);
    }
    const FloatLanes white = around[0] * along[0];
    return Vec3Lanes{white, white, white} + along[1] * Vec3Lanes{around[1], around[2], around[3]} +
           along[2] * Vec3Lanes{around[4], around[5], around[6]} + along[3] * rest;
  }

  /// a_f: the share of the light at an inclination that one fibre scatters onwards.
  Vec3Lanes forward(const FloatLanes& sin_theta) const { return look_up(row_of(cosine_of(sin_theta)), 3); }
  /// a_b: the share that it scatters back.
  Vec3Lanes backward(const FloatLanes& sin_theta) const { return look_up(row_of(cosine_of(sin_theta)), 6); }

 private:
  /// The number of a step and the place in it, from 0 to 1; NaN stays in the place.
  struct Cell {
    IntLanes number;
    FloatLanes place;
  };

  static FloatLanes cosine_of(const FloatLanes& sine) {
    return sqrt(max((1.0f - sine) * (1.0f + sine), FloatLanes(0.0f)));
  }
  static Cell cell_of(const FloatLanes& x, int n_ends) {
    const FloatLanes last = float(n_ends - 2), bounded = select(x <= last, x, last);
    const IntLanes number = to_int(max(bounded, FloatLanes(0.0f)));
    return {number, min(x - to_float(number), FloatLanes(1.0f))};
  }
  /// Rows are equal steps of (c + c²) / 2, with c = cos θ.
  Cell row_of(const FloatLanes& cosine) const {
    return cell_of((cosine + cosine * cosine) * (0.5f * float(n_rows_ - 1)), n_rows_);
  }

  void look_up(const Cell& row, const Cell& column, FloatLanes (&found)[kValues]) const {
    std::int32_t rows[kLanes], columns[kLanes];
    float weights[4][kLanes], mixed[kLanes][kValues], each[kLanes];
    row.number.store(rows);
    column.number.store(columns);
    const FloatLanes left = 1.0f - column.place, upper = 1.0f - row.place;
    (upper * left).store(weights[0]);
    (upper * column.place).store(weights[1]);
    (row.place * left).store(weights[2]);
    (row.place * column.place).store(weights[3]);
    for (int i = 0; i < kLanes; ++i) {
      const float* const cell = azimuths_ + (std::size_t(rows[i]) * n_columns_ + columns[i]) * kValues;
      const float* const below = cell + std::size_t(n_columns_) * kValues;
      for (int k = 0; k < kValues; ++k)
        mixed[i][k] = (cell[k] * weights[0][i] + cell[kValues + k] * weights[1][i]) +
                      (below[k] * weights[2][i] + below[kValues + k] * weights[3][i]);
    }
    for (int k = 0; k < kValues; ++k) {
      for (int i = 0; i < kLanes; ++i) each[i] = mixed[i][k];
      found[k] = FloatLanes::load(each);
    }
  }

  /// Three values of a row, the first of them `first`.
  Vec3Lanes look_up(const Cell& row, int first) const {
    std::int32_t rows[kLanes];
    float upper[3 * kLanes], lower[3 * kLanes];
    row.number.store(rows);
    for (int i = 0; i < kLanes; ++i) {
      const float* const here = inclinations_ + std::size_t(rows[i]) * kRest + first;
      std::copy_n(here, 3, upper + 3 * i);
      std::copy_n(here + kRest, 3, lower + 3 * i);
    }
    return (1.0f - row.place) * Vec3Lanes::load(upper, kLanes) + row.place * Vec3Lanes::load(lower, kLanes);
  }

  const HairMaterial& material_;
  const float *azimuths_, *inclinations_;
  int n_rows_, n_columns_;
};

}  // namespace fastlines
