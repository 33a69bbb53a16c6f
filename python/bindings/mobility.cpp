#include "axode/constraints/local_mobility/local_mobility.hpp"

#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

nb::list texts(const std::vector<std::string>& all) {
  nb::list list;
  for (const std::string& text : all) list.append(to_str(text));
  return list;
}
nb::list texts(const std::vector<std::string>& all, const std::vector<int>& which) {
  nb::list list;
  for (const int k : which) list.append(to_str(all[static_cast<std::size_t>(k)]));
  return list;
}
nb::list integers(const std::vector<int>& all) {
  nb::list list;
  for (const int k : all) list.append(k);
  return list;
}
std::vector<std::string> names_of(const std::vector<ClosureCoordinate>& coordinates) {
  std::vector<std::string> names;
  for (const ClosureCoordinate& coordinate : coordinates) names.push_back(coordinate.name);
  return names;
}

nb::object branch_of(const MotionBranch& branch, const std::vector<std::string>& coordinates,
                     const std::vector<std::string>& loops) {
  const int D = branch.dimension;
  nb::list points;
  for (const BranchPoint& point : branch.points)
    points.append(record("BranchPoint", to_array(point.parameter), to_array(point.x), to_array(point.q),
                         point.residual));
  nb::object II = nb::none();
  if (branch.II.size() > 0)
    II = to_array(branch.II).array.attr("reshape")(D, D, static_cast<int>(coordinates.size()));
  nb::object series = nb::none();
  if (branch.series.size() > 0) series = to_array(branch.series).array;
  return record("MotionBranch", D, branch.power, to_array(branch.T), II, series, branch.settled,
                branch.closes, branch.multiple, branch.differential_mobility_beside,
                texts(coordinates, branch.dead), texts(coordinates, branch.idle), texts(loops, branch.loops),
                points, to_array(branch.residual_orders));
}

nb::object local_mobility_of(const BoundModel& m, ArrayLike q, int order, double length) {
  const States state = one_state(m, q);
  const LocalMobility found = state.unlocked(100000, [&](const batch::Monitor& monitor) {
    return local_mobility(m, state.q(0),
                          {.order = order, .length = length, .monitor = [&] { return monitor(0, 0); }});
  });
  const std::vector<std::string> names = names_of(found.coordinates);
  std::vector<int> velocities;
  for (const ClosureCoordinate& coordinate : found.coordinates) velocities.push_back(coordinate.velocity);
  nb::list branches, conditions;
  for (const MotionBranch& branch : found.branches) branches.append(branch_of(branch, names, found.loops));
  for (const MobilityCondition& condition : found.conditions)
    conditions.append(nb::make_tuple(condition.degree, texts(found.loops, condition.loops)));
  return record(
      "LocalMobility", texts(mobility_words(*m, found)), found.local_mobility, found.differential_mobility,
      integers(found.mobility_by_order), found.settled, found.settled_at_order, found.rigid_at_order,
      branches, conditions, texts(names), integers(velocities), integers(found.outside), texts(found.loops),
      found.order, found.length, found.equations, found.rank, found.smallest_kept, found.largest_dropped,
      found.decided_by_rank, nb::make_tuple(found.probe.starts, found.probe.closed, found.probe.missed));
}

Array closure_derivatives_of(const BoundModel& m, ArrayLike q, ArrayLike derivatives) {
  const States state = one_state(m, q);
  const Numbers numbers("derivatives", derivatives);
  const auto n = static_cast<nb::ssize_t>(closure_coordinates(m).size());
  if (numbers.axes() != 2 || !numbers.ends_with({n}))
    numbers.wrong_shape("(K, " + std::to_string(n) + "), a row for each order");
  const nb::ssize_t K = numbers.length(0);
  const Eigen::Map<const Eigen::MatrixXd> x(numbers.data(), n, K);
  const std::vector<Eigen::MatrixXd> H = closure_derivatives(m, state.q(0), x);
  NewArray out({static_cast<nb::ssize_t>(H.size()), K, 6});
  double* to = out.data();
  for (const Eigen::MatrixXd& of_loop : H) to = std::copy_n(of_loop.data(), of_loop.size(), to);
  return out.array();
}

}  // namespace

void add_mobility(nb::module_& module) {
  module.def(
      "local_mobility", &local_mobility_of, "m"_a, "q"_a, nb::kw_only(), "order"_a = 0, "length"_a = 0.0,
      nb::sig("def local_mobility(m: Model, q: numpy.typing.ArrayLike, *, order: int = 0, length: float "
              "= 0.0) -> axode.records.LocalMobility"),
      R"(
What a mechanism with loops can do at a closed q (nq,): mobility by order, branches, cusps, shakiness, see `LocalMobility`.

The closures of the loops are expanded to `order` by brackets of joint screws; 0 chooses the order, and raises it while nothing
is settled. `length` (m) is what lengths are divided by before they are compared with angles, 0 for the mean distance between
two joints. About 1 ms for a loop of six joints. ValueError for a q that leaves a loop open, and for rolling contacts and belts.

>>> found = axode.local_mobility(fourbar, fourbar.neutral())
>>> found.words[0], found.mobility_by_order[:3], len(found.branches)
('regular', [1, 1, 1], 1)
>>> bool(np.allclose(axode.loop_jacobian(fourbar, fourbar.neutral()) @ found.branches[0].T[0, : fourbar.nv], 0))
True
)");
  module.def(
      "closure_coordinates", [](const BoundModel& m) { return texts(names_of(closure_coordinates(m))); },
      "m"_a, nb::sig("def closure_coordinates(m: Model) -> list[str]"),
      R"(
The coordinates of the closure of the loops: velocities of joints in loops, then those of the loop joints.

>>> axode.closure_coordinates(fourbar)
['crank_joint', 'coupler_joint', 'rocker_joint', 'pin']
)");
  module.def("closure_derivatives", &closure_derivatives_of, "m"_a, "q"_a, "derivatives"_a,
             R"(
Constraints of higher order: time derivatives 0 to K - 1 of the twist of the last body of every loop, (loops, K, 6).

They belong to a curve x(t) from q with the `derivatives` x', x'', ... (K, n) of the coordinates `closure_coordinates(m)`, and
vanish along motions of the mechanism. Spatial twists about the inertial origin, angular before linear, rad and m. O(n K^2).

>>> still = axode.local_mobility(fourbar, fourbar.neutral()).branches[0].series
>>> bool(np.allclose(axode.closure_derivatives(fourbar, fourbar.neutral(), [still[:, 1], 2 * still[:, 2]]), 0))
True
)");
}

}  // namespace axode::python
