#include "axode/kinematics/jacobian.hpp"

#include "axode/fast/jacobians.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/lie/representation_change.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionRepresentation Rep, class T>
void jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
              const std::type_identity_t<Place<T>>& given, std::type_identity_t<std::span<Twist<Rep, T>>> J) {
  checked<"jacobian">(model, workspace, q, J);
  const Place<T> place = found(model, given);
  for (Twist<Rep, T>& column : J) column = {};
  // The pose of the place is known only at the end of the walk, so that the columns remain in body-fixed
  // representation until then.
  const SE3<T> C =
      each_body_fixed_column(model.tree<T>(), q.data(), place, [&](int, int c, const Screw<T>& X) {
        J[c].w += X.w;
        J[c].v += X.v;
      });
  if constexpr (!std::same_as<Rep, BodyFixed>)
    for (Twist<Rep, T>& column : J) column = change<Rep>(C, Twist<BodyFixed, T>{column.w, column.v});
}

template <RecursionRepresentation Rep, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<Twist<Rep, T>>> J) {
  Arena arena = checked<"jacobians">(model, workspace, q, J);
  const Tree<T>& tree = model.tree<T>();
  const std::size_t nv = static_cast<std::size_t>(tree->nv);
  FastJacobians<T> of(arena);
  of.template run<Rep>(tree, q.data());
  for (std::size_t f = 0; f < tree->frame_body.size(); ++f)
    of.write(tree, tree->frame_body[f], tree.frame_offset[f], J.data() + f * nv);
}

template <RecursionRepresentation Rep, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<const Place<T>>> places,
               std::type_identity_t<std::span<Twist<Rep, T>>> J) {
  check_state(model, workspace, q);
  const Tree<T>& tree = model.tree<T>();
  const std::size_t nv = static_cast<std::size_t>(tree->nv);
  check_size("J", J.size(), places.size() * nv, "nv for each place");
  check_separate("J", J, "q", q);
  Arena arena = workspace.arena(model.topology());
  FastJacobians<T> of(arena);
  of.template run<Rep>(tree, q.data());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Place<T> place = found(model, places[k]);
    of.write(tree, tree->frame_body[place.frame], tree.frame_offset[place.frame] * place.offset,
             J.data() + k * nv);
  }
}

template <RecursionRepresentation Rep, class T>
std::size_t jacobian_columns(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& given,
                             std::type_identity_t<std::span<JacobianColumn<Rep, T>>> columns) {
  check_state(model, workspace, q);
  const Place<T> place = found(model, given);
  check_separate("columns", columns, "q", q);
  const Tree<T>& tree = model.tree<T>();
  std::size_t count = 0;
  for (int i = tree->frame_body[place.frame]; i > 0; i = tree->parent[i])
    count += static_cast<std::size_t>(tree->first_screw[i + 1] - tree->first_screw[i]);
  if (columns.size() < count)
    throw std::invalid_argument("columns has " + std::to_string(columns.size()) +
                                " entries; the path to the place has " + std::to_string(count) +
                                " joint screws");
  std::size_t k = 0;
  const SE3<T> C = each_body_fixed_column(tree, q.data(), place, [&](int, int c, const Screw<T>& X) {
    columns[k++] = {c, {X.w, X.v}};
  });
  if constexpr (!std::same_as<Rep, BodyFixed>)
    for (k = 0; k < count; ++k)
      columns[k].J = change<Rep>(C, Twist<BodyFixed, T>{columns[k].J.w, columns[k].J.v});
  return count;
}

template <RecursionRepresentation Rep, class T>
void relative_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& given,
                       const std::type_identity_t<Place<T>>& given_base,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J) {
  checked<"relative_jacobian">(model, workspace, q, J);
  const Place<T> place = found(model, given);
  const Place<T> base = found(model, given_base);
  const Tree<T>& tree = model.tree<T>();
  for (Twist<Rep, T>& column : J) column = {};
  // Joints that move both places in the same way do not contribute to the relative motion.
  const int common = common_predecessor(tree, tree->frame_body[base.frame], tree->frame_body[place.frame]);
  // The screws of the observer come first. They contribute with the opposite sign.
  const auto subtract = [&](int, int c, const Screw<T>& X) {
    J[c].w -= X.w;
    J[c].v -= X.v;
  };
  const SE3<T> C_base = each_body_fixed_column(tree, q.data(), base, subtract, common);
  const SE3<T> C_place = each_body_fixed_column(
      tree, q.data(), place, [](int, int, const Screw<T>&) {}, common);
  const SE3<T> C = inverse(C_base) * C_place;
  for (Twist<Rep, T>& column : J) {
    const Screw<T> X = Ad_inv(C, Screw<T>{column.w, column.v});
    column = {X.w, X.v};
  }
  const auto add = [&](int, int c, const Screw<T>& X) {
    J[c].w += X.w;
    J[c].v += X.v;
  };
  each_body_fixed_column(tree, q.data(), place, add, common);
  if constexpr (!std::same_as<Rep, BodyFixed>)
    for (Twist<Rep, T>& column : J) column = change<Rep>(C, Twist<BodyFixed, T>{column.w, column.v});
}

template AXODE_ENTRY decltype(jacobian<AXODE_REP, AXODE_T>) jacobian<AXODE_REP, AXODE_T>;
template AXODE_ENTRY void jacobians<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                               std::span<Twist<AXODE_REP, AXODE_T>>);
template AXODE_ENTRY void jacobians<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                               std::span<const Place<AXODE_T>>,
                                               std::span<Twist<AXODE_REP, AXODE_T>>);
template AXODE_ENTRY decltype(jacobian_columns<AXODE_REP, AXODE_T>) jacobian_columns<AXODE_REP, AXODE_T>;
template AXODE_ENTRY decltype(relative_jacobian<AXODE_REP, AXODE_T>) relative_jacobian<AXODE_REP, AXODE_T>;

}  // namespace axode
