#include "axode/constraints/loops.hpp"

#include "axode/constraints/check_loops.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
LoopWorkspace<T>::LoopWorkspace(const Model& model) : system_(std::make_unique<LoopSystem<T>>(model)) {}
template <class T> LoopWorkspace<T>::~LoopWorkspace() = default;
template <class T>
LoopWorkspace<T>::LoopWorkspace(const LoopWorkspace& other) : LoopWorkspace(other.system_->model()) {}
template <class T> LoopWorkspace<T>& LoopWorkspace<T>::operator=(const LoopWorkspace& other) {
  return *this = LoopWorkspace(other);
}
template <class T> LoopWorkspace<T>::LoopWorkspace(LoopWorkspace&&) noexcept = default;
template <class T> LoopWorkspace<T>& LoopWorkspace<T>::operator=(LoopWorkspace&&) noexcept = default;

template <class T> LoopSystem<T>& LoopWorkspace<T>::system(const Model& model) {
  if (&model.loops() != &system_->model().loops())
    throw std::invalid_argument(
        "loop workspace: it was made for another model than \"" + model.name() +
        "\"; copies of one model share their workspaces, but a model that is built again needs its own");
  return *system_;
}

template <class T>
void loop_residual(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> r) {
  LoopSystem<T>& system = checked(model, workspace, q);
  check_rows("r", r.size(), model.loops().residuals, "loops().residuals");
  check_separate("r", r, "q", q);
  system.update_kinematics(q.data());
  system.residual(q.data(), r.data());
}

template <class T>
void loop_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> A) {
  LoopSystem<T>& system = checked(model, workspace, q);
  check_rows("A", A.size(), model.loops().rows, "loops().rows * nv", model.nv());
  system.update_kinematics(q.data());
  system.make_rows(ConstraintLevel::velocity);
  system.write(A.data());
}

template <class T>
void loop_residual_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                            std::type_identity_t<std::span<T>> R) {
  LoopSystem<T>& system = checked(model, workspace, q);
  check_rows("R", R.size(), model.loops().residuals, "loops().residuals * nv", model.nv());
  system.update_kinematics(q.data());
  system.make_rows(ConstraintLevel::position);
  system.write(R.data());
}

template <class T>
void loop_hessian_product(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                          Numbers<T> w, std::type_identity_t<std::span<T>> product) {
  LoopSystem<T>& system = checked(model, workspace, q);
  check_rows("lambda", lambda.size(), model.loops().residuals, "loops().residuals");
  check_rows("w", w.size(), model.nv(), "nv");
  check_rows("product", product.size(), model.nv(), "nv");
  check_separate("product", product, "lambda", lambda);
  std::vector<T> h(w.size());
  system.move(q.data(), w.data(), {}, h.data());
  system.differentiate_residuals(lambda.data(), product.data());
}

template <class T>
void loop_bias(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
               std::type_identity_t<std::span<T>> gamma) {
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_rows("gamma", gamma.size(), model.loops().rows, "loops().rows");
  std::vector<T> h(v.size());
  system.move(q.data(), v.data(), {}, h.data());
  system.bias(gamma.data());
}

template class LoopWorkspace<AXODE_T>;
template AXODE_ENTRY decltype(loop_residual<AXODE_T>) loop_residual<AXODE_T>;
template AXODE_ENTRY decltype(loop_jacobian<AXODE_T>) loop_jacobian<AXODE_T>;
template AXODE_ENTRY decltype(loop_residual_jacobian<AXODE_T>) loop_residual_jacobian<AXODE_T>;
template AXODE_ENTRY decltype(loop_hessian_product<AXODE_T>) loop_hessian_product<AXODE_T>;
template AXODE_ENTRY decltype(loop_bias<AXODE_T>) loop_bias<AXODE_T>;

}  // namespace axode
