#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/commands/assembling.hpp"
#include "apps/files/contact_tables.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/state.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "axode/contact.hpp"
#include "axode/model/configuration.hpp"
#include "axode/view/mesh_hull.hpp"

namespace axode::command {
namespace {

struct ContactsOptions {
  ModelOptions mechanism;
  std::string state, format = "table";
  AtRestOptions contacts;
  Assembling assembling;
};

constexpr const char* contacts_footer =
    R"(Finds the points at which collision shapes touch or nearly touch, and the forces there if the mechanism
is at rest and is let go at this instant. Forces obey Signorini's and Coulomb's laws for accelerations, and the
last line says whether the mechanism stays at rest under them. Hard stops, closed loops and springs take part.

The normal is a unit vector from a to b, and the force acts on b, in inertial axes. The status of a point is
stick, slide (it begins to slide) or open (no force). Where several points carry one load, as four points of
a box do, the share of each is arbitrary; their sum and moment are not.

STATE is the JSON object of `axode eval` with the keys q, tau and loads. Without STATE the mechanism is in
the initial state of the drawing, [state], or with all joints at zero.

Example:
  axode contacts quadruped.toml --margin 0.05)";

void run(const ContactsOptions& options) {
  const Format format = choose("--format", options.format, formats);
  const Model model = load(options.mechanism);
  State state = options.state.empty() ? starting_state(model) : read_state(model, options.state);
  if (!options.state.empty() && std::ranges::any_of(state.v, [](double x) { return x != 0; }))
    throw InputError(
        "STATE has velocities, v; contacts finds forces at rest, and simulate those of a motion");
  Assembling assembling = options.assembling;
  if (options.state.empty() && model.description().state) assembling.wanted = !model.loops().empty();
  assemble(model, assembling, state);
  const ContactShapes shapes(model, hull_of_mesh);
  const ContactsAtRest found =
      contacts_at_rest(model, shapes, state.q, state.tau, options.contacts, {state.loads});
  std::vector<std::string> names;
  for (int i = 0; i < shapes.size(); ++i) names.push_back(shapes[i].name);
  double fastest = 0;
  for (const double a : found.a) fastest = std::max(fastest, std::abs(a));
  constexpr double rest = 1e-9;
  if (format == Format::json) {
    fmt::print("{}", text({{"model", model.name()},
                           {"contacts", contacts_json(names, found.contacts)},
                           {"velocities", velocity_names(model)},
                           {"a", found.a},
                           {"at_rest", fastest <= rest},
                           {"certificate", found.certificate}}));
    return;
  }
  if (shapes.pairs().empty())
    fmt::print("no collision shapes can touch; --floor puts the mechanism on a floor\n");
  else if (found.contacts.empty())
    fmt::print("no shapes are nearer than the margin of {} m\n",
               significant(options.contacts.margin.value_or(shapes.margin())));
  else
    fmt::print("{}\n", contacts_table(names, found.contacts));
  fmt::print("{}; certificate {}\n",
             fastest <= rest ? "the mechanism stays at rest"
                             : fmt::format("the mechanism starts to move, with accelerations of up to {}",
                                           significant(fastest, 3)),
             significant(found.certificate, 2));
}

}  // namespace

void add_contacts(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<ContactsOptions>();
  CLI::App* contacts = app.add_subcommand("contacts", "Find points of contact, and their forces at rest");
  add_model_options(*contacts, options->mechanism);
  add_floor_option(*contacts, options->mechanism);
  contacts->add_option("--state", options->state, "JSON, - for standard input; default: the initial state")
      ->type_name("FILE");
  add_assembly_options(*contacts, options->assembling);
  contacts
      ->add_option("--margin", options->contacts.margin,
                   "Show points with a gap below this, m; default: that of the drawing")
      ->type_name("NUMBER");
  contacts
      ->add_option("--touching", options->contacts.touching,
                   "Gap up to which shapes press on each other, m; default: 1e-6")
      ->type_name("NUMBER");
  contacts->add_flag("--joint-losses", options->contacts.joint_losses,
                     "Count dry friction of the joints at rest");
  contacts->add_option("--format", options->format, "Output format; default: table")
      ->type_name(words(formats));
  contacts->footer(contacts_footer);
  contacts->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
