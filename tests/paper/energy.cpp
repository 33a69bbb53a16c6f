#include "tests/paper/energy.hpp"

namespace axode::test::paper {

namespace {

/// T(q, v) in any scalar type.
template <class S> S kinetic_energy(const Motion& m, const std::vector<S>& q, const std::vector<S>& v) {
  using Along = Taylor<S, 2>;
  std::vector<Along> moved(q.size());
  for (std::size_t k = 0; k < q.size(); ++k) moved[k].c = {q[k], v[k]};
  const std::vector<SE3<Along>> C = poses_on(m, moved);
  S sum(0);
  for (int i = 1; i <= m.n(); ++i)
    for (const PointMass& point : m.drawn(i).points) {
      const Vec3<Along> p = C[i] * axode::cast<Along>(point.p);
      sum += S(0.5 * point.m) * (p.x.c[1] * p.x.c[1] + p.y.c[1] * p.y.c[1] + p.z.c[1] * p.z.c[1]);
    }
  return sum;
}

std::size_t size_of(const Motion& m) { return m.v().size(); }
/// M_ij = ∂²T/∂v_i∂v_j, and its partial derivatives with respect to q.
double mass_matrix_entry(const Motion& m, int i, int j) {
  std::vector<Two> q(m.q().begin(), m.q().end()), v(size_of(m));
  v[i].c[0].c[1] += 1;
  v[j].c[1] += One(1);
  return kinetic_energy(m, q, v).c[1].c[1];
}
double mass_matrix_partial(const Motion& m, int i, int j, int k) {
  std::vector<Three> q(m.q().begin(), m.q().end()), v(size_of(m));
  q[k].c[0].c[0].c[1] = 1;
  v[i].c[0].c[1] += One(1);
  v[j].c[1] += Two(1);
  return kinetic_energy(m, q, v).c[1].c[1].c[1];
}

}  // namespace

Matrix energy_gradient(const Motion& m) {
  Matrix out(m.model().nv(), 1);
  for (std::size_t k = 0; k < size_of(m); ++k) {
    std::vector<One> q(m.q().begin(), m.q().end());
    q[k].c[1] = 1;
    out[static_cast<int>(k)] = kinetic_energy(m, q, std::vector<One>(m.v().begin(), m.v().end())).c[1];
  }
  return out;
}
Momenta conjugate_momenta(const Motion& m) {
  Momenta out{Matrix(m.model().nv(), 1), Matrix(m.model().nv(), 1)};
  for (std::size_t k = 0; k < size_of(m); ++k) {
    std::vector<Two> q(size_of(m)), v(size_of(m));
    for (std::size_t c = 0; c < size_of(m); ++c) {
      q[c].c[0].c = {m.q()[c], m.v()[c]};
      v[c].c[0].c = {m.v()[c], m.a()[c]};
    }
    v[k].c[1] = One(1);
    const One p = kinetic_energy(m, q, v).c[1];
    out.p[static_cast<int>(k)] = p.c[0], out.dp[static_cast<int>(k)] = p.c[1];
  }
  return out;
}
Matrix mass_matrix_of(const Motion& m) {
  Matrix M(m.model().nv(), m.model().nv());
  for (int i = 0; i < M.rows(); ++i)
    for (int j = 0; j < M.cols(); ++j) M(i, j) = mass_matrix_entry(m, i, j);
  return M;
}
std::vector<double> christoffel_symbols_of(const Motion& m) {
  const int n = m.model().nv();
  std::vector<double> dM, Gamma;  // dM: ∂M_ij/∂q_k at [(i n + j) n + k]
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        dM.push_back(j < i ? dM[(j * n + i) * n + k] : mass_matrix_partial(m, i, j, k));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        Gamma.push_back((dM[(i * n + k) * n + j] + dM[(i * n + j) * n + k] - dM[(j * n + k) * n + i]) / 2);
  return Gamma;
}

Matrix drive_forces(const Motion& m) {
  Matrix tau(m.model().nv(), 1);
  for (int i = 1; i <= m.n(); ++i) tau.set_block(velocity(m, i), 0, m.joint_force<BodyFixed>(i));
  return tau;
}
Matrix generalised_forces(const Motion& m) {
  return drive_forces(m) + system_jacobian<BodyFixed>(m).transpose() * system_W_app<BodyFixed>(m);
}

}  // namespace axode::test::paper
