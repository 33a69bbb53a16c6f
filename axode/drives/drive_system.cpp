#include "axode/drives/drive_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <unordered_map>

#include "axode/drives/make_law.hpp"
#include "axode/model/building/placement.hpp"

namespace axode {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Throws std::invalid_argument unless an added drive has a law and joints with finite factors, not 0.
void check(const AddedDrive& drive) {
  const std::string subject = "drive \"" + drive.name + "\" ";
  if (!drive.law)
    throw std::invalid_argument(subject + "has no law; give one, such as a DriveLawOf with a struct");
  if (drive.joints.empty()) throw std::invalid_argument(subject + "acts on nothing; name its joint");
  for (const auto& [joint, factor] : drive.joints)
    if (!std::isfinite(factor) || factor == 0)
      throw std::invalid_argument(subject + "has the factor " + to_text(factor) + " of joint \"" + joint +
                                  "\"; it must be finite and not 0");
}

}  // namespace

DriveSystem::DriveSystem(const Model& model, std::span<const AddedDrive> more) : model_(model) {
  std::size_t line = 0;
  for (std::size_t k = 0; k < model.drives().size(); ++k) {
    const DriveDescription& it = model.drives()[k];
    const std::string name = drive_name(it, k);
    DrivePort port =
        it.line ? DrivePort(model.springs().drive_lines[line++]) : DrivePort(model, name, it.joints);
    drives_.push_back(
        {name, make_law(it), std::move(port), DriveSignal(it.input), it.input.from, it.initial});
  }
  for (const AddedDrive& it : more) {
    check(it);
    drives_.push_back({it.name,
                       it.law,
                       DrivePort(model, it.name, it.joints),
                       it.input ? DriveSignal(it.input) : DriveSignal(),
                       "",
                       {}});
  }
  for (Drive& drive : drives_) {
    drive.first_x = states_.size();
    drive.statuses.resize(drive.law->n_statuses());
    for (DriveState& state : drive.law->states()) {
      state.name = drive.name + "." + state.name;
      states_.push_back(std::move(state));
    }
    drive.n_x = states_.size() - drive.first_x;
  }
  order_by_inputs();
  now_.x.resize(nx());
  now_.dx.resize(nx());
  for (auto* each : {&now_.l, &now_.w, &now_.u, &now_.outputs}) each->resize(size());
}

/// Finds which drives have the output of another one as input, and an order that computes outputs first.
void DriveSystem::order_by_inputs() {
  std::unordered_map<std::string_view, std::size_t> index;
  for (std::size_t d = 0; d < size(); ++d) index.try_emplace(drives_[d].name, d);
  std::vector<char> listed(size());
  for (std::size_t d = 0; d < size(); ++d) {
    if (drives_[d].from.empty()) {
      inputs_.push_back(d);
      order_.push_back(d);
      listed[d] = 1;
      continue;
    }
    const std::size_t feeder = index.at(drives_[d].from);
    drives_[d].fed_by = static_cast<int>(feeder);
    drives_[feeder].feeds = true;
  }
  std::vector<std::size_t> fed;
  for (std::size_t d = 0; d < size(); ++d) {
    for (std::size_t next = d; !listed[next]; next = static_cast<std::size_t>(drives_[next].fed_by)) {
      fed.push_back(next);
      listed[next] = 1;
    }
    order_.insert(order_.end(), fed.rbegin(), fed.rend());
    fed.clear();
  }
}

void DriveSystem::update_ports(double t, Span q, Span v) {
  for (std::size_t d = 0; d < size(); ++d) {
    drives_[d].port.update(model_.tree<double>(), q, v);
    now_.l[d] = drives_[d].port.l();
    now_.w[d] = drives_[d].port.w();
    now_.u[d] = drives_[d].signal(t);
  }
}

template <class T> DrivePoint<T> DriveSystem::point(std::size_t d, double t, const Values<T>& values) const {
  const Drive& drive = drives_[d];
  const T& u = drive.fed_by < 0 ? values.u[d] : values.outputs[static_cast<std::size_t>(drive.fed_by)];
  return {t, u, values.l[d], values.w[d], std::span<const T>(values.x).subspan(drive.first_x, drive.n_x)};
}

