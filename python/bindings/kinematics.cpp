#include "axode/kinematics.hpp"

#include "axode/batch.hpp"
#include "bindings.hpp"
#include "choice.hpp"
#include "conversions.hpp"
#include "states.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

Array poses_of(const BoundModel& m, ArrayLike q, int threads) {
  const States states(m, q, threads);
  const std::size_t frames = static_cast<std::size_t>(m->n_frames());
  NewArray out = states.result({m->n_frames(), 4, 4});
  std::vector<SE3<>> C(states.count() * frames);
  states.unlocked(linear_cost(m), [&] {
    batch::poses<double>(m, states.q(), C, states.threads());
    for (std::size_t k = 0; k < C.size(); ++k) write(C[k], out.data() + 16 * k);
  });
  return out.array();
}

Array twists_of(const BoundModel& m, ArrayLike q, ArrayLike v, Representation representation, int threads) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v);
  NewArray out = states.result({m->n_frames(), 6});
  with_representation(representation, [&](auto rep) {
    using Rep = decltype(rep);
    states.each(linear_cost(m), [&](Workspace<>& workspace, std::size_t k) {
      twists<Rep>(m, workspace, states.q(k), velocities[k], screws_of<Twist<Rep>>(out, k, m->n_frames()));
    });
  });
  return out.array();
}

}  // namespace

void add_kinematics(nb::module_& module) {
  module.def("poses", &poses_of, "m"_a, "q"_a, nb::kw_only(), "threads"_a = 1, R"(
C_i, the pose of every frame in the inertial frame, shape (n_frames, 4, 4) or (N, n_frames, 4, 4), m (eqs. POEX, aVbRec2).

In the order of `m.frame_names`. O(n).

>>> C = axode.poses(arm, arm.neutral())
>>> C[arm.frame_names.index("flange")][:3, 3]
array([0.   , 0.   , 1.266])
)");
  module.def("twists", &twists_of, "m"_a, "q"_a, "v"_a, "representation"_a = "body", nb::kw_only(),
             "threads"_a = 1, R"(
V_i, the twist of every frame, shape (n_frames, 6) or (N, n_frames, 6): angular (rad/s), then linear (m/s).

body: axes of the frame, about its origin; spatial: inertial axes, about the inertial origin; hybrid: inertial axes,
about the frame's origin; mixed: angular part in the frame's axes, linear part in inertial axes (eqs. VbRec, Vsrec,
VhRec). In the order of `m.frame_names`. O(n).

>>> V = axode.twists(arm, arm.neutral(), np.ones(7), "hybrid")
>>> V.shape
(9, 6)
)");
}

}  // namespace axode::python
