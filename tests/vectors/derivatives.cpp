#include "axode/derivatives.hpp"
#include "axode/catalog.hpp"
#include "axode/lie/six.hpp"
#include "tests/vectors/reference_state.hpp"

/// Derivatives of every reference system: first and second derivatives of dynamics with and without loads,
/// and derivatives with respect to time and geometry, of single terms and of the motion of bodies.
namespace axode::test {
namespace {

std::vector<std::string> derivative_files() {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(vectors_folder(), ".json")) {
    const std::string name = file.stem().string();
    if (name.find("_derivatives") != std::string::npos ||
        (name.starts_with("multidof") && name.find("_trajectory") == std::string::npos))
      names.push_back(name);
  }
  return names.empty() ? std::vector{none} : names;
}

/// A model and a state of it, read from a file of derivatives.
struct DerivativeState {
  Json file;
  Model model;
  std::vector<std::size_t> place;  ///< the index in the model of each velocity of the file
  std::vector<double> q;
  std::vector<AppliedWrench<>> wrenches;

  explicit DerivativeState(const std::string& name)
      : file(read_json(vectors_folder() / (name + ".json"))), model(build(name, file)) {
    const Json& coordinates = file.at("input").at("q");
    q.resize(static_cast<std::size_t>(model.nq()));
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      const Joint& joint =
          model.joint(model.joint_index(ReferenceSystem::joint_name(static_cast<int>(i) + 1)));
      for (int k = 0; k < joint.nq; ++k)
        q[static_cast<std::size_t>(joint.iq + k)] =
            number(coordinates.at(i).is_array() ? coordinates.at(i).at(static_cast<std::size_t>(k))
                                                : coordinates.at(i));
      for (int k = 0; k < joint.nv; ++k) place.push_back(static_cast<std::size_t>(joint.iv + k));
    }
    wrenches = system(name, file).loads(model);
  }
  std::size_t nv() const { return place.size(); }

  std::vector<double> velocities(const char* key) const {
    return in_model_order(numbers(file.at("input").at(key)));
  }
  std::vector<double> in_model_order(const std::vector<double>& x) const {
    std::vector<double> out(nv());
    for (std::size_t k = 0; k < nv(); ++k) out[place[k]] = x[k];
    return out;
  }
  /// An array with `dimensions` indices, each of them over all velocities, brought into the order of the
  /// file.
  std::vector<double> in_file_order(std::span<const double> x, int dimensions) const {
    std::vector<double> out;
    const auto walk = [&](const auto& self, int left, std::size_t at) -> void {
      if (left == 0) return out.push_back(x[at]);
      for (const std::size_t k : place) self(self, left - 1, at * nv() + k);
    };
    walk(walk, dimensions, 0);
    return out;
  }

  /// Calls a function of the catalogue and returns its results one by one, in the order of the file.
  std::vector<std::vector<double>> call(const char* name, catalog::Arguments<double> given, bool loaded,
                                        int dimensions) {
    const catalog::Function<double>& function = *catalog::find<BodyFixed>(name);
    given.q = q;
    if (loaded) given.loads.wrenches = wrenches;
    std::vector<double> out(function.size(model, 0));
    Workspace<> workspace(model);
    EXPECT_TRUE(function.call(model, workspace, given, out).ok());
    std::vector<std::vector<double>> results;
    const std::size_t size = out.size() / function.symbols.size();
    for (std::size_t k = 0; k < function.symbols.size(); ++k)
      results.push_back(in_file_order(std::span(out).subspan(k * size, size), dimensions));
    return results;
  }
  /// An entry of a group of results without loads, or of the one with loads. Entries on which loads have no
  /// effect stand only in the group with loads.
  const Json& expected(bool loaded, const char* group, const char* key) const {
    const Json& found = file.at(loaded ? "with_loads" : "without_loads").at(group);
    return found.contains(key) ? found.at(key) : file.at("with_loads").at(group).at(key);
  }

