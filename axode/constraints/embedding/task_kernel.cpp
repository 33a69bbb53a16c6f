#include "axode/constraints/embedding/task_kernel.hpp"

#include <algorithm>
#include <stdexcept>

#include "axode/constraints/embedding/limb_pack.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/eigen.hpp"
#include "axode/model/configuration.hpp"

namespace axode {
namespace {

/// Solves a linear system by elimination. The argument A is n × (n + 1): a square matrix, and in the last
/// column the right side, which is replaced by the solution. Returns false if a pivot is not larger than
/// RowElimination::certain times the larger of two numbers: the largest entry of the square matrix, and
/// `considerable`, a magnitude of entries that are no rounding errors.
bool solve_square(Eigen::MatrixXd& A, double considerable) noexcept {
  const Eigen::Index n = A.rows();
  double size = considerable;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) size = std::max(size, std::abs(A(i, j)));
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index best = k;
    for (Eigen::Index i = k + 1; i < n; ++i)
      if (std::abs(A(i, k)) > std::abs(A(best, k))) best = i;
    if (!(std::abs(A(best, k)) > RowElimination<double>::certain * size)) return false;
    for (Eigen::Index j = k; j <= n; ++j) std::swap(A(k, j), A(best, j));
    const double inverse = A(k, k) = 1 / A(k, k);
    for (Eigen::Index i = k + 1; i < n; ++i) A(i, k) *= inverse;
    for (Eigen::Index j = k + 1; j <= n; ++j) {
      const double pivot = A(k, j);
      for (Eigen::Index i = k + 1; i < n; ++i) A(i, j) -= A(i, k) * pivot;
    }
  }
  for (Eigen::Index k = n; k-- > 0;) {
    const double x = A(k, n) *= A(k, k);
    for (Eigen::Index i = 0; i < k; ++i) A(i, n) -= A(i, k) * x;
  }
  return true;
}

}  // namespace

TaskKernel::~TaskKernel() = default;

int TaskKernel::eliminate_limbs() noexcept {
  const double considerable = system_.considerable_entry();
  int singular = -1;
  for (LimbPack& pack : packs_) {
    const int limb = pack.resolve(system_.entries(), considerable, RowElimination<double>::certain);
    if (limb >= 0 && (singular < 0 || limb < singular)) singular = limb;
  }
  return singular;
}

bool TaskKernel::eliminate_constraints() noexcept {
  const int s = static_cast<int>(carrying_.size());
  int rows = 0;
  for (const Part& part : parts_) rows += static_cast<int>(part.rows.size()) - part.dependent;
  constraints_.reset(rows, dependent_);
  if (rows == 0) return true;
  double largest = system_.considerable_entry();
  int next = 0;
  for (const LimbPack& pack : packs_)
    for (int l = 0; l < std::ssize(pack.limbs()); ++l)
      for (int i = 0; i < pack.shape.rows; ++i)
        for (int j = 0; j < s; ++j) {
          const double entry = pack.carrying_entry(l, i, j);
          largest = std::max(largest, std::abs(entry));
          if (i >= pack.shape.dependent) constraints_.row(next + i - pack.shape.dependent)[j] = entry;
          if (i == pack.shape.rows - 1 && j == s - 1) next += pack.shape.rows - pack.shape.dependent;
        }
  return constraints_.run(largest);
}

void TaskKernel::solve_constraints() noexcept {
  const int free = static_cast<int>(carrying_.size()) - dependent_;
  for (int j = 0; j < free; ++j) {
    for (int k = 0; k < dependent_; ++k) before_[k] = -constraints_.row(k)[dependent_ + j];
    constraints_.solve(before_.data(), after_.data());
    for (int k = 0; k < dependent_; ++k) N_(k, j) = after_[k];
    for (int k = 0; k < free; ++k) N_(dependent_ + k, j) = k == j ? 1 : 0;
  }
}