template <class T> DriveResponse<T> DriveSystem::respond(std::size_t d, double t, Values<T>& values) const {
  const Drive& drive = drives_[d];
  DriveResponse<T> response{std::span<T>(values.dx).subspan(drive.first_x, drive.n_x)};
  drive.law->evaluate(point(d, t, values), drive.statuses, response);
  values.outputs[d] = response.force;
  return response;
}

void DriveSystem::evaluate_laws(double t, Span q, Span v, Span x) {
  std::ranges::copy(x, now_.x.begin());
  update_ports(t, q, v);
  for (const std::size_t d : order_) static_cast<void>(respond(d, t, now_));
}

void DriveSystem::choose_statuses(double t, std::size_t d) {
  drives_[d].law->choose(point(d, t, now_), drives_[d].statuses);
  static_cast<void>(respond(d, t, now_));
}

void DriveSystem::start(double t, Span q, Span v, std::span<double> x) {
  for (Drive& drive : drives_) drive.signal.begin(t);
  update_ports(t, q, v);
  for (const std::size_t d : order_) {
    const Drive& drive = drives_[d];
    const std::span<double> own = std::span(now_.x).subspan(drive.first_x, drive.n_x);
    drive.law->start(point(d, t, now_), own);
    for (const auto& [name, value] : drive.initial)
      for (std::size_t k = 0; k < drive.n_x; ++k)
        if (states_[drive.first_x + k].name == drive.name + "." + name) own[k] = value;
    choose_statuses(t, d);
  }
  std::ranges::copy(now_.x, x.begin());
}

void DriveSystem::set_state(double t, Span q, Span v, Span x) {
  for (Drive& drive : drives_) drive.signal.begin(t);
  std::ranges::copy(x, now_.x.begin());
  update_ports(t, q, v);
  for (const std::size_t d : order_) choose_statuses(t, d);
}

void DriveSystem::evaluate(double t, Span q, Span v, Span x, std::span<double> tau, std::span<double> dx) {
  evaluate_laws(t, q, v, x);
  std::ranges::copy(now_.dx, dx.begin());
  for (std::size_t d = 0; d < size(); ++d) {
    if (drives_[d].feeds) continue;
    for (const auto& [c, factor] : drives_[d].port.row())
      tau[static_cast<std::size_t>(c)] += factor * now_.outputs[d];
  }
}

void DriveSystem::add_line_forces(std::span<double> tau) const {
  for (std::size_t d = 0; d < size(); ++d)
    if (drives_[d].port.is_line() && !drives_[d].feeds)
      for (const auto& [c, factor] : drives_[d].port.row())
        tau[static_cast<std::size_t>(c)] += factor * now_.outputs[d];
}

DriveEnergy DriveSystem::energy(double t, Span q, Span v, Span x) {
  std::ranges::copy(x, now_.x.begin());
  update_ports(t, q, v);
  DriveEnergy sum;
  for (const std::size_t d : order_) {
    const DriveResponse<double> response = respond(d, t, now_);
    if (drives_[d].feeds) continue;
    sum.stored += response.stored;
    sum.supplied += response.supplied;
    sum.lost += response.lost;
  }
  return sum;
}

void DriveSystem::set_duals() {
  const auto copy = [](const std::vector<double>& from, std::vector<DriveLaw::Dual>& to) {
    to.assign(from.begin(), from.end());
  };
  copy(now_.x, duals_.x);
  copy(now_.l, duals_.l);
  copy(now_.w, duals_.w);
  copy(now_.u, duals_.u);
  copy(now_.outputs, duals_.outputs);
  copy(now_.dx, duals_.dx);
}

