#include "axode/constraints/embedding/task_kernel.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/eigen.hpp"
#include "axode/fast/fast.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

constexpr std::array<std::string_view, 6> components{"omega_x", "omega_y", "omega_z", "v_x", "v_y", "v_z"};

[[noreturn]] void refuse_rank(const std::string& what) {
  throw std::invalid_argument("q is near a singularity of " + what +
                              "; limbs are determined at a configuration away from singularities");
}

/// Divides the mechanism into limbs, the chains that carry the body `platform`; -1 chooses the body for which
/// computations limb by limb cost least. Throws std::invalid_argument if another body carries the platform or
/// its joint is coupled.
Limbs division(const Model& model, const LoopTable& table, int platform) {
  const auto carried = [&](int i) {
    return i > 0 && (model.body(i).predecessor > 0 || model.joint(i).leader.has_value());
  };
  if (platform >= 0 && carried(platform))
    throw std::invalid_argument(
        "platform: body \"" + model.body(platform).name +
        "\" hangs on another body, or its joint is coupled; draw it on the ground with "
        "a passive free joint, and close its limbs by loops");
  Limbs limbs = platform < 0 ? limbs_of(model, table.paths) : limbs_of(model, table.paths, platform);
  return carried(limbs.platform) ? limbs_of(model, table.paths, 0) : limbs;
}

}  // namespace

TaskVerdict judged(TaskVerdict verdict, std::initializer_list<std::span<double>> results) noexcept {
  for (const std::span<double> x : results)
    if (verdict.ok() && !finite(x)) verdict.kind = TaskVerdict::Kind::not_finite;
  if (!verdict.ok())
    for (const std::span<double> x : results) std::ranges::fill(x, std::numeric_limits<double>::quiet_NaN());
  return verdict;
}

TaskKernel::TaskKernel(const Model& model, std::span<const double> q, int body)
    : zero(Vector::Zero(model.nv())),
      acceleration(model.nv()),
      bias(model.loops().rows),
      system_(model),
      workspace_(model),
      column_(index(model.nv())),
      carries_(index(model.nv())) {
  const Limbs limbs = division(model, system_.table(), body);
  platform = limbs.platform;
  make_parts(limbs);
  const Eigen::Index longest = std::max<Eigen::Index>({model.loops().rows, model.nv(), 6});
  for (Vector* x : {&before_, &after_, &remaining_, &s_, &y_}) x->setZero(longest);
  system_.update_kinematics(q.data());
  system_.make_rows(ConstraintLevel::velocity);
  determine_ranks();
  choose_components();
  for (Part& part : parts_) part.F.setZero(std::ssize(part.velocities), freedom_);
  tree_M_.setZero(model.nv(), model.nv());
  composite_.resize(index(model.n_bodies()) + 1);
  const Topology& topology = model.topology();
  screw_.resize(index(model.nv()));
  for (int i = 1; i <= topology.n; ++i)
    for (int s = topology.first_screw[index(i)]; s < topology.first_screw[index(i) + 1]; ++s)
      screw_[index(topology.iv[index(i)] + s - topology.first_screw[index(i)])] = s;
  M_.setZero(freedom_, freedom_);
  work_.setZero(model.nv(), freedom_);
  factor_ = Eigen::LLT<Eigen::MatrixXd>(freedom_);
}

void TaskKernel::make_parts(const Limbs& limbs) {
  const LoopTable& table = system_.table();
  const Topology& topology = model().topology();
  carrying_ = limbs.carrying;
  for (const int c : carrying_) carries_[index(c)] = 1;
  std::vector<Limb> all = limbs.limbs;
  if (!limbs.outside.empty()) all.push_back({limbs.outside, {}});
  for (const Limb& limb : all) {
    Part part;
    part.velocities = limb.velocities;
    part.loops = limb.loops;
    for (const int k : part.loops) {
      const LoopPath::Range range = table.paths[index(k)].rows;
      for (int r = 0; r < range.count; ++r) part.rows.push_back(range.first + r);
    }
    for (int c : part.velocities)
      for (; c >= 0; c = topology.velocity_parent[index(c)])
        part.coupled = part.coupled || carries_[index(c)] != 0;
    part.matrix.reserve(part.rows.size(), part.velocities.size() + carrying_.size());
    part.x.setZero(std::ssize(part.velocities));
    part.b.setZero(std::ssize(part.rows));
    parts_.push_back(std::move(part));
  }
}

void TaskKernel::number_columns(const std::vector<int>& velocities) {
  for (std::size_t j = 0; j < velocities.size(); ++j) column_[index(velocities[j])] = static_cast<int>(j);
}

int TaskKernel::sort(const RowElimination<double>& matrix, std::vector<int>& velocities) {
  std::vector<int> sorted;
  for (int j = 0; j < static_cast<int>(velocities.size()); ++j)
    sorted.push_back(velocities[index(matrix.column_before(j))]);
  const auto middle = sorted.begin() + matrix.rank();
  std::sort(sorted.begin(), middle);
  std::sort(middle, sorted.end());
  velocities = sorted;
  number_columns(velocities);
  return matrix.rank();
}