bool TaskKernel::change_to_components() noexcept {
  const int s = static_cast<int>(carrying_.size()), free = s - dependent_;
  to_components_.reset(free, free);
  for (int i = 0; i < free; ++i)
    for (int j = 0; j < free; ++j) {
      double sum = 0;
      for (int k = 0; k < s; ++k) sum += P_(i, k) * N_(k, j);
      to_components_.row(i)[j] = sum;
    }
  if (!to_components_.run() || to_components_.rank() < free) return false;
  std::array<std::array<double, 6>, 6> G{};  // column j of G: the independent carrying velocities for a unit
                                             // of component j
  for (int j = 0; j < free; ++j) {
    std::array<double, 6> unit{}, reduced{};
    unit[index(j)] = 1;
    to_components_.reduce(unit.data(), reduced.data());
    to_components_.solve(reduced.data(), G[index(j)].data());
  }
  for (int k = 0; k < s; ++k) {
    std::array<double, 6> row{};
    for (int j = 0; j < free; ++j)
      for (int i = 0; i < free; ++i) row[index(j)] += N_(k, i) * G[index(j)][index(i)];
    for (int j = 0; j < free; ++j) N_(k, j) = row[index(j)];
  }
  return true;
}

TaskVerdict TaskKernel::resolve() noexcept {
  using enum TaskVerdict::Kind;
  if (const int limb = eliminate_limbs(); limb >= 0) return {limb_singular, limb};
  if (!eliminate_constraints() || constraints_.rank() < dependent_) return {constraint_singular};
  if (dependent_ > 0 || !are_components_) solve_constraints();
  if (platform > 0 && !are_components_ && !change_to_components()) return {constraint_singular};
  return {};
}

void TaskKernel::expand(const double* X, const double* gamma, double* x) noexcept {
  const int s = static_cast<int>(carrying_.size()), free = s - dependent_;
  int next = 0;
  for (LimbPack& pack : packs_) {
    pack.set_right_side(gamma);
    for (int l = 0; l < std::ssize(pack.limbs()); ++l)
      for (int i = pack.shape.dependent; i < pack.shape.rows; ++i) remaining_[next++] = pack.right_side(l, i);
  }
  s_.setZero();
  constraints_.reduce(remaining_.data(), after_.data());
  constraints_.solve(after_.data(), s_.data());
  for (int j = 0; j < free; ++j) {
    y_[j] = X[j];
    for (int k = 0; k < s; ++k) y_[j] -= P_(j, k) * s_[k];
  }
  for (int k = 0; k < s; ++k)
    for (int j = 0; j < free; ++j) s_[k] += N_(k, j) * y_[j];
  for (int j = free; j < freedom_; ++j) y_[j] = X[j];
  for (int k = 0; k < s; ++k) x[carrying_[index(k)]] = s_[k];
  for (LimbPack& pack : packs_) pack.expand(y_.data(), first_inner_, s_.data(), x);
}

void TaskKernel::make_F() noexcept {
  for (LimbPack& pack : packs_) pack.make_F(N_.data(), freedom_);
}

void TaskKernel::write_F(Eigen::MatrixXd& F) const {
  F.setZero(model().nv(), freedom_);
  for (std::size_t j = 0; j < carrying_.size(); ++j)
    F.row(carrying_[j]) = N_.row(static_cast<Eigen::Index>(j));
  for (const LimbPack& pack : packs_)
    for (int l = 0; l < std::ssize(pack.limbs()); ++l)
      for (int j = 0; j < pack.velocities(); ++j)
        for (int t = 0; t < pack.motions(); ++t) {
          const int inner = t - independent();
          F(pack.velocity(l, j), inner < 0 ? t : first_inner_[index(pack.limbs()[index(l)])] + inner) =
              pack.F(l, j, t);
        }
}

