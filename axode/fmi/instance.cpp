#include "axode/fmi/instance.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/eigen.hpp"
#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/text.hpp"

namespace axode::fmi {
namespace {

/// A threshold of FMUs for model exchange with loops: if closing the loops would change an entry of q or v by
/// more than this number (rad, m, rad/s, m/s), the FMU asks for an event, in which it closes the loops. The
/// threshold is usual_drift if the importing program sets no tolerance. Otherwise it is this tolerance, but
/// not less than least_drift.
constexpr double usual_drift = 1e-8, least_drift = 1e-10;
/// A threshold of FMUs for model exchange without loops: if normalising the quaternions would change the
/// state by more than this number, the FMU asks for an event, in which it normalises them.
constexpr double usual_norm_error = 1e-6;
/// The event indicator of the drives is the least of their margins plus this fraction of the largest margin
/// so far. A margin becomes negative when a status of a drive, an integer that selects the form of its law,
/// must change. Because of the added number, the margin is already negative at the time at which a solver
/// locates the zero of the indicator, and the status changes.
constexpr double indicator_shift = 1e-9;

Model read(std::string_view drawing) {
  return ModelBuilder(read_drawing_text(drawing, "mechanism.toml")).build();
}

std::string open_at(double t) {
  return "the loops do not stay closed at t = " + axode::to_text(t) + " s; use a shorter step";
}

}  // namespace

Instance::Instance(Kind kind, std::string_view drawing, std::string_view settings)
    : kind_(kind),
      settings_(read_settings(settings)),
      model_(read(drawing)),
      table_(model_, settings_),
      equations_(model_, settings_, table_.loads()) {
  check_supported(model_, settings_, kind_);
  for (const Variable& it : table_.of(Role::parameter)) parameters_.push_back(it.start);
  reset();
}

void Instance::reset() {
  const auto starts = [&](Role role) {
    std::vector<double> all;
    for (const Variable& it : table_.of(role)) all.push_back(it.start);
    return all;
  };
  at_ = {0,
         starts(Role::coordinate),
         starts(Role::velocity),
         starts(Role::drive_state),
         std::vector<double>(static_cast<std::size_t>(model_.nv())),
         std::vector<double>(6 * table_.loads().size())};
  parameters_ = starts(Role::parameter);
  motion_.reset();
  mode_ = Mode::instantiated;
  model_is_old_ = state_is_raw_ = true;
  margin_scale_ = 0;
  tolerance_.reset();
  state_changed();
}

void Instance::set_up(double start, std::optional<double> tolerance) {
  at_.t = start;
  tolerance_ = tolerance;
  motion_.reset();
  state_is_raw_ = true;
  state_changed();
}

void Instance::exit_initialization() {
  prepare();
  if (kind_ == Kind::co_simulation && !motion_) start_stepping();
  mode_ = kind_ == Kind::co_simulation ? Mode::step : Mode::event;
}

void Instance::prepare() {
  if (!is_before_start()) return;
  if (model_is_old_) {
    Description description = model_.description();
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      table_.parameters()[k].in(description) = parameters_[k];
    // The states of drives start at the values that the importing program has set.
    std::size_t k = 0;
    for (DriveDescription& drive : description.drives) drive.initial.clear();
    for (const DriveState& state : equations_.drives().states()) {
      const std::size_t dot = state.name.rfind('.');
      for (std::size_t d = 0; d < description.drives.size(); ++d)
        if (equations_.drives().name(d) == state.name.substr(0, dot))
          description.drives[d].initial.emplace_back(state.name.substr(dot + 1), at_.x[k]);
      ++k;
    }
    model_ = ModelBuilder(std::move(description)).build();
    equations_ = MotionEquations(model_, settings_, table_.loads());
    model_is_old_ = false;
    state_is_raw_ = true;
  }
  if (!state_is_raw_) return;
  equations_.start(at_);
  if (kind_ == Kind::model_exchange) equations_.start_plays(at_);
  state_is_raw_ = false;
  state_changed();
}

void Instance::start_stepping() {
  motion_.emplace(model_, settings_, at_.t, at_.q, at_.v, tolerance_);
  motion_->set_forces(at_.tau, applied(at_.wrenches, table_.loads()));
}

void Instance::step(double t, double h) {
  if (mode_ != Mode::step)
    throw std::runtime_error("a communication step was requested before the initialization had ended");
  if (!(h > 0))
    throw std::runtime_error("the length of a communication step is " + axode::to_text(h) +
                             " s; it must be positive");
  constexpr double rounding = 1e-9;
  if (!(std::abs(t - motion_->t()) <= rounding * std::max({1.0, std::abs(t), h})))
    throw std::runtime_error("the communication step begins at t = " + axode::to_text(t) +
                             " s, and the last one has ended at " + axode::to_text(motion_->t()) + " s");
  motion_->set_forces(at_.tau, applied(at_.wrenches, table_.loads()));
  motion_->advance(t + h);
  at_.t = motion_->t();
  at_.q.assign(motion_->q().begin(), motion_->q().end());
  at_.v.assign(motion_->v().begin(), motion_->v().end());
  at_.x.assign(motion_->x().begin(), motion_->x().end());
  equations_.act_by(motion_->drives(), motion_->friction());
  state_changed();
}

// Values.

const Variable& Instance::variable(unsigned reference) const {
  if (reference >= table_.size())
    throw std::invalid_argument("there is no variable with the value reference " + std::to_string(reference));
  return table_[reference];
}

void Instance::refuse(const Variable& variable, const char* why) const {
  throw std::invalid_argument("variable \"" + variable.name + "\" " + why);
}

void Instance::set(References references, Span values) {
  for (std::size_t k = 0; k < references.size(); ++k) {
    const Variable& it = variable(references[k]);
    if (!std::isfinite(values[k])) refuse(it, "cannot be set to a number that is not finite");
    set_one(it, values[k]);
  }
  state_changed();
}

void Instance::set_one(const Variable& it, double value) {
  if (it.role == Role::force) {
    at_.tau[table_.driven()[it.index]] = value;
    return;
  }
  if (it.role == Role::load) {
    at_.wrenches[it.index] = value;
    return;
  }
  const bool is_state =
      it.role == Role::coordinate || it.role == Role::velocity || it.role == Role::drive_state;
  if (!is_state && it.role != Role::parameter) refuse(it, "is computed and cannot be set");
  if (!is_before_start()) refuse(it, "can be set before the end of the initialization only");
  if (it.role == Role::coordinate) at_.q[it.index] = value;
  if (it.role == Role::velocity) at_.v[it.index] = value;
  if (it.role == Role::drive_state) at_.x[it.index] = value;
  if (it.role == Role::parameter) parameters_[it.index] = value;
  state_is_raw_ = true;
  motion_.reset();
  if (it.role == Role::parameter || it.role == Role::drive_state) model_is_old_ = true;
}

void Instance::get(References references, std::span<double> values) {
  for (std::size_t k = 0; k < references.size(); ++k) values[k] = get_one(variable(references[k]));
}

double Instance::get_one(const Variable& it) {
  switch (it.role) {
    case Role::time: return at_.t;
    case Role::parameter: return parameters_[it.index];
    case Role::force: return at_.tau[table_.driven()[it.index]];
    case Role::load: return at_.wrenches[it.index];
    case Role::coordinate: return at_.q[it.index];
    case Role::velocity: return at_.v[it.index];
    case Role::drive_state: return at_.x[it.index];
    case Role::coordinate_rate: return rates().dq[it.index];
    case Role::acceleration: return rates().a[it.index];
    case Role::drive_rate: return rates().dx[it.index];
    case Role::pose: return poses()[it.index];
    case Role::indicator: prepare(); return indicator(it.index);
  }
  return 0;
}

const Rates& Instance::rates() {
  prepare();
  if (rates_) return *rates_;
  if (kind_ == Kind::co_simulation) {
    if (!motion_) start_stepping();
    motion_->set_forces(at_.tau, applied(at_.wrenches, table_.loads()));
    rates_ = Rates{coordinate_rates(model_, at_.q, at_.v),
                   {motion_->a().begin(), motion_->a().end()},
                   {motion_->dx().begin(), motion_->dx().end()}};
  } else {
    rates_ = equations_.rates(at_);
  }
  return *rates_;
}

const std::vector<double>& Instance::poses() {
  prepare();
  if (!poses_) poses_ = equations_.poses(at_, table_.frames());
  return *poses_;
}

// Model exchange.

void Instance::set_states(Span states) {
  std::size_t k = 0;
  for (const Role role : {Role::coordinate, Role::velocity, Role::drive_state})
    for (const Variable& it : table_.of(role))
      if (const double x = states[k++]; !std::isfinite(x))
        throw NoRates("the state \"" + it.name + "\" is " + axode::to_text(x) +
                      " at t = " + axode::to_text(at_.t) + " s; it must be finite");
  for (std::vector<double>* part : {&at_.q, &at_.v, &at_.x}) {
    std::ranges::copy(states.first(part->size()), part->begin());
    states = states.subspan(part->size());
  }
  state_changed();
}

void Instance::get_states(std::span<double> states) const {
  for (const std::vector<double>* part : {&at_.q, &at_.v, &at_.x}) {
    std::ranges::copy(*part, states.begin());
    states = states.subspan(part->size());
  }
}

void Instance::get_rates(std::span<double> out) {
  const Rates& now = rates();
  for (const std::vector<double>* part : {&now.dq, &now.a, &now.dx}) {
    std::ranges::copy(*part, out.begin());
    out = out.subspan(part->size());
  }
}

double Instance::gap(const Stop& stop) const {
  return stop.side * (stop.limit - (stop.ratio * at_.q[stop.coordinate] + stop.offset));
}

double Instance::indicator(std::size_t k) {
  if (k < table_.stops().size()) return gap(table_.stops()[k]);
  k -= table_.stops().size();
  if (k < table_.n_statuses()) return reserves()[k];
  return equations_.least_margin(at_) + indicator_shift * margin_scale_;
}

/// The event indicators of dry friction, plays and hard stops.
std::vector<double> Instance::reserves() {
  return kind_ == Kind::co_simulation ? equations_.rates(at_).reserves : rates().reserves;
}

double Instance::observe_margin() {
  if (!table_.drives_have_indicator()) return 1;
  const double margin = equations_.least_margin(at_);
  margin_scale_ = std::max(margin_scale_, std::abs(margin));
  return margin;
}

void Instance::get_indicators(std::span<double> indicators) {
  prepare();
  for (std::size_t k = 0; k < indicators.size(); ++k) indicators[k] = indicator(k);
}

void Instance::get_nominals(std::span<double> nominals) const {
  std::size_t k = 0;
  for (const Role role : {Role::coordinate, Role::velocity, Role::drive_state})
    for (const Variable& it : table_.of(role)) nominals[k++] = it.nominal;
}

double Instance::drift(const Point& closed) const {
  double most = 0;
  for (std::size_t k = 0; k < at_.q.size(); ++k) most = std::max(most, std::abs(closed.q[k] - at_.q[k]));
  for (std::size_t k = 0; k < at_.v.size(); ++k) most = std::max(most, std::abs(closed.v[k] - at_.v[k]));
  return most;
}

bool Instance::needs_event() {
  if (observe_margin() < 0) return true;
  if (table_.n_statuses() > 0 && std::ranges::min(reserves()) < 0) return true;
  equations_.complete_step(at_);
  Point closed = at_;
  if (!equations_.close(closed)) throw std::runtime_error(open_at(at_.t));
  if (!equations_.has_loops()) return drift(closed) > usual_norm_error;
  return drift(closed) > (tolerance_ ? std::max(*tolerance_, least_drift) : usual_drift);
}

Instance::Event Instance::update_discrete_states() {
  Event event;
  const Point before = at_;
  if (!equations_.close(at_)) throw std::runtime_error(open_at(at_.t));
  equations_.switch_plays(at_);
  equations_.switch_drives(at_);
  observe_margin();
  equations_.switch_friction(at_);
  event.states_changed = at_.q != before.q || at_.v != before.v || at_.x != before.x;
  if (const double next = equations_.next_jump(at_.t); std::isfinite(next)) event.next = next;
  state_changed();
  return event;
}

// Derivatives.

/// Whether losses of gears or, in co-simulation, contact or play act, of which there are no derivatives.
bool Instance::has_jumps() const {
  const bool meets = moves_with_contact(model_) || !model_.loops().backlashes.empty();
  return (kind_ == Kind::co_simulation && meets) || (settings_.joint_losses && !model_.gears().empty());
}

Eigen::RowVectorXd Instance::row(const Variable& it, const Eigen::MatrixXd& all) const {
  const Eigen::Index nq = std::ssize(at_.q), nv = std::ssize(at_.v), nx = std::ssize(at_.x),
                     k = static_cast<Eigen::Index>(it.index);
  Eigen::RowVectorXd unit = Eigen::RowVectorXd::Zero(all.cols());
  switch (it.role) {
    case Role::coordinate_rate: return all.row(k);
    case Role::acceleration: return all.row(nq + k);
    case Role::drive_rate: return all.row(nq + nv + k);
    case Role::pose: return all.row(nq + nv + nx + k);
    case Role::coordinate: unit[k] = 1; return unit;
    case Role::velocity: unit[nq + k] = 1; return unit;
    case Role::drive_state: unit[nq + nv + k] = 1; return unit;
    case Role::indicator:
      if (it.index < table_.stops().size()) {
        const Stop& stop = table_.stops()[it.index];
        unit[static_cast<Eigen::Index>(stop.coordinate)] = -stop.side * stop.ratio;
        return unit;
      }
      break;
    default: break;
  }
  refuse(it, "is no unknown of a derivative: unknowns are rates, outputs and gaps of stops");
}

/// Finds the column of a variable in the Jacobian of the equations of motion; empty for a parameter, which
/// has no column. Throws std::invalid_argument if derivatives by the variable do not exist.
std::optional<Eigen::Index> Instance::column(const Variable& known) const {
  const std::size_t nq = at_.q.size(), nv = at_.v.size(), nx = at_.x.size();
  const auto at = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  switch (known.role) {
    case Role::coordinate: return at(known.index);
    case Role::velocity: return at(nq + known.index);
    case Role::drive_state: return at(nq + nv + known.index);
    case Role::force: return at(nq + nv + nx + table_.driven()[known.index]);
    case Role::load: return at(nq + 2 * nv + nx + known.index);
    case Role::parameter:
      if (!is_before_start()) refuse(known, "is a known of a derivative during the initialization only");
      if (table_.parameters()[known.index].has_derivative) return {};
      refuse(known, "is no known of a derivative, because the geometry depends on it");
    default: refuse(known, "is no known of a derivative: knowns are states, inputs and parameters");
  }
}

Eigen::MatrixXd Instance::jacobian(References unknowns, References knowns) {
  prepare();
  if (has_jumps())
    throw std::runtime_error(
        "there are no derivatives with losses of gears or, in co-simulation, with contact, hard stops or "
        "play");
  if (!jacobian_) jacobian_ = equations_.jacobian(at_, table_.frames());
  const Eigen::MatrixXd& all = *jacobian_;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(unknowns.size()),
                                            static_cast<Eigen::Index>(knowns.size()));
  for (Eigen::Index i = 0; i < J.rows(); ++i) {
    const Eigen::RowVectorXd by_all = row(variable(unknowns[static_cast<std::size_t>(i)]), all);
    for (Eigen::Index k = 0; k < J.cols(); ++k)
      if (const std::optional<Eigen::Index> c = column(variable(knowns[static_cast<std::size_t>(k)])))
        J(i, k) = by_all[*c];
  }
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    const Variable& known = variable(knowns[static_cast<std::size_t>(k)]);
    if (known.role != Role::parameter) continue;
    const Eigen::VectorXd by_known = equations_.acceleration_by(at_, table_.parameters()[known.index]);
    for (Eigen::Index i = 0; i < J.rows(); ++i) {
      const Variable& unknown = variable(unknowns[static_cast<std::size_t>(i)]);
      if (unknown.role == Role::acceleration) J(i, k) = by_known[static_cast<Eigen::Index>(unknown.index)];
    }
  }
  return J;
}

void Instance::directional_derivative(References unknowns, References knowns, Span seed,
                                      std::span<double> result) {
  as_eigen(result) = jacobian(unknowns, knowns) * as_eigen(seed);
}

void Instance::adjoint_derivative(References unknowns, References knowns, Span seed,
                                  std::span<double> result) {
  as_eigen(result) = jacobian(unknowns, knowns).transpose() * as_eigen(seed);
}

}  // namespace axode::fmi
