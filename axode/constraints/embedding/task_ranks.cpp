#include <algorithm>
#include <stdexcept>

#include "axode/constraints/embedding/limb_pack.hpp"
#include "axode/constraints/embedding/task_kernel.hpp"
#include "axode/model/configuration.hpp"

/// The part of TaskKernel that is computed once: its limbs, their ranks, and the task velocities.
namespace axode {
namespace {

constexpr std::array<std::string_view, 6> components{"omega_x", "omega_y", "omega_z", "v_x", "v_y", "v_z"};

[[noreturn]] void refuse_rank(const std::string& what) {
  throw std::invalid_argument("q is near a singularity of " + what +
                              "; limbs are determined at a configuration away from singularities");
}

/// Divides the mechanism into limbs, the chains that carry the body `platform`. The joint of this body must
/// be on the ground and must not be coupled. If `platform` is -1, the body is chosen for which computations
/// limb by limb cost least, or none if its joint does not meet these conditions. Throws std::invalid_argument
/// if the joint of a given platform does not meet them.
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

TaskKernel::TaskKernel(const Model& model, std::span<const double> q, int body)
    : zero(Vector::Zero(model.nv())),
      acceleration(model.nv()),
      bias(model.loops().rows),
      system_(model),
      workspace_(model),
      inverse_(
          std::make_unique<WithScratch<double, InverseDynamicsRecursion<Fast, double>>>(model.topology())),
      forces_(index(model.nv())),
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
  tree_M_.setZero(model.nv(), model.nv());
  composite_.resize(index(model.n_bodies()) + 1);
  const Topology& topology = model.topology();
  screw_.resize(index(model.nv()));
  for (int i = 1; i <= topology.n; ++i)
    for (int s = topology.first_screw[index(i)]; s < topology.first_screw[index(i) + 1]; ++s)
      screw_[index(topology.iv[index(i)] + s - topology.first_screw[index(i)])] = s;
  M_.setZero(freedom_, freedom_);
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
  std::stable_partition(sorted.begin(), middle, [&](int c) { return !has_drive(c); });
  std::sort(middle, sorted.end());
  velocities = sorted;
  number_columns(velocities);
  return matrix.rank();
}

void TaskKernel::determine_rank(Part& part) {
  const LoopTable& table = system_.table();
  number_columns(part.velocities);
  RowElimination<double> matrix;
  matrix.reserve(part.rows.size(), part.velocities.size());
  matrix.reset(static_cast<int>(part.rows.size()), static_cast<int>(part.velocities.size()));
  int row = 0;
  for (const int k : part.loops) {
    const LoopPath& path = table.paths[index(k)];
    const double* entry = system_.entries()[index(k)].data();
    for (const LoopColumn& column : path.columns)
      for (int r = 0; r < path.rows.count; ++r, ++entry)
        if (carries_[index(column.velocity)] == 0)
          matrix.row(row + r)[column_[index(column.velocity)]] += *entry;
    row += path.rows.count;
  }
  if (!matrix.run(system_.considerable_entry()))
    refuse_rank("limb " + name_of_limb(static_cast<int>(&part - parts_.data())));
  part.dependent = sort(matrix, part.velocities);
}

void TaskKernel::determine_ranks() {
  std::size_t remaining = 0;
  for (Part& part : parts_) {
    determine_rank(part);
    remaining += part.rows.size() - index(part.dependent);
  }
  number_columns(carrying_);
  dependent_ = static_cast<int>(carrying_.size());
  make_packs();
  constraints_.reserve(remaining, carrying_.size());
  const int singular = eliminate_limbs();
  if (singular >= 0) refuse_rank("limb " + name_of_limb(singular));
  if (!eliminate_constraints()) refuse_rank("the constraints of the platform");
  dependent_ = sort(constraints_, carrying_);
  make_packs();
  static_cast<void>(eliminate_limbs());  // with the carrying velocities in their final order
  static_cast<void>(eliminate_constraints());
  freedom_ = static_cast<int>(carrying_.size()) - dependent_;
  for (const Part& part : parts_) {
    first_inner_.push_back(freedom_);
    freedom_ += part.inner();
  }
  N_.setZero(std::ssize(carrying_), freedom_);
  solve_constraints();
}

void TaskKernel::make_packs() {
  packs_.clear();
  const int s = static_cast<int>(carrying_.size());
  std::ptrdiff_t transmitted = 0;
  drives_by_limbs_ = std::ranges::none_of(carrying_, [&](int c) { return has_drive(c); });
  for (std::size_t l = 0; l < parts_.size(); ++l) {
    const Part& part = parts_[l];
    const auto passive = [&](auto begin, auto end) {
      return static_cast<int>(std::count_if(begin, end, [&](int c) { return !has_drive(c); }));
    };
    const auto inner = part.velocities.begin() + part.dependent;
    const LimbShape shape{.rows = static_cast<int>(part.rows.size()),
                          .dependent = part.dependent,
                          .passive = passive(part.velocities.begin(), inner),
                          .inner = part.inner(),
                          .coupled = part.coupled};
    drives_by_limbs_ = drives_by_limbs_ && passive(inner, part.velocities.end()) == 0;
    transmitted += shape.rows - shape.passive;
    auto pack =
        std::ranges::find_if(packs_, [&](const LimbPack& it) { return it.shape == shape && !it.full(); });
    if (pack == packs_.end()) pack = packs_.emplace(packs_.end(), shape, s, s - dependent_);
    number_columns(part.velocities);
    number_columns(carrying_);
    pack->add(static_cast<int>(l), part.velocities, part.rows, part.loops, system_.table(), [&](int c) {
      return carries_[index(c)] != 0 ? pack->velocities() + column_[index(c)] : column_[index(c)];
    });
  }
  drives_by_limbs_ = drives_by_limbs_ && transmitted == s;
  drives_.setZero(s, s + 1);
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

}  // namespace axode
