#include "axode/codegen/c/c_sine_cosine.hpp"

#include "axode/scalar/sine_cosine.hpp"

namespace axode::codegen {
namespace {

constexpr const char* sine_cosine_loop =
    R"(/* Sines and cosines without a branch, so that several are computed at once: x = m pi/2 + r + low with
   pi/2 in parts whose products with m are exact, and polynomials in r. The error is below 2 units in the
   last place for |x| <= 1e5@BEYOND@. */
static void @NAME@(
    const @T@ *AXODE_RESTRICT angle, @T@ *AXODE_RESTRICT sine, @T@ *AXODE_RESTRICT cosine, int count) {
  int k@LARGE@;
  for (k = 0; k < count; ++k) {
    const double x = (double)angle[k], m = (x * @TWO_OVER_PI@ + @ROUNDER@) - @ROUNDER@;
    const double u = x - m * @PART_0@, m1 = m * @PART_1@, m2 = m * @PART_2@;
    const double u1 = u - m1, u2 = u1 - m2;
    const double rest = (((u - u1) - m1) + ((u1 - u2) - m2)) - m * @PART_3@;
    const @T@ quadrant = (@T@)(m - 4.0 * ((m * 0.25 + @ROUNDER@) - @ROUNDER@));
    const @T@ r = (@T@)u2, low = (@T@)rest, z = r * r, half = @0.5@ * z, c = @1@ - half;
    const @T@ p = @SINE@;
    const @T@ g = @COSINE@;
    const @T@ s1 = r + (r * z * p + low * c), c1 = c + (((@1@ - c) - half) + (z * z * g - r * low));
    const int odd = quadrant * quadrant == @1@;
    const @T@ s2 = odd ? c1 : s1, c2 = odd ? s1 : c1;
    sine[k] = ((quadrant < -@0.5@) | (quadrant > @1.5@)) ? -s2 : s2;
    cosine[k] = ((quadrant > @0.5@) | (quadrant < -@1.5@)) ? -c2 : c2;
@LOOK@  }
@MEND@}
)";

constexpr const char* turn_in_lanes = R"(#if AXODE_LANES > 1
static void @NAME@_lanes(
    const axode_lanes *AXODE_RESTRICT angle, axode_lanes *AXODE_RESTRICT sine,
    axode_lanes *AXODE_RESTRICT cosine, int count) {
  axode_mask large = {0};
  int k, l, any = 0;
  for (k = 0; k < count; ++k) {
    const axode_lanes x = angle[k], n = x * @TWO_OVER_PI@ + @ROUNDER@, m = n - @ROUNDER@;
    const axode_lanes u = x - m * @PART_0@, m1 = m * @PART_1@, m2 = m * @PART_2@;
    const axode_lanes u1 = u - m1, r = u1 - m2;
    const axode_lanes low = (((u - u1) - m1) + ((u1 - r) - m2)) - m * @PART_3@;
    const axode_lanes z = r * r, half = 0.5 * z, c = 1.0 - half;
    const axode_lanes p = @SINE@;
    const axode_lanes g = @COSINE@;
    const axode_lanes s1 = r + (r * z * p + low * c), c1 = c + (((1.0 - c) - half) + (z * z * g - r * low));
    const axode_mask quadrant = (axode_mask)n, odd = -(quadrant & 1);
    sine[k] = (axode_lanes)((axode_mask)axode_select(odd, c1, s1) ^ ((quadrant & 2) << 62));
    cosine[k] = (axode_lanes)((axode_mask)axode_select(odd, s1, c1) ^ (((quadrant + 1) & 2) << 62));
    large |= (axode_mask)(x > 1e5) | (axode_mask)(x < -1e5);
  }
  for (l = 0; l < AXODE_LANES; ++l) any |= large[l] != 0;
  for (k = 0; any && k < count; ++k)
    for (l = 0; l < AXODE_LANES; ++l)
      if (angle[k][l] > 1e5 || angle[k][l] < -1e5) {
        sine[k][l] = sin(angle[k][l]);
        cosine[k][l] = cos(angle[k][l]);
      }
}
#endif
)";
/// C code of a function NAME_lanes that computes sines and cosines for the states in all SIMD lanes, in
/// single precision. It calls the generated function NAME for an array of angles (see c_sine_cosine()),
/// because NAME reduces angles in double precision; the vector types of single precision cannot do so.
constexpr const char* turn_one_by_one = R"(#if AXODE_LANES > 1
static void @NAME@_lanes(
    const axode_lanes *AXODE_RESTRICT angle, axode_lanes *AXODE_RESTRICT sine,
    axode_lanes *AXODE_RESTRICT cosine, int count) {
  @NAME@((const @T@ *)angle, (@T@ *)sine, (@T@ *)cosine, count * AXODE_LANES);
}
#endif
)";

std::string with_constants(std::string text, const std::string& name, const Precision& precision) {
  namespace reduced = reduced_angle;
  const auto polynomial = [&](const auto& c) {
    std::string sum = precision.literal(c[std::size(c) - 1]);
    for (std::size_t k = std::size(c) - 1; k-- > 0;)
      sum.insert(0, 1, '(').append(" * z + ").append(precision.literal(c[k])).append(1, ')');
    return sum;
  };
  const auto number = [](double x) { return Precision{false}.literal(x); };
  return filled(std::move(text), {{"NAME", name},
                                  {"T", precision.type()},
                                  {"TWO_OVER_PI", number(reduced::two_over_pi)},
                                  {"ROUNDER", number(reduced::rounder)},
                                  {"PART_0", number(reduced::part[0])},
                                  {"PART_1", number(reduced::part[1])},
                                  {"PART_2", number(reduced::part[2])},
                                  {"PART_3", number(reduced::part[3])},
                                  {"SINE", precision.single ? polynomial(reduced::sine<float>)
                                                            : polynomial(reduced::sine<double>)},
                                  {"COSINE", precision.single ? polynomial(reduced::cosine<float>)
                                                              : polynomial(reduced::cosine<double>)},
                                  {"0.5", precision.literal(0.5)},
                                  {"1", precision.literal(1)},
                                  {"1.5", precision.literal(1.5)}});
}

}  // namespace

std::string c_sine_cosine(const std::string& name, const Precision& precision, Angles angles) {
  const bool all = angles == Angles::all;
  return with_constants(
      filled(sine_cosine_loop, {{"LARGE", all ? ", large = 0" : ""},
                                {"BEYOND", all ? "; larger angles are left to the library of C" : ""},
                                {"LOOK", all ? "    large |= (x > 1e5) | (x < -1e5);\n" : ""},
                                {"MEND", all ? R"(  if (large)
    for (k = 0; k < count; ++k)
      if (angle[k] > 1e5 || angle[k] < -1e5) {
        sine[k] = (@T@)sin(angle[k]);
        cosine[k] = (@T@)cos(angle[k]);
      }
)"
                                             : ""}}),
      name, precision);
}

std::string c_sine_cosine_in_lanes(const std::string& name, const Precision& precision) {
  return with_constants(precision.single ? turn_one_by_one : turn_in_lanes, name, precision);
}

}  // namespace axode::codegen