void TaskKernel::determine_ranks() {
  number_columns(carrying_);
  std::size_t remaining = 0;
  for (Part& part : parts_) {
    part.dependent = part.first_carrying();
    number_columns(part.velocities);
    if (!eliminate(part)) refuse_rank("limb " + name_of_limb(static_cast<int>(&part - parts_.data())));
    part.dependent = sort(part.matrix, part.velocities);
    static_cast<void>(eliminate(part));
    remaining += part.rows.size() - index(part.dependent);
  }
  constraints_.reserve(remaining, carrying_.size());
  dependent_ = static_cast<int>(carrying_.size());
  if (!eliminate_constraints()) refuse_rank("the constraints of the platform");
  dependent_ = sort(constraints_, carrying_);
  for (Part& part : parts_)
    static_cast<void>(eliminate(part));  // now with the carrying velocities in their final order
  static_cast<void>(eliminate_constraints());
  freedom_ = static_cast<int>(carrying_.size()) - dependent_;
  for (Part& part : parts_) {
    part.first_inner = freedom_;
    freedom_ += part.inner();
  }
  N_.setZero(std::ssize(carrying_), freedom_);
  solve_constraints();
}

void TaskKernel::choose_components() {
  const int s = static_cast<int>(carrying_.size()), free = s - dependent_;
  const std::vector<std::string> velocities = velocity_names(model());
  if (platform > 0) {
    Matrix P(6, s);
    for (int j = 0; j < s; ++j) {
      const Screw<>& X = model().body(platform).X[index(carrying_[index(j)] - model().joint(platform).iv)];
      P.col(j) << X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z;
    }
    const Matrix PN = P * N_.leftCols(free);
    to_components_.reserve(index(free), 6);
    to_components_.reset(free, 6);
    for (int j = 0; j < free; ++j)
      for (int k = 0; k < 6; ++k) to_components_.row(j)[k] = PN(k, j);
    static_cast<void>(to_components_.run());
    for (int j = 0; j < to_components_.rank(); ++j) chosen_.push_back(to_components_.column_before(j));
    if (static_cast<int>(chosen_.size()) < free) refuse_rank("the twist of the platform");
    std::sort(chosen_.begin(), chosen_.end());
    P_ = P(chosen_, Eigen::indexing::all);
    are_components_ = P_.isIdentity(0) && free == s;
    for (const int k : chosen_)
      names.push_back(model().body(platform).name + "." + std::string(components[index(k)]));
  }
  for (const Part& part : parts_)
    for (std::size_t j = index(part.dependent); j < part.velocities.size(); ++j)
      names.push_back(velocities[index(part.velocities[j])]);
}

bool TaskKernel::eliminate(Part& part) noexcept {
  const LoopTable& table = system_.table();
  part.matrix.reset(static_cast<int>(part.rows.size()), part.dependent);
  int row = 0;
  for (const int k : part.loops) {
    const LoopPath& path = table.paths[index(k)];
    const double* entry = system_.entries()[index(k)].data();
    for (const LoopColumn& column : path.columns) {
      const std::size_t c = index(column.velocity);
      const int j = carries_[c] != 0 ? part.first_carrying() + column_[c] : column_[c];
      for (int r = 0; r < path.rows.count; ++r) part.matrix.row(row + r)[j] += *entry++;
    }
    row += path.rows.count;
  }
  return part.matrix.run(system_.considerable_entry());
}

