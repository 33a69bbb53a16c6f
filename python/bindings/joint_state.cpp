#include "axode/constraints/absolute/joint_state.hpp"

#include <nanobind/stl/string.h>

#include <optional>

#include "axode/lie/representation_change.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

/// The state of the joints from the poses and twists of all frames, or of the ground and the bodies only.
nb::object joint_state_of(const BoundModel& m, ArrayLike given_C, ArrayLike given_V,
                          Representation representation, nb::handle near) {
  const Numbers C("C", given_C), V("V", given_V);
  const nb::ssize_t bodies = m->n_bodies() + 1, frames = C.axes() == 3 ? C.length(0) : 0;
  const std::string expected = std::to_string(bodies) + " bodies, the ground first, or all " +
                               std::to_string(m->n_frames()) + " frames";
  if (C.axes() != 3 || !C.ends_with({4, 4}) || (frames != bodies && frames != m->n_frames()))
    C.wrong_shape("(N, 4, 4), poses of " + expected);
  if (V.axes() != 2 || !V.ends_with({frames, 6}))
    V.wrong_shape("(" + std::to_string(frames) + ", 6), a twist for each pose");
  std::vector<SE3<>> poses;
  std::vector<Twist<BodyFixed>> twists;
  for (nb::ssize_t i = 0; i < bodies; ++i) {
    poses.push_back(pose_from("C[" + std::to_string(i) + "]", C.data() + 16 * i));
    const double* const at = V.data() + 6 * i;
    with_representation(representation, [&](auto rep) {
      const Twist<decltype(rep)> X{vector_from(at), vector_from(at + 3)};
      twists.push_back(change<BodyFixed>(poses.back(), X));
    });
  }
  std::optional<States> around;
  if (!near.is_none()) around.emplace(one_state(m, {near.ptr()}));
  const JointState found = joint_state(m, poses, twists, around ? around->q(0) : std::span<const double>());
  return record("JointState", to_array(found.q), to_array(found.v), found.position_residual,
                found.velocity_residual);
}

}  // namespace

void add_joint_state(nb::module_& module) {
  module.def(
      "joint_state", &joint_state_of, "m"_a, "C"_a, "V"_a, "representation"_a = "body", "near"_a = nb::none(),
      nb::sig(
          "def joint_state(m: Model, C: numpy.typing.ArrayLike, V: numpy.typing.ArrayLike, representation: "
          "typing.Literal['body', 'spatial', 'hybrid', 'mixed'] = 'body', near: numpy.typing.ArrayLike | "
          "None = "
          "None) -> axode.records.JointState"),
      R"(
The state (q, v) of the joints whose bodies have poses C and twists V, with the residuals of the joints: see
`JointState`.

C (n, 4, 4) and V (n, 6) are those of the ground and all bodies, or of all frames; the function is the inverse of
`poses` and `twists`. Angles are those nearest to `near` (nq,), or to the neutral configuration if it is left out.
O(n).

>>> q, v = np.full(7, 0.5), np.ones(7)
>>> found = axode.joint_state(arm, axode.poses(arm, q), axode.twists(arm, q, v))
>>> found.q.round(9), bool(found.position_residual < 1e-12)
(array([0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]), True)
)");
}

}  // namespace axode::python
