#include <algorithm>
#include <array>

#include "axode/integration.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"

/// Poses from twists. Arguments are prepared and documented in the Python module axode.simulation.
namespace axode::python {

using namespace nb::literals;

namespace {

enum class Reconstruction { munthe_kaas, cayley, magnus, apart };

Reconstruction reconstruction(nb::handle method) {
  constexpr std::array<std::string_view, 4> words{"munthe_kaas", "cayley", "magnus", "apart"};
  return static_cast<Reconstruction>(choose("method", method, words));
}

/// The times at which a method of reconstruction reads the twist, as fractions of a step.
std::vector<double> stage_times(int order, nb::handle method) {
  if (reconstruction(method) != Reconstruction::magnus) return runge_kutta(order).c;
  if (order != 4) throw nb::value_error("order: Magnus' method is of order 4");
  return {magnus_points.begin(), magnus_points.end()};
}

Array reconstruct_of(ArrayLike C0, ArrayLike twists, ArrayLike times, Representation representation,
                     int order, nb::handle given_method) {
  const Numbers start("C0", C0), V("twist", twists), t("times", times);
  if (start.axes() != 2 || !start.ends_with({4, 4})) start.wrong_shape("(4, 4), a pose");
  const Reconstruction way = reconstruction(given_method);
  const std::size_t stages = stage_times(order, given_method).size(), N = static_cast<std::size_t>(t.size());
  const Shape expected{static_cast<nb::ssize_t>(N > 0 ? N - 1 : 0), static_cast<nb::ssize_t>(stages), 6};
  if (V.axes() != 3 || !V.ends_with(expected)) V.wrong_shape(expected.text());
  std::size_t asked = 0;
  const auto next = [&]<class Rep>(Rep) {
    const double* x = V.data() + 6 * asked++;
    return Twist<Rep>{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
  };
  const std::span<const double> at(t.data(), N);
  const SE3<> C = pose_from("C0", start.data());
  const auto by = [&]<class Rep>(Rep rep) {
    const auto twist = [&](double) { return next(rep); };
    if (way == Reconstruction::magnus) return reconstruct_magnus<Rep>(C, twist, at);
    const Tableau& method = runge_kutta(order);
    if (way == Reconstruction::apart) return reconstruct_apart<Rep>(C, twist, at, method);
    return reconstruct<Rep>(
        C, twist, at, method,
        way == Reconstruction::cayley ? LocalCoordinates::cayley : LocalCoordinates::exponential);
  };
  std::vector<SE3<>> found;
  if (representation == Representation::body)
    found = by(BodyFixed{});
  else if (representation == Representation::spatial)
    found = by(Spatial{});
  else
    throw nb::value_error("representation must be 'body' or 'spatial' to integrate a twist to a pose");
  NewArray out({static_cast<nb::ssize_t>(N), 4, 4});
  for (std::size_t k = 0; k < N; ++k) write(found[k], out.data() + 16 * k);
  return out.array();
}

}  // namespace

void add_reconstruction(nb::module_& module) {
  module.def("reconstruct_poses", &reconstruct_of, "C0"_a, "twists"_a, "times"_a, "representation"_a,
             "order"_a, "method"_a, "See axode.reconstruct.");
  module.def(
      "stage_times", [](int order, nb::handle method) { return to_array(stage_times(order, method)); },
      "order"_a, "method"_a, "Stage times of a method as parts of a step, from 0 to 1.");
}

}  // namespace axode::python