bool TaskKernel::eliminate_constraints() noexcept {
  const int s = static_cast<int>(carrying_.size());
  int rows = 0;
  for (const Part& part : parts_) rows += part.matrix.rows() - part.matrix.rank();
  constraints_.reset(rows, dependent_);
  double largest = system_.considerable_entry();
  int next = 0;
  for (const Part& part : parts_)
    for (int i = 0; i < part.matrix.rows(); ++i) {
      const double* const row = part.matrix.row(i) + part.first_carrying();
      for (int j = 0; j < s; ++j) largest = std::max(largest, std::abs(row[j]));
      if (i >= part.matrix.rank()) std::copy_n(row, s, constraints_.row(next++));
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
  for (std::size_t l = 0; l < parts_.size(); ++l)
    if (!eliminate(parts_[l]) || parts_[l].matrix.rank() < parts_[l].dependent)
      return {limb_singular, static_cast<int>(l)};
  if (!eliminate_constraints() || constraints_.rank() < dependent_) return {constraint_singular};
  solve_constraints();
  if (platform > 0 && !are_components_ && !change_to_components()) return {constraint_singular};
  return {};
}

void TaskKernel::expand(const double* X, const double* gamma, double* x) noexcept {
  const int s = static_cast<int>(carrying_.size()), free = s - dependent_;
  int next = 0;
  for (Part& part : parts_) {
    const int rows = part.matrix.rows();
    for (int i = 0; i < rows; ++i) before_[i] = gamma == nullptr ? 0 : -gamma[part.rows[index(i)]];
    part.matrix.reduce(before_.data(), part.b.data());
    for (int i = part.dependent; i < rows; ++i) remaining_[next++] = part.b[i];
    std::copy_n(X + part.first_inner, part.inner(), part.x.data() + part.dependent);
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
  for (int k = 0; k < s; ++k) x[carrying_[index(k)]] = s_[k];
  for (Part& part : parts_) {
    for (int i = 0; i < part.dependent; ++i) {
      const double* const row = part.matrix.row(i);
      for (int j = part.dependent; j < part.first_carrying(); ++j) part.b[i] -= row[j] * part.x[j];
      for (int k = 0; k < s; ++k) part.b[i] -= row[part.first_carrying() + k] * s_[k];
    }
    part.matrix.solve(part.b.data(), part.x.data());
    for (std::size_t j = 0; j < part.velocities.size(); ++j)
      x[part.velocities[j]] = part.x[static_cast<Eigen::Index>(j)];
  }
}

void TaskKernel::make_F() noexcept {
  const int s = static_cast<int>(carrying_.size()), f = freedom_;
  for (Part& part : parts_) {
    for (int k = part.dependent; k-- > 0;) {
      const double* const row = part.matrix.row(k);
      double* const out = part.F.row(part.matrix.column_before(k)).data();
      std::fill_n(out, f, 0.0);
      for (int j = 0; j < part.inner(); ++j) out[part.first_inner + j] = -row[part.dependent + j];
      const auto subtract = [&](double factor, const double* from) {
        for (int t = 0; t < f; ++t) out[t] -= factor * from[t];
      };
      if (are_components_) {
        for (int j = 0; j < s; ++j) out[j] -= row[part.first_carrying() + j];
      } else {
        for (int j = 0; j < s; ++j) subtract(row[part.first_carrying() + j], N_.row(j).data());
      }
      for (int j = k + 1; j < part.dependent; ++j)
        subtract(row[j], part.F.row(part.matrix.column_before(j)).data());
      const double inverse = part.matrix.inverse_pivot(k);
      for (int t = 0; t < f; ++t) out[t] *= inverse;
    }
    for (int j = 0; j < part.inner(); ++j) part.F(part.dependent + j, part.first_inner + j) = 1;
  }
}

void TaskKernel::make_tree_M(std::span<const double> q) noexcept {
  const Tree<double>& tree = model().tree<double>();
  if (!tree->coupled_bodies.empty()) {
    mass_matrix<Hybrid>(model(), workspace_, q, as_span(tree_M_));
    return;
  }
  for (int i = 1; i <= tree->n; ++i) composite_[index(i)] = system_.link(i).inertia(tree.M[index(i)]);
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
  const int f = freedom_;
  make_tree_M(q);
  M_.setZero();
  // Adds Bᵀ M_ba A to M_. The rows of B and A belong to the velocities b and a, and M_ba is the block of the
  // tree's mass matrix for them. If `both`, the transpose of the product is added as well.
  const auto add = [&](const std::vector<int>& b, const Matrix& B, const std::vector<int>& a, const Matrix& A,
                       bool both) {
    for (std::size_t i = 0; i < b.size(); ++i) {
      double* const product = work_.data();
      std::fill_n(product, f, 0.0);
      for (std::size_t j = 0; j < a.size(); ++j) {
        const double m = tree_M_(b[i], a[j]);
        const double* const row = A.row(static_cast<Eigen::Index>(j)).data();
        for (int t = 0; t < f; ++t) product[t] += m * row[t];
      }
      const double* const left = B.row(static_cast<Eigen::Index>(i)).data();
      for (int r = 0; r < f; ++r) {
        double* const out = M_.row(r).data();
        for (int t = 0; t < f; ++t) out[t] += left[r] * product[t];
        if (both)
          for (int t = 0; t < f; ++t) M_(t, r) += left[r] * product[t];
      }
    }
  };
  add(carrying_, N_, carrying_, N_, false);
  for (const Part& part : parts_) {
    add(part.velocities, part.F, part.velocities, part.F, false);
    if (part.coupled) add(part.velocities, part.F, carrying_, N_, true);
  }
}

void TaskKernel::project(const double* w, double* out) const noexcept {
  std::fill_n(out, freedom_, 0.0);
  const auto add = [&](const std::vector<int>& velocities, const Matrix& F) {
    for (std::size_t i = 0; i < velocities.size(); ++i) {
      const double x = w[velocities[i]];
      const double* const row = F.row(static_cast<Eigen::Index>(i)).data();
      for (int t = 0; t < freedom_; ++t) out[t] += x * row[t];
    }
  };
  add(carrying_, N_);
  for (const Part& part : parts_) add(part.velocities, part.F);
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
  factor_.compute(M_);
  if (factor_.info() != Eigen::Success) return false;
  Eigen::Map<Vector> x(b, freedom_);
  factor_.solveInPlace(x);
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
