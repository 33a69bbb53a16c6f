#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "apps/demo/tree_drawing.hpp"
#include "apps/files/json_text.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/state_table.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "axode/constraints/assembly.hpp"
#include "axode/constraints/mobility.hpp"
#include "axode/kinematics.hpp"

namespace axode::command {
namespace {

struct InfoOptions {
  ModelOptions mechanism;
  std::string format = "table";
};

constexpr const char* info_footer = R"(Example:
  axode info humanoid.urdf --base free

Joints are listed with the indices of their coordinates q and velocities v: a joint with a rotation has
one coordinate more (a quaternion x y z w) than velocities. Coupled joints have neither.

For a mechanism with loops the command prints the degrees of freedom and the number of drives, which is
the number of velocities of all joints that are not passive. A joint is passive if the drawing says so, and
a free joint unless the drawing says passive = false.)";

constexpr std::size_t most_warnings = 12;

/// A property of a degree of freedom of a joint, such as its damping: its name in JSON, its heading in a
/// table, and the member of Dof that holds it.
struct DofField {
  const char* name;
  const char* heading;
  double Dof::*value;
};
/// The numbers of joint springs and stops, which few joints have.
constexpr std::array<DofField, 4> spring_fields{{{"stiffness", "stiffness", &Dof::stiffness},
                                                 {"rest", "rest", &Dof::rest},
                                                 {"stop_stiffness", "stop", &Dof::stop_stiffness},
                                                 {"stop_damping", "its damping", &Dof::stop_damping}}};
constexpr std::array<DofField, 7> dof_fields{{{"lower", "lower", &Dof::lower},
                                              {"upper", "upper", &Dof::upper},
                                              {"velocity", "speed", &Dof::velocity},
                                              {"effort", "effort", &Dof::effort},
                                              {"damping", "damping", &Dof::damping},
                                              {"friction", "friction", &Dof::friction},
                                              {"armature", "armature", &Dof::armature}}};

/// The joint whose coordinate is in a term of a coupling.
const Joint& moved_by(const Model& model, const LoopCoupling::Term& term) {
  return *std::ranges::find_if(model.joints(),
                               [&](const Joint& j) { return !j.leader && j.iv == term.velocity; });
}
/// The sum Σ factor q of a coupling as text.
std::string sum(const Model& model, const LoopCoupling& coupling) {
  std::string text;
  for (const LoopCoupling::Term& term : coupling.terms) {
    const bool negative = term.factor < 0;
    text += text.empty() ? (negative ? "-" : "") : (negative ? " - " : " + ");
    text += fmt::format("{} q({})", significant(std::abs(term.factor)), moved_by(model, term).name);
  }
  return text;
}

bool says_nothing(const Dof& dof, const DofField& field) { return dof.*field.value == Dof{}.*field.value; }

/// The centre of mass with every joint at zero; null if the model has no mass.
Json neutral_center_of_mass(const Model& model) {
  if (!(model.total_mass() > 0)) return nullptr;
  Workspace<> workspace(model);
  return to_json(center_of_mass(model, workspace, neutral(model)));
}

/// The mobility of a mechanism with loops, at a closed configuration near q = 0; empty if none is found.
std::optional<int> degrees_of_freedom(const Model& model) {
  const AssemblyResult closed = assemble(model, neutral(model));
  if (closed.status != AssemblyStatus::closed) return std::nullopt;
  return loop_mobility(model, closed.q).degrees_of_freedom;
}

std::ptrdiff_t number_of_drives(const Model& model) { return std::ranges::count(model.loops().driven, 1); }

/// A text about a mechanism with loops, such as `3 degrees of freedom, 9 drives`.
std::string freedom_and_drives(const Model& model) {
  const std::string drives = counted(static_cast<std::size_t>(number_of_drives(model)), "drive");
  if (const std::optional<int> freedom = degrees_of_freedom(model))
    return counted(static_cast<std::size_t>(*freedom), "degree of freedom", "degrees of freedom") + ", " +
           drives;
  return drives + "; the loops do not close from the neutral configuration";
}

Json as_json(const Loop& loop, const Model& model) {
  return {{"name", loop.name},
          {"kind", to_string(loop.kind)},
          {"rows", loop.rows},
          {"between", {model.body(loop.ends[0].body).name, model.body(loop.ends[1].body).name}}};
}
Json as_json(const LoopCoupling& coupling, const Model& model) {
  Json about{
      {"name", coupling.name}, {"kind", "coupling"}, {"rows", coupling.rows}, {"offset", coupling.offset}};
  for (const LoopCoupling::Term& term : coupling.terms)
    about["terms"].push_back({{"joint", moved_by(model, term).name}, {"factor", term.factor}});
  return about;
}

std::string_view curve_name(const ForceCurve& curve) {
  constexpr std::array<std::string_view, 4> names{"linear", "polynomial", "table", "gas"};
  static_assert(names.size() == std::variant_size_v<ForceCurve>);
  return names[curve.index()];
}

/// The names of the frames that a spring connects, in this order; empty for a spring on joint coordinates.
std::vector<std::string> places_of(const Model& model, const Spring& spring) {
  std::vector<std::string> names;
  if (const auto* path = std::get_if<Spring::Path>(&spring.geometry))
    for (const Spring::Path::Point& it : path->points) names.push_back(model.frame(it.frame).name);
  else if (const auto* torsion = std::get_if<Spring::Torsion>(&spring.geometry))
    for (const Spring::End& end : torsion->ends) names.push_back(model.frame(end.frame).name);
  else if (const auto* bushing = std::get_if<Spring::Bushing>(&spring.geometry))
    for (const Spring::End& end : bushing->ends) names.push_back(model.frame(end.frame).name);
  return names;
}

/// Spring k of the model as JSON.
Json as_json(const Model& model, std::size_t k) {
  const Spring& spring = model.springs().elements[k];
  const SpringDescription& described = model.description().springs[k];
  Json about{{"name", spring.name}, {"kind", to_string(described.kind)}};
  if (traits(described.kind).has("terms"))
    for (const auto& [joint, factor] : described.terms)
      about["terms"].push_back({{"joint", joint}, {"factor", factor}});
  else
    about["between"] = places_of(model, spring);
  if (const auto* path = std::get_if<Spring::Path>(&spring.geometry))
    for (const Spring::Path::Point& it : path->points) about["points"].push_back(to_json(it.point));
  if (described.kind == SpringKind::bushing) {
    about["stiffness"] = described.K;
    about["damping"] = described.C;
    return about;
  }
  about["law"] = curve_name(spring.law.curve);
  if (const auto* linear = std::get_if<LinearCurve>(&spring.law.curve))
    about["stiffness"] = linear->stiffness;
  about["rest"] = spring.law.rest;
  about["damping"] = spring.law.damping;
  return about;
}

Json as_json(const Model& model) {
  Json out{{"model", model.name()},
           {"nq", model.nq()},
           {"nv", model.nv()},
           {"n_bodies", model.n_bodies()},
           {"gravity", to_json(model.gravity())},
           {"total_mass", model.total_mass()},
           {"center_of_mass", neutral_center_of_mass(model)},
           {"bodies", Json::array()},
           {"joints", Json::array()},
           {"frames", Json::array()},
           {"springs", Json::array()},
           {"loops", Json::array()},
           {"warnings", Json::array()}};
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    const Joint& joint = model.joint(i);
    Json about{{"name", body.name},
               {"predecessor", model.body(body.predecessor).name},
               {"joint", joint.name},
               {"mass", body.M.m}};
    if (body.M.m > 0) {
      about["center_of_mass"] = to_json(center_of_mass(body.M));
      about["inertia_about_center_of_mass"] = to_json(inertia_about_com(body.M));
    }
    out["bodies"].push_back(about);
    Json moves{{"name", joint.name}, {"kind", to_string(joint.kind)},
               {"body", body.name},  {"iq", joint.iq},
               {"nq", joint.nq},     {"iv", joint.iv},
               {"nv", joint.nv}};
    if (joint.kind == Subgroup::helical) moves["pitch"] = joint.pitch;
    if (joint.passive) moves["passive"] = true;
    if (joint.leader)
      moves["follows"] = {{"joint", model.joint(joint.leader->joint).name},
                          {"ratio", joint.leader->ratio},
                          {"offset", joint.leader->offset}};
    for (const DofField& field : dof_fields)
      for (const Dof& dof : joint.dof) moves[field.name].push_back(dof.*field.value);
    if (std::ranges::binary_search(model.springs().joints, i))
      for (const DofField& field : spring_fields)
        for (const Dof& dof : joint.dof) moves[field.name].push_back(dof.*field.value);
    out["joints"].push_back(moves);
  }
  for (const Frame& frame : model.frames())
    out["frames"].push_back(
        {{"name", frame.name}, {"body", model.body(frame.body).name}, {"pose", to_json(frame.pose)}});
  for (const Gear& gear : model.gears())
    out["gears"].push_back({{"joint", velocity_names(model)[static_cast<std::size_t>(gear.velocity)]},
                            {"gear_loss", gear.loss},
                            {"gear_loss_back", gear.loss_back}});
  for (std::size_t k = 0; k < model.springs().elements.size(); ++k)
    out["springs"].push_back(as_json(model, k));
  for (const Loop& loop : model.loops().joints) out["loops"].push_back(as_json(loop, model));
  for (const LoopCoupling& coupling : model.loops().couplings)
    out["loops"].push_back(as_json(coupling, model));
  if (!model.loops().empty()) {
    const std::optional<int> freedom = degrees_of_freedom(model);
    out["degrees_of_freedom"] = freedom ? Json(*freedom) : Json(nullptr);
    out["drives"] = number_of_drives(model);
  }
  for (const Fault& fault : model.warnings()) out["warnings"].push_back(to_string(fault));
  return out;
}