 private:
  static ReferenceSystem system(const std::string& name, const Json& file) {
    if (file.contains("model")) return {name, file.at("model")};
    return ReferenceSystem(name.substr(0, name.find("_derivatives")));
  }
  static Model build(const std::string& name, const Json& file) {
    return system(name, file).build(Telling::joint_frames);
  }
};

class ReferenceDerivatives : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == none) GTEST_SKIP() << missing(vectors_folder(), "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, ReferenceDerivatives, testing::ValuesIn(derivative_files()), name_of);

TEST_P(ReferenceDerivatives, FirstOrder) {
  DerivativeState at(GetParam());
  const std::vector<double> v = at.velocities("v"), a = at.velocities("a"), tau = at.velocities("tau");
  Comparison inverse("inverse", bound), forward("forward", bound);
  for (const bool loaded : {true, false}) {
    const auto dtau = at.call("inverse_dynamics_derivatives", {.v = v, .a = a}, loaded, 2);
    const auto da = at.call("forward_dynamics_derivatives", {.v = v, .tau = tau}, loaded, 2);
    std::size_t k = 0;
    for (const char* const key : {"dtau_dq", "dtau_dv", "dtau_da"})
      inverse.expect_equal(dtau[k++], numbers(at.expected(loaded, "inverse", key)));
    k = 0;
    for (const char* const key : {"da_dq", "da_dv", "da_dtau"})
      forward.expect_equal(da[k++], numbers(at.expected(loaded, "forward", key)));
  }
}

TEST_P(ReferenceDerivatives, SecondOrder) {
  DerivativeState at(GetParam());
  const bool contracted = at.file.at("second_partials").text() == "contracted";
  const std::vector<double> v = at.velocities("v"), a = at.velocities("a"), tau = at.velocities("tau");
  const std::size_t nv = at.nv();
  const auto check = [&](const char* function, bool loaded, const catalog::Arguments<double>& given,
                         const char* group, std::initializer_list<const char*> keys, Comparison& comparison) {
    std::vector<std::vector<double>> found(keys.size());
    for (std::size_t i = 0; i < (contracted ? 1 : nv); ++i) {
      catalog::Arguments<double> weighed = given;
      std::vector<double> w(nv);
      if (contracted)
        w = at.velocities("weights");
      else
        w[at.place[i]] = 1;
      weighed.w = w;
      const auto blocks = at.call(function, weighed, loaded, 2);
      for (std::size_t k = 0; k < blocks.size(); ++k)
        found[k].insert(found[k].end(), blocks[k].begin(), blocks[k].end());
    }
    std::size_t k = 0;
    for (const char* const key : keys)
      comparison.expect_equal(found[k++], numbers(at.expected(loaded, group, key)));
  };
  Comparison inverse("inverse", 1e-10), forward("forward", 1e-10);
  for (const bool loaded : {true, false}) {
    check("inverse_dynamics_hessian", loaded, {.v = v, .a = a}, "inverse",
          {"d2tau_dqdq", "d2tau_dqdv", "d2tau_dvdv", "d2tau_dadq"}, inverse);
    check("forward_dynamics_hessian", loaded, {.v = v, .tau = tau}, "forward",
          {"d2a_dqdq", "d2a_dqdv", "d2a_dvdv", "d2a_dtaudq"}, forward);
  }
}

TEST_P(ReferenceDerivatives, InTime) {
  DerivativeState at(GetParam());
  std::vector<double> motion;
  for (const char* const key : {"v", "a", "jerk", "snap", "crackle", "pop"})
    for (const double x : at.velocities(key)) motion.push_back(x);
  const std::size_t nv = at.nv();
  InverseDynamicsRates<> rates(at.model, 4);
  Workspace<> workspace(at.model);
  Comparison there("forces", bound), back("forces of the motion that they make", bound);
  for (const bool loaded : {true, false}) {
    Loads<> loads;
    if (loaded) loads.wrenches = at.wrenches;
    std::vector<double> tau(5 * nv), found(5 * nv);
    rates.evaluate(at.q, motion, tau, loads);
    std::size_t k = 0;
    for (const char* const key : {"tau", "dtau_dt", "d2tau_dt2", "d3tau_dt3", "d4tau_dt4"})
      there.expect_equal(at.in_file_order(std::span(tau).subspan(nv * k++, nv), 1),
                         numbers(at.expected(loaded, "time", key)));
    const std::span<const double> v = std::span(motion).first(nv);
    EXPECT_TRUE(forward_dynamics_rates<double>(at.model, workspace, at.q, v, tau, found, loads).ok());
    std::vector<double> again(v.begin(), v.end()), forces(5 * nv);
    again.insert(again.end(), found.begin(), found.end());
    rates.evaluate(at.q, again, forces, loads);
    for (k = 0; k < 5; ++k) {
      const auto order = [&](const std::vector<double>& all) {
        return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(k * nv),
                                   all.begin() + static_cast<std::ptrdiff_t>((k + 1) * nv));
      };
      back.expect_equal(order(forces), order(tau));
    }
  }
}

