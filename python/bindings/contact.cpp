#include <nanobind/stl/optional.h>

#include <limits>
#include <optional>

#include "axode/contact.hpp"
#include "axode/view/mesh_hull.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/text.hpp"

/// Collision shapes and their distances.
namespace axode::python {
namespace {

using namespace nb::literals;

nb::list distances_of(const BoundModel& m, ArrayLike q, std::optional<double> margin) {
  const States states = one_state(m, q);
  Distances distances = states.released(1000, [&] {  // files of meshes may be read
    return Distances(m, ContactShapes(m, hull_of_mesh));
  });
  const std::span<const ShapeDistance> found =
      distances.evaluate(states.q(0), margin.value_or(std::numeric_limits<double>::infinity()));
  const std::size_t nv = static_cast<std::size_t>(m->nv());
  std::vector<double> J(found.size() * nv);
  distances.jacobian(J);
  nb::list all;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const ShapeDistance& d = found[k];
    all.append(named_tuple("axode.records", "ShapeDistance", to_str(distances.shapes()[d.a].name),
                           to_str(distances.shapes()[d.b].name), d.distance, to_array(d.normal),
                           to_array(d.point_a), to_array(d.point_b), d.residual, d.proved,
                           to_array(std::span<const double>(J).subspan(k * nv, nv))));
  }
  return all;
}

}  // namespace

void add_contact(nb::module_& module) {
  module.def("distances", &distances_of, "m"_a, "q"_a, "margin"_a = nb::none(),
             nb::sig("def distances(m: Model, q: numpy.typing.ArrayLike, margin: float | None = None) -> "
                     "list[axode.records.ShapeDistance]"),
             R"(
Signed distances of the collision shapes that may touch, at q (nq,), where they are less than `margin` (m; None: all), see `ShapeDistance`.

Each has its nearest points, a certificate and its exact Jacobian. ValueError for a shape that cannot touch, such as a mesh
without a hull.

>>> ball = {"kind": "sphere", "role": "collision", "radius": 0.1}
>>> slider = axode.Model.from_dict({"format": "axode drawing 1", "shape": [ball], "body": [{
...     "name": "slide", "joint": {"kind": "prismatic", "axis": "x"}, "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1],
...     "shape": [ball]}]})
>>> [near] = axode.distances(slider, [0.5])
>>> near.a, near.b, round(near.distance, 12), near.jacobian
('ground shape 1', 'slide shape 1', 0.3, array([1.]))
)");
}

}  // namespace axode::python
