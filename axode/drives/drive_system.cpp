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

DriveSystem::Values<DriveLaw::Dual> DriveSystem::with_duals() const {
  const auto of = [](const std::vector<double>& numbers) {
    return std::vector<DriveLaw::Dual>(numbers.begin(), numbers.end());
  };
  return {of(now_.x), of(now_.l), of(now_.w), of(now_.u), of(now_.outputs), of(now_.dx)};
}

Eigen::MatrixXd DriveSystem::rates_by_states(double t, Span q, Span v, Span x, std::span<double> dx) {
  evaluate_laws(t, q, v, x);
  std::ranges::copy(now_.dx, dx.begin());
  Values<DriveLaw::Dual> values = with_duals();
  const auto n = static_cast<Eigen::Index>(nx());
  Eigen::MatrixXd f_x(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    DriveLaw::Dual& argument = values.x[static_cast<std::size_t>(k)];
    argument.dx[0] = 1;
    for (const std::size_t d : order_) static_cast<void>(respond(d, t, values));
    argument.dx[0] = 0;
    for (Eigen::Index c = 0; c < n; ++c) f_x(c, k) = values.dx[static_cast<std::size_t>(c)].dx[0];
  }
  return f_x;
}

/// Computes the derivatives of n numbers by the arguments of the laws. After the laws have been evaluated
/// with dual numbers along a direction, f(values, out) is called with their results and must write the
/// directional derivatives of the n numbers to `out`.
template <class F>
DriveSystem::ByArguments DriveSystem::by_arguments(double t, Span q, Span v, Eigen::Index n, const F& f) {
  const auto index = [](auto k) { return static_cast<Eigen::Index>(k); };
  const Eigen::Index nv = model_.nv();
  const auto zeros = [n](Eigen::Index columns) { return Eigen::MatrixXd::Zero(n, columns).eval(); };
  ByArguments out{zeros(nv), zeros(nv), zeros(index(nx())), zeros(index(inputs_.size()))};
  Values<DriveLaw::Dual> values = with_duals();
  Vector by(n);
  const auto along = [&](DriveLaw::Dual& argument) -> const Vector& {
    argument.dx[0] = 1;
    for (const std::size_t d : order_) static_cast<void>(respond(d, t, values));
    f(values, by);
    argument.dx[0] = 0;
    return by;
  };
  for (std::size_t k = 0; k < nx(); ++k) out.x.col(index(k)) = along(values.x[k]);
  for (std::size_t k = 0; k < inputs_.size(); ++k) out.u.col(index(k)) = along(values.u[inputs_[k]]);
  std::vector<double> of_row(static_cast<std::size_t>(nv * nv));
  for (std::size_t d = 0; d < size(); ++d) {
    const Drive& drive = drives_[d];
    along(values.l[d]);
    for (const auto& [c, factor] : drive.port.row()) out.q.col(c) += factor * by;
    along(values.w[d]);
    for (const auto& [c, factor] : drive.port.row()) out.v.col(c) += factor * by;
    // The row E of a line depends on q, and hence w = E v depends on q also by E.
    if (!drive.port.is_line()) continue;
    std::ranges::fill(of_row, 0.0);
    drive.port.add_row_derivatives(model_.tree<double>(), q, 1, of_row);
    const Eigen::Map<const Vector> velocities(v.data(), nv);
    out.q += by * (velocities.transpose() * Eigen::Map<const Matrix>(of_row.data(), nv, nv));
  }
  return out;
}

DriveDerivatives DriveSystem::derivatives(double t, Span q, Span v, Span x) {
  evaluate_laws(t, q, v, x);
  const Eigen::Index nv = model_.nv(), n_x = static_cast<Eigen::Index>(nx());
  const ByArguments by = by_arguments(t, q, v, nv + n_x, [&](Values<DriveLaw::Dual>& values, Vector& out) {
    out.setZero();
    for (std::size_t d = 0; d < size(); ++d) {
      if (drives_[d].feeds) continue;
      for (const auto& [c, factor] : drives_[d].port.row()) out[c] += factor * values.outputs[d].dx[0];
    }
    for (Eigen::Index k = 0; k < n_x; ++k) out[nv + k] = values.dx[static_cast<std::size_t>(k)].dx[0];
  });
  DriveDerivatives out{by.q.topRows(nv),     by.v.topRows(nv),     by.x.topRows(nv),
                       by.u.topRows(nv),     by.q.bottomRows(n_x), by.v.bottomRows(n_x),
                       by.x.bottomRows(n_x), by.u.bottomRows(n_x)};
  // The force τ = Eᵀ g of a line depends on q also by the row E.
  std::vector<double> of_row(static_cast<std::size_t>(nv * nv));
  for (std::size_t d = 0; d < size(); ++d)
    if (!drives_[d].feeds)
      drives_[d].port.add_row_derivatives(model_.tree<double>(), q, now_.outputs[d], of_row);
  out.tau_q += Eigen::Map<const Matrix>(of_row.data(), nv, nv);
  return out;
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
  const ByArguments by = by_arguments(t, q, v, 1, [&](const Values<DriveLaw::Dual>& values, Vector& out) {
    out[0] = drive.law->margin(least.status, point(least.drive, t, values), drive.statuses).dx[0];
  });
  return {by.q, by.v, by.x, by.u};
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

}  // namespace axode
