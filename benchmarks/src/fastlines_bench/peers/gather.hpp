// What all rays and beams of a gather share, in the layout that Python fills (peers/beam_loops.py).
#pragma once

namespace fastlines::peers {

/// The numbers of colours that a beam's power has.
inline constexpr int kColours = 3;

struct Gather {
  float radius;
  float sigma;       // extinction along the ray, per unit of length
  float line_sigma;  // extinction along the beam
  float g;           // the mean cosine of the phase function
  float t_min, t_max;
};

}  // namespace fastlines::peers