std::span<double> TaskKernel::tree_forces(std::span<const double> q, std::span<const double> v,
                                          const double* a, const Loads<double>& loads) noexcept {
  (*inverse_)->run(model().tree<double>(), q.data(), v.data(), a, loads);
  (*inverse_)->project(model().tree<double>(), v.data(), a, loads.joint_losses, forces_.data());
  return forces_;
}

bool TaskKernel::drive_forces(const double* f, double* tau) noexcept {
  if (!drives_by_limbs_) return system_.drive_forces({}, f, tau, nullptr);
  const int s = static_cast<int>(carrying_.size());
  double* const b = drives_.col(s).data();
  for (int k = 0; k < s; ++k) b[k] = f[carrying_[index(k)]];
  int row = 0;
  for (LimbPack& pack : packs_) {
    pack.subtract_passive(f, b);
    for (int l = 0; l < std::ssize(pack.limbs()); ++l)
      for (int i = pack.shape.passive; i < pack.shape.rows; ++i, ++row)
        for (int k = 0; k < s; ++k) drives_(k, row) = pack.carrying_entry(l, i, k);
  }
  if (!solve_square(drives_, system_.considerable_entry())) return false;
  row = 0;
  for (LimbPack& pack : packs_) {
    for (int l = 0; l < std::ssize(pack.limbs()); ++l)
      for (int i = pack.shape.passive; i < pack.shape.rows; ++i) pack.set_multiplier(l, i, b[row++]);
    pack.subtract_rows(f, tau);
  }
  for (const int c : carrying_) tau[c] = 0;
  return true;
}

void TaskKernel::set_inertias(int first) noexcept {
  constexpr int width = LimbPack::width;
  using L = Lanes<double>;
  const Tree<double>& tree = model().tree<double>();
  const int count = std::min(width, tree->n + 1 - first);
  std::array<std::array<double, width>, 12> at{};
  for (int l = 0; l < count; ++l) {
    const SE3<>& C = system_.link(first + l).C;
    int k = 0;
    for (const Vec3<>& column : {C.R.x, C.R.y, C.R.z, C.r})
      for (const double x : {column.x, column.y, column.z}) at[index(k++)][index(l)] = x;
  }
  const auto load3 = [&](std::size_t k) {
    return Vec3<L::Number>{L::load(at[k].data()), L::load(at[k + 1].data()), L::load(at[k + 2].data())};
  };
  const SE3<L::Number> C{{load3(0), load3(3), load3(6)}, load3(9)};
  const auto [m, h, A] = transform(C, inertias_in_lanes<double>(tree, first));
  for (int l = 0; l < count; ++l) {
    const auto x = [k = index(l)](const L::Number& of) { return of[k]; };
    composite_[index(first + l)] = {
        x(m), {x(h.x), x(h.y), x(h.z)}, {x(A.xx), x(A.yy), x(A.zz), x(A.xy), x(A.xz), x(A.yz)}};
  }
}

void TaskKernel::make_tree_M(std::span<const double> q) noexcept {
  const Tree<double>& tree = model().tree<double>();
  if (!tree->coupled_bodies.empty()) {
    mass_matrix<Hybrid>(model(), workspace_, q, as_span(tree_M_));
    return;
  }
  for (int i = 0; i <= tree->n; i += LimbPack::width) set_inertias(i);
  for (int i = tree->n; i > 0; --i)
    if (const int p = tree->parent[index(i)]; p > 0) composite_[index(p)] += composite_[index(i)];
  const Twist<Spatial>* const S = system_.bodies().S;
  for (int i = 1; i <= tree->n; ++i)
    for (int s = tree->first_screw[index(i)]; s < tree->first_screw[index(i) + 1]; ++s) {
      const Momentum<Spatial> U = composite_[index(i)] * S[s];
      const int c = tree->iv[index(i)] + s - tree->first_screw[index(i)];
      for (int r = c; r >= 0; r = tree->velocity_parent[index(r)])
        tree_M_(r, c) = tree_M_(c, r) = U | S[screw_[index(r)]];
      tree_M_(c, c) += tree.armature[index(c)];
    }
}