void print_joints(const Model& model) {
  std::vector<std::string> headings{"#", "joint", "kind", "q", "v"};
  for (const DofField& field : dof_fields) headings.emplace_back(field.heading);
  headings.insert(headings.end(), {"pitch", "coupling"});
  Table table(headings);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Joint& joint = model.joint(i);
    for (std::size_t d = 0; d < joint.dof.size(); ++d) {
      const bool silent = std::all_of(dof_fields.begin(), dof_fields.end(), [&](const DofField& field) {
        return says_nothing(joint.dof[d], field);
      });
      if (d > 0 && silent) continue;
      std::vector<Cell> row;
      if (d == 0) {
        row = {std::to_string(i), joint.name,
               std::string(to_string(joint.kind)) + (joint.passive ? ", passive" : ""),
               slice('q', joint.iq, joint.nq), slice('v', joint.iv, joint.nv)};
      } else {
        row = {"", "", "", "", slice('v', joint.iv + static_cast<int>(d), 1)};
      }
      for (const DofField& field : dof_fields)
        row.push_back(says_nothing(joint.dof[d], field) ? Cell("") : Cell(joint.dof[d].*field.value));
      row.push_back(joint.kind == Subgroup::helical && d == 0 ? Cell(joint.pitch) : Cell(""));
      row.push_back(d == 0 ? coupling(model, joint) : "");
      table.row(std::move(row));
    }
  }
  fmt::print("\n{} (rad or m, N m or N, and per s; pitch in m/rad)\n{}", in(Ink::heading, "joints"),
             table.text());
}

