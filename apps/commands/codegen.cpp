#include "axode/codegen.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>

#include "apps/files/model_options.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"

namespace axode::command {
namespace {

struct CodegenOptions {
  ModelOptions mechanism;
  std::string functions = "inverse_dynamics", name, out, abi = "plain";
  bool single_precision = false;
  int states = 1;
};

constexpr const char* codegen_footer = R"(Functions (several are separated by commas):
  inverse_dynamics         tau from q, v, a
  forward_dynamics         a from q, v, tau; returns 1 if the mass matrix may be singular, else 0
  mass_matrix              M from q, nv x nv
  inverse_mass_matrix      inverse of M from q, nv x nv; returns 1 or 0 like forward_dynamics
  poses                    C of all frames from q: the columns of R, then r, 12 numbers each
  pose:FRAME               C of one frame from q
  jacobian:FRAME[:REP]     J of a frame from q, 6 x nv, angular rows first; REP is body (if left out),
                           spatial, hybrid or mixed
and derivatives of inverse_dynamics and forward_dynamics, whose names begin with the name of the function:
  _derivatives             Jacobians by q, v and a or tau, nv x nv each, one after the other
  _jvp                     derivative along a direction (dq, dv, da or dtau)
  _vjp                     gradients of w times the result by q, v and a or tau, nv each
  _hessian                 second derivatives of w times the result by (q, q), (q, v), (v, v)
                           and (a or tau, q), nv x nv each

Example:
  axode codegen arm7.toml --functions inverse_dynamics,jacobian:flange:hybrid

The file is C99 (and C++), includes no other file, and describes the arguments of each function. It
contains only the operations that this mechanism needs: products with 0 and 1, changes of sign and
repeated operations are removed, and inertia that a joint does not turn is added to the preceding body.
For angles up to 1e5 rad the results agree with `axode eval` to rounding. Compile with cc -O3
-march=native -ffp-contract=fast; -ffast-math gives wrong results.

With --abi casadi the functions are external functions of CasADi, and each has exact first and second
derivatives (the functions for derivatives above are then not available):
  axode codegen arm7.toml --functions forward_dynamics --abi casadi --output arm7.c
  cc -O3 -march=native -ffp-contract=fast -fPIC -shared arm7.c -o arm7.so -lm
and in Python casadi.external("arm7_forward_dynamics", "./arm7.so"). With --states N a function computes N
states at once, which are the columns of its arguments.

With --abi cuda the file is CUDA: it has each function for one thread of a GPU, and a kernel NAME_states
for n states. Entry k of state i is at x[k * n + i]. The kernel writes NaN if the function returns 1.)";

/// The words of an option as pairs of a word and its value, which is the index of the word.
template <class Meaning, std::size_t N> constexpr auto named(const std::array<std::string_view, N>& words) {
  std::array<std::pair<std::string_view, Meaning>, N> pairs{};
  for (std::size_t k = 0; k < N; ++k) pairs[k] = {words[k], static_cast<Meaning>(k)};
  return pairs;
}
constexpr auto function_words = named<std::size_t>(codegen::recorded_functions);
constexpr auto abis = named<codegen::Abi>(codegen::abis);

bool has_frame(const Model& model, std::string_view name) {
  return std::ranges::any_of(model.frames(), [&](const Frame& frame) { return frame.name == name; });
}

/// Parses a request for the code of the pose or the Jacobian of a frame: `pose:FRAME`, `jacobian:FRAME` or
/// `jacobian:FRAME:REP`, where REP is a representation of twists. Names of frames may contain colons.
codegen::Function of_a_frame(const Model& model, codegen::Function function, std::string frame) {
  if (frame.empty())
    throw UsageError(function.is("pose")
                         ? "--functions: pose needs a frame: pose:FRAME"
                         : "--functions: jacobian needs a frame: jacobian:FRAME or jacobian:FRAME:REP");
  const std::size_t colon = frame.rfind(':');
  if (function.is("jacobian") && colon != std::string::npos && !has_frame(model, frame)) {
    function.representation = choose("--functions: " + frame, frame.substr(colon + 1), representations);
    frame.resize(colon);
  }
  function.frame = model.frame_index(frame);
  return function;
}

std::vector<codegen::Function> wanted(const Model& model, const std::string& list) {
  std::vector<codegen::Function> all;
  for (const std::string& word : CLI::detail::split(list, ',')) {
    const std::size_t colon = std::min(word.find(':'), word.size());
    const std::size_t chosen = choose("--functions", word.substr(0, colon), function_words);
    const codegen::Function function{*catalog::Id::of(codegen::recorded_functions[chosen])};
    const std::string rest = word.substr(std::min(colon + 1, word.size()));
    if (!function.is_of_a_frame() && colon < word.size())
      throw UsageError("--functions: \"" + word + "\": only jacobian and pose take a frame");
    all.push_back(function.is_of_a_frame() ? of_a_frame(model, function, rest) : function);
  }
  return all;
}

void run(const CodegenOptions& options) {
  const Model model = load(options.mechanism);
  if (!options.name.empty() && !codegen::is_identifier(options.name))
    throw UsageError("--name: \"" + options.name +
                     "\" is not a C identifier: letters, digits and underscores, no digit first");
  const std::vector<codegen::Function> functions = wanted(model, options.functions);
  const codegen::Source source = codegen::c_source(
      model, functions,
      {options.name, options.single_precision, choose("--abi", options.abi, abis), options.states});
  if (options.out.empty()) {
    fmt::print("{}", source.text);
    return;
  }
  write_text(options.out, source.text);
  for (const auto& [name, n] : source.functions)
    fmt::print(stderr, "{}: {} products, {} sums, {} divisions, {} sines and cosines\n", name, n.products,
               n.sums, n.divisions, n.angles);
}

}  // namespace

void add_codegen(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<CodegenOptions>();
  CLI::App* codegen =
      app.add_subcommand("codegen", "Write the dynamics of a mechanism as C without loops and branches");
  add_model_options(*codegen, options->mechanism);
  codegen
      ->add_option("--functions", options->functions,
                   "Functions to write, from the list below; default: inverse_dynamics")
      ->type_name("FUNCTIONS");
  codegen->add_flag("--float", options->single_precision, "Write float instead of double");
  codegen
      ->add_option("--abi", options->abi,
                   "Calling convention: of C, of CasADi, or for threads of a GPU; default: plain")
      ->type_name(words(abis));
  codegen
      ->add_option("--states", options->states,
                   "With --abi casadi: how many states a function is of; default: 1")
      ->type_name("N");
  codegen->add_option("--name", options->name, "Prefix of all names; default: the model's name")
      ->type_name("PREFIX");
  codegen->add_option("--output", options->out, "The file to write; default: standard output")
      ->type_name("FILE");
  codegen->footer(codegen_footer);
  codegen->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