TEST_P(ReferenceDerivatives, SecondOrderOfEveryComponent) {
  DerivativeState at(GetParam());
  if (at.file.at("second_partials").text() == "contracted") GTEST_SKIP() << "the file has contracted ones";
  const std::vector<double> v = at.velocities("v"), a = at.velocities("a"), tau = at.velocities("tau");
  Comparison inverse("inverse", 1e-10), forward("forward", 1e-10);
  std::size_t k = 0;
  const auto of_tau = at.call("inverse_dynamics_second_derivatives", {.v = v, .a = a}, false, 3);
  for (const char* const key : {"d2tau_dqdq", "d2tau_dqdv", "d2tau_dvdv", "d2tau_dadq"})
    inverse.expect_equal(of_tau[k++], numbers(at.expected(false, "inverse", key)));
  k = 0;
  const auto of_a = at.call("forward_dynamics_second_derivatives", {.v = v, .tau = tau}, false, 3);
  for (const char* const key : {"d2a_dqdq", "d2a_dqdv", "d2a_dvdv", "d2a_dtaudq"})
    forward.expect_equal(of_a[k++], numbers(at.expected(false, "forward", key)));
}

TEST_P(ReferenceDerivatives, InGeometry) {
  DerivativeState at(GetParam());
  const std::vector<double> v = at.velocities("v"), a = at.velocities("a"), tau = at.velocities("tau");
  const std::size_t n = static_cast<std::size_t>(at.model.n_bodies());
  Workspace<> workspace(at.model);
  Comparison inverse("inverse", bound), forward("forward", bound), leaves("displacements of leaves", bound),
      jacobian("Jacobian", bound);
  const auto body = [&](std::size_t i) { return ReferenceSystem::frame(at.model, static_cast<int>(i)); };
  for (const bool loaded : {true, false}) {
    Loads<> loads;
    if (loaded) loads.wrenches = at.wrenches;
    std::vector<double> dtau(at.nv() * n * 6), da(dtau);
    inverse_dynamics_geometry_derivatives(at.model, workspace, at.q, v, a, dtau, loads);
    EXPECT_TRUE(forward_dynamics_geometry_derivatives(at.model, workspace, at.q, v, tau, da, loads).ok());
    const auto in_file_order = [&](const std::vector<double>& x) {
      std::vector<double> out;
      for (std::size_t i = 1; i <= n; ++i)
        for (const std::size_t row : at.place)
          for (std::size_t u = 0; u < 6; ++u)
            out.push_back(x[(row * n + static_cast<std::size_t>(body(i)) - 1) * 6 + u]);
      return out;
    };
    inverse.expect_equal(in_file_order(dtau), numbers(at.expected(loaded, "geometric", "dtau_dpi")));
    forward.expect_equal(in_file_order(da), numbers(at.expected(loaded, "geometric", "da_dpi")));
  }
  const std::vector<double> leaf_bodies = numbers(at.file.at("leaf_bodies"));
  for (std::size_t leaf = 0; leaf < leaf_bodies.size(); ++leaf) {
    std::vector<double> J(6 * n * 6), found;
    frame_geometry_jacobian<double>(at.model, workspace, at.q,
                                    body(static_cast<std::size_t>(leaf_bodies[leaf])), J);
    for (std::size_t i = 1; i <= n; ++i)
      for (std::size_t row = 0; row < 6; ++row)
        for (std::size_t u = 0; u < 6; ++u)
          found.push_back(J[(row * n + static_cast<std::size_t>(body(i)) - 1) * 6 + u]);
    leaves.expect_equal(found, numbers(at.file.at("leaf_displacement_dpi").at(leaf)));
  }
  std::vector<Twist<BodyFixed>> dJ(n * 6 * at.nv());
  jacobian_geometry_derivatives<double>(at.model, workspace, at.q, body(n), dJ);
  std::vector<double> found;
  for (std::size_t i = 1; i <= n; ++i)
    for (std::size_t u = 0; u < 6; ++u)
      for (int row = 0; row < 6; ++row)
        for (const std::size_t k : at.place)
          found.push_back(entry(dJ[((static_cast<std::size_t>(body(i)) - 1) * 6 + u) * at.nv() + k], row));
  jacobian.expect_equal(found, numbers(at.file.at("last_body_jacobian_dpi")));
}