void DriveSystem::rates_by_states(double t, Span q, Span v, Span x, std::span<double> dx,
                                  Eigen::MatrixXd& f_x) {
  evaluate_laws(t, q, v, x);
  std::ranges::copy(now_.dx, dx.begin());
  set_duals();
  const auto n = static_cast<Eigen::Index>(nx());
  f_x.resize(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    DriveLaw::Dual& argument = duals_.x[static_cast<std::size_t>(k)];
    argument.dx[0] = 1;
    for (const std::size_t d : order_) static_cast<void>(respond(d, t, duals_));
    argument.dx[0] = 0;
    for (Eigen::Index c = 0; c < n; ++c) f_x(c, k) = duals_.dx[static_cast<std::size_t>(c)].dx[0];
  }
}

/// Computes by_, the derivatives of n numbers by the arguments of the laws. After the laws have been
/// evaluated with dual numbers along a direction, f(values, out) is called with their results and must write
/// the directional derivatives of the n numbers to `out`.
template <class F> void DriveSystem::by_arguments(double t, Span q, Span v, Eigen::Index n, const F& f) {
  const auto index = [](auto k) { return static_cast<Eigen::Index>(k); };
  const Eigen::Index nv = model_.nv();
  by_.q.setZero(n, nv);
  by_.v.setZero(n, nv);
  by_.x.setZero(n, index(nx()));
  by_.u.setZero(n, index(inputs_.size()));
  set_duals();
  along_.resize(n);
  const auto along = [&](DriveLaw::Dual& argument) -> const Vector& {
    argument.dx[0] = 1;
    for (const std::size_t d : order_) static_cast<void>(respond(d, t, duals_));
    f(duals_, along_);
    argument.dx[0] = 0;
    return along_;
  };
  for (std::size_t k = 0; k < nx(); ++k) by_.x.col(index(k)) = along(duals_.x[k]);
  for (std::size_t k = 0; k < inputs_.size(); ++k) by_.u.col(index(k)) = along(duals_.u[inputs_[k]]);
  for (std::size_t d = 0; d < size(); ++d) {
    Drive& drive = drives_[d];
    along(duals_.l[d]);
    for (const auto& [c, factor] : drive.port.row()) by_.q.col(c) += factor * along_;
    along(duals_.w[d]);
    for (const auto& [c, factor] : drive.port.row()) by_.v.col(c) += factor * along_;
    // The row E of a line depends on q, and hence w = E v depends on q also by E.
    if (!drive.port.is_line()) continue;
    of_row_.assign(static_cast<std::size_t>(nv * nv), 0.0);
    drive.port.add_row_derivatives(model_.tree<double>(), q, 1, of_row_);
    const Eigen::Map<const Vector> velocities(v.data(), nv);
    const Eigen::Map<const Matrix> E_q(of_row_.data(), nv, nv);
    for (Eigen::Index j = 0; j < nv; ++j) by_.q.col(j) += velocities.dot(E_q.col(j)) * along_;
  }
}

void DriveSystem::derivatives(double t, Span q, Span v, Span x, DriveDerivatives& out) {
  evaluate_laws(t, q, v, x);
  const Eigen::Index nv = model_.nv(), n_x = static_cast<Eigen::Index>(nx());
  by_arguments(t, q, v, nv + n_x, [&](const Values<DriveLaw::Dual>& values, Vector& along) {
    along.setZero();
    for (std::size_t d = 0; d < size(); ++d) {
      if (drives_[d].feeds) continue;
      for (const auto& [c, factor] : drives_[d].port.row()) along[c] += factor * values.outputs[d].dx[0];
    }
    for (Eigen::Index k = 0; k < n_x; ++k) along[nv + k] = values.dx[static_cast<std::size_t>(k)].dx[0];
  });
  out.tau_q = by_.q.topRows(nv);
  out.tau_v = by_.v.topRows(nv);
  out.tau_x = by_.x.topRows(nv);
  out.tau_u = by_.u.topRows(nv);
  out.f_q = by_.q.bottomRows(n_x);
  out.f_v = by_.v.bottomRows(n_x);
  out.f_x = by_.x.bottomRows(n_x);
  out.f_u = by_.u.bottomRows(n_x);
  // The force τ = Eᵀ g of a line depends on q also by the row E.
  of_row_.assign(static_cast<std::size_t>(nv * nv), 0.0);
  for (std::size_t d = 0; d < size(); ++d)
    if (!drives_[d].feeds)
      drives_[d].port.add_row_derivatives(model_.tree<double>(), q, now_.outputs[d], of_row_);
  out.tau_q += Eigen::Map<const Matrix>(of_row_.data(), nv, nv);
}

