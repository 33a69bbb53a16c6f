#include "axode/view.hpp"

#include <nanobind/stl/string.h>

#include <sstream>

#include "axode/model/configuration.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/long_call.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/text.hpp"
#include "python/bindings/trajectory.hpp"

/// Pages for a browser. Arguments are prepared and documented in the Python module axode.viewer.
namespace axode::python {

using namespace nb::literals;

namespace {

/// A point of contact from the 17 numbers by which a page describes it.
ContactForce contact_from(const double* x) {
  const auto vector = [&](int k) { return Vec3<>{x[k], x[k + 1], x[k + 2]}; };
  return {.a = static_cast<int>(x[0]),
          .b = static_cast<int>(x[1]),
          .point = vector(2),
          .normal = vector(5),
          .gap = x[8],
          .force = vector(9),
          .moment = vector(12),
          .friction = x[15],
          .branch = static_cast<LawBranch>(static_cast<int>(x[16]))};
}

/// Sets the contact points of a motion: those of an axode.Trajectory, or a tuple (names of shapes, points).
void set_contacts(nb::handle given, ShownMotion& motion) {
  if (const Trajectory* shown = shown_in(given)) {
    if (shown->contact_shapes.empty()) return;
    motion.contact_shapes = shown->contact_shapes;
    for (std::size_t k = 0; k < shown->size(); ++k) {
      const std::span<const ContactForce> contacts = shown->contacts(k);
      motion.contacts.emplace_back(contacts.begin(), contacts.end());
    }
    return;
  }
  const nb::tuple read = nb::borrow<nb::tuple>(given);
  for (const nb::handle name : read[0]) motion.contact_shapes.push_back(text_of(name));
  for (const nb::handle points : read[1]) {
    const Numbers numbers("motion.contacts", {points.ptr()});
    std::vector<ContactForce>& list = motion.contacts.emplace_back();
    for (nb::ssize_t k = 0; k < numbers.size(); k += 17) list.push_back(contact_from(numbers.data() + k));
  }
}

/// Sets the loads of a motion with coordinates q: axode.Loads with one wrench, or one for each time.
void set_loads(const BoundModel& m, ArrayLike q, nb::handle given, ShownMotion& motion) {
  const States states(m, q, 1, "motion.q");
  const AppliedLoads loads(states, {given.ptr()}, false);
  if (loads.count() == 0) return;
  for (std::size_t k = 0; k < states.count(); ++k)
    loads.with(
        k, [&](const Loads<>& now) { motion.loads.emplace_back(now.wrenches.begin(), now.wrenches.end()); });
}

/// The motion in a tuple (t, q, v, a, tau, contacts, loads). All but t, q and v may be None.
ShownMotion motion_from(const BoundModel& m, const nb::tuple& given) {
  const auto rows = [&](std::size_t k, const char* name, int width) {
    if (given[k].is_none()) return std::vector<double>{};
    const nb::object object = given[k];
    const Numbers numbers(name, {object.ptr()});
    const bool is_list = width == 0;
    if (numbers.axes() != (is_list ? 1 : 2) || (!is_list && !numbers.ends_with({width})))
      numbers.wrong_shape(is_list ? "(N,)" : "(N, " + std::to_string(width) + ")");
    return std::vector<double>(numbers.data(), numbers.data() + numbers.size());
  };
  ShownMotion motion{rows(0, "motion.t", 0), rows(1, "motion.q", m->nq()), rows(2, "motion.v", m->nv()),
                     rows(3, "motion.a", m->nv()), rows(4, "motion.tau", m->nv())};
  if (!given[5].is_none()) set_contacts(given[5], motion);
  if (const nb::object loads = given[6]; !loads.is_none()) {
    const nb::object q = given[1];
    set_loads(m, {q.ptr()}, loads, motion);
  }
  return motion;
}

nb::tuple page_of(const BoundModel& m, const std::string& empty_page, ArrayLike q, nb::handle motion,
                  const std::string& live) {
  const States state = one_state(m, q);
  SceneOptions options{.live = live};
  if (!motion.is_none()) options.motion = motion_from(m, nb::borrow<nb::tuple>(motion));
  std::ostringstream page;
  SceneContents contents;
  {
    const nb::gil_scoped_release released;
    contents = write_page(empty_page, m, state.q(0), page, options);
  }
  nb::list warnings, meshes;
  for (const std::string& warning : contents.warnings) warnings.append(to_str(warning));
  for (const SceneContents::Mesh& mesh : contents.meshes) meshes.append(to_str(mesh.file));
  return nb::make_tuple(to_str(std::move(page).str()), warnings, meshes);
}

}  // namespace

void add_view(nb::module_& module) {
  module.def(
      "first_configuration",
      [](const BoundModel& m) {
        LongCall call(true);
        const std::vector<double> q =
            first_configuration(*m, [monitor = call.monitor()] { return monitor(0, 0); });
        call.end();
        return to_array(q);
      },
      "m"_a, nb::sig("def first_configuration(m: Model) -> numpy.typing.NDArray[numpy.float64]"),
      "The configuration that a page shows first if no other is given; see axode.viewer.");
  module.def("viewer_page", &page_of, "m"_a, "empty_page"_a, "q"_a, "motion"_a.none(), "live"_a,
             nb::sig("def viewer_page(m: Model, empty_page: str, q: numpy.typing.ArrayLike, "
                     "motion: tuple[typing.Any, typing.Any, typing.Any, typing.Any, typing.Any, typing.Any, "
                     "typing.Any] | None, "
                     "live: str) -> tuple[str, list[str], list[str]]"),
             "The page of a scene, its warnings, and the files of its meshes; see axode.viewer.");
}

}  // namespace axode::python