void print_gears(const Model& model) {
  Table table({"joint", "loss when driving", "loss when driven back", ""});
  for (const Gear& gear : model.gears())
    table.row({velocity_names(model)[static_cast<std::size_t>(gear.velocity)], gear.loss, gear.loss_back,
               gear.loss_back >= 1 ? "locks itself" : ""});
  if (!table.empty())
    fmt::print("\n{} (parts of the force that they transmit)\n{}", in(Ink::heading, "gears"), table.text());
}

void print_springs(const Model& model) {
  std::vector<std::string> headings{"joint", "v"};
  for (const DofField& field : spring_fields) headings.emplace_back(field.heading);
  Table table(headings);
  for (const int i : model.springs().joints) {
    const Joint& joint = model.joint(i);
    for (std::size_t d = 0; d < joint.dof.size(); ++d) {
      std::vector<Cell> row{joint.name, slice('v', joint.iv + static_cast<int>(d), joint.nv > 0 ? 1 : 0)};
      for (const DofField& field : spring_fields)
        row.push_back(says_nothing(joint.dof[d], field) ? Cell("") : Cell(joint.dof[d].*field.value));
      table.row(std::move(row));
    }
  }
  if (!table.empty())
    fmt::print("\n{} (rad or m, N m or N, and per s)\n{}", in(Ink::heading, "springs and stops"),
               table.text());
  Table elements({"spring", "kind", "between", "and", "stiffness", "rest", "damping"});
  for (std::size_t k = 0; k < model.springs().elements.size(); ++k) {
    const Spring& spring = model.springs().elements[k];
    const SpringDescription& described = model.description().springs[k];
    std::vector<std::string> places = places_of(model, spring);
    for (const auto& [joint, factor] : described.terms) places.push_back(joint);
    const auto* linear = std::get_if<LinearCurve>(&spring.law.curve);
    const bool bushing = described.kind == SpringKind::bushing;
    elements.row({spring.name, std::string(to_string(described.kind)), places.front(), places.back(),
                  bushing             ? Cell("6 x 6")
                  : linear != nullptr ? Cell(linear->stiffness)
                                      : Cell(std::string(curve_name(spring.law.curve))),
                  spring.law.rest, spring.law.damping});
  }
  if (!elements.empty())
    fmt::print("\n{} (N/m or N m/rad, m or rad, N s/m or N m s/rad)\n{}",
               in(Ink::heading, "springs and dampers of the drawing"), elements.text());
}

