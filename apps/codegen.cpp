#include "axode/codegen.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>

#include "choice.hpp"
#include "commands.hpp"
#include "model_options.hpp"
#include "text_file.hpp"

namespace axode::command {
namespace {

struct Options {
  ModelOptions mechanism;
  std::string functions = "inverse_dynamics", name, out, abi = "plain";
  bool single_precision = false;
  int states = 1;
};

constexpr const char* footer = R"(Functions (several are separated by commas):
  inverse_dynamics         tau from q, v, a
  forward_dynamics         a from q, v, tau; returns 1 where the mass matrix may be singular, else 0
  mass_matrix              M from q, nv x nv
  inverse_mass_matrix      its inverse from q, nv x nv; returns what forward_dynamics does
  poses                    C of all frames from q: the columns of R, then r, 12 numbers each
  pose:FRAME               that of one frame
  jacobian:FRAME[:REP]     J of a frame from q, 6 x nv, angular rows first; REP is body (if left out),
                           spatial, hybrid or mixed
and, of inverse_dynamics and forward_dynamics, with their names before:
  _derivatives             by q, v and a or tau, nv x nv each, one behind the other
  _jvp                     what a direction (dq, dv, da or dtau) does to the result
  _vjp                     the gradients of w times the result by q, v and a or tau, nv each
  _hessian                 the second derivatives of w times the result by (q, q), (q, v), (v, v)
                           and (a or tau, q), nv x nv each

Example:
  axode codegen arm7.toml --functions inverse_dynamics,jacobian:flange:hybrid

The file is C99 (and C++), needs no other, and says what its arguments are. Only the operations that this
mechanism needs are in it: products with 0 and 1, signs and repetitions are gone, and inertia that a joint
does not turn is counted to the body before it. Results differ from those of `axode eval` by rounding, for
angles up to 1e5 rad. Fast with cc -O3 -march=native -ffp-contract=fast, wrong with -ffast-math.

With --abi casadi the functions, without those of derivatives, are external functions of CasADi, and each brings
its exact first and second derivatives along:
  axode codegen arm7.toml --functions forward_dynamics --abi casadi --output arm7.c
  cc -O3 -march=native -ffp-contract=fast -fPIC -shared arm7.c -o arm7.so -lm
and in Python casadi.external("arm7_forward_dynamics", "./arm7.so"). With --states N they are of N states at once,
the columns of their arguments.

With --abi cuda it is CUDA: each function for a thread of a GPU, and NAME_states, a kernel for n states that lie
side by side, entry k of state i at x[k * n + i], which writes NaN where the function returns 1.)";

/// Pairs of words and their values.
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

/// `pose:FRAME`, `jacobian:FRAME` or `jacobian:FRAME:REP`; the name of a frame may have colons itself.
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
      throw UsageError("--functions: \"" + word + "\": only jacobian and pose are about a frame");
    all.push_back(function.is_of_a_frame() ? of_a_frame(model, function, rest) : function);
  }
  return all;
}

void run(const Options& options) {
  const Model model = load(options.mechanism);
  if (!options.name.empty() && !codegen::is_identifier(options.name))
    throw UsageError("--name: \"" + options.name +
                     "\" is no C identifier: letters, digits and underscores, no digit first");
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
  const auto options = std::make_shared<Options>();
  CLI::App* codegen =
      app.add_subcommand("codegen", "Write the dynamics of a mechanism as C without loops and branches");
  add_model_options(*codegen, options->mechanism);
  codegen->add_option("--functions", options->functions, "What to write; inverse_dynamics if left out")
      ->type_name("FUNCTIONS");
  codegen->add_flag("--float", options->single_precision, "float instead of double");
  codegen
      ->add_option("--abi", options->abi,
                   "Who calls the functions: C, CasADi, or threads of a GPU; plain if left out")
      ->type_name(words(abis));
  codegen
      ->add_option("--states", options->states,
                   "With --abi casadi: how many states a function is of; 1 if left out")
      ->type_name("N");
  codegen->add_option("--name", options->name, "What all names begin with; the model's name if left out")
      ->type_name("PREFIX");
  codegen->add_option("--output", options->out, "The file to write; standard output if left out")
      ->type_name("FILE");
  codegen->footer(footer);
  codegen->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