void TaskKernel::make_M(std::span<const double> q) noexcept {
  const int f = freedom_, s = static_cast<int>(carrying_.size()), free = independent();
  make_tree_M(q);
  M_.setZero();
  if (are_components_) {
    for (int i = 0; i < s; ++i)
      for (int j = 0; j < s; ++j) M_(i, j) = tree_M_(carrying_[index(i)], carrying_[index(j)]);
  }
  for (int i = are_components_ ? s : 0; i < s; ++i)  // Nᵀ M N of the carrying velocities
    for (int t = 0; t < free; ++t) {
      double sum = 0;
      for (int j = 0; j < s; ++j) sum += tree_M_(carrying_[index(i)], carrying_[index(j)]) * N_(j, t);
      for (int r = 0; r < free; ++r) M_(r, t) += N_(i, r) * sum;
    }
  for (LimbPack& pack : packs_) {
    pack.make_M(tree_M_.data(), model().nv(), carrying_, N_.data(), f);
    pack.add_M(first_inner_, M_.data(), f);
  }
}

void TaskKernel::project(const double* w, double* out) noexcept {
  std::fill_n(out, freedom_, 0.0);
  for (std::size_t k = 0; k < carrying_.size(); ++k)
    for (int t = 0; t < independent(); ++t) out[t] += N_(static_cast<Eigen::Index>(k), t) * w[carrying_[k]];
  for (LimbPack& pack : packs_) pack.project(w, first_inner_, out);
}

void TaskKernel::subtract_inertia_forces(const double* x, double* w) const noexcept {
  const auto subtract = [&](const std::vector<int>& rows, const std::vector<int>& columns) {
    for (const int r : rows)
      for (const int c : columns) w[r] -= tree_M_(r, c) * x[c];
  };
  subtract(carrying_, carrying_);
  for (const Part& part : parts_) {
    subtract(part.velocities, part.velocities);
    if (!part.coupled) continue;
    subtract(part.velocities, carrying_);
    subtract(carrying_, part.velocities);
  }
}

bool TaskKernel::solve(double* b) noexcept {
  for (int k = 0; k < freedom_; ++k) {  // L Lᵀ = M, with the inverses of the diagonal of L on that of M_
    double rest = M_(k, k);
    for (int j = 0; j < k; ++j) rest -= M_(k, j) * M_(k, j);
    if (!(rest > 0)) return false;
    const double inverse = M_(k, k) = 1 / std::sqrt(rest);
    for (int i = k + 1; i < freedom_; ++i) {
      double sum = M_(i, k);
      for (int j = 0; j < k; ++j) sum -= M_(i, j) * M_(k, j);
      M_(i, k) = sum * inverse;
    }
    double sum = b[k];
    for (int j = 0; j < k; ++j) sum -= M_(k, j) * b[j];
    b[k] = sum * inverse;
  }
  for (int k = freedom_; k-- > 0;) {
    b[k] *= M_(k, k);
    for (int j = 0; j < k; ++j) b[j] -= M_(k, j) * b[k];
  }
  return true;
}

void TaskKernel::check_platform() const {
  if (platform == 0)
    throw std::invalid_argument("model: \"" + model().name() +
                                "\" has no platform; name the body when the task space is made");
}

SE3<> TaskKernel::platform_pose() const {
  const SE3<> C = system_.link(platform).C;
  return {C.R, C.r + system_.root_origins()[platform]};
}

std::string TaskKernel::name_of_limb(int l) const {
  const Part& part = parts_[index(l)];
  std::string name;
  for (const int k : part.loops)
    name += (name.empty() ? "\"" : ", \"") + model().loops().all[index(k)].name + '"';
  return "with " +
         (name.empty() ? "joints outside loops" : (part.loops.size() > 1 ? "loops " : "loop ") + name);
}

}  // namespace axode
