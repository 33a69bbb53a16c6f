#include "apps/quantities/quantities.hpp"

#include <fmt/format.h>

#include <optional>

#include "apps/shell/commands.hpp"
#include "axode/catalog.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/dynamics.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "axode/table/check_counts.hpp"

/// The quantities of `axode eval` that axode/catalog.hpp has, whose results are arrays of numbers.
namespace axode::command {
namespace {

using catalog::Choice;
using catalog::Entry;
using catalog::Extent;
using catalog::Input;
using Row = catalog::Function<double>;
using Reals = std::span<const double>;

std::string_view name_of(Representation representation) {
  switch (representation) {
    case Representation::body: return "body-fixed";
    case Representation::spatial: return "spatial";
    case Representation::hybrid: return "hybrid";
    case Representation::mixed: break;
  }
  return "mixed";
}

std::string rate_axes(Representation representation) {
  switch (representation) {
    case Representation::body: return "in the frame's own axes; v' = R^T r'' - w x v, not r''";
    case Representation::spatial:
      return "in inertial axes, about the inertial origin; v' is not r'' of the frame";
    case Representation::hybrid: return "in inertial axes; v' = r'' of the frame's origin";
    case Representation::mixed: break;
  }
  return "w' in the frame's own axes; v' = r'' of its origin in inertial axes";
}
/// Says in words in which axes a wrench is given and about which point its moment is. `whose` ("frame" or
/// "body") names the owner of the axes in the body-fixed and mixed representations, as in "the frame's own
/// axes". `own` names the point in these two representations, and `point` names it in the hybrid one.
std::string wrench_axes(Representation representation, const char* whose, const char* own,
                        const std::string& point) {
  switch (representation) {
    case Representation::body: return fmt::format("in the {}'s own axes, about {}", whose, own);
    case Representation::spatial: return "in inertial axes, about the inertial origin";
    case Representation::hybrid: return fmt::format("in inertial axes, about {}", point);
    case Representation::mixed: break;
  }
  return fmt::format("moment in the {}'s own axes, about {}; force in inertial axes", whose, own);
}

std::string details_of(const Row& row, const Question& ask) {
  const Representation representation = ask.representation;
  if (row.choice != Choice::representation) return "";
  switch (row.entry) {
    case Entry::twist: return components_in(representation, twist_axes(representation));
    case Entry::rate: return components_in(representation, rate_axes(representation));
    default: break;
  }
  const char* const whose = row.takes_input(Input::place) ? "frame" : "body";
  constexpr const char* joint = "the joint's point";
  const bool at_joint = row.takes_input(Input::at) && ask.at == WrenchPoint::joint;
  return components_in(representation, wrench_axes(representation, whose, at_joint ? joint : "its origin",
                                                   at_joint ? joint : fmt::format("the {}'s origin", whose)));
}

/// An axis of a result that is an array, with the names of the entries along it.
struct Axis {
  std::string_view heading;
  std::vector<std::string> names;
  bool keyed = false;  ///< whether entries have their names as keys in JSON
};
Axis axis_of(Extent extent, const Question& ask) {
  const Model& model = ask.model;
  const auto names = [](int first, int end, auto name_of) {
    std::vector<std::string> list;
    for (int i = first; i < end; ++i) list.push_back(name_of(i));
    return list;
  };
  const auto joint = [&](int i) { return model.joint(i).name; };
  switch (extent) {
    case Extent::nv: return {"joint", velocity_names(model)};
    case Extent::n_bodies:
      return {"body", names(1, model.n_bodies() + 1, [&](int i) { return model.body(i).name; }), true};
    case Extent::n_joints: return {"joint", names(1, model.n_bodies() + 1, joint), true};
    case Extent::n_frames:
      return {"frame", names(0, model.n_frames(), [&](int f) { return model.frame(f).name; }), true};
    case Extent::n_screws: {
      Axis axis{"joint", {}, true};
      for (int i = 1; i <= model.n_bodies(); ++i)
        axis.names.insert(axis.names.end(), model.first_screw(i + 1) - model.first_screw(i), joint(i));
      return axis;
    }
    case Extent::n_parameters: return {"parameter", parameter_names(model)};
    case Extent::n_loads:
      return {"load on frame", names(0, static_cast<int>(ask.state.loads.size()),
                                     [&](int k) { return model.frame(ask.state.loads[k].frame).name; })};
    case Extent::six: break;
  }
  return {"unit of", {"w x", "w y", "w z", "v x", "v y", "v z"}};
}

std::vector<std::string> components_of(Entry entry, std::string_view symbol) {
  switch (entry) {
    case Entry::number: return {std::string(symbol)};
    case Entry::vector: return {"x", "y", "z"};
    case Entry::twist: return {"w x", "w y", "w z", "v x", "v y", "v z"};
    case Entry::rate: return {"w' x", "w' y", "w' z", "v' x", "v' y", "v' z"};
    case Entry::wrench: return {"m x", "m y", "m z", "f x", "f y", "f z"};
    case Entry::momentum: return {"l x", "l y", "l z", "p x", "p y", "p z"};
    case Entry::pose: return {"x", "y", "z", "quaternion x", "quaternion y", "quaternion z", "quaternion w"};
    case Entry::inertia: break;
  }
  return {"mass", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"};
}

SE3<> pose(Reals x) {
  const auto column = [&](std::size_t k) { return Vec3<>{x[k], x[k + 1], x[k + 2]}; };
  return {{column(0), column(3), column(6)}, column(9)};
}
/// The mass and the six moments of inertia about the centre of mass, without the first moment, which is 0.
std::vector<double> mass_and_inertia(Reals x) {
  std::vector<double> kept{x[0]};
  kept.insert(kept.end(), x.begin() + 4, x.end());
  return kept;
}

/// The numbers that a table shows for an entry of a result. A pose is shown as position and quaternion.
std::vector<double> shown(Entry entry, Reals x) {
  if (entry == Entry::inertia) return mass_and_inertia(x);
  if (entry != Entry::pose) return {x.begin(), x.end()};
  const auto& [R, r] = pose(x);
  const Quaternion<> a = quaternion(R);
  return {r.x, r.y, r.z, a.x, a.y, a.z, a.w};
}
Json json_of(Entry entry, Reals x) {
  if (entry == Entry::number) return x[0];
  if (entry == Entry::pose) return to_json(pose(x));
  if (entry == Entry::inertia)
    return {{"mass", x[0]}, {"inertia", std::vector<double>(x.begin() + 4, x.end())}};
  return std::vector<double>(x.begin(), x.end());
}

/// Writes the results of one call of a function of the catalogue. A result is an array with the axes `axes`.
struct Result {
  const Question& ask;
  const Row& row;
  std::vector<Axis> axes;

  std::size_t numbers_from(std::size_t axis) const {
    std::size_t n = static_cast<std::size_t>(catalog::numbers_of(row.entry));
    for (; axis < axes.size(); ++axis) n *= axes[axis].names.size();
    return n;
  }
  /// Whether entry k along an axis of the result is left out, as it belongs to a frame that is not wanted.
  bool left_out(std::size_t axis, std::size_t k) const {
    return row.shape[axis] == Extent::n_frames && !ask.frames.empty() &&
           std::find(ask.frames.begin(), ask.frames.end(), static_cast<int>(k)) == ask.frames.end();
  }

  Json json(Reals x, std::size_t axis = 0) const {
    if (axis == axes.size()) return json_of(row.entry, x);
    const std::size_t size = numbers_from(axis + 1);
    const auto part = [&](std::size_t k) { return x.subspan(k * size, size); };
    const auto& [heading, names, keyed] = axes[axis];
    Json out = keyed ? Json::object() : Json::array();
    if (row.shape[axis] == Extent::n_screws) {
      for (const Joint& joint : ask.model.joints()) out[joint.name] = Json::array();
      for (std::size_t k = 0; k < names.size(); ++k) out[names[k]].push_back(json(part(k), axis + 1));
    } else if (row.columns && axis + 1 == axes.size()) {
      for (std::size_t r = 0; r < size; ++r) {
        Json& entries = out.emplace_back(Json::array());
        for (std::size_t k = 0; k < names.size(); ++k) entries.push_back(part(k)[r]);
      }
    } else {
      for (std::size_t k = 0; k < names.size(); ++k) {
        if (left_out(axis, k)) continue;
        if (keyed) {
          out[names[k]] = json(part(k), axis + 1);
        } else {
          out.push_back(json(part(k), axis + 1));
        }
      }
    }
    return out;
  }

  /// Whether a result is printed as a matrix of numbers; on_its_side() says whether the matrix is transposed.
  bool matrix() const { return row.entry == Entry::number && axes.size() > 1; }
  bool on_its_side() const { return matrix() && row.shape.back() == Extent::n_parameters; }
  /// Whether several results of the function are printed below each other and not side by side.
  bool stacked() const { return row.symbols.size() > 1 && (matrix() || row.entry != Entry::number); }

  std::vector<std::string> headings() const {
    std::vector<std::string> list;
    const auto append = [&](const std::vector<std::string>& more) {
      list.insert(list.end(), more.begin(), more.end());
    };
    if (row.takes_input(Input::place)) list.emplace_back("frame");
    if (stacked()) list.emplace_back("");
    if (on_its_side()) {
      list.emplace_back(axes[1].heading);
      append(axes[0].names);
      return list;
    }
    for (std::size_t axis = 0; axis + (matrix() ? 1 : 0) < axes.size(); ++axis)
      list.emplace_back(matrix() && axes.size() == 3 && axis == 0 ? (row.name == "christoffel" ? "i" : "k")
                                                                  : axes[axis].heading);
    if (matrix()) {
      append(axes.back().names);
    } else if (stacked()) {
      append(components_of(row.entry, ""));
    } else {
      for (const std::string_view symbol : row.symbols) append(components_of(row.entry, symbol));
    }
    return list;
  }

  /// The JSON of the results: a single result as it is, or several results with their symbols as keys.
  Json json_of_all(const std::vector<Reals>& results) const {
    if (results.size() == 1) return json(results[0]);
    Json all = Json::object();
    for (std::size_t k = 0; k < results.size(); ++k) all[row.symbols[k]] = json(results[k]);
    return all;
  }
  /// Adds all results of the call to a table. `before` are the first cells of the first row, such as the name
  /// of a frame; they are empty in all other rows, so that a name is printed only once.
  void tabulate_all(const std::vector<Reals>& results, std::vector<Cell> before, Table& table) const {
    if (!stacked()) return tabulate(results, std::move(before), table);
    for (std::size_t k = 0; k < results.size(); ++k) {
      std::vector<Cell> cells = before;
      cells.emplace_back(std::string(row.symbols[k]));
      tabulate({results[k]}, std::move(cells), table);
      for (Cell& cell : before) cell = "";  // a name is printed only in its first row
      if (k + 1 < results.size() && !axes.empty()) table.rule();
    }
  }

  /// Adds rows with the numbers of the arrays `results` to a table. The arrays have the same shape, and one
  /// row has the numbers of all of them side by side. A row begins with the names of its indices, one for
  /// each axis of the arrays; the last axis of a matrix is an exception, because its indices are the columns
  /// of the table. The function calls itself for each axis: `results` are then the parts of arrays at one
  /// index on each of the first `axis` axes. `before` are the cells before the indices, such as the name of a
  /// frame. They are filled in the first row and empty in all other rows, so that a name is printed only
  /// once. A matrix whose columns are inertial parameters is written transposed, without these cells.
  void tabulate(const std::vector<Reals>& results, std::vector<Cell> before, Table& table,
                std::size_t axis = 0) const {
    if (on_its_side()) {
      const auto& names = axes[1].names;
      for (std::size_t k = 0; k < names.size(); ++k) {
        std::vector<Cell> cells{names[k]};
        for (std::size_t r = 0; r < axes[0].names.size(); ++r)
          cells.emplace_back(results[0][r * names.size() + k]);
        table.row(std::move(cells));
      }
      return;
    }
    if (axis + (matrix() ? 1 : 0) == axes.size()) {
      for (const Reals x : results) {
        const std::vector<double> numbers =
            matrix() ? std::vector<double>(x.begin(), x.end()) : shown(row.entry, x);
        before.insert(before.end(), numbers.begin(), numbers.end());
      }
      table.row(std::move(before));
      return;
    }
    const std::size_t size = numbers_from(axis + 1);
    for (std::size_t k = 0; k < axes[axis].names.size(); ++k) {
      if (left_out(axis, k)) continue;
      std::vector<Reals> parts;
      for (const Reals x : results) parts.push_back(x.subspan(k * size, size));
      std::vector<Cell> cells = before;
      cells.emplace_back(axes[axis].names[k]);
      tabulate(parts, std::move(cells), table, axis + 1);
      for (Cell& cell : before) cell = "";  // a name is printed only in its first row
      if (matrix() && axis + 2 < axes.size()) table.rule();
    }
  }
};

const Row& row_of(std::string_view name, Representation representation) {
  return with_representation(representation,
                             [&]<class Rep>(Rep) -> const Row& { return *catalog::find<Rep>(name); });
}

Answer answer(const Question& ask, std::string_view name) {
  const Row& row = row_of(name, ask.representation);
  const Model& model = ask.model;
  catalog::check_counts(row, model, catalog::Caller::whole);
  Workspace<> workspace(model);
  std::optional<LoopWorkspace<>> loops;
  if (!model.loops().empty() && row.call_with_loops != nullptr) loops.emplace(model);
  const State& state = ask.state;
  catalog::Arguments<double> given{state.q, state.v, state.a, state.tau, state.p};
  given.dq = state.dq;
  given.dv = state.dv;
  given.da = state.da;
  given.dtau = state.dtau;
  given.w = state.w;
  given.loads = ask.loads();
  given.base = ask.relative_to;
  given.form = ask.coriolis;
  given.at = ask.at;
  std::vector<double> p(model.nv());
  if (ask.state.p.empty()) {
    momenta(model, workspace, ask.state.q, ask.state.v, p);
    given.p = p;
  }

  Result result{ask, row, {}};
  for (const Extent extent : row.shape) result.axes.push_back(axis_of(extent, ask));
  Answer made{Json::object(), Table(result.headings()), std::string(row.units), details_of(row, ask)};
  std::vector<double> out(row.size(model, ask.state.loads.size()));
  const auto make = [&](const std::string& who) {
    const Solvability outcome =
        loops ? row.call_with_loops(model, *loops, given, out) : row.call(model, workspace, given, out);
    if (!outcome.ok()) throw InputError(who + to_string(model, outcome));
    std::vector<Reals> results;
    for (std::size_t k = 0, size = out.size() / row.symbols.size(); k < row.symbols.size(); ++k)
      results.push_back(Reals(out).subspan(k * size, size));
    return results;
  };
  if (row.takes_input(Input::place)) {
    for (const int frame : frames_of(ask)) {
      const std::string& frame_name = model.frame(frame).name;
      given.place = frame;
      const std::vector<Reals> results = make(fmt::format("{}: frame \"{}\": ", name, frame_name));
      made.value[frame_name] = result.json_of_all(results);
      result.tabulate_all(results, {frame_name}, made.table);
      made.table.rule();
    }
    return made;
  }
  const std::vector<Reals> results = make("");
  if (results.size() > 1 && row.takes_input(Input::p)) made.value["p"] = given.p;
  const Json found = result.json_of_all(results);
  if (results.size() > 1) {
    made.value.update(found);
  } else {
    made.value = found;
  }
  result.tabulate_all(results, {}, made.table);
  return made;
}

}  // namespace

std::string twist_axes(Representation representation) {
  switch (representation) {
    case Representation::body: return "in the frame's own axes, v of its origin";
    case Representation::spatial: return "in inertial axes, v of the body's point at the inertial origin";
    case Representation::hybrid: return "in inertial axes, v = r' of the frame's origin";
    case Representation::mixed: break;
  }
  return "w in the frame's own axes, v = r' of its origin in inertial axes";
}

std::string components_in(Representation representation, const std::string& axes) {
  return fmt::format("{}: {}", name_of(representation), axes);
}

std::vector<int> frames_of(const Question& ask) {
  if (!ask.frames.empty()) return ask.frames;
  std::vector<int> all;
  for (int f = 1; f < ask.model.n_frames(); ++f) all.push_back(f);
  return all;
}

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = [] {
    std::vector<Quantity> list;
    for (const Row& row : catalog::functions<BodyFixed>())
      list.push_back(
          {row.name, row.purpose, [name = row.name](const Question& ask) { return answer(ask, name); }});
    for (Quantity& other : other_quantities()) list.push_back(std::move(other));
    for (Quantity& other : loop_quantities()) list.push_back(std::move(other));
    for (Quantity& other : contact_quantities()) list.push_back(std::move(other));
    for (Quantity& other : drive_quantities()) list.push_back(std::move(other));
    return list;
  }();
  return all;
}

}  // namespace axode::command
