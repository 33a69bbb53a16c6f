#include "quantities.hpp"

#include <fmt/format.h>

#include "axode/dynamics.hpp"

namespace axode::command {
namespace {

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

std::string_view name_of(Representation representation) {
  switch (representation) {
    case Representation::body: return "body-fixed";
    case Representation::spatial: return "spatial";
    case Representation::hybrid: return "hybrid";
    case Representation::mixed: break;
  }
  return "mixed";
}

/// An answer of six numbers for each name.
template <class Range, class NameOf>
Answer six_each(std::string label, std::vector<std::string> headings, const Range& values,
                NameOf name_of_value) {
  Answer answer{std::move(label), Json::object(), Table(std::move(headings))};
  int k = 0;
  for (const auto& value : values) {
    const std::string& name = name_of_value(k++);
    const auto& [a, b] = value;
    answer.value[name] = to_json(value);
    answer.table.row({name, a.x, a.y, a.z, b.x, b.y, b.z});
  }
  return answer;
}

std::vector<std::string> numbered(const Model& model, int Joint::*count, int total) {
  std::vector<std::string> names;
  names.reserve(total);
  for (const Joint& joint : model.joints())
    for (int k = 0; k < joint.*count; ++k)
      names.push_back(joint.*count == 1 ? joint.name : fmt::format("{}[{}]", joint.name, k));
  return names;
}

Answer inverse_dynamics_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<double> tau(ask.model.nv());
  const Loads<> loads{ask.state.loads, ask.joint_losses};
  with_representation(ask.representation, [&](auto rep) {
    inverse_dynamics<decltype(rep)>(ask.model, workspace, ask.state.q, ask.state.v, ask.state.a, tau, loads);
  });
  Answer answer{"drive forces tau that make the accelerations a; N m for angles, N for lengths", tau,
                Table({"joint", "tau"})};
  const std::vector<std::string> names = velocity_names(ask.model);
  for (std::size_t k = 0; k < names.size(); ++k) answer.table.row({names[k], tau[k]});
  return answer;
}

Answer poses_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  std::vector<SE3<>> C(ask.model.n_frames());
  poses(ask.model, workspace, ask.state.q, C);
  Answer answer{"of the frames in the inertial frame; m. In JSON the rows of the 4x4 matrix [[R, r], [0, 1]]",
                Json::object(), Table({"frame", "x", "y", "z", "quaternion x", "y", "z", "w"})};
  for (int f = 0; f < ask.model.n_frames(); ++f) {
    const std::string& name = ask.model.frame(f).name;
    const auto& [R, r] = C[f];
    const Quaternion<> a = quaternion(R);
    answer.value[name] = to_json(C[f]);
    answer.table.row({name, r.x, r.y, r.z, a.x, a.y, a.z, a.w});
  }
  return answer;
}

Answer twists_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    Workspace<> workspace(ask.model);
    std::vector<Twist<decltype(rep)>> V(ask.model.n_frames());
    twists<decltype(rep)>(ask.model, workspace, ask.state.q, ask.state.v, V);
    return six_each(headline("velocities (w; v) of the frames", ask.representation,
                             twist_axes(ask.representation), "rad/s, m/s"),
                    {"frame", "w x", "w y", "w z", "v x", "v y", "v z"}, V,
                    [&](int f) -> const std::string& { return ask.model.frame(f).name; });
  });
}

Answer accelerations_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    Workspace<> workspace(ask.model);
    std::vector<TwistRate<decltype(rep)>> dV(ask.model.n_frames());
    accelerations<decltype(rep)>(ask.model, workspace, ask.state.q, ask.state.v, ask.state.a, dV);
    return six_each(headline("time derivatives of the components of the twists, gravity not included",
                             ask.representation, rate_axes(ask.representation), "rad/s^2, m/s^2"),
                    {"frame", "w' x", "w' y", "w' z", "v' x", "v' y", "v' z"}, dV,
                    [&](int f) -> const std::string& { return ask.model.frame(f).name; });
  });
}

Answer joint_wrenches_answer(const Question& ask) {
  return with_representation(ask.representation, [&](auto rep) {
    Workspace<> workspace(ask.model);
    std::vector<Wrench<decltype(rep)>> W(ask.model.n_bodies());
    joint_wrenches<decltype(rep)>(ask.model, workspace, ask.state.q, ask.state.v, ask.state.a, W,
                                  {ask.state.loads, ask.joint_losses});
    return six_each(headline("wrenches that the joints transmit to their bodies, drive and reaction",
                             ask.representation, wrench_axes(ask.representation), "N m, N"),
                    {"joint", "m x", "m y", "m z", "f x", "f y", "f z"}, W,
                    [&](int k) -> const std::string& { return ask.model.joint(k + 1).name; });
  });
}

Answer center_of_mass_answer(const Question& ask) {
  Workspace<> workspace(ask.model);
  const Vec3<> c = center_of_mass(ask.model, workspace, ask.state.q);
  Answer answer{"of all moving bodies, in the inertial frame; m", to_json(c), Table({"x", "y", "z"})};
  answer.table.row({c.x, c.y, c.z});
  return answer;
}

}  // namespace

std::string wrench_axes(Representation representation) {
  switch (representation) {
    case Representation::body: return "in the body's own axes, about its origin";
    case Representation::spatial: return "in inertial axes, about the inertial origin";
    case Representation::hybrid: return "in inertial axes, about the body's origin";
    case Representation::mixed: break;
  }
  return "moment in the body's own axes, about its origin; force in inertial axes";
}

std::string twist_axes(Representation representation) {
  switch (representation) {
    case Representation::body: return "in the frame's own axes, v of its origin";
    case Representation::spatial: return "in inertial axes, v of the body's point at the inertial origin";
    case Representation::hybrid: return "in inertial axes, v = r' of the frame's origin";
    case Representation::mixed: break;
  }
  return "w in the frame's own axes, v = r' of its origin in inertial axes";
}

std::string headline(std::string_view what, Representation representation, const std::string& axes,
                     std::string_view units) {
  return fmt::format("{}, {}: {}; {}", what, name_of(representation), axes, units);
}

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = [] {
    std::vector<Quantity> list{
        {"inverse_dynamics", "the drive forces that make the accelerations a", inverse_dynamics_answer},
        {"poses", "where every frame is", poses_answer},
        {"twists", "how every frame moves", twists_answer},
        {"accelerations", "the time derivatives of the twists", accelerations_answer},
        {"joint_wrenches", "all six components of what every joint transmits", joint_wrenches_answer},
        {"center_of_mass", "of all moving bodies", center_of_mass_answer},
    };
    for (const auto& more : {kinematic_quantities(), dynamic_quantities()})
      list.insert(list.end(), more.begin(), more.end());
    return list;
  }();
  return all;
}

std::vector<std::string> velocity_names(const Model& model) {
  return numbered(model, &Joint::nv, model.nv());
}
std::vector<std::string> coordinate_names(const Model& model) {
  return numbered(model, &Joint::nq, model.nq());
}

}  // namespace axode::command