void print_loops(const Model& model) {
  Table loops({"loop", "kind", "between", "and", "rows"}), couplings({"coupling", "", "offset"});
  for (const Loop& loop : model.loops().joints)
    loops.row({loop.name, std::string(to_string(loop.kind)), model.body(loop.ends[0].body).name,
               model.body(loop.ends[1].body).name, std::to_string(loop.rows)});
  for (const LoopCoupling& coupling : model.loops().couplings)
    couplings.row({coupling.name, sum(model, coupling), coupling.offset});
  if (!loops.empty()) fmt::print("\n{}\n{}", in(Ink::heading, "loops"), loops.text());
  if (!couplings.empty())
    fmt::print("\n{} (rad or m)\n{}", in(Ink::heading, "couplings of coordinates"), couplings.text());
}

void print_bodies(const Model& model) {
  Table table({"#", "body", "mass", "com x", "com y", "com z"});
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    if (body.M.m > 0) {
      const Vec3<> c = center_of_mass(body.M);
      table.row({std::to_string(i), body.name, body.M.m, c.x, c.y, c.z});
    } else {
      table.row({std::to_string(i), body.name, "massless"});
    }
  }
  if (model.total_mass() > 0) {
    Workspace<> workspace(model);
    const Vec3<> c = center_of_mass(model, workspace, neutral(model));
    table.rule().row({"", "all, in the inertial frame at q = 0", model.total_mass(), c.x, c.y, c.z});
  }
  fmt::print("\n{} (with what is fixed to them; kg, and centre of mass in the body frame, m)\n{}",
             in(Ink::heading, "bodies"), table.text());
}

void print_frames(const Model& model) {
  Table table({"frame", "on body", "x", "y", "z", "quaternion x", "y", "z", "w"});
  for (int f = model.n_bodies() + 1; f < model.n_frames(); ++f) {
    const Frame& frame = model.frame(f);
    const Quaternion<> a = quaternion(frame.pose.R);
    const Vec3<>& r = frame.pose.r;
    table.row({frame.name, model.body(frame.body).name, r.x, r.y, r.z, a.x, a.y, a.z, a.w});
  }
  if (!table.empty())
    fmt::print("\n{} (other than those of the bodies, in the frame of their body; m)\n{}",
               in(Ink::heading, "frames"), table.text());
}

void print_warnings(const Model& model, const std::string& file) {
  const auto warnings = model.warnings();
  if (warnings.empty()) return;
  fmt::print("\n{}\n", in(Ink::heading, "warnings"));
  for (const Fault& fault : warnings.first(std::min(warnings.size(), most_warnings)))
    fmt::print("  {}\n", in(Ink::warning, to_string(fault)));
  if (warnings.size() > most_warnings)
    fmt::print("  and {} more: axode check {}\n", warnings.size() - most_warnings, file);
}

void run(const InfoOptions& options) {
  const Format format = choose("--format", options.format, formats);
  const Model model = load(options.mechanism);
  if (format == Format::json) {
    fmt::print("{}", text(as_json(model)));
    return;
  }
  fmt::print("{}: {} moving bodies, {} frames, nq = {}, nv = {}, gravity {}\n\n",
             in(Ink::heading, model.name()), model.n_bodies(), model.n_frames(), model.nq(), model.nv(),
             gravity_text(model));
  if (!model.loops().empty()) fmt::print("{}\n\n", freedom_and_drives(model));
  fmt::print("{}", draw_tree(model));
  print_joints(model);
  print_gears(model);
  print_springs(model);
  print_loops(model);
  print_bodies(model);
  print_frames(model);
  print_warnings(model, options.mechanism.files.front());
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<InfoOptions>();
  CLI::App* info = app.add_subcommand(
      "info", "Show the tree, joints, springs, loops, masses, frames and warnings of a mechanism");
  add_model_options(*info, options->mechanism);
  info->add_option("--format", options->format, "Output format; default: table")->type_name(words(formats));
  info->footer(info_footer);
  info->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