double DriveSystem::next_jump(double t) const {
  double next = std::numeric_limits<double>::infinity();
  for (const Drive& drive : drives_) next = std::min(next, drive.signal.next_jump(t));
  return next;
}

DriveSystem::LeastMargin DriveSystem::least_margin_now(double t) const {
  LeastMargin least{std::numeric_limits<double>::infinity()};
  for (std::size_t d = 0; d < size(); ++d)
    for (std::size_t k = 0; k < drives_[d].statuses.size(); ++k)
      if (const double margin = drives_[d].law->margin(k, point(d, t, now_), drives_[d].statuses);
          margin < least.value)
        least = {margin, d, k};
  return least;
}

double DriveSystem::least_margin(double t, Span q, Span v, Span x) {
  evaluate_laws(t, q, v, x);
  return least_margin_now(t).value;
}

MarginDerivatives DriveSystem::margin_derivatives(double t, Span q, Span v, Span x) {
  evaluate_laws(t, q, v, x);
  const LeastMargin least = least_margin_now(t);
  const Drive& drive = drives_[least.drive];
  by_arguments(t, q, v, 1, [&](const Values<DriveLaw::Dual>& values, Vector& out) {
    out[0] = drive.law->margin(least.status, point(least.drive, t, values), drive.statuses).dx[0];
  });
  return {by_.q, by_.v, by_.x, by_.u};
}

Eigen::VectorXd DriveSystem::input_rates(double t) const {
  constexpr double h = 1e-6;
  Eigen::VectorXd rates(static_cast<Eigen::Index>(inputs_.size()));
  for (std::size_t k = 0; k < inputs_.size(); ++k) {
    const DriveSignal& signal = drives_[inputs_[k]].signal;
    rates[static_cast<Eigen::Index>(k)] = (signal(t + h) - signal(t - h)) / (2 * h);
  }
  return rates;
}

bool DriveSystem::switch_at(double t, Span q, Span v, std::span<double> x) {
  bool changed = false;
  for (Drive& drive : drives_) {
    const double before = drive.signal(t);
    drive.signal.begin(t);
    changed = changed || drive.signal(t) != before;
  }
  // A change may make the margin of another status negative, so that statuses are checked again. The number
  // of repetitions is limited.
  constexpr int most_changes = 20;
  for (int changes = 0; changes < most_changes; ++changes) {
    evaluate_laws(t, q, v, x);
    bool again = false;
    for (Drive& drive : drives_) {
      const auto d = static_cast<std::size_t>(&drive - drives_.data());
      for (std::size_t k = 0; k < drive.statuses.size(); ++k) {
        const DrivePoint<double> at = point(d, t, now_);
        if (!(drive.law->margin(k, at, drive.statuses) < 0)) continue;
        drive.law->change(k, at, drive.statuses, x.subspan(drive.first_x, drive.n_x));
        changed = again = true;
      }
    }
    if (!again) break;
  }
  return changed;
}

void DriveSystem::discrete(std::vector<std::size_t>& out) const {
  out.clear();
  for (const Drive& drive : drives_) {
    out.push_back(drive.signal.interval());
    for (const int status : drive.statuses) out.push_back(static_cast<std::size_t>(status));
  }
}

void DriveSystem::set_discrete(std::span<const std::size_t> from) {
  auto next = from.begin();
  for (Drive& drive : drives_) {
    drive.signal.set_interval(*next++);
    for (int& status : drive.statuses) status = static_cast<int>(*next++);
  }
}

}  // namespace axode