TEST_P(ReferenceDerivatives, OfTerms) {
  DerivativeState at(GetParam());
  const std::vector<double> v = at.velocities("v");
  Comparison terms("terms", bound);
  const Json& expected = at.file.at("terms");
  terms.expect_equal(at.call("gravity_derivatives", {}, false, 2)[0], numbers(expected.at("dgravity_dq")));
  const auto coriolis = at.call("coriolis_derivatives", {.v = v}, false, 2);
  terms.expect_equal(coriolis[0], numbers(expected.at("dcoriolis_dq")));
  terms.expect_equal(coriolis[1], numbers(expected.at("dcoriolis_dv")));
  terms.expect_equal(at.call("generalized_load_derivatives", {.v = v}, true, 2)[0],
                     numbers(expected.at("dapplied_dq")));
}

template <class Rep> const char* key_of();
template <> const char* key_of<BodyFixed>() { return "b"; }
template <> const char* key_of<Spatial>() { return "s"; }
template <> const char* key_of<Hybrid>() { return "h"; }
template <> const char* key_of<Mixed>() { return "m"; }

TEST_P(ReferenceDerivatives, OfTheMotionOfLeaves) {
  DerivativeState at(GetParam());
  const std::vector<double> v = at.velocities("v"), a = at.velocities("a");
  const std::vector<double> leaf_bodies = numbers(at.file.at("leaf_bodies"));
  Workspace<> workspace(at.model);
  Comparison motion("motion", bound);
  for (std::size_t leaf = 0; leaf < leaf_bodies.size(); ++leaf) {
    const int frame = ReferenceSystem::frame(at.model, static_cast<int>(leaf_bodies[leaf]));
    const auto check = [&]<class Rep>(Rep) {
      std::vector<Twist<Rep>> V_q(at.nv()), V_v(V_q), dV_q(V_q), dV_v(V_q);
      motion_derivatives<Rep, double>(at.model, workspace, at.q, v, a, frame, {V_q, V_v, dV_q, dV_v});
      const auto in_file_order = [&](const std::vector<Twist<Rep>>& columns) {
        std::vector<double> out;
        for (int row = 0; row < 6; ++row)
          for (const std::size_t k : at.place) out.push_back(entry(columns[k], row));
        return out;
      };
      const Json& kinematics = at.file.at("kinematics");
      const auto expected = [&](const char* name) {
        return numbers(kinematics.at(name).at(key_of<Rep>()).at(leaf));
      };
      motion.expect_equal(in_file_order(V_q), expected("dV_dq"));
      motion.expect_equal(in_file_order(V_v), expected("dV_dv"));
      motion.expect_equal(in_file_order(dV_q), expected("dVdot_dq"));
      motion.expect_equal(in_file_order(dV_v), expected("dVdot_dv"));
    };
    check(BodyFixed{}), check(Spatial{}), check(Hybrid{}), check(Mixed{});
  }
}

}  // namespace
}  // namespace axode::test
