#include "axode/constraints/prescribed/motion_function.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "axode/constraints/prescribed/quintic_spline.hpp"

namespace axode {
namespace {

MotionFunction::Function harmonic(const MotionDescription& d) {
  return [offset = d.offset, amplitude = d.amplitude, w = 2 * std::numbers::pi * d.frequency,
          phase = d.phase](double t) {
    const double sine = amplitude * std::sin(w * t + phase), cosine = amplitude * std::cos(w * t + phase);
    return MotionValue{offset + sine, w * cosine, -w * w * sine, -w * w * w * cosine};
  };
}

/// The ramp from + (to - from) (10 u³ - 15 u⁴ + 6 u⁵), u = (t - start) / (end - start) limited to 0 to 1.
MotionFunction::Function ramp(const MotionDescription& d) {
  return [from = d.from, rise = d.to - d.from, start = d.start, length = d.end - d.start](double t) {
    const double u = std::clamp((t - start) / length, 0.0, 1.0), rest = 1 - u;
    return MotionValue{from + rise * u * u * u * (10 + u * (6 * u - 15)),
                       rise * 30 * u * u * rest * rest / length,
                       rise * 60 * u * rest * (1 - 2 * u) / (length * length),
                       u > 0 && u < 1 ? rise * (60 - 360 * u * rest) / (length * length * length) : 0};
  };
}

/// A polynomial in t. Horner's scheme computes its value and its Taylor coefficients up to order 3 at t.
MotionFunction::Function polynomial(const MotionDescription& d) {
  return [coefficients = d.coefficients](double t) {
    double c_0 = 0, c_1 = 0, c_2 = 0, c_3 = 0;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {
      c_3 = c_3 * t + c_2;
      c_2 = c_2 * t + c_1;
      c_1 = c_1 * t + c_0;
      c_0 = c_0 * t + *c;
    }
    return MotionValue{c_0, c_1, 2 * c_2, 6 * c_3};
  };
}

MotionFunction::Function samples(const MotionDescription& d) {
  return [spline = QuinticSpline(d.times, d.values)](double t) {
    return MotionValue{spline.derivative(0, t), spline.derivative(1, t), spline.derivative(2, t),
                       spline.derivative(3, t)};
  };
}

}  // namespace

MotionFunction::MotionFunction(const MotionDescription& description) {
  switch (description.kind) {
    case MotionDescription::Kind::harmonic: function_ = harmonic(description); break;
    case MotionDescription::Kind::ramp:
      function_ = ramp(description);
      jumps_ = {description.start, description.end};
      break;
    case MotionDescription::Kind::polynomial: function_ = polynomial(description); break;
    case MotionDescription::Kind::samples:
      function_ = samples(description);
      begin_ = description.times.front();
      end_ = description.times.back();
      break;
  }
}

}  // namespace axode
