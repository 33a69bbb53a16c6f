#include "axode/constraints/constrained_dynamics.hpp"

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/independent_rows.hpp"
#include "axode/dynamics/check_loads.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {
namespace {

/// Room for multipliers where the caller gives none.
template <class T> class Multipliers {
 public:
  Multipliers(const Model& model, const char* name, std::span<T> given) : given_(given) {
    if (given.empty()) {
      own_.resize(static_cast<std::size_t>(model.loops().rows));
    } else {
      check_rows(name, given.size(), model.loops().rows, "loops().rows");
    }
  }
  T* data() { return given_.empty() ? own_.data() : given_.data(); }

 private:
  std::span<T> given_;
  std::vector<T> own_;
};

std::vector<int> driven(const Model& model, std::span<const int> drives) {
  if (!drives.empty()) {
    for (const int c : drives)
      if (c < 0 || c >= model.nv())
        throw std::invalid_argument("drives holds " + std::to_string(c) + "; velocities are 0 to " +
                                    std::to_string(model.nv() - 1));
    return {drives.begin(), drives.end()};
  }
  std::vector<int> all;
  for (int c = 0; c < model.nv(); ++c)
    if (model.loops().driven[static_cast<std::size_t>(c)]) all.push_back(c);
  return all;
}

}  // namespace

template <class T>
Solvability forward_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             std::type_identity_t<std::span<T>> lambda,
                             const std::type_identity_t<Loads<T>>& loads) {
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("tau", tau.size(), v.size(), "nv");
  check_size("a", a.size(), v.size(), "nv");
  check_loads(model, loads);
  check_separate("lambda", lambda, "a", a);
  return system.accelerate(q.data(), v.data(), tau.data(), loads, a.data(),
                           Multipliers<T>(model, "lambda", lambda).data());
}

template <class T>
T inverse_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<T>> tau, std::type_identity_t<std::span<T>> lambda,
                   std::span<const int> drives, const std::type_identity_t<Loads<T>>& loads,
                   std::type_identity_t<Numbers<T>> forces) {
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("a", a.size(), v.size(), "nv");
  check_size("tau", tau.size(), v.size(), "nv");
  check_loads(model, loads);
  check_separate("lambda", lambda, "tau", tau);
  if (!forces.empty()) {
    check_size("forces", forces.size(), v.size(), "nv");
    check_separate("tau", tau, "forces", forces);
  }
  const std::vector<int> at = driven(model, drives);
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;
  Vector need(model.nv());
  system.force(q.data(), v.data(), a.data(), loads, need.data());
  if constexpr (std::same_as<T, double>)  // single precision does not tell them from rounding
    check_accelerations(system, q, v, a);
  for (std::size_t c = 0; c < forces.size(); ++c) need[static_cast<Eigen::Index>(c)] -= forces[c];
  const IndependentRows<T> rows(system, LoopSystem<T>::Rows::velocities);
  const Matrix N = rows.kernel();
  const Vector wanted = N.transpose() * need;
  Matrix NB(N.cols(), static_cast<Eigen::Index>(at.size()));
  for (std::size_t k = 0; k < at.size(); ++k) NB.col(static_cast<Eigen::Index>(k)) = N.row(at[k]).transpose();
  Vector u = Vector::Zero(NB.cols());
  if (NB.size() > 0) {
    const double rounding =
        static_cast<double>(Eigen::NumTraits<T>::epsilon() * T(std::min(NB.rows(), NB.cols())));
    u = least_squares(NB.template cast<double>(), wanted.template cast<double>(), rounding)
            .template cast<T>();
  }
  std::ranges::fill(tau, T(0));
  for (std::size_t k = 0; k < at.size(); ++k)
    tau[static_cast<std::size_t>(at[k])] += u[static_cast<Eigen::Index>(k)];
  const T left = (wanted - NB * u).norm(), size = need.norm();
  if (!lambda.empty()) {
    check_rows("lambda", lambda.size(), model.loops().rows, "loops().rows");
    for (std::size_t c = 0; c < tau.size(); ++c) need[static_cast<Eigen::Index>(c)] -= tau[c];
    rows.least_multipliers(need, lambda);
  }
  return size > T(0) ? left / size : T(0);
}

template <class T>
Solvability impact(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, T restitution,
                   std::type_identity_t<std::span<T>> v_after, std::type_identity_t<std::span<T>> impulses) {
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("v_after", v_after.size(), v.size(), "nv");
  check_separate("impulses", impulses, "v", v), check_separate("impulses", impulses, "v_after", v_after);
  if (!(restitution >= T(0) && restitution <= T(1)))
    throw std::invalid_argument("restitution is " + to_text(static_cast<double>(restitution)) +
                                "; it must be from 0 to 1");
  return system.collide(q.data(), v.data(), restitution, v_after.data(),
                        Multipliers<T>(model, "impulses", impulses).data());
}

template <RecursionRepresentation Rep, class T>
void loop_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                   std::type_identity_t<std::span<Wrench<Rep, T>>> W) {
  LoopSystem<T>& system = checked(model, workspace, q);
  check_rows("lambda", lambda.size(), model.loops().rows, "loops().rows");
  const std::vector<Loop>& loops = model.loops().all;
  check_size("W", W.size(), loops.size(), "loops().all.size()");
  system.place(q.data());
  system.make_rows(LoopSystem<T>::Rows::velocities);
  const Tree<T>& tree = model.tree<T>();
  for (std::size_t k = 0; k < loops.size(); ++k) {
    const Wrench<Spatial, T> about_O = system.wrench(k, lambda.data());
    const int j = loops[k].ends[1].body;
    const Vec3<T> O = system.origin(k);
    if constexpr (std::same_as<Rep, Spatial>) {
      W[k] = {about_O.m + cross(O, about_O.f), about_O.f};
    } else {
      const SE3<T> C = j > 0 ? system.link(j).C * tree.frame_offset[j] : SE3<T>{{}, -O};
      W[k] = change<Rep>(C, about_O);
    }
  }
}

template Solvability forward_dynamics(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>,
                                      Numbers<AXODE_T>, Numbers<AXODE_T>, std::span<AXODE_T>,
                                      std::span<AXODE_T>, const Loads<AXODE_T>&);
template AXODE_T inverse_dynamics(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                  Numbers<AXODE_T>, std::span<AXODE_T>, std::span<AXODE_T>,
                                  std::span<const int>, const Loads<AXODE_T>&, Numbers<AXODE_T>);
template Solvability impact(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                            AXODE_T, std::span<AXODE_T>, std::span<AXODE_T>);
#define AXODE_LOOP_WRENCHES(Rep)                                                            \
  template void loop_wrenches<Rep>(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>, \
                                   Numbers<AXODE_T>, std::span<Wrench<Rep, AXODE_T>>)
AXODE_LOOP_WRENCHES(BodyFixed);
AXODE_LOOP_WRENCHES(Spatial);
AXODE_LOOP_WRENCHES(Hybrid);
AXODE_LOOP_WRENCHES(Mixed);
#undef AXODE_LOOP_WRENCHES

}  // namespace axode
